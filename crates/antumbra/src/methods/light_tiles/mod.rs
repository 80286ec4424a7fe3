//! `light-tiles`: samples in tiles around the light, triangles streamed through them. Nothing is kept between frames.
//!
//! Ours. It descends from the irregular z-buffer (Johnson et al. 2005; `ofts`) and from tiled rasterisation, with what
//! exactness needs.
//!
//! 1. [`grid`]: cells of directions around the light are gathered to tiles of some 3,000 to 12,000 samples each, fewer where samples are few.
//!    [`sight`]: where a far light sees all samples in almost one direction, directions are measured from a point among them.
//!    [`sparse`]: where few triangles are near many samples in no order, there is one tile for all.
//! 2. [`leaves`]: blocks of 8 x 4 pixels become leaves of tiles ([`leaf`]), with bounds of directions and nearness; [`parts`]: some are parted.
//! 3. [`bin`]: each triangle is seen from the light ([`project`]) and goes to the lists of the tiles that it may shadow; large ones descend a tree over the tiles.
//! 4. [`work`]: tile by tile, [`chunk`]: eight blocks of eight of a tile's triangles at a time,
//! 5. [`pairs`]: blocks are tested against the leaves, then their triangles, then sample by sample; [`state`] is what is known of the samples.
//!
//! All culling is interval arithmetic with the bounds of `antumbra_predicates::tile`; samples are decided by the shared
//! leaf test, f64 and exact arithmetic.
//!
//! Cost: O(N) for the samples; O(T) for the triangles plus the tiles they touch; then leaves times the triangles near them.

mod bin;
mod boxes;
mod chunk;
mod debug;
mod descend;
mod frame;
mod grid;
mod layout;
mod leaf;
mod leaves;
mod lists;
mod order;
mod pairs;
mod parts;
mod prefetch;
mod project;
mod shuffle;
mod sight;
mod sparse;
mod state;
#[cfg(test)]
mod tests;
mod tuning;
mod work;

use std::iter::Enumerate;
use std::slice::ChunksMut;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

use fearless_simd::dispatch;
use rayon::prelude::*;

use self::frame::FACES;
use self::grid::{Point, Tiles};
use self::layout::{BLOCK, Layout};
use self::sight::Sights;
use self::sparse::Crowds;
use self::tuning::{EVERY, WIDE};
use super::{DebugView, Method, Options, RayCast, Samples, Stats, StatsBuilder, check_input, simd_level};
use crate::Isa;
use crate::mask::{LIT, SHADOWED};
use crate::scene::{InputError, Triangle};
use antumbra_predicates::tile::Region;

/// Shadows by tiles of samples around the light.
#[derive(Debug)]
pub struct LightTiles {
    isa: Isa,
    capacity: usize,
    tiles: Tiles,
    points: Vec<Point>,
    crowds: Crowds,
    gathered: Vec<leaves::Gathered>,
    binned: Vec<bin::Binned>,
    scratch: Vec<work::Scratch>,
    /// One word a block: samples in shadow after the rounds before, if there are several.
    words: Vec<u32>,
    covered: Vec<AtomicBool>,
    wild: Wild,
}

/// Samples that have no direction in f32: rays take them.
#[derive(Debug)]
struct Wild {
    rays: RayCast,
    slots: Vec<u32>,
    positions: Vec<[f32; 3]>,
    mask: Vec<u8>,
}

/// List entries that all workers together may hold before the tiles are worked off: 512 MiB.
const CAPACITY: usize = 1 << 26;

impl LightTiles {
    /// With room for 67 million list entries.
    pub fn new(options: &Options) -> LightTiles {
        LightTiles::with_capacity(options, CAPACITY)
    }

    /// With room for about `entries` list entries of 8 bytes (a triangle in a tile is one; several of eight that follow one another, with their bounds, are two); what does not fit is done in rounds.
    pub fn with_capacity(options: &Options, entries: usize) -> LightTiles {
        LightTiles {
            isa: options.isa,
            capacity: entries,
            tiles: Tiles::default(),
            points: Vec::new(),
            crowds: Crowds::default(),
            gathered: Vec::new(),
            binned: Vec::new(),
            scratch: Vec::new(),
            words: Vec::new(),
            covered: Vec::new(),
            wild: Wild {
                rays: RayCast::new(options),
                slots: Vec::new(),
                positions: Vec::new(),
                mask: Vec::new(),
            },
        }
    }
}

