//! The program `antumbra-rivals`.

use std::process::ExitCode;

use antumbra_bench::args::Plan;
use antumbra_bench::{run, suite};

fn main() -> ExitCode {
    let result = match Plan::parse() {
        Plan::Arrays(arrays) => run::arrays(&arrays),
        Plan::Suite(plan) => suite::run(&plan),
    };
    result.unwrap_or_else(|e| {
        eprintln!("antumbra-rivals: {e:#}");
        ExitCode::from(2)
    })
}
