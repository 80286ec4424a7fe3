//! Pictures of the work: a second run with counters at every node.

use std::sync::atomic::Ordering::Relaxed;

use super::engine::Engine;
use super::walk::Visits;
use crate::methods::{Samples, StatsBuilder, check_input};
use crate::scene::{InputError, Triangle};

pub(crate) const NAMES: &[&str] = &["visits", "level", "tile"];

/// One number a sample; `None` for an unknown view.
pub(crate) fn draw(
    engine: &mut Engine,
    view: &str,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> Result<Option<Vec<f32>>, InputError> {
    if !NAMES.contains(&view) {
        return Ok(None);
    }
    check_input(triangles, samples, light, &vec![0; samples.positions.len()])?;
    super::check_count(triangles)?;
    engine.build(samples, &mut StatsBuilder::start("", ""));
    let visits = Visits::new(&engine.tree);
    engine.traverse(triangles, light, Some(&visits));
    let tree = &engine.tree;
    // Of a leaf, from the root down: sums of visits, and the highest node that is shadowed as a whole.
    let along = |leaf: u32| {
        let mut node = leaf as usize;
        let mut sum = u64::from(visits.leaves[node].load(Relaxed));
        let mut level = 0;
        let mut parent = tree.leaves[node].parent as usize;
        for (height, l) in tree.levels.iter().enumerate() {
            sum += u64::from(visits.groups[height][parent].load(Relaxed));
            if l.words[parent].load(Relaxed) >> (node as u32 - l.groups[parent].first_child) & 1 == 1 {
                level = height + 2;
            }
            (node, parent) = (parent, l.groups[parent].parent as usize);
        }
        (sum, level)
    };
    let mut out = vec![f32::NAN; samples.positions.len()];
    let mut scratch = Vec::new();
    engine.expand(&mut out, &mut scratch, f32::NAN, |leaf, slot| match view {
        "visits" => along(leaf).0 as f32,
        // A node is also complete when leaf tests or smaller nodes completed it one by one.
        "level" => match along(leaf).1 {
            0 => (tree.leaf_words[leaf as usize].load(Relaxed) >> slot & 1) as f32,
            level => level as f32,
        },
        // Neighbours get far numbers (Fibonacci hashing), so that they can be told apart.
        _ => (leaf.wrapping_mul(0x9e37_79b9) >> 24) as f32,
    });
    Ok(Some(out))
}