impl Method for LightTiles {
    fn name(&self) -> &'static str {
        "light-tiles"
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let isa = self.isa.resolved();
        let mut stats = StatsBuilder::start("light-tiles", isa.name());
        if mask.len() != samples.positions.len() || !light.iter().all(|v| v.is_finite()) {
            check_input(triangles, samples, light, mask)?;
        }
        let limit = 1 << 31;
        for (what, got) in [("triangles", triangles.len()), ("samples", samples.positions.len())] {
            if got > limit {
                return Err(InputError::TooMany { what, got, limit });
            }
        }
        let positions = samples.positions;
        let layout = Layout::new(positions.len(), samples.width);
        let workers = rayon::current_num_threads();
        self.gathered.resize_with(workers, Default::default);
        self.binned.resize_with(workers, Default::default);
        self.scratch.resize_with(workers, Default::default);

        let margin = if triangles.len() <= positions.len() / WIDE { 2 } else { 1 };
        let (band, filled) = self.choose_tiles(isa, &layout, positions, light, triangles, margin, mask);
        stats.stage("choose_tiles");
        self.gather(isa, &layout, positions, light, band, filled, mask);
        stats.stage("gather_samples");
        let mut rounds = 0u64;
        let next_triangle = AtomicUsize::new(0);
        for worker in &mut self.binned {
            worker.left = 0..0;
            worker.counts = bin::Counts::default();
            worker.broken = false;
        }
        for worker in &mut self.scratch {
            worker.counts = work::Counts::default();
        }
        let mut entries = 0;
        let mut peak = 0;
        while rounds == 0
            || next_triangle.load(Relaxed) < triangles.len()
            || self.binned.iter().any(|w| !w.left.is_empty())
        {
            rounds += 1;
            self.bin(isa, triangles, light, &next_triangle);
            stats.stage("bin_triangles");
            self.work(isa, &layout, positions, triangles, light, rounds > 1);
            stats.stage("test_tiles");
            let now: usize = self.binned.iter().map(bin::Binned::entries).sum();
            entries += now;
            peak = peak.max(self.binned.iter().map(|w| w.ids.bytes() + w.eights.bytes()).sum());
        }
        if self.gathered.iter().any(|w| w.broken) || self.binned.iter().any(|w| w.broken) {
            check_input(triangles, samples, light, mask)?;
        }
        self.wild_samples(&layout, positions, triangles, light)?;
        self.write(&layout, mask);
        stats.stage("write_mask");
        self.report(&mut stats, rounds, entries, peak);
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
        debug::draw(self, view, triangles, samples, light)
    }
}

impl LightTiles {
    /// Stage 1: chooses tiles, and fills rows of blocks of the mask with "lit" meanwhile. Returns the depth band of each face, and how many
    /// rows were filled.
    fn choose_tiles(
        &mut self,
        isa: Isa,
        layout: &Layout,
        positions: &[[f32; 3]],
        light: [f32; 3],
        triangles: &[Triangle],
        margin: u32,
        mask: &mut [u8],
    ) -> ([f32; FACES], usize) {
        let columns = layout.columns;
        self.points.resize(columns * layout.rows.div_ceil(EVERY), Point::NONE);
        self.tiles.sights = Sights::new(light, positions);
        let sights = &self.tiles.sights;
        let empty = ([Region::EMPTY; FACES], [0; FACES]);
        let (bounds, counts) = self
            .points
            .par_chunks_mut(columns.max(1))
            .enumerate()
            .map(|(row, points)| leaves::look(layout, positions, light, sights, EVERY * row, points))
            .reduce(
                || empty,
                |(a, m), (b, n)| {
                    (std::array::from_fn(|f| a[f].union(&b[f])), std::array::from_fn(|f| m[f] + n[f]))
                },
            );
        let Self { tiles, points, crowds, .. } = self;
        for (sight, bounds) in tiles.sights.faces.iter_mut().zip(&bounds) {
            sight.bound(bounds);
        }
        tiles.count(points, &bounds, &counts, triangles.len(), margin);
        crowds.find(isa, tiles, points, columns, &bounds, triangles);
        // Choosing is serial; who has nothing to do does something useful meanwhile, and stays awake.
        let chosen = AtomicBool::new(false);
        let choose = || {
            tiles.choose(points);
            chosen.store(true, Relaxed);
        };
        let fill = || {
            let rows = mask.chunks_mut(layout.row_samples().max(1));
            rows.take_while(|_| !chosen.load(Relaxed)).map(|row| row.fill(LIT)).count()
        };
        let filled = rayon::join(choose, fill).1;
        let band =
            bounds.map(|b| if b.hi[2] > 0.0 { tuning::DEPTH_BAND * (1.0 - b.lo[2] / b.hi[2]) } else { 0.0 });
        (band, filled)
    }

