//! Pictures of the work: one number a sample.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::build::Hierarchy;
use super::order::EMPTY;
use crate::methods::DebugView;
use crate::methods::debug::group;

pub(super) const VIEWS: &[DebugView] = &[
    DebugView::amount(
        "visits",
        "the sample's share of the triangles tested against nodes: those of a node are divided among the rays below it",
    ),
    DebugView::label(
        "accept-level",
        "level of the highest node above the sample that one triangle covered, 0 if none was",
    ),
    DebugView::label("cone", "the cone of 64 rays that the sample is in; numbers only tell neighbours apart"),
    DebugView::amount("spread", "half angle, in degrees, of the cone of 64 rays that the sample is in"),
];

/// Level of the nodes of 64 rays.
const CONE_LEVEL: usize = 3;

/// What a traversal did at each node.
#[derive(Debug)]
pub(super) struct Record {
    /// By level (0 unused) and node: triangles that tested it, and whether one of them covered it.
    nodes: Vec<Vec<(AtomicU32, AtomicU32)>>,
}

impl Record {
    pub(super) fn new(hierarchy: &Hierarchy) -> Record {
        let level = |k: usize| {
            let mut nodes = Vec::new();
            nodes.resize_with(if k == 0 { 0 } else { hierarchy.nodes(k) }, Default::default);
            nodes
        };
        Record { nodes: (0..=hierarchy.top()).map(level).collect() }
    }

    /// Siblings `mask` of a group were tested.
    pub(super) fn visit(&self, level: usize, group: usize, mask: u8) {
        self.each(level, group, mask, |node| {
            node.0.fetch_add(1, Relaxed);
        });
    }

    /// Siblings `mask` of a group were covered.
    pub(super) fn accept(&self, level: usize, group: usize, mask: u8) {
        self.each(level, group, mask, |node| node.1.store(1, Relaxed));
    }

    fn each(&self, level: usize, group: usize, mask: u8, mut f: impl FnMut(&(AtomicU32, AtomicU32))) {
        (0..4).filter(|i| mask >> i & 1 == 1).for_each(|i| f(&self.nodes[level][4 * group + i]));
    }

    /// Adds to each ray's sample its share of the visits of the nodes above it. (The visits themselves are nearly the same
    /// for all: every triangle starts at the top.)
    pub(super) fn add_visits(&self, hierarchy: &Hierarchy, out: &mut [f32]) {
        for_each_ray(hierarchy, |leaf, sample| {
            let share = |k: usize| {
                let rays = (1u64 << (2 * k)).min(hierarchy.count as u64);
                f64::from(self.nodes[k][leaf >> (2 * k)].0.load(Relaxed)) / rays as f64
            };
            let sum: f64 = (1..self.nodes.len()).map(share).sum();
            out[sample] = sum as f32 + if out[sample].is_nan() { 0.0 } else { out[sample] };
        });
    }

    /// Notes for each ray's sample the highest level at which a node above it was covered.
    pub(super) fn note_accepts(&self, hierarchy: &Hierarchy, out: &mut [f32]) {
        for_each_ray(hierarchy, |leaf, sample| {
            let covered = |k: &usize| self.nodes[*k][leaf >> (2 * k)].1.load(Relaxed) == 1;
            let level = (1..self.nodes.len()).rev().find(covered).unwrap_or(0) as f32;
            out[sample] = level.max(out[sample]);
        });
    }
}

/// The half angle, in degrees, of the cone of 64 rays (or fewer, in a small tree) that each sample is in.
pub(super) fn spread(hierarchy: &Hierarchy, out: &mut [f32]) {
    let level = hierarchy.top().min(CONE_LEVEL);
    for_each_ray(hierarchy, |leaf, sample| {
        let node = leaf >> (2 * level);
        let cone = hierarchy.level(level)[node / 4].cone(node % 4);
        out[sample] = cone.sin.atan2(cone.cos).to_degrees() as f32;
    });
}

/// A number for that cone.
pub(super) fn cones(hierarchy: &Hierarchy, out: &mut [f32]) {
    let level = hierarchy.top().min(CONE_LEVEL);
    for_each_ray(hierarchy, |leaf, sample| out[sample] = group(leaf >> (2 * level)));
}

fn for_each_ray(hierarchy: &Hierarchy, mut f: impl FnMut(usize, usize)) {
    for (leaf, &sample) in hierarchy.order.iter().enumerate() {
        if sample != EMPTY {
            f(leaf, sample as usize);
        }
    }
}
