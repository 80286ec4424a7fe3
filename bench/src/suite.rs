//! A folder of scenes: times, answers, and a record.

use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Context, Result, bail};

use crate::args::Suite;
use crate::definition::{Definition, size};
use crate::measure::Measured;
use crate::report::{self, Report};
use crate::{run, stage};

/// Runs the suite. Exit code 1: an answer is not the one that there must be.
///
/// # Errors
/// What cannot be read, started or written.
pub fn run(plan: &Suite) -> Result<ExitCode> {
    size(&plan.size).map_err(anyhow::Error::msg)?;
    let definitions = Definition::read_all(&plan.definitions)?;
    let wanted = |d: &&Definition| plan.only.is_empty() || plan.only.iter().any(|o| d.name.contains(o));
    let mut done: Vec<(Report, Vec<Measured>)> = Vec::new();
    let (mut wrong, mut skipped) = (Vec::new(), Vec::new());
    for definition in definitions.iter().filter(wanted) {
        if let Some(path) = stage::file(definition).filter(|path| !path.exists()) {
            skipped.push(format!("{}: {} is not there", definition.name, path.display()));
            continue;
        }
        eprintln!("{}", definition.name);
        let text = definition.size.as_ref().unwrap_or(&plan.size);
        let case = stage::case(definition, size(text).map_err(anyhow::Error::msg)?);
        let case = case.with_context(|| definition.path.display().to_string())?;
        let (report, measured) = run::one(&definition.name, &case, &plan.how)?;
        wrong.extend(check(definition, text, &report, plan.update)?);
        done.push((report, measured));
    }
    if done.is_empty() && skipped.is_empty() {
        bail!("{}: no case of that name", plan.only.join(","));
    }
    print!("{}", report::markdown(done.iter().map(|(report, _)| report)));
    for line in &skipped {
        println!("\nskipped: {line} ({} says where scenes are)", stage::SCENES);
    }
    for line in &wrong {
        println!("\nWRONG: {line}");
    }
    if !plan.no_record && !done.is_empty() {
        let machine = plan.machine.clone().unwrap_or_else(|| machine(done[0].0.threads));
        let path = plan.record.join(machine).join(format!("{}-{}.csv", today(), plan.size));
        report::write(&path, &report::csv(&done))?;
        eprintln!("wrote {}", path.display());
    }
    Ok(ExitCode::from(u8::from(!wrong.is_empty())))
}

/// Holds a report against what the definition says, or makes the definition say it.
fn check(definition: &Definition, size: &str, report: &Report, update: bool) -> Result<Vec<String>> {
    let name = &definition.name;
    let mut wrong = Vec::new();
    if !report.is_exact() {
        wrong.push(format!("{name}: the masks of exact engines differ"));
    }
    let Some(exact) = report.engines.iter().find(|row| row.exact) else { return Ok(wrong) };
    if update && wrong.is_empty() {
        definition.record(size, report.triangles, exact.shadowed)?;
        return Ok(wrong);
    }
    if let Some(expected) = definition.triangles.filter(|&n| n != report.triangles) {
        wrong.push(format!("{name}: {} triangles, not {expected}: is it the same scene?", report.triangles));
    }
    if let Some(expected) = definition.shadowed.get(size).filter(|&&n| n != exact.shadowed) {
        wrong.push(format!("{name}: {} samples in shadow, not {expected}", exact.shadowed));
    }
    Ok(wrong)
}

/// Processor and threads, as a folder's name.
fn machine(threads: usize) -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or(std::env::consts::ARCH, |(_, name)| name.trim());
    let kept = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let slug: String = model.chars().map(kept).collect();
    let words: Vec<&str> = slug.split('-').filter(|w| !w.is_empty()).collect();
    format!("{}-{threads}-threads", words.join("-"))
}

/// `2026-02-28`, by universal time.
fn today() -> String {
    let days = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs() / 86_400);
    let [year, month, day] = civil(days);
    format!("{year:04}-{month:02}-{day:02}")
}

/// Year, month and day of a number of days since 1970-01-01.
fn civil(mut days: u64) -> [u64; 3] {
    let leap = |y: u64| y.is_multiple_of(4) && (!y.is_multiple_of(100) || y.is_multiple_of(400));
    let mut year = 1970;
    while days >= 365 + u64::from(leap(year)) {
        days -= 365 + u64::from(leap(year));
        year += 1;
    }
    let lengths = [31, 28 + u64::from(leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let mut month = 0;
    while days >= lengths[month] {
        days -= lengths[month];
        month += 1;
    }
    [year, month as u64 + 1, days + 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days() {
        assert_eq!(civil(0), [1970, 1, 1]);
        assert_eq!(civil(11_016), [2000, 2, 29]);
        assert_eq!(civil(20_453), [2025, 12, 31]);
    }
}
