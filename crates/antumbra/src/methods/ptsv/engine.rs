//! The pipeline that PTSV and CPTSV share: tiles, tree, walks, merge, mask.

use std::sync::atomic::Ordering::Relaxed;

use rayon::prelude::*;

use super::space::{Space, V3, wide};
use super::tiles::{Band, Item, Plan, Slices, Tiling, collect, order};
use super::tree::Tree;
use super::tuning::Tuning;
use super::walk::{Counts, Frame, Job, Visits, walk_all};
use crate::Isa;
use crate::bvh::Bounds;
use crate::bvh::build::morton;
use crate::mask::{LIT, NONE, SHADOWED};
use crate::methods::{Samples, StatsBuilder};
use crate::scene::Triangle;

/// In what the two methods differ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Pixels of the lowest tile, at most 64 in all.
    pub(crate) tile: [usize; 2],
    /// Cut tiles into depth slices, and order the tree by depth too.
    pub(crate) clusters: bool,
}

/// Scratch memory of a method.
#[derive(Debug)]
pub(crate) struct Engine {
    pub(crate) shape: Shape,
    pub(crate) isa: Isa,
    pub(crate) tuning: Tuning,
    pub(crate) space: Space,
    residual: V3,
    pub(crate) tiling: Tiling,
    pub(crate) bands: Vec<Band>,
    items: Vec<Item>,
    /// Bits of x, y and slice in an interleaved key.
    pub(crate) key_bits: [u32; 3],
    pub(crate) tree: Tree,
    jobs: Vec<Job>,
    list: Vec<Item>,
    sorted: Vec<[f32; 3]>,
    sorted_mask: Vec<u8>,
}

impl Engine {
    pub(crate) fn new(shape: Shape, isa: Isa, tuning: Tuning) -> Engine {
        Engine {
            shape,
            isa,
            tuning,
            space: Space::default(),
            residual: [0.0; 3],
            tiling: Tiling::Runs { length: 1 },
            bands: Vec::new(),
            items: Vec::new(),
            key_bits: [0; 3],
            tree: Tree::default(),
            jobs: Vec::new(),
            list: Vec::new(),
            sorted: Vec::new(),
            sorted_mask: Vec::new(),
        }
    }

    /// Fills the mask. Input has been checked.
    pub(crate) fn run(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
        stats: &mut StatsBuilder,
    ) {
        self.build(samples, stats);
        let counts = self.traverse(triangles, light, None);
        stats.stage("traverse");
        self.tree.merge();
        stats.stage("merge");
        self.write_mask(mask);
        stats.stage("write_mask");
        self.report(&counts, stats);
    }

    /// Collects tiles, or sorted runs, and builds the tree.
    pub(crate) fn build(&mut self, samples: Samples<'_>, stats: &mut StatsBuilder) {
        let positions = samples.positions;
        let bounds = bounds(positions);
        // A list has no neighbourhood of its own; clusters without a camera are made of quantised positions.
        let is_list = samples.width >= positions.len()
            || !positions.len().is_multiple_of(samples.width.max(1))
            || (self.shape.clusters && samples.view.is_none());
        let [w, h] = self.shape.tile;
        self.tiling = if is_list {
            Tiling::Runs { length: w * h }
        } else {
            Tiling::Picture { width: samples.width.max(1), tile: [w, h] }
        };
        self.list.clear();
        let mut sorted = std::mem::take(&mut self.sorted);
        let positions = if is_list {
            self.sort_list(positions, &bounds, &mut sorted);
            stats.stage("sort_samples");
            &sorted[..]
        } else {
            positions
        };
        self.collect_tiles(positions, samples, &bounds);
        stats.stage("collect_tiles");
        let sliced = self.shape.clusters && !is_list;
        self.key_bits = order(&self.bands, self.tiling, sliced, &mut self.items);
        self.tree.build(&self.items, &mut self.bands, positions, self.tiling);
        stats.stage("build_hierarchy");
        self.sorted = sorted;
    }

    /// In clip space if all samples have a place there, else in the world.
    fn collect_tiles(&mut self, positions: &[[f32; 3]], samples: Samples<'_>, bounds: &Bounds) {
        let (isa, tiling) = (self.isa, self.tiling);
        if let Some(view) = samples.view {
            self.space = Space::clip(view);
            let rows = positions.len().div_ceil(tiling.band().max(1));
            let is_picture = matches!(tiling, Tiling::Picture { .. });
            let slices = (self.shape.clusters && is_picture).then(|| Slices::new(view, rows));
            let plan = Plan { isa, tiling, slices, space: &self.space };
            if let Some(residual) = collect(&mut self.bands, positions, &plan) {
                self.residual = residual;
                return;
            }
        }
        let middle = [0, 1, 2].map(|k| bounds.lo[k] * 0.5 + bounds.hi[k] * 0.5);
        let origin = if middle.iter().all(|v| v.is_finite()) { middle } else { [0.0; 3] };
        self.space = Space::World { origin: wide(origin) };
        let plan = Plan { isa, tiling, slices: None, space: &self.space };
        // Every sample has a place in the world.
        self.residual = collect(&mut self.bands, positions, &plan).unwrap_or([f64::INFINITY; 3]);
    }

