//! `rh-*`: a tree of cones over the shadow rays, through which the triangles are streamed in any order.
//!
//! Source: Olsson and Assarsson 2011, "Improved Ray Hierarchy Alias Free Shadows" (Chalmers, technical report 2011:09), all
//! seven variants of its table 1; it builds on the ray-space hierarchy of Roger, Assarsson, Holzschuch 2007. There is no
//! hierarchy over the scene: what is sorted and bounded are the rays, one a sample, that all start at the light. A cone
//! with its apex there, and the lengths of its shortest and longest ray, bound each node.
//!
//! 1. `order`: candidates are sorted by direction along a Hilbert curve, or stay in screen order (section 3.5).
//! 2. `build`: an implicit 4-ary tree, four neighbours at a time (3.1).
//! 3. `blockers`: triangles that are seen large go first; rays that they shadow leave the tree (3.4).
//! 4. `traverse`: each triangle descends where `node_test` cannot reject it (3.2); nodes that it covers are shadowed at
//!    once and dead for all others (3.3); queues are bounded (4.2).
//!
//! What we changed: the leaf is the shared exact test, so there is no bias, and `front_face_culling` (3.6) is only an
//! option. The cone tests are the paper's with the projection divided out; they are done in f64, four siblings at once, and keep a
//! derived margin (`triangle`), so that early accept cannot disagree with the leaf. A node also dies when several triangles
//! shadow it together (`done`). Traversal is breadth-first within a block of triangles, blocks in parallel.
//!
//! Cost: build O(N) after a radix sort; traversal O(T log N) plus the nodes that silhouettes cross, times the layers of
//! blockers without early accept; some 19 bytes a sample for nodes and 17 for rays.

mod blockers;
mod build;
mod cone;
mod debug;
mod done;
mod leaf_tests;
mod node_test;
mod options;
mod order;
#[cfg(test)]
mod tests;
mod traverse;
mod triangle;
mod tuning;
mod vector;

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

pub use options::{ConeTest, LeafKind, RayHierarchyOptions};

use super::debug::{check_view, complete};
use super::{DebugView, Method, Samples, Stats, StatsBuilder, check_input};
use crate::mask::{LIT, NONE, SHADOWED};
use crate::scene::{InputError, Triangle};
use blockers::Passes;
use build::Hierarchy;
use debug::Record;
use traverse::{Counts, Frame, Queues, traverse};

/// The ray hierarchy, in one of its variants.
#[derive(Debug)]
pub struct RayHierarchy {
    name: &'static str,
    options: RayHierarchyOptions,
    hierarchy: Hierarchy,
    keys: Vec<u64>,
    passes: Passes,
    queues: Vec<Queues>,
    /// One bit a sample: shadowed.
    shadowed: Vec<AtomicU64>,
}

impl RayHierarchy {
    /// A method that reports itself as `name`.
    pub fn new(name: &'static str, options: RayHierarchyOptions) -> RayHierarchy {
        RayHierarchy {
            name,
            options,
            hierarchy: Hierarchy::default(),
            keys: Vec::new(),
            passes: Passes::default(),
            queues: Vec::new(),
            shadowed: Vec::new(),
        }
    }

    fn order_rays(&mut self, samples: Samples<'_>, light: [f32; 3]) {
        let order = &mut self.hierarchy.order;
        if self.options.sorted {
            order::by_direction(samples.positions, light, &mut self.keys, order);
        } else {
            order::by_screen(samples, light, &mut self.keys, order);
        }
    }

    /// Brings the tree's answers back to the samples. Returns how many rays were shadowed.
    fn collect_shadows(&mut self) -> usize {
        self.hierarchy.done.hand_down();
        let h = &self.hierarchy;
        let shadowed = &self.shadowed;
        h.valid
            .par_iter()
            .with_min_len(256)
            .enumerate()
            .map(|(word, valid)| {
                let bits = h.done.rays(word) & valid;
                let mut left = bits;
                while left != 0 {
                    let sample = h.order[word * 64 + left.trailing_zeros() as usize] as usize;
                    shadowed[sample / 64].fetch_or(1 << (sample % 64), Relaxed);
                    left &= left - 1;
                }
                bits.count_ones() as usize
            })
            .sum()
    }

