//! The stackless query of one sample (section 5.3): the way back is stored in the tree.

use super::build::Tree;
use super::node::{CAP, NONE, Node, ROUNDING, Sample, TINY};
use super::query::Counts;
use crate::scene::Triangle;

/// May the crossing subtree of shadow plane k hold a triangle that blocks the sample?
///
/// If it does, the sample's true direction lies in that triangle's cone, so `|ν·P| <= wedge |P|`. The value computed is
/// off by at most 5 u `|q|₁` (sums, products, `q`), see `node.rs`.
#[inline(always)]
pub(super) fn in_wedge(node: &Node, k: usize, value: f32, sample: &Sample) -> bool {
    // NaN counts as "may".
    let beyond = value.abs() > node.wedge(k) * sample.length + (ROUNDING * sample.sum + TINY);
    !beyond
}

/// Is the sample inside plane k? Exact.
#[inline(always)]
pub(super) fn inside(
    node: &Node,
    k: usize,
    sample: &Sample,
    triangles: &[Triangle],
    light: [f32; 3],
    counts: &mut Counts,
) -> (bool, f32) {
    let (value, error) = node.value(k, sample.q, sample.sum);
    let inside = if value.abs() > error {
        counts.sure += 1;
        value > 0.0
    } else {
        counts.exact += 1;
        node.exactly_inside(k, triangles, light, sample.p)
    };
    (inside, value)
}

/// Does some triangle of the subtree at `top` block the sample?
///
/// A triangle's `back` is the last crossing link on its path. So when a walk ends at an empty link, all that is left to do
/// starts there: at the node and plane of `back`, whose crossing subtree is finished ("second visit"). The subtree is
/// finished when the walk would leave it, by the `back` that its top triangle has.
pub(super) fn shadowed(
    tree: &Tree,
    top: u32,
    sample: &Sample,
    triangles: &[Triangle],
    light: [f32; 3],
    counts: &mut Counts,
) -> bool {
    let stop = tree.nodes[top as usize].back();
    let (mut at, mut from, mut second) = (top, 0, false);
    loop {
        let node = &tree.nodes[at as usize];
        counts.nodes += 1;
        counts.sample_visits += u64::from(!second);
        let mut next = NONE;
        if !second && sample.length < node.nearest() {
            counts.depth_skips += 1;
        } else {
            for k in from..4 {
                let (inside, value) = inside(node, k, sample, triangles, light, counts);
                if k == CAP && inside {
                    return true;
                }
                let child = node.crossing(k);
                if child != NONE && !(second && k == from) {
                    if k == CAP || in_wedge(node, k, value, sample) {
                        next = child;
                        break;
                    }
                    counts.wedge_skips += 1;
                }
                if !inside {
                    next = node.outside(k);
                    break;
                }
            }
        }
        if next != NONE {
            (at, from, second) = (next, 0, false);
            continue;
        }
        let back = node.back();
        if back == stop {
            return false;
        }
        (at, from, second) = (back >> 2, (back & 3) as usize, true);
    }
}
