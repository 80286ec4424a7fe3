//! Writers: arrays, pictures, and any bytes.
//!
//! Every file appears whole or not at all: it is written under another name in the same folder and then renamed, so
//! that a reader never sees half of one and an interrupted run leaves the old one. Devices and pipes are written
//! directly, links are followed.

pub mod exr;
pub mod npy;
pub mod png;

use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::Error;

/// Writes bytes (JSON, CSV, …) as a file.
///
/// # Errors
/// [`Error`] names the file and why it cannot be written, e.g. that its folder does not exist.
pub fn bytes(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    atomically(path, |file| file.write_all(bytes))
}

/// Lets `fill` write a file that appears only when it is complete.
fn atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), Error> {
    let failed = |e| Error::io(path, e);
    // A dangling link cannot be resolved: then the link itself is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match fs::metadata(&target) {
        Ok(old) if old.is_dir() => return Err(Error::content(path, "is a folder, not a file")),
        Ok(old) if !old.is_file() => {
            let file = OpenOptions::new().write(true).open(&target).map_err(failed)?;
            return finish(file, fill).map_err(failed);
        }
        _ => {}
    }
    let (temporary, file) = create_beside(&target, path)?;
    finish(file, fill).and_then(|()| fs::rename(&temporary, &target)).map_err(|e| {
        // Best effort: the first error is the one to tell.
        let _ = fs::remove_file(&temporary);
        failed(e)
    })
}

fn finish(file: File, fill: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>) -> std::io::Result<()> {
    let mut file = BufWriter::with_capacity(1 << 16, file);
    fill(&mut file)?;
    file.flush()
}

/// A new file next to `target`, under a name that no other thread or process uses.
fn create_beside(target: &Path, path: &Path) -> Result<(PathBuf, File), Error> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let Some(name) = target.file_name() else {
        return Err(Error::content(path, "names no file"));
    };
    loop {
        let mut temporary = std::ffi::OsString::from(".");
        temporary.push(name);
        temporary.push(format!(".{}-{}.tmp", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
        let temporary = target.with_file_name(temporary);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => return Ok((temporary, file)),
            // Left over from a process of the same number.
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(why_not(target, path, e)),
        }
    }
}

fn why_not(target: &Path, path: &Path, e: std::io::Error) -> Error {
    let folder = target.parent().filter(|f| !f.as_os_str().is_empty());
    match folder {
        Some(folder) if !folder.exists() => {
            Error::content(path, format!("the folder {} does not exist", folder.display()))
        }
        Some(folder) if !folder.is_dir() => {
            Error::content(path, format!("{} is not a folder", folder.display()))
        }
        _ => Error::io(path, e),
    }
}

/// Checks that an array has as many entries as its shape says.
fn check_len(path: &Path, what: &str, len: usize, shape: &[usize]) -> Result<(), Error> {
    let wanted = shape.iter().try_fold(1usize, |n, s| n.checked_mul(*s));
    if wanted == Some(len) {
        return Ok(());
    }
    Err(Error::content(path, format!("{what}: {len} entries do not fill the shape {shape:?}")))
}

/// `InvalidInput` from what a library says.
fn invalid(e: impl std::fmt::Display) -> std::io::Error {
    std::io::Error::new(ErrorKind::InvalidInput, e.to_string())
}
