//! `--debug`: what a method did, one number a sample, as colours or as numbers.

use std::path::Path;
use std::process::ExitCode;

use antumbra::methods::{DebugView, Scale, create};
use anyhow::Result;
use serde::Serialize;

use crate::console::{Progress, print, print_json, table};
use crate::false_color::{Legend, PERCENTILE};
use crate::files;
use crate::plan::{Method, ending};
use crate::report::SCHEMA_VERSION;

/// The word that asks for the names, in the place of a name.
pub(crate) const LIST: &str = "list";

#[derive(Serialize)]
struct Entry {
    name: &'static str,
    shows: &'static str,
}

#[derive(Serialize)]
struct List {
    schema_version: u32,
    method: &'static str,
    views: Vec<Entry>,
}

/// `--debug list`.
pub(crate) fn list(method: &Method, json: bool) -> Result<ExitCode> {
    let views = create(method.info.name, &method.options)?.debug_views();
    let method = method.info.name;
    if json {
        let views = views.iter().map(|v| Entry { name: v.name, shows: v.shows }).collect();
        print_json(&List { schema_version: SCHEMA_VERSION, method, views })?;
    } else if views.is_empty() {
        print(&format!("{method} has no debug views\n"))?;
    } else {
        let rows: Vec<Vec<String>> =
            views.iter().map(|v| [v.name, v.shows].map(str::to_owned).into()).collect();
        print(&format!("debug views of {method}:\n{}", table(&rows, &[0, 1])))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The numbers of one light, and what their colours mean.
pub(crate) struct Numbers {
    numbers: Vec<f32>,
    legend: Legend,
}

/// What `--json` and `--stats` say of a view.
#[derive(Serialize)]
pub(crate) struct DebugReport {
    view: &'static str,
    shows: &'static str,
    /// What the range ends at.
    range_to: String,
    lights: Vec<Legend>,
}

impl DebugReport {
    pub(crate) fn new(view: &DebugView, told: Option<f32>, lights: &[Numbers]) -> DebugReport {
        let lights = lights.iter().map(|n| n.legend).collect();
        DebugReport { view: view.name, shows: view.shows, range_to: range_to(view, told), lights }
    }
}

fn range_to(view: &DebugView, told: Option<f32>) -> String {
    match view.scale {
        _ if told.is_some() => "as told".to_owned(),
        Scale::Amount => format!("{PERCENTILE}th percentile"),
        Scale::Label => "largest number".to_owned(),
    }
}

impl Numbers {
    pub(crate) fn new(view: &DebugView, told: Option<f32>, numbers: Vec<f32>) -> Numbers {
        let legend = Legend::new(&numbers, view.scale, told);
        Numbers { numbers, legend }
    }

    /// Says what the colours mean.
    pub(crate) fn note(&self, view: &DebugView, told: Option<f32>, progress: &Progress) {
        let Legend { range: [from, to], max, mean, above } = self.legend;
        progress.note(&format!(
            "debug view {}: {}\n  colours: dark violet {from} to yellow {} ({}); mean {mean:.2}, largest {}, {above} of {} samples \
             above the range",
            view.name,
            view.shows,
            short(to),
            range_to(view, told),
            short(max),
            self.numbers.iter().filter(|v| !v.is_nan()).count(),
        ));
    }

    /// `.exr`: the numbers. `.png`: colours over the linear `picture`.
    pub(crate) fn write(&self, path: &Path, size: [usize; 2], picture: &[[f32; 3]]) -> Result<()> {
        if ending(path) == "exr" {
            return files::write_numbers(path, size, &self.numbers);
        }
        let picture = antumbra::shade::encode::picture(picture);
        files::write_painting(path, size, &self.legend.paint(&self.numbers, &picture))
    }
}

/// Whole numbers as they are, others to two places.
fn short(number: f32) -> String {
    if number.fract() == 0.0 { number.to_string() } else { format!("{number:.2}") }
}
