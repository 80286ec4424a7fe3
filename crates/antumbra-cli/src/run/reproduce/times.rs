//! How the methods compare in time: ratios of one run only, as times belong to a machine.

use antumbra::methods::{self, CATALOGUE, Options};
use anyhow::Result;

use super::bench::{Bench, counter};
use super::markdown::{short, table};
use super::settings::SPONZA;
use super::{Finding, Section, Verdict};
use crate::report::median;

/// Slower than this many times `ray-cast` wants an explanation.
const LIMIT: f64 = 20.0;

/// Runs of which the fastest counts: the machine may be busy.
const RUNS: usize = 2;

/// Runs of `ray-cast` before and after each method, whose median is what the method is compared with: how busy the machine is
/// changes within the minutes that the table takes.
const BASES: usize = 3;

/// K21's milliseconds on its own Sponza, by our name of the method. The rows of table 3 lost their labels in the text; they are those of
/// table 5, in the same order.
const PUBLISHED: [(&str, f64); 6] = [
    ("cptsv", 3.08),
    ("cssv", 1.57),
    ("dpsv-hybrid", 2.91),
    ("ofts", 3.70),
    ("ptsv", 10.25),
    ("ray-cast", 2.33),
];

pub(super) const TIMES: Section = Section {
    key: "times",
    title: "Times against ray casting",
    claim: "Ray tracing with a hierarchy built every frame is among the fastest; CSSV is faster on closed rooms, PTSV the slowest.",
    source: "K21, section 4.2, table 3, Sponza at 1920 x 1080",
    published: "ms on a GPU: CSSV 1.57, RTX with rebuild 2.33, DPSV 2.91, CPTSV 3.08, OFTS 3.70, PTSV 10.25",
    run: run_all,
};

fn run_all(bench: &mut Bench<'_>) -> Result<Finding> {
    let Some(setting) = bench.resolve(&SPONZA) else {
        return Ok(Finding { verdict: Verdict::Differs, ours: "not run".to_owned(), body: String::new() });
    };
    let mut found = Vec::new();
    for info in CATALOGUE.iter().filter(|m| m.name != "oracle") {
        let mut bases = Vec::new();
        let mut best = f64::INFINITY;
        for run in 0..2 * BASES + RUNS {
            let method = if (BASES..BASES + RUNS).contains(&run) { info.name } else { "ray-cast" };
            let label = format!("{method} timed beside {}, run {run}", info.name);
            let options = Options { isa: bench.isa, count: false };
            let exact = methods::info(method)?.exact;
            let stats = bench.run(&setting, &label, exact, || Ok(methods::create(method, &options)?))?;
            if method == info.name && method != "ray-cast" {
                best = best.min(stats.total_ms);
            } else {
                bases.push(stats.total_ms);
            }
        }
        let base = median(&bases).unwrap_or(f64::NAN);
        let best = if info.name == "ray-cast" { base } else { best };
        let counts = bench.count(&setting, info.name)?;
        let [nodes, leaves] = ["node_visits", "leaf_tests"].map(|n| counter(&counts, n));
        found.push((info, best / base, best, nodes, leaves));
    }
    let published = |name: &str| PUBLISHED.iter().find(|p| p.0 == name).map(|p| p.1);
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let rows: Vec<Vec<String>> = found
        .iter()
        .map(|(info, ratio, ms, nodes, leaves)| {
            let theirs = published(info.name).map_or(String::new(), |ms| format!("{:.2}", ms / 2.33));
            let name = if info.exact { info.name.to_owned() } else { format!("{} (not exact)", info.name) };
            vec![name, format!("{ms:.0}"), format!("{ratio:.1}"), theirs, short(*nodes), short(*leaves)]
        })
        .collect();
    let slow: Vec<&str> = found.iter().filter(|f| f.1 > LIMIT).map(|f| f.0.name).collect();
    let mut body =
        table(&["method", "ms", "to ray-cast", "K21: to RTX rebuild", "node visits", "leaf tests"], &rows);
    body += "\nThe faster of two runs each, against the median of six runs of `ray-cast` around them, on the machine and under the load of the day: \
             only ratios mean something. The paper's are of a GPU with hardware for rasterising and for ray tracing, ours of a CPU that has neither: volumes lose \
             their rasteriser, hierarchies their traversal units. `docs/performance.md` explains the ratios over 20 by the counts of the last two columns.\n";
    let ours = if slow.is_empty() {
        format!("no method takes more than {LIMIT} times as long as ray-cast")
    } else {
        format!("more than {LIMIT} times as long as ray-cast: {}", slow.join(", "))
    };
    // The order of the paper is of other hardware; what is asked of ours is the bound.
    let verdict = if slow.is_empty() { Verdict::Holds } else { Verdict::Partly };
    Ok(Finding { verdict, ours, body })
}
