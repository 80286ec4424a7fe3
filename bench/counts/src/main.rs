//! `antumbra-counts`: instructions and work counters of one small frame a method, held against what is recorded.
//!
//! Times on a shared machine say little; how many instructions one thread runs for the same frame is the same to a fraction of
//! a per cent. `check` starts this program again under valgrind's callgrind, which counts within one function only,
//! [`frame::counted_frame`]. (A benchmark framework would do the same start, but keeps its baselines with the build; these are
//! to be reviewed with the code.)

mod frame;
mod instructions;
mod record;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};

use record::{Case, Record};

#[derive(Debug, Parser)]
#[command(
    name = "antumbra-counts",
    about = "Instructions and work of one small frame a method, against the record"
)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Holds all cases of the record against it. Exit code 1: one of them does more than it did.
    Check {
        /// The record.
        #[arg(long, default_value = "bench/record/counts.toml")]
        record: PathBuf,
        /// Writes what is found into the record.
        #[arg(long)]
        update: bool,
        /// Only work counters; needs no valgrind.
        #[arg(long)]
        no_instructions: bool,
    },
    /// One frame, twice: the second is the one that counts. What `check` starts.
    Frame {
        /// As in `antumbra methods`.
        method: String,
        /// Of a built-in scene.
        scene: String,
        /// `WxH`.
        size: String,
        /// As in `antumbra mask --isa`.
        isa: String,
    },
}

fn main() -> ExitCode {
    let result = match Cli::parse().verb {
        Verb::Check { record, update, no_instructions } => check(&record, update, !no_instructions),
        Verb::Frame { method, scene, size, isa } => frame::run(&method, &scene, &size, &isa).map(|stats| {
            println!("{}: {} samples shadowed", stats.method, stats.shadowed);
            ExitCode::SUCCESS
        }),
    };
    result.unwrap_or_else(|e| {
        eprintln!("antumbra-counts: {e:#}");
        ExitCode::from(2)
    })
}

fn check(path: &std::path::Path, update: bool, instructions: bool) -> Result<ExitCode> {
    let mut record = Record::read(path)?;
    let mut worse = false;
    let tolerance = record.tolerance;
    for case in &mut record.cases {
        println!("{} on {} at {}, {}", case.method, case.scene, case.size, case.isa);
        if let Err(reason) = frame::possible(case) {
            println!("  skipped: {reason}");
            continue;
        }
        let found = measure(case, instructions).with_context(|| case.method.clone())?;
        for line in case.compare(&found, tolerance) {
            println!("  {line}");
            worse |= line.is_worse();
        }
        if update {
            *case = found;
        }
    }
    if update {
        record.write(path)?;
        println!("wrote {}", path.display());
        return Ok(ExitCode::SUCCESS);
    }
    println!("{}", if worse { "FAIL" } else { "pass" });
    Ok(ExitCode::from(u8::from(worse)))
}

/// The case as it is now.
fn measure(case: &Case, instructions: bool) -> Result<Case> {
    let stats = frame::run(&case.method, &case.scene, &case.size, &case.isa)?;
    let counters = stats.counters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let instructions = if instructions { Some(instructions::count(case)?) } else { case.instructions };
    Ok(Case { shadowed: Some(stats.shadowed as u64), instructions, counters, ..case.clone() })
}
