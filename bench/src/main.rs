//! The program `antumbra-rivals`.

use std::process::ExitCode;

use antumbra_bench::args::Cli;
use antumbra_bench::run;
use clap::Parser;

fn main() -> ExitCode {
    let cli = Cli::parse();
    run::arrays(&cli).unwrap_or_else(|e| {
        eprintln!("antumbra-rivals: {e:#}");
        ExitCode::from(2)
    })
}
