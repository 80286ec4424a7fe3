//! `mask`: arrays in, mask out.

use std::process::ExitCode;

use antumbra::methods::{Samples, create};
use antumbra::scene::{PointLight, Soup};
use anyhow::{Context, Result};

use crate::console::{Progress, print_json};
use crate::files;
use crate::plan::Mask;
use crate::report::StatsReport;

pub(crate) fn run(plan: &Mask) -> Result<ExitCode> {
    let mut progress = Progress::new(plan.talk.quiet);
    progress.doing("reading");
    let (triangles, samples) =
        rayon::join(|| files::read_triangles(&plan.triangles), || files::read_samples(&plan.samples));
    let (triangles, (positions, shape)) = (triangles?, samples?);
    progress.stage("read");

    let count = triangles.len();
    let soup = Soup { positions: triangles, object: vec![0; count], ..Soup::default() };
    let light = PointLight { skip_radius: plan.skip_radius, ..PointLight::at(plan.light) };
    let casters = soup.casters(&light);
    // A picture's rows help some methods; a list is one row.
    let width = *shape.last().unwrap_or(&positions.len());
    let samples = Samples::image(&positions, width);

    let mut method = create(plan.method.info.name, &plan.method.options)?;
    let mut mask = vec![0; positions.len()];
    let mut runs = Vec::new();
    for k in 0..plan.repeat {
        progress.doing(format!("shadows: {} {}/{}", plan.method.info.name, k + 1, plan.repeat));
        runs.push(method.shadow(&casters.triangles, samples, light.position, &mut mask)?);
    }
    progress.stage("shadow");
    let report = StatsReport::of_runs(&runs).context("no run")?;
    let report = if plan.repeat == 1 { StatsReport { runs_ms: Vec::new(), ..report } } else { report };

    progress.doing("writing");
    if let Some(path) = &plan.output {
        files::write_mask(path, &mask, &shape)?;
    }
    if let Some(path) = &plan.stats {
        files::write_json(path, &report)?;
    }
    progress.finish();
    progress.note(&format!(
        "{}: {} of {} samples shadowed by {} triangles in {:.1} ms",
        report.method, report.shadowed, report.samples, report.triangles, report.total_ms
    ));
    if plan.talk.json {
        print_json(&report)?;
    }
    Ok(ExitCode::SUCCESS)
}
