//! One case: from arrays to a report.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result};
use bench_common::Case;

use crate::args::{Arrays, How};
use crate::compare::{ratios, rows};
use crate::engines;
use crate::measure::{Measured, Patience, measure};
use crate::report::{self, Report};

/// Arrays from files.
///
/// # Errors
/// What cannot be read, started or written.
pub fn arrays(cli: &Arrays) -> Result<ExitCode> {
    let triangles = antumbra_io::read::npy::read_triangles(&cli.triangles)?;
    let (samples, shape) = antumbra_io::read::npy::read_samples(&cli.samples)?;
    let width = shape.last().copied().unwrap_or(samples.len());
    let case = Arc::new(Case::new(triangles, samples, width, cli.light, None));
    let name = cli.triangles.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let (report, measured) = one(&name, &case, &cli.how)?;
    if cli.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print!("{}", report.text());
    }
    let exact = report.is_exact();
    if let Some(path) = &cli.output {
        report::write(path, &report::csv(&[(report, measured)]))?;
    }
    Ok(ExitCode::from(u8::from(!exact)))
}

/// Measures one case.
///
/// # Errors
/// What an engine says.
pub fn one(name: &str, case: &Arc<Case>, how: &How) -> Result<(Report, Vec<Measured>)> {
    let mut builder = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = how.threads {
        builder = builder.num_threads(usize::from(threads));
    }
    let pool = builder.build().context("threads cannot be started")?;
    let threads = pool.current_num_threads();
    let mut engines =
        how.engines.iter().map(|name| engines::create(name, threads)).collect::<Result<Vec<_>>>()?;
    let patience = Patience {
        rounds: usize::from(how.rounds),
        budget: Duration::from_secs(how.budget),
        rest: Duration::from_millis(how.rest),
        stale: Duration::from_millis(how.stale),
    };
    let measured = measure(&mut engines, case, &pool, patience)?;
    let report = Report {
        case: name.to_owned(),
        triangles: case.triangles().len(),
        size: [case.width, case.height()],
        samples: case.samples.iter().filter(|p| !p.iter().any(|v| v.is_nan())).count(),
        threads,
        rounds: measured.first().map_or(0, |m| m.frames.len()),
        engines: rows(&measured)?,
        ratios: ratios(&measured),
    };
    Ok((report, measured))
}
