//! Completions and manual pages, from the table of arguments.

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::CommandFactory;

use crate::args::Cli;
use crate::console::print_bytes;

/// `completions`.
pub(crate) fn completions(shell: clap_complete::Shell) -> Result<ExitCode> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "antumbra", &mut text);
    print_bytes(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// `man`.
pub(crate) fn man(verb: Option<&str>) -> Result<ExitCode> {
    let mut program = Cli::command();
    // Gives the verbs their full names, `antumbra render`.
    program.build();
    let page = match verb {
        None => program,
        Some(verb) => match program.find_subcommand(verb) {
            Some(command) => command.clone(),
            None => bail!("man {verb}: there is no such verb; `antumbra --help` lists them"),
        },
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text)?;
    print_bytes(&text)?;
    Ok(ExitCode::SUCCESS)
}
