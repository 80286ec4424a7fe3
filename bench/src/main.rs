//! The program `antumbra-rivals`.

use std::process::ExitCode;

use antumbra_bench::args::{Cli, Verb};
use antumbra_bench::{run, suite};
use clap::{CommandFactory, Parser};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match (&cli.verb, &cli.arrays) {
        (Some(Verb::Suite(suite)), _) => suite::run(suite),
        (None, Some(arrays)) => run::arrays(arrays),
        (None, None) => {
            let _ = Cli::command().print_help();
            return ExitCode::from(2);
        }
    };
    result.unwrap_or_else(|e| {
        eprintln!("antumbra-rivals: {e:#}");
        ExitCode::from(2)
    })
}
