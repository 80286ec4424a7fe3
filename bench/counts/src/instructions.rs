//! Starts this program under callgrind and reads what it counted.

use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::record::Case;

/// Instructions of the counted frame.
pub(crate) fn count(case: &Case) -> Result<u64> {
    let program = std::env::current_exe()?;
    let folder = std::env::temp_dir();
    let out = folder.join(format!("antumbra-counts-{}.callgrind", std::process::id()));
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no", "--toggle-collect=*counted_frame*"])
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(program)
        .args(["frame", &case.method, &case.scene, &case.size, &case.isa])
        .output()
        .context("valgrind cannot be started; --no-instructions does without")?;
    if !output.status.success() {
        bail!("valgrind: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    let text = std::fs::read_to_string(&out).with_context(|| out.display().to_string())?;
    std::fs::remove_file(&out)?;
    // One line of totals a thread's part, or one for all.
    let totals = text.lines().filter_map(|l| l.strip_prefix("totals:")?.trim().parse::<u64>().ok());
    match totals.max() {
        Some(instructions) if instructions > 0 => Ok(instructions),
        _ => bail!("callgrind counted nothing: was counted_frame inlined?"),
    }
}
