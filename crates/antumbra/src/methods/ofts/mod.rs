//! `ofts`: omnidirectional frustum-traced shadows, an irregular z-buffer around the light.
//!
//! Source: Kobrtek, Milet, Tóth, Herout 2021 ("Comparison of Modern Omnidirectional Precise Shadowing Techniques Versus Ray
//! Tracing", sections 2.3 and 3.4), who extend Wyman, Hoetzlein, Lefohn 2015 ("Frustum-Traced Raster Shadows") to six cube
//! faces. The view samples are sorted into cells of directions as seen from the light; each triangle is rasterised into the
//! cells, and every sample of a cell that it touches is tested exactly.
//!
//! What we changed, and why:
//! - *Faces without matrices.* The face is the axis of the largest component, so a sample is in one list of one face: no
//!   near or far plane, no overlap of faces, no line of lit pixels between them.
//! - *Lists by counting* (histogram, scan, scatter) instead of linked lists: contiguous, eight samples a vector, the same
//!   in every run.
//! - *Grids that fit.* A heat map gives each face a tight window (again inside it where a distant light sees everything in
//!   one heat cell); a tile's cells span what its samples occupy, and a list of over 64 samples gets a sub-grid. So no
//!   resolution, field of view or threshold is left for a user to tune.
//! - *Conservative in homogeneous form.* An edge of the shadow is linear in a face's (u, v): triangles beside and behind the
//!   light need no clipping. Margins are derived ([`face`]), and no projected corner decides anything alone.
//! - *Depth culling that culls.* A cell's deepest sample against the triangle's plane over the cell.
//!
//! Cost: lists O(N); traversal O(sum over triangles of touched cells and their samples). Memory: some 28 bytes a sample, 12 a
//! cell, and 8 MiB of (tile, triangle) pairs, however many triangles there are.

mod bins;
mod build;
mod debug;
mod face;
mod grid;
#[cfg(test)]
mod tests;
mod traverse;
mod tuning;
mod windows;

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use fearless_simd::dispatch;
use rayon::prelude::*;

use super::debug::check_view;
use super::{DebugView, Method, Options, Samples, Stats, StatsBuilder, check_input};
use crate::Isa;
use crate::mask::{LIT, NONE, SHADOWED};
use crate::scene::{InputError, Triangle};
use bins::{BinCounts, Bins, Frame};
use build::{Lists, NO_ID, Tile, TileLists};
use face::FACES;
use traverse::Counts;
use windows::Window;

/// Omnidirectional frustum-traced shadows.
#[derive(Debug)]
pub struct Ofts {
    isa: Isa,
    round_triangles: usize,
    round_pairs: usize,
    heat: Vec<AtomicU32>,
    lists: TileLists,
    tiles: Vec<Tile>,
    far: Vec<f32>,
    bins: Bins,
    shadowed: Vec<AtomicU32>,
}

/// What a frame did, for the statistics.
struct Done {
    windows: [Window; FACES],
    tiles: usize,
    lists: Lists,
    rounds: u64,
    peak: u64,
    binned: BinCounts,
    pairs: u64,
    counts: Counts,
}

impl Ofts {
    /// A method with nothing kept yet.
    pub fn new(options: &Options) -> Ofts {
        Ofts {
            isa: options.isa,
            round_triangles: tuning::ROUND_TRIANGLES,
            round_pairs: tuning::ROUND_PAIRS,
            heat: Vec::new(),
            lists: TileLists::default(),
            tiles: Vec::new(),
            far: Vec::new(),
            bins: Bins::default(),
            shadowed: Vec::new(),
        }
    }

    /// Bounds the (tile, triangle) pairs that wait at once (one triangle's pairs always may). Any bound gives the same mask.
    pub fn set_round_pairs(&mut self, pairs: usize) {
        self.round_pairs = pairs.max(1);
    }

