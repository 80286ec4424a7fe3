//! The verbs.

mod compare;
mod debug;
mod info;
mod lists;
mod mask;
mod pages;
mod render;
mod reproduce;

use std::process::ExitCode;

use anyhow::{Context, Result};

use crate::args::Verb;
use crate::plan::{Compare, Input, Machine, Mask, Method, Render, Reproduce};

/// Plans a verb and runs it, in a thread pool of the size that was asked for.
pub(crate) fn verb(verb: Verb) -> Result<ExitCode> {
    match verb {
        Verb::Render(args) => {
            let machine = Machine::new(&args.machine)?;
            if args.debug.as_deref() == Some(debug::LIST) {
                return debug::list(&Method::new(&args.method, machine.isa)?, args.report.talk.json);
            }
            let plan = Render::new(&args, &machine)?;
            on(&machine, || render::run(&plan))
        }
        Verb::Mask(args) => {
            let machine = Machine::new(&args.machine)?;
            let plan = Mask::new(&args, &machine)?;
            on(&machine, || mask::run(&plan))
        }
        Verb::Compare(args) => {
            let machine = Machine::new(&args.machine)?;
            let plan = Compare::new(&args, &machine)?;
            on(&machine, || compare::run(&plan))
        }
        Verb::Reproduce(args) => {
            let machine = Machine::new(&args.machine)?;
            let plan = Reproduce::new(&args, &machine)?;
            on(&machine, || reproduce::run(&plan))
        }
        Verb::Methods(list) => lists::methods(list.json),
        Verb::Scenes(list) => lists::scenes(list.json),
        Verb::Info(args) => info::run(&Input::new(&args.input)?, args.first, args.json),
        Verb::Completions { shell } => pages::completions(shell),
        Verb::Man { verb } => pages::man(verb.as_deref()),
    }
}

fn on(machine: &Machine, run: impl FnOnce() -> Result<ExitCode> + Send) -> Result<ExitCode> {
    let Some(threads) = machine.threads else { return run() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.with_context(|| format!("--threads {threads}: cannot be started"))?.install(run)
}
