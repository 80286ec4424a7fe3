//! Tables for people, JSON and CSV for machines.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};
use serde::Serialize;

use crate::compare::{Ratio, Row, Spread};
use crate::measure::Measured;

/// One case, all that is known about it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The scene, or the file of triangles.
    pub case: String,
    /// Casters.
    pub triangles: usize,
    /// Samples a row, rows.
    pub size: [usize; 2],
    /// Samples, background left out.
    pub samples: usize,
    /// Threads of each engine.
    pub threads: usize,
    /// Frames of each engine.
    pub rounds: usize,
    /// The engines.
    pub engines: Vec<Row>,
    /// Ours by theirs.
    pub ratios: Vec<Ratio>,
}

impl Report {
    /// True if no exact engine differs from another.
    pub fn is_exact(&self) -> bool {
        self.engines.iter().all(|row| !row.exact || row.mismatches == Some(0))
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut out = format!(
            "{}: {} triangles, {} samples of {}x{}, {} threads, {} rounds\n\n",
            self.case, self.triangles, self.samples, self.size[0], self.size[1], self.threads, self.rounds
        );
        let width = self.engines.iter().map(|r| r.engine.len()).max().unwrap_or(0);
        let pair = |s: &Spread| format!("{:>8.2} {:>8.2}", s.min, s.median);
        let _ = writeln!(
            out,
            "{:width$} {:>17} {:>17} {:>17} {:>17} {:>10} {:>10}",
            "ms: min, median", "total", "build", "trace", "cpu/threads", "shadowed", "mismatches"
        );
        for row in &self.engines {
            let [total, build, trace, cpu] =
                [&row.total_ms, &row.build_ms, &row.trace_ms, &row.cpu_ms].map(pair);
            let mismatches = row.mismatches.map_or("-".to_owned(), |n| n.to_string());
            let name = format!("{:w$}", row.engine, w = width.max("ms: min, median".len()));
            let _ =
                writeln!(out, "{name} {total} {build} {trace} {cpu} {:>10} {mismatches:>10}", row.shadowed);
        }
        out.push('\n');
        for row in &self.engines {
            let _ = writeln!(out, "{:width$} {}", row.engine, row.setup);
        }
        if !self.ratios.is_empty() {
            out.push_str(
                "\nours / theirs                            medians  minima   rounds: min, median, max\n",
            );
        }
        for r in &self.ratios {
            let name = format!("{} / {}, {}", r.engine, r.rival, r.of);
            let Spread { min, median, max } = r.rounds;
            let _ = writeln!(
                out,
                "{name:<52} {:>6.3}  {:>6.3}   {min:>6.3} {median:>6.3} {max:>6.3}",
                r.of_medians, r.of_minima
            );
        }
        out
    }
}

/// All cases as a table for a page: medians, and how ours stand to theirs. Ratios by processor time stand beside those by
/// the clock, because a shared machine disturbs them less.
pub fn markdown<'a>(reports: impl Iterator<Item = &'a Report> + Clone) -> String {
    let Some(first) = reports.clone().next() else { return String::new() };
    let mut out = format!(
        "Medians of up to {} rounds, {} threads; times in ms (processor time by threads in brackets).\n\n",
        reports.clone().map(|r| r.rounds).max().unwrap_or(0),
        first.threads
    );
    let compared: Vec<&Ratio> = first.ratios.iter().filter(|r| r.of == "total").collect();
    let mut head = vec!["scene".to_owned(), "triangles".to_owned(), "samples".to_owned()];
    for row in &first.engines {
        head.push(row.engine.clone());
    }
    for row in first.engines.iter().filter(|row| !row.exact) {
        head.push(format!("{} wrong", row.engine));
    }
    for r in &compared {
        let short = |name: &str| name.trim_start_matches("antumbra:").to_owned();
        head.push(format!("{} / {}: total, to trace alone, cpu", short(&r.engine), r.rival));
    }
    let _ = writeln!(out, "| {} |", head.join(" | "));
    let _ = writeln!(out, "|{}", " --- |".repeat(head.len()));
    for report in reports.clone() {
        let mut cells = vec![report.case.clone(), report.triangles.to_string(), report.samples.to_string()];
        cells.extend(
            report.engines.iter().map(|r| format!("{:.1} ({:.1})", r.total_ms.median, r.cpu_ms.median)),
        );
        let inexact = report.engines.iter().filter(|row| !row.exact);
        cells.extend(inexact.map(|r| r.mismatches.map_or("-".to_owned(), |n| n.to_string())));
        for three in report.ratios.chunks(3) {
            let three: Vec<String> = three.iter().map(|r| format!("{:.2}", r.of_medians)).collect();
            cells.push(three.join(", "));
        }
        let _ = writeln!(out, "| {} |", cells.join(" | "));
    }
    let mut cells = vec![String::from("geometric mean"), String::new(), String::new()];
    cells.resize(head.len() - compared.len(), String::new());
    for pair in 0..compared.len() {
        let mean = |of: usize| {
            let logs = reports.clone().map(|r| r.ratios[3 * pair + of].of_medians.ln());
            format!("{:.2}", (logs.sum::<f64>() / reports.clone().count() as f64).exp())
        };
        cells.push(format!("**{}, {}, {}**", mean(0), mean(1), mean(2)));
    }
    let _ = writeln!(out, "| {} |", cells.join(" | "));
    out
}

/// One row an engine and round, with a head. Lines that begin with `#` say what was run.
pub fn csv(cases: &[(Report, Vec<Measured>)]) -> String {
    let mut out = format!("# commit {}\n", commit());
    for row in cases.first().map_or(&[][..], |(report, _)| &report.engines) {
        let _ = writeln!(out, "# {}: {}", row.engine, row.setup);
    }
    out.push_str(
        "case,triangles,width,height,samples,threads,engine,round,build_ms,trace_ms,total_ms,cpu_ms,shadowed,mismatches\n",
    );
    for (report, all) in cases {
        for (row, measured) in report.engines.iter().zip(all) {
            for (round, frame) in measured.frames.iter().enumerate() {
                let mismatches = row.mismatches.map_or(String::new(), |n| n.to_string());
                let _ = writeln!(
                    out,
                    "{},{},{},{},{},{},{},{round},{:.3},{:.3},{:.3},{:.3},{},{mismatches}",
                    report.case,
                    report.triangles,
                    report.size[0],
                    report.size[1],
                    report.samples,
                    report.threads,
                    row.engine,
                    frame.time.build_ms,
                    frame.time.trace_ms,
                    frame.time.total_ms,
                    frame.cpu_ms,
                    row.shadowed,
                );
            }
        }
    }
    out
}

/// The version of the code that is here, with a `+` if it was changed since; `unknown` without git.
fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = std::process::Command::new("git").args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let Some(hash) = git(&["rev-parse", "--short=12", "HEAD"]) else { return "unknown".to_owned() };
    // Records and answers change by running the bench itself.
    let changed = git(&["status", "--porcelain", "--untracked-files=no", "--", "*.rs", "*Cargo.*"]);
    if changed.is_some_and(|files| !files.is_empty()) { hash + "+" } else { hash }
}

/// Writes a text file, and its folder where there is none.
///
/// # Errors
/// Names the file.
pub fn write(path: &Path, text: &str) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    std::fs::write(path, text).with_context(|| path.display().to_string())
}