    pub(crate) fn traverse(
        &mut self,
        triangles: &[Triangle],
        light: [f32; 3],
        visits: Option<&Visits>,
    ) -> Counts {
        let frame = Frame {
            tree: &self.tree,
            triangles,
            light,
            space: &self.space,
            residual: self.residual,
            // Without an eye there are no eye planes: these take their place.
            wedges: self.shape.clusters || self.space.eye().is_none(),
            tuning: self.tuning,
            visits,
        };
        walk_all(self.isa, &frame, &mut self.jobs)
    }

    /// Puts the samples of a list into Morton order, background left out.
    fn sort_list(&mut self, positions: &[[f32; 3]], bounds: &Bounds, sorted: &mut Vec<[f32; 3]>) {
        use rdst::RadixSort;
        let scale = [0, 1, 2].map(|k| {
            let s = 1024.0 / (bounds.hi[k] - bounds.lo[k]);
            if s.is_finite() { s } else { 0.0 }
        });
        let all = positions.par_iter().enumerate().filter(|(_, p)| !p.iter().any(|v| v.is_nan()));
        self.list.par_extend(all.map(|(i, p)| {
            let code = morton([0, 1, 2].map(|k| (p[k] - bounds.lo[k]) * scale[k]));
            Item { key: u64::from(code), record: i as u32, ..Item::default() }
        }));
        self.list.radix_sort_unstable();
        sorted.clear();
        sorted.par_extend(self.list.par_iter().map(|item| positions[item.record as usize]));
    }

    /// Expands the shadow bits of the leaves.
    pub(crate) fn write_mask(&mut self, mask: &mut [u8]) {
        let words = &self.tree.leaf_words;
        let value = |leaf: u32, slot: u32| {
            let bit = words[leaf as usize].load(Relaxed) >> slot & 1;
            if bit == 1 { SHADOWED } else { LIT }
        };
        let mut scratch = std::mem::take(&mut self.sorted_mask);
        self.expand(mask, &mut scratch, NONE, value);
        self.sorted_mask = scratch;
    }

    /// Writes `value(leaf, slot)` for every sample, `none` where there is none.
    pub(crate) fn expand<T: Copy + Send + Sync>(
        &self,
        out: &mut [T],
        scratch: &mut Vec<T>,
        none: T,
        value: impl Fn(u32, u32) -> T + Sync,
    ) {
        if let Tiling::Picture { .. } = self.tiling {
            self.expand_bands(out, none, value);
            return;
        }
        scratch.resize(self.list.len(), none);
        self.expand_bands(scratch, none, value);
        out.fill(none);
        for (item, v) in self.list.iter().zip(scratch) {
            out[item.record as usize] = *v;
        }
    }

    fn expand_bands<T: Copy + Send + Sync>(
        &self,
        out: &mut [T],
        none: T,
        value: impl Fn(u32, u32) -> T + Sync,
    ) {
        let tiling = self.tiling;
        out.par_chunks_mut(tiling.band()).zip(&self.bands).for_each(|(out, band)| {
            out.fill(none);
            let len = out.len();
            let mut first = 0;
            for (tile, &end) in band.ends.iter().enumerate() {
                for r in &band.records[first as usize..end as usize] {
                    let mut slot = 0;
                    tiling.for_each(len, tile, |bit, index| {
                        if r.mask >> bit & 1 == 1 {
                            out[index] = value(r.leaf, slot);
                            slot += 1;
                        }
                    });
                }
                first = end;
            }
        });
    }

    /// Bytes by buffer and counters.
    pub(crate) fn report(&self, counts: &Counts, stats: &mut StatsBuilder) {
        let [nodes, words, positions] = self.tree.bytes();
        stats.bytes("nodes", nodes);
        stats.bytes("shadow_bits", words);
        stats.bytes("positions", positions);
        let records: usize =
            self.bands.iter().map(|b| size_of_val(&b.records[..]) + size_of_val(&b.ends[..])).sum();
        stats.bytes("tiles", records + size_of_val(&self.items[..]));
        stats.bytes("sorted_list", self.list.len() * (size_of::<Item>() + size_of::<[f32; 3]>() + 1));
        stats.bytes("queue", self.jobs.capacity() * size_of::<Job>());
        stats.counter("levels", self.tree.levels.len() as u64);
        stats.counter("nodes", self.tree.nodes() as u64);
        stats.counter("leaves", self.tree.leaves.len() as u64);
        counts.report(stats);
    }
}

/// Of all samples that are there.
fn bounds(positions: &[[f32; 3]]) -> Bounds {
    positions
        .par_iter()
        .with_min_len(4096)
        .filter(|p| !p.iter().any(|v| v.is_nan()))
        .fold(
            || Bounds::EMPTY,
            |mut b, p| {
                b.add(*p);
                b
            },
        )
        .reduce(|| Bounds::EMPTY, Bounds::union)
}
