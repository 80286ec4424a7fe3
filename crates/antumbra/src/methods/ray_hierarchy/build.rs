//! The tree of cones over the rays: implicit, left-balanced, 4-ary (sections 3.1 and 3.5 of the paper).
//!
//! Level 0 are the rays themselves, in leaf order; node j of level k covers the leaves `j 4^k .. (j + 1) 4^k`. Siblings are stored
//! together as structure of arrays, so that one vector operation tests all four: group g of level k holds the children of node
//! g of level k + 1. The top level is the first with at most four nodes; the root above it is never tested, as testing its
//! children costs the same.

use rayon::prelude::*;

use super::cone::Cone;
use super::done::Done;
use super::order::EMPTY;

/// Four sibling cones; those that do not exist have a negative `max`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Group {
    pub(super) axis: [[f64; 4]; 3],
    pub(super) cos: [f64; 4],
    pub(super) sin: [f64; 4],
    pub(super) min: [f64; 4],
    pub(super) max: [f64; 4],
}

impl Group {
    #[inline(always)]
    pub(super) fn from_cones(cones: [Cone; 4]) -> Group {
        Group {
            axis: [0, 1, 2].map(|k| cones.map(|c| c.axis[k])),
            cos: cones.map(|c| c.cos),
            sin: cones.map(|c| c.sin),
            min: cones.map(|c| c.min),
            max: cones.map(|c| c.max),
        }
    }

    pub(super) fn cone(&self, i: usize) -> Cone {
        Cone {
            axis: [self.axis[0][i], self.axis[1][i], self.axis[2][i]],
            cos: self.cos[i],
            sin: self.sin[i],
            min: self.min[i],
            max: self.max[i],
        }
    }

    /// The cone around all four.
    #[inline(always)]
    fn parent(&self) -> Cone {
        Cone::around(&[0, 1, 2, 3].map(|i| self.cone(i)))
    }
}

/// Eight neighbouring rays' samples, as the leaf test takes them.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Eight(pub(super) [[f32; 8]; 3]);

/// Rays, cones, and what of them is done.
#[derive(Debug, Default)]
pub(super) struct Hierarchy {
    /// The sample of each leaf, or [`EMPTY`].
    pub(super) order: Vec<u32>,
    /// World coordinates of the leaves' samples.
    pub(super) rays: Vec<Eight>,
    /// One bit a leaf: there is a ray.
    pub(super) valid: Vec<u64>,
    /// `levels[k - 1]`: the groups of level k, as far as [`Hierarchy::top`].
    levels: Vec<Vec<Group>>,
    top: usize,
    /// Bits that traversal sets.
    pub(super) done: Done,
    /// Rays, without empty leaves.
    pub(super) count: usize,
}

/// Groups that one task of the build makes.
const CHUNK: usize = 1024;

impl Hierarchy {
    /// The level that traversal starts at.
    pub(super) fn top(&self) -> usize {
        self.top
    }

    /// The groups of a level.
    #[inline(always)]
    pub(super) fn level(&self, level: usize) -> &[Group] {
        &self.levels[level - 1]
    }

    /// Nodes of a level.
    #[inline(always)]
    pub(super) fn nodes(&self, level: usize) -> usize {
        self.order.len().div_ceil(1 << (2 * level))
    }

    /// Builds the tree over [`Hierarchy::order`], bottom up.
    pub(super) fn build(&mut self, positions: &[[f32; 3]], light: [f32; 3]) {
        let order = &self.order;
        let leaves = order.len();
        self.rays.resize(leaves.div_ceil(16) * 2, Eight::default());
        self.rays.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(block, eight)| {
            for lane in 0..8 {
                let sample = order.get(block * 8 + lane).copied().unwrap_or(EMPTY);
                let p = if sample == EMPTY { [0.0; 3] } else { positions[sample as usize] };
                for k in 0..3 {
                    eight.0[k][lane] = p[k];
                }
            }
        });
        self.valid.resize(leaves.div_ceil(64), 0);
        self.valid.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(word, bits)| {
            let run = &order[word * 64..leaves.min(word * 64 + 64)];
            *bits = run.iter().enumerate().fold(0, |b, (i, s)| b | u64::from(*s != EMPTY) << i);
        });
        self.count = self.valid.par_iter().with_min_len(CHUNK).map(|w| w.count_ones() as usize).sum();
        self.done.reset(&self.valid);

        let mut level = 1;
        loop {
            let nodes = leaves.div_ceil(1 << (2 * level));
            if self.levels.len() < level {
                self.levels.push(Vec::new());
            }
            let empty = Group::from_cones([Cone::EMPTY; 4]);
            let (below, rest) = self.levels.split_at_mut(level - 1);
            let groups = &mut rest[0];
            groups.resize(nodes.div_ceil(4), empty);
            if let Some(below) = below.last() {
                groups.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(g, group)| {
                    let parent = |i: usize| below.get(4 * g + i).map_or(Cone::EMPTY, Group::parent);
                    *group = Group::from_cones([0, 1, 2, 3].map(parent));
                });
            } else {
                let (rays, valid) = (&self.rays, &self.valid);
                groups.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(g, group)| {
                    let ray = |leaf: usize| {
                        if valid.get(leaf / 64).is_none_or(|w| w >> (leaf % 64) & 1 == 0) {
                            return Cone::EMPTY;
                        }
                        let eight = &rays[leaf / 8].0;
                        Cone::ray([0, 1, 2].map(|k| eight[k][leaf % 8]), light)
                    };
                    let node = |i: usize| {
                        let first = 16 * g + 4 * i;
                        Cone::around(&[0, 1, 2, 3].map(|j| ray(first + j)))
                    };
                    *group = Group::from_cones([0, 1, 2, 3].map(node));
                });
            }
            if nodes <= 4 {
                break;
            }
            level += 1;
        }
        self.top = level;
    }

    /// Takes the rays that are done out of [`Hierarchy::order`]. Sorted leaves close ranks in the same order; unsorted ones stay
    /// where they are, as empty leaves, so that quads stay quads. Call [`Done::hand_down`] first.
    pub(super) fn drop_done(&mut self, compact: bool) {
        let done = &self.done;
        self.order.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(leaf, sample)| {
            if done.rays(leaf / 64) >> (leaf % 64) & 1 == 1 {
                *sample = EMPTY;
            }
        });
        if compact {
            self.order.retain(|sample| *sample != EMPTY);
        }
    }

    /// Mean solid angle of the nodes of a level that hold rays.
    pub(super) fn mean_solid_angle(&self, level: usize) -> f64 {
        let (sum, count) = self
            .level(level.clamp(1, self.top))
            .iter()
            .flat_map(|g| (0..4).map(|i| g.cone(i)))
            .filter(|c| !c.is_empty())
            // 2 π (1 - cos α), without the cancellation for small α.
            .map(|c| if c.cos > 0.0 { c.sin * c.sin / (1.0 + c.cos) } else { 1.0 - c.cos })
            .fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
        if count == 0 { 0.0 } else { std::f64::consts::TAU * sum / f64::from(count) }
    }

    pub(super) fn bytes(&self) -> [(&'static str, usize); 3] {
        let groups: usize = self.levels[..self.top].iter().map(Vec::len).sum();
        [
            ("rays", self.order.len() * 4 + self.rays.len() * size_of::<Eight>() + self.valid.len() * 8),
            ("nodes", groups * size_of::<Group>()),
            ("done_bits", self.done.bytes()),
        ]
    }
}