    /// Stage 2.
    fn gather(
        &mut self,
        isa: Isa,
        layout: &Layout,
        positions: &[[f32; 3]],
        light: [f32; 3],
        band: [f32; FACES],
        filled: usize,
        mask: &mut [u8],
    ) {
        let level = simd_level(isa);
        let tiles = self.tiles.len();
        let pass = leaves::Pass { layout, positions, light, tiles: &self.tiles, band, filled };
        // Each worker takes the next row of blocks, and with it the slice of the mask that it fills.
        let rows = Mutex::new(mask.chunks_mut(layout.row_samples()).enumerate());
        self.gathered.par_iter_mut().with_max_len(1).for_each(|worker| {
            worker.reset(tiles);
            dispatch!(level, s => gather_rows(s, &pass, &rows, worker));
        });
        self.tiles.region.clear();
        self.tiles.region.resize(tiles, Region::EMPTY);
        for worker in &self.gathered {
            for (sum, region) in self.tiles.region.iter_mut().zip(&worker.regions) {
                *sum = sum.union(&Region::unpack(region));
            }
        }
        self.tiles.bound_nodes();
        self.covered.clear();
        self.covered.resize_with(tiles, Default::default);
    }

    /// Stage 3: until the triangles or the capacity are used up.
    fn bin(&mut self, isa: Isa, triangles: &[Triangle], light: [f32; 3], next: &AtomicUsize) {
        let level = simd_level(isa);
        let capacity = (self.capacity / self.binned.len().max(1)).max(1);
        let pass = bin::Pass { triangles, light, tiles: &self.tiles, covered: &self.covered, next, capacity };
        let tiles = self.tiles.len();
        self.binned.par_iter_mut().with_max_len(1).for_each(|worker| {
            worker.ids.reset(tiles);
            worker.eights.reset(tiles);
            dispatch!(level, s => bin::bin(s, &pass, worker));
        });
    }

    /// Stage 4.
    fn work(
        &mut self,
        isa: Isa,
        layout: &Layout,
        positions: &[[f32; 3]],
        triangles: &[Triangle],
        light: [f32; 3],
        again: bool,
    ) {
        let level = simd_level(isa);
        let next = AtomicUsize::new(0);
        if again {
            self.merge_words();
        } else {
            self.words.clear();
        }
        let pass = work::Pass {
            layout,
            positions,
            triangles,
            light,
            tiles: &self.tiles,
            covered: &self.covered,
            gathered: &self.gathered,
            binned: &self.binned,
            words: &self.words,
            next: &next,
            again,
        };
        self.scratch.par_iter_mut().with_max_len(1).for_each(|scratch| {
            if !again {
                scratch.words.clear();
                scratch.words.resize(layout.blocks(), 0);
            }
            dispatch!(level, s => work::work(s, &pass, scratch));
        });
    }

    /// Puts together what the workers have found.
    fn merge_words(&mut self) {
        let (scratch, chunk) = (&self.scratch, 4096);
        self.words.resize(scratch.first().map_or(0, |s| s.words.len()), 0);
        self.words.par_chunks_mut(chunk).enumerate().for_each(|(i, words)| {
            words.fill(0);
            for worker in scratch {
                for (sum, word) in words.iter_mut().zip(&worker.words[chunk * i..]) {
                    *sum |= word;
                }
            }
        });
    }