    /// Both passes, or the only one. `debug` sees each tree after its traversal.
    fn run(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        stats: &mut StatsBuilder,
        debug: Option<&mut dyn FnMut(&Hierarchy, &Record)>,
    ) {
        let options = self.options;
        self.shadowed.resize_with(samples.positions.len().div_ceil(64), AtomicU64::default);
        self.shadowed.par_iter_mut().for_each(|word| *word.get_mut() = 0);
        self.order_rays(samples, light);
        stats.stage(if options.sorted { "sort_rays" } else { "order_rays" });
        self.hierarchy.build(samples.positions, light);
        stats.stage("build_hierarchy");
        let rays = self.hierarchy.count;
        let (nodes, top) = (self.hierarchy.bytes(), self.hierarchy.top());

        let mut debug = debug;
        let mut pass = |this: &mut RayHierarchy, list: Option<&[u32]>| {
            if this.hierarchy.count == 0 {
                return Counts::default();
            }
            let record = debug.is_some().then(|| Record::new(&this.hierarchy));
            let frame = Frame {
                options: &options,
                hierarchy: &this.hierarchy,
                triangles,
                light,
                record: record.as_ref(),
            };
            let counts = traverse(&frame, list, &mut this.queues);
            if let (Some(debug), Some(record)) = (&mut debug, &record) {
                debug(&this.hierarchy, record);
            }
            counts
        };
        let mut counts;
        let (mut blockers, mut rebuilt, mut first) = (0, 0, 0);
        if options.two_pass && rays > 0 {
            let mean = self.hierarchy.mean_solid_angle(tuning::BLOCKER_LEVEL);
            let mut passes = std::mem::take(&mut self.passes);
            passes.choose(triangles, light, mean, &options);
            stats.stage("choose_blockers");
            counts = pass(self, Some(&passes.blockers));
            blockers = passes.blockers.len();
            stats.stage("traverse_blockers");
            first = self.collect_shadows();
            if first as f64 >= options.rebuild_share * rays as f64 {
                rebuilt = 1;
                self.hierarchy.drop_done(options.sorted);
                self.hierarchy.build(samples.positions, light);
                stats.stage("rebuild_hierarchy");
            }
            counts = counts.add(pass(self, Some(&passes.rest)));
            self.passes = passes;
        } else {
            counts = pass(self, None);
        }
        stats.stage("traverse");
        self.collect_shadows();

        for (name, bytes) in nodes {
            stats.bytes(name, bytes);
        }
        stats.bytes("keys", self.keys.len() * 8);
        stats.bytes("passes", self.passes.bytes());
        stats.bytes("queues", self.queues.iter().map(Queues::bytes).sum());
        stats.bytes("shadow_bits", self.shadowed.len() * 8);
        stats.counter("rays", rays as u64);
        if options.two_pass {
            stats.counter("blockers", blockers as u64);
            stats.counter("shadowed_by_blockers", first as u64);
            stats.counter("rebuilds", rebuilt);
        }
        counts.report(&options, top, stats);
    }
}

impl Method for RayHierarchy {
    fn name(&self) -> &'static str {
        self.name
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let mut stats = StatsBuilder::start(self.name, self.options.isa.resolved().name());
        check_input(triangles, samples, light, mask)?;
        stats.stage("check_input");
        self.run(triangles, samples, light, &mut stats, None);
        let shadowed = &self.shadowed;
        mask.par_iter_mut().zip(samples.positions).with_min_len(4096).enumerate().for_each(|(i, (m, p))| {
            *m = if p.iter().any(|v| v.is_nan()) {
                NONE
            } else if shadowed[i / 64].load(Relaxed) >> (i % 64) & 1 == 1 {
                SHADOWED
            } else {
                LIT
            };
        });
        stats.stage("write_mask");
        Ok(stats.finish(triangles.len(), mask))
    }

    fn debug_views(&self) -> &'static [DebugView] {
        debug::VIEWS
    }

    fn debug_view(
        &mut self,
        view: &str,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
    ) -> Result<Option<Vec<f32>>, InputError> {
        if !check_view(debug::VIEWS, view, triangles, samples, light)? {
            return Ok(None);
        }
        let mut out = vec![f32::NAN; samples.positions.len()];
        let mut first = true;
        let mut see = |hierarchy: &Hierarchy, record: &Record| {
            match view {
                "visits" => record.add_visits(hierarchy, &mut out),
                "accept-level" => record.note_accepts(hierarchy, &mut out),
                // The first tree holds all rays.
                "spread" if first => debug::spread(hierarchy, &mut out),
                "cone" if first => debug::cones(hierarchy, &mut out),
                _ => {}
            }
            first = false;
        };
        let mut stats = StatsBuilder::start(self.name, "");
        self.run(triangles, samples, light, &mut stats, Some(&mut see));
        Ok(Some(complete(out, samples.positions)))
    }
}
