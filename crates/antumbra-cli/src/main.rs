//! The program `antumbra`: parse (`args.rs`), say what it means (`plan.rs`), run (`run/`), report.
#![forbid(unsafe_code)]

mod args;
mod console;
mod false_color;
mod files;
mod plan;
mod report;
mod run;
mod stage;
mod values;

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;

/// Exit code of a usage error and of anything that went wrong.
const FAILED: u8 = 2;

fn main() -> ExitCode {
    let cli = match args::Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    match run::verb(cli.verb) {
        Ok(code) => code,
        Err(error) => {
            console::tell(&format!("error: {}", causes(&error)));
            ExitCode::from(FAILED)
        }
    }
}

/// The error and what caused it, on one line. Causes that the text before already tells are left out.
fn causes(error: &anyhow::Error) -> String {
    let mut told = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !told.contains(&cause) {
            told = format!("{told}: {cause}");
        }
    }
    told
}

/// Help goes to stdout; a mistake to stderr, in two lines: what is wrong, and where to read on.
fn usage(error: &clap::Error) -> ExitCode {
    let text = match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // Nobody to tell if this fails.
            let _ = console::print(&error.to_string());
            return ExitCode::SUCCESS;
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            console::tell(&error.to_string());
            return ExitCode::from(FAILED);
        }
        _ => error.to_string(),
    };
    let told: Vec<&str> = text
        .lines()
        .take_while(|l| !l.starts_with("Usage"))
        .map(str::trim)
        .filter(|l| !l.is_empty())
        .collect();
    console::tell(&told.join(" "));
    let verb = std::env::args().nth(1).filter(|v| !v.starts_with('-')).unwrap_or_default();
    let known = <args::Cli as clap::CommandFactory>::command().find_subcommand(&verb).is_some();
    console::tell(&format!(
        "For more, try: antumbra {}--help",
        if known { verb + " " } else { String::new() }
    ));
    ExitCode::from(FAILED)
}
