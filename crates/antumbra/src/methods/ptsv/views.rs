//! Pictures of the work: a second run with counters at every node.

use std::sync::atomic::Ordering::Relaxed;

use super::engine::Engine;
use super::tree::Tree;
use super::walk::Visits;
use crate::methods::debug::{check_view, complete, group};
use crate::methods::{DebugView, Samples, StatsBuilder};
use crate::scene::{InputError, Triangle};

const VISITS: DebugView = DebugView::amount(
    "visits",
    "tests of the sample, and its share of the box tests: those of a node are divided among the samples below it",
);
const LEVEL: DebugView = DebugView::label(
    "level",
    "height of the highest node above the sample that is in shadow as a whole: 1 if single tests decided, 0 if it is lit",
);

/// Of `ptsv`.
pub(crate) const PTSV: &[DebugView] = &[
    VISITS,
    LEVEL,
    DebugView::label(
        "tile",
        "the tile of 8 x 4 pixels that the sample is in; numbers only tell neighbours apart",
    ),
];

/// Of `cptsv`.
pub(crate) const CPTSV: &[DebugView] = &[
    VISITS,
    LEVEL,
    DebugView::label("cluster", "the cluster that the sample is in; numbers only tell neighbours apart"),
    DebugView::amount(
        "clusters",
        "clusters, that is occupied depth slices, of the sample's tile of 8 x 8 pixels",
    ),
];

/// One number a sample; `None` for an unknown view.
pub(crate) fn draw(
    engine: &mut Engine,
    views: &[DebugView],
    view: &str,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> Result<Option<Vec<f32>>, InputError> {
    if !check_view(views, view, triangles, samples, light)? {
        return Ok(None);
    }
    super::check_count(triangles)?;
    engine.build(samples, &mut StatsBuilder::start("", ""));
    let visits = Visits::new(&engine.tree);
    engine.traverse(triangles, light, Some(&visits));
    let tree = &engine.tree;
    let below = samples_below(tree);
    // Of a leaf, up to the root: visits (box tests would else be the same for all, as every triangle starts at the root),
    // and the highest node that is shadowed as a whole.
    let along = |leaf: u32| {
        let mut node = leaf as usize;
        let mut sum = f64::from(visits.leaves[node].load(Relaxed));
        let mut level = 0;
        let mut parent = tree.leaves[node].parent as usize;
        for (height, l) in tree.levels.iter().enumerate() {
            sum += f64::from(visits.groups[height][parent].load(Relaxed)) / below[height][parent];
            if l.words[parent].load(Relaxed) >> (node as u32 - l.groups[parent].first_child) & 1 == 1 {
                level = height + 2;
            }
            (node, parent) = (parent, l.groups[parent].parent as usize);
        }
        (sum, level)
    };
    let clusters = leaves_of_tiles(engine);
    let mut out = vec![f32::NAN; samples.positions.len()];
    let mut scratch = Vec::new();
    engine.expand(&mut out, &mut scratch, f32::NAN, |leaf, slot| match view {
        "visits" => along(leaf).0 as f32,
        // A node is also complete when leaf tests or smaller nodes completed it one by one.
        "level" => match along(leaf).1 {
            0 => (tree.leaf_words[leaf as usize].load(Relaxed) >> slot & 1) as f32,
            level => level as f32,
        },
        "clusters" => clusters[leaf as usize],
        _ => group(leaf as usize),
    });
    Ok(Some(complete(out, samples.positions)))
}

/// By level and group: samples below it.
fn samples_below(tree: &Tree) -> Vec<Vec<f64>> {
    let mut below: Vec<Vec<f64>> = tree.levels.iter().map(|l| vec![0.0; l.groups.len()]).collect();
    for leaf in &tree.leaves {
        let mut parent = leaf.parent as usize;
        for (below, level) in below.iter_mut().zip(&tree.levels) {
            below[parent] += f64::from(leaf.count);
            parent = level.groups[parent].parent as usize;
        }
    }
    below
}

/// By leaf: how many leaves its tile has.
fn leaves_of_tiles(engine: &Engine) -> Vec<f32> {
    let mut counts = vec![0.0; engine.tree.leaves.len()];
    for band in &engine.bands {
        let mut first = 0;
        for &end in &band.ends {
            let records = &band.records[first as usize..end as usize];
            records.iter().for_each(|r| counts[r.leaf as usize] = records.len() as f32);
            first = end;
        }
    }
    counts
}
