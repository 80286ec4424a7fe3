//! Pictures of the work: one number a sample.

use rayon::prelude::*;

use super::build::Tree;
use super::node::{CAP, NONE, Sample};
use super::query::Counts;
use super::stackless::{in_wedge, inside};
use crate::methods::{DebugView, Samples};
use crate::scene::Triangle;

pub(super) const VIEWS: &[DebugView] = &[
    DebugView::amount("visits", "triangles of the tree that the sample visits until it is in shadow or done"),
    DebugView::label(
        "depth",
        "depth in the tree of the triangle that blocks the sample; 0 if none of the tree does",
    ),
    DebugView::amount("exact", "signs that the sample takes to exact arithmetic"),
];

/// One number a sample, each alone with a stack of its own.
pub(super) fn draw(
    tree: &Tree,
    view: &str,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> Vec<f32> {
    let look = |p: &[f32; 3]| {
        if p.iter().any(|v| v.is_nan()) {
            return f32::NAN;
        }
        let (visits, depth, exact) = walk(tree, &Sample::new(*p, light), triangles, light);
        let number = match view {
            "visits" => visits,
            "depth" => depth,
            _ => exact,
        };
        number as f32
    };
    samples.positions.par_iter().map(look).collect()
}

/// Visits, depth of the blocker, exact signs of one sample.
fn walk(tree: &Tree, sample: &Sample, triangles: &[Triangle], light: [f32; 3]) -> (u64, u64, u64) {
    let mut counts = Counts::default();
    let mut stack: Vec<(u32, u64)> = tree.root().map(|root| (root, 1)).into_iter().collect();
    while let Some((at, depth)) = stack.pop() {
        let node = &tree.nodes[at as usize];
        counts.nodes += 1;
        if sample.length < node.nearest() {
            continue;
        }
        for k in 0..4 {
            let (inside, value) = inside(node, k, sample, triangles, light, &mut counts);
            if k == CAP && inside {
                return (counts.nodes, depth, counts.exact);
            }
            let crossing = node.crossing(k);
            if crossing != NONE && (k == CAP || in_wedge(node, k, value, sample)) {
                stack.push((crossing, depth + 1));
            }
            if !inside {
                let child = node.outside(k);
                if child != NONE {
                    stack.push((child, depth + 1));
                }
                break;
            }
        }
    }
    (counts.nodes, 0, counts.exact)
}
