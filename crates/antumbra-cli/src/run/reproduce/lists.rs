//! What K21 says about the lists of the irregular z-buffer.

use anyhow::Result;

use super::bench::{Bench, Setting, counter};
use super::markdown::{grouped, table};
use super::settings::{BUILDING, CITY, FOREST, HD, MUSEUM, ROBOTS, ROOM, SPONZA, UHD};
use super::{Finding, Section, Verdict};

/// Samples of one cell at most, where no two samples are the same point of light space.
const BOUND: u64 = 64;

pub(super) const LISTS: Section = Section {
    key: "lists",
    title: "Lists of the irregular z-buffer",
    claim: "OFTS owes its spikes to long lists: how many samples fall into one cell of light space has no bound but by tuning.",
    source: "K21, sections 2.3, 4.2 and 4.3",
    published: "no lengths; \"270 ms spikes on both Sponza and Hairball\" until resolution and threshold were tuned for the scene",
    run: lists,
};

const HARD: [Setting; 3] = [
    Setting::new("builtin:one-cell", "builtin:one-cell", HD),
    Setting::new("builtin:two-clumps", "builtin:two-clumps", HD),
    Setting::new("builtin:far-light", "builtin:far-light", HD),
];

fn lists(bench: &mut Bench<'_>) -> Result<Finding> {
    let mut settings =
        vec![SPONZA, SPONZA.sized(UHD), ROBOTS.at(10.0), MUSEUM.at(2.0), BUILDING, ROOM, CITY, FOREST];
    settings.extend(HARD);
    let mut rows = Vec::new();
    let mut longest = 0;
    for setting in settings {
        let Some(setting) = bench.resolve(&setting) else { continue };
        let stats = bench.count(&setting, "ofts")?;
        let length = counter(&stats, "list_len_max");
        longest = longest.max(length);
        let [width, height] = setting.size;
        rows.push(vec![
            format!("{}, {width} x {height}", setting.name),
            grouped(length),
            grouped(counter(&stats, "list_len_mean")),
            grouped(counter(&stats, "sub_grids")),
            grouped(counter(&stats, "lists")),
        ]);
    }
    let mut body = table(&["list lengths", "longest", "mean", "sub-grids", "lists"], &rows);
    body += "\nA cell with more than 64 samples gets a grid of its own over the rectangle that they span, so no threshold has to fit the scene. Longer lists are \
             left only where samples coincide as seen from the light, so that no grid can part them. The last three scenes are made to put all samples \
             into one cell, or into two clumps, or to see them all from very far.\n";
    let ours = format!("the longest list anywhere has {longest} samples");
    Ok(Finding { verdict: Verdict::of(longest <= BOUND), ours, body })
}
