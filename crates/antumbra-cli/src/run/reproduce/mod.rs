//! `reproduce`: what the papers claim about the work of their methods, counted again, as one page of Markdown.
//!
//! Every section runs its own methods (`bench.rs` keeps the counts, so no run is made twice), states what was published,
//! what comes out here, and whether the claim holds; the verdict follows from the numbers, the explanations are
//! templates beside them. Nothing on the page is typed in by hand after the run.

mod bench;
mod lists;
mod markdown;
mod memory;
mod ray_hierarchy;
mod settings;
mod times;
mod volumes;

use std::process::ExitCode;

use anyhow::{Result, bail};

use self::bench::Bench;
use crate::console::{Progress, print};
use crate::plan::Reproduce;

/// One claim.
struct Section {
    /// For `--only`.
    key: &'static str,
    title: &'static str,
    /// What the paper says.
    claim: &'static str,
    /// Which paper, and where in it.
    source: &'static str,
    /// The published number, or that there is none.
    published: &'static str,
    run: fn(&mut Bench<'_>) -> Result<Finding>,
}

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Holds,
    Partly,
    Differs,
}

/// What came out.
struct Finding {
    verdict: Verdict,
    /// Our number, in one line.
    ours: String,
    /// Tables, and why they differ where they do.
    body: String,
}

impl Verdict {
    fn of(holds: bool) -> Verdict {
        if holds { Verdict::Holds } else { Verdict::Differs }
    }

    fn told(self) -> &'static str {
        match self {
            Verdict::Holds => "yes",
            Verdict::Partly => "partly",
            Verdict::Differs => "no",
        }
    }
}

/// In the order of the page.
const SECTIONS: &[Section] = &[
    ray_hierarchy::FRAMES,
    ray_hierarchy::SORTING,
    ray_hierarchy::PRECISE,
    ray_hierarchy::EARLY,
    volumes::GROWTH,
    volumes::CULLING,
    lists::LISTS,
    memory::TABLE,
    memory::BYTES,
    times::TIMES,
];

const INTRO: &str = "\
# Reproducing the papers

What the papers say about the work of their methods, beside what comes out here. Work is counted, not timed (the last section
apart), so the numbers do not depend on the machine; where early accept lets threads overtake one another they
vary in the third digit. In every run of an exact method
with all casters the mask was held against `ray-cast`'s: one sample that differed would have ended it.

Sources: *OA11* is Olsson, Assarsson 2011, \"Improved Ray Hierarchy Alias Free Shadows\"; *SOA11* is Sintorn, Olsson, Assarsson 2011, \"An
Efficient Alias-free Shadow Algorithm for Opaque and Transparent Objects using per-triangle Shadow Volumes\"; *K21* is Kobrtek,
Milet, Tóth, Herout 2021, \"Comparison of Modern Omnidirectional Precise Shadowing Techniques Versus Ray Tracing\".
";

pub(crate) fn run(plan: &Reproduce) -> Result<ExitCode> {
    for key in &plan.only {
        if !SECTIONS.iter().any(|s| s.key == key) {
            let known: Vec<&str> = SECTIONS.iter().map(|s| s.key).collect();
            bail!("--only {key}: no such section; there are {}", known.join(", "));
        }
    }
    let mut progress = Progress::new(plan.quiet);
    let mut told = Vec::new();
    let mut bench = Bench::new(plan.scenes.clone(), plan.isa, plan.divide, &progress);
    let chosen: Vec<&Section> =
        SECTIONS.iter().filter(|s| plan.only.is_empty() || plan.only.iter().any(|k| k == s.key)).collect();
    for (k, section) in chosen.iter().enumerate() {
        progress.note(&format!("{}/{}: {}", k + 1, chosen.len(), section.key));
        told.push((*section, (section.run)(&mut bench)?));
    }
    let missing = std::mem::take(&mut bench.missing);
    drop(bench);
    let text = page(plan, &told, &missing);
    match &plan.output {
        Some(path) => {
            std::fs::write(path, &text).map_err(|e| anyhow::anyhow!("{}: {e}", path.display()))?;
        }
        None => print(&text)?,
    }
    progress.finish();
    if let Some(path) = &plan.output {
        progress.note(&format!("wrote {}", path.display()));
    }
    Ok(ExitCode::SUCCESS)
}

fn page(plan: &Reproduce, told: &[(&Section, Finding)], missing: &[String]) -> String {
    let mut text = INTRO.to_owned();
    let mut command = "antumbra reproduce --scenes DIR".to_owned();
    if !plan.only.is_empty() {
        command += &format!(" --only {}", plan.only.join(","));
    }
    if plan.divide > 1 {
        command += &format!(" --divide {}", plan.divide);
    }
    text += &format!(
        "\nThis page is the output of `{command} -o docs/reproducing.md`, version {}, instruction set {}; change the program, not the page.\n",
        env!("CARGO_PKG_VERSION"),
        plan.isa.resolved().name(),
    );
    if plan.divide > 1 {
        text +=
            &format!("\n**A trial run**: width and height of all pictures are divided by {}.\n", plan.divide);
    }
    let rows: Vec<Vec<String>> = told
        .iter()
        .map(|(s, f)| {
            let title = format!("[{}](#{})", s.title, anchor(s.title));
            vec![title, s.source.to_owned(), f.ours.clone(), f.verdict.told().to_owned()]
        })
        .collect();
    text += &format!("\n{}", markdown::table(&["claim", "source", "here", "holds"], &rows));
    if !missing.is_empty() {
        text += "\nNot there when this page was made:\n\n";
        for line in missing {
            text += &format!("- {line}\n");
        }
    }
    for (section, finding) in told {
        text += &format!(
            "\n## {}\n\n{} ({})\n\n- Published: {}\n- Here: {}\n- Holds: {}\n\n{}",
            section.title,
            section.claim,
            section.source,
            section.published,
            finding.ours,
            finding.verdict.told(),
            finding.body,
        );
    }
    text
}

/// The link that a heading gets.
fn anchor(title: &str) -> String {
    let kept = title.to_lowercase();
    kept.chars().filter(|c| c.is_alphanumeric() || " -".contains(*c)).collect::<String>().replace(' ', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_headings_are_unique() {
        for (i, a) in SECTIONS.iter().enumerate() {
            for b in &SECTIONS[i + 1..] {
                assert_ne!(a.key, b.key);
                assert_ne!(anchor(a.title), anchor(b.title));
            }
        }
        assert_eq!(anchor("Lists, and cells: 64"), "lists-and-cells-64");
    }
}