    fn run(
        &mut self,
        triangles: &[Triangle],
        positions: &[[f32; 3]],
        light: [f32; 3],
        count_tests: bool,
        stats: &mut StatsBuilder,
    ) -> Done {
        let level = self.isa.resolved().level().unwrap_or_else(fearless_simd::Level::new);
        let windows = windows::find_windows(positions, light, &mut self.heat);
        stats.stage("find_windows");
        let candidates = self.lists.sort(positions, light, &windows);
        stats.stage("sort_samples");
        let lists = self.lists.build_cells(positions, light, &windows, &mut self.tiles);
        // Every sample is in one list, once.
        debug_assert_eq!(lists.samples, candidates as u64);
        let tiles = self.lists.starts.len() - 1;
        let tiles = &mut self.tiles[..tiles];
        self.far.clear();
        self.far.extend(tiles.iter().map(|t| t.cells.iter().fold(0.0, |far: f32, c| far.max(c.far))));
        if count_tests {
            tiles.iter_mut().for_each(|t| t.tests.resize(t.blocks.len(), [0; 8]));
        }
        stats.stage("build_cells");

        let frame = Frame { triangles, light, windows: &windows };
        let mut counts = Counts::default();
        let mut pair_count = 0;
        let (rounds, peak, binned) = frame.rounds(
            &mut self.bins,
            self.round_triangles,
            self.round_pairs,
            &mut self.far,
            |pairs, far| {
                pair_count += pairs.len() as u64;
                let found = tiles
                    .par_iter_mut()
                    .zip(far.par_iter_mut())
                    .enumerate()
                    .map_init(Vec::new, |stack, (index, (tile, far))| {
                        let key = (index as u64) << 32;
                        let from = pairs.partition_point(|&p| p < key);
                        let own = &pairs[from..];
                        let own = &own[..own.partition_point(|&p| p < key + (1 << 32))];
                        let mut counts = Counts::default();
                        if !own.is_empty() {
                            *far = dispatch!(level, s => traverse::process(
                                s, tile, own, triangles, light, stack, &mut counts
                            ));
                        }
                        counts
                    })
                    .reduce(Counts::default, Counts::add);
                counts = counts.add(found);
            },
        );
        stats.stage("traverse");
        let tiles = tiles.len();
        Done { windows, tiles, lists, rounds, peak, binned, pairs: pair_count, counts }
    }

    /// One bit a sample from the tiles, then one byte a sample.
    fn write_mask(&mut self, tiles: usize, positions: &[[f32; 3]], mask: &mut [u8]) {
        self.shadowed.clear();
        self.shadowed.resize_with(positions.len().div_ceil(32), AtomicU32::default);
        let shadowed = &self.shadowed;
        self.tiles[..tiles].par_iter().for_each(|tile| {
            for (block, alive) in tile.blocks.iter().zip(&tile.alive) {
                for (lane, &id) in block.id.iter().enumerate() {
                    if id != NO_ID && alive >> lane & 1 == 0 {
                        shadowed[id as usize / 32].fetch_or(1 << (id % 32), Relaxed);
                    }
                }
            }
        });
        mask.par_chunks_mut(4096).zip(positions.par_chunks(4096)).enumerate().for_each(
            |(chunk, (mask, positions))| {
                for (i, (m, p)) in mask.iter_mut().zip(positions).enumerate() {
                    let i = chunk * 4096 + i;
                    let dark = shadowed[i / 32].load(Relaxed) >> (i % 32) & 1 == 1;
                    *m = match p.iter().any(|v| v.is_nan()) {
                        true => NONE,
                        false if dark => SHADOWED,
                        false => LIT,
                    };
                }
            },
        );
    }
}

impl Method for Ofts {
    fn name(&self) -> &'static str {
        "ofts"
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let mut stats = StatsBuilder::start("ofts", self.isa.resolved().name());
        check_input(triangles, samples, light, mask)?;
        check_count(triangles)?;
        stats.stage("check_input");
        let done = self.run(triangles, samples.positions, light, false, &mut stats);
        self.write_mask(done.tiles, samples.positions, mask);
        stats.stage("write_mask");

        stats.bytes("heat_map", 4 * self.heat.capacity());
        stats.bytes("tile_lists", self.lists.bytes());
        stats.bytes("tiles", self.tiles.iter().map(|t| t.bytes() + size_of::<Tile>()).sum());
        stats.bytes("pairs", self.bins.bytes());
        stats.bytes("shadow_bits", 4 * self.shadowed.capacity());
        stats.counter("active_faces", done.windows.iter().filter(|w| w.samples > 0).count() as u64);
        stats.counter("tiles", done.tiles as u64);
        stats.counter("lists", done.lists.occupied);
        stats.counter("list_len_max", done.lists.longest);
        stats.counter("list_len_mean", done.lists.samples / done.lists.occupied.max(1));
        stats.counter("sub_grids", done.lists.sub_grids);
        stats.counter("culled_tris", done.binned.culled);
        stats.counter("tile_pairs", done.pairs);
        stats.counter("tile_pairs_behind", done.binned.behind);
        stats.counter("queue_peak", done.peak);
        stats.counter("queue_flushes", done.rounds.saturating_sub(1));
        stats.counter("node_visits", done.counts.node_visits);
        stats.counter("node_reject", done.counts.node_reject);
        stats.counter("node_refine", done.counts.node_refine);
        stats.counter("early_out_shadowed", done.counts.early_out_shadowed);
        done.counts.leaf.report(&mut stats);
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
        check_count(triangles)?;
        let mut stats = StatsBuilder::start("ofts", self.isa.resolved().name());
        let done = self.run(triangles, samples.positions, light, true, &mut stats);
        Ok(Some(debug::draw(&self.tiles[..done.tiles], view, samples.positions)))
    }
}

/// Pairs hold the number of a triangle in 32 bits.
fn check_count(triangles: &[Triangle]) -> Result<(), InputError> {
    let limit = u32::MAX as usize;
    if triangles.len() > limit {
        return Err(InputError::TooMany { what: "triangles", got: triangles.len(), limit });
    }
    Ok(())
}