    /// Samples without a direction: rays.
    fn wild_samples(
        &mut self,
        layout: &Layout,
        positions: &[[f32; 3]],
        triangles: &[Triangle],
        light: [f32; 3],
    ) -> Result<(), InputError> {
        let Wild { rays, slots, positions: at, mask } = &mut self.wild;
        slots.clear();
        slots.extend(self.gathered.iter().flat_map(|w| &w.wild));
        if slots.is_empty() {
            return Ok(());
        }
        let words = &mut self.scratch[0].words;
        at.clear();
        at.extend(slots.iter().map(|&slot| {
            layout.index(slot as usize / BLOCK, slot as usize % BLOCK).map_or([f32::NAN; 3], |i| positions[i])
        }));
        mask.clear();
        mask.resize(at.len(), 0);
        rays.shadow(triangles, Samples::list(at), light, mask)?;
        for (&slot, &m) in slots.iter().zip(mask.iter()) {
            if m == SHADOWED {
                words[slot as usize / BLOCK] |= 1 << (slot as usize % BLOCK);
            }
        }
        Ok(())
    }

    /// Words to bytes: the mask says "lit" or "none" so far, and "none" is all ones.
    fn write(&self, layout: &Layout, mask: &mut [u8]) {
        let workers = &self.scratch;
        mask.par_chunks_mut(layout.row_samples().max(1)).enumerate().for_each(|(row, mask)| {
            for column in 0..layout.columns {
                let block = row * layout.columns + column;
                let word = workers.iter().fold(0, |word, worker| word | worker.words[block]);
                if word != 0 {
                    layout.mark(mask, column, word, SHADOWED);
                }
            }
        });
    }

    fn report(&self, stats: &mut StatsBuilder, rounds: u64, entries: usize, peak: usize) {
        let leaves: usize = self.gathered.iter().map(|w| w.leaves.items()).sum();
        let loose: usize = self.gathered.iter().map(|w| w.loose.items()).sum();
        stats.bytes("tiles", self.tiles.bytes());
        let lists = |f: fn(&leaves::Gathered) -> usize| self.gathered.iter().map(f).sum::<usize>();
        stats.bytes("leaves", lists(|w| w.leaves.bytes()));
        stats.bytes("loose_samples", lists(|w| w.loose.bytes()));
        stats.bytes("triangle_lists", peak);
        let words = self.words.len() + self.scratch.iter().map(|w| w.words.len()).sum::<usize>();
        stats.bytes("words", 4 * words);
        stats.counter("tiles", self.tiles.len() as u64);
        stats.counter("rounds", rounds);
        stats.counter("block_leaves", leaves as u64);
        stats.counter("loose_samples", loose as u64);
        stats.counter("wild_samples", self.wild.slots.len() as u64);
        let sum = |f: fn(&bin::Counts) -> u64| self.binned.iter().map(|w| f(&w.counts)).sum();
        stats.counter("setup_tris", sum(|c| c.setup_tris));
        stats.counter("culled_tris", sum(|c| c.culled_tris));
        stats.counter("descents", sum(|c| c.descents));
        stats.counter("node_visits", sum(|c| c.node_visits));
        stats.counter("list_entries", entries as u64);
        let accepts: u64 = sum(|c| c.node_accept);
        let sum = |f: fn(&work::Counts) -> u64| self.scratch.iter().map(|w| f(&w.counts)).sum::<u64>();
        stats.counter("node_accept", accepts + sum(|c| c.node_accept));
        stats.counter("prepared", sum(|c| c.prepared));
        stats.counter("kept", sum(|c| c.kept));
        stats.counter("leaves", sum(|c| c.leaves));
        stats.counter("leaf_box_tests", sum(|c| c.leaf_box_tests));
        stats.counter("pairs", sum(|c| c.pairs));
        stats.counter("plane_f64", sum(|c| c.plane_f64));
        let mut counts = super::leaf::LeafCounts::default();
        for worker in &self.scratch {
            counts.add(&worker.counts.leaf);
        }
        stats.counter("leaf_tests", counts.leaf_tests);
        stats.counter("filter_f32_sure", counts.leaf_tests - counts.filter_f64);
        stats.counter("filter_f64", counts.filter_f64);
        stats.counter("filter_exact", counts.filter_exact);
    }
}

/// Rows of blocks until none is left.
#[inline(always)]
fn gather_rows<S: fearless_simd::Simd>(
    s: S,
    pass: &leaves::Pass<'_>,
    rows: &Mutex<Enumerate<ChunksMut<'_, u8>>>,
    worker: &mut leaves::Gathered,
) {
    loop {
        // A poisoned lock means that another worker has panicked: its panic goes on, ours would hide it.
        let next = rows.lock().unwrap_or_else(PoisonError::into_inner).next();
        let Some((row, mask)) = next else { return };
        leaves::gather(s, pass, row, mask, worker);
    }
}
