//! The tile pass: the triangles of a tile's list against its leaves.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use antumbra_predicates::Triangle;
use fearless_simd::Simd;

use super::bin::{Binned, Eight, Entry, LARGE};
use super::boxes::LEAVES;
use super::chunk::{Chunk, Eights, Setup};
use super::grid::Tiles;
use super::layout::{HALF, Layout};
use super::leaf::{LOOSE, LOW, Leaf, Loose, load_loose};
use super::leaves::{Gathered, bounds_of};
use super::order::{LeafPlace, counting_sort, entry_keys, front_first};
use super::pairs::{Memory, test};
use super::prefetch::prefetch_second;
use super::state::State;
use super::tuning::{AHEAD, DENSE, FEW, MOST_LEAVES};
use crate::methods::leaf::LeafCounts;

/// What all workers share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass<'a> {
    pub(super) layout: &'a Layout,
    pub(super) positions: &'a [[f32; 3]],
    pub(super) triangles: &'a [Triangle],
    pub(super) light: [f32; 3],
    pub(super) tiles: &'a Tiles,
    pub(super) covered: &'a [AtomicBool],
    pub(super) gathered: &'a [Gathered],
    pub(super) binned: &'a [Binned],
    /// One word a block: samples in shadow after the rounds before.
    pub(super) words: &'a [u32],
    pub(super) next: &'a AtomicUsize,
    /// Not the first round: some samples are in shadow already.
    pub(super) again: bool,
}

/// Work of the pass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Leaves, blocks and loose ones.
    pub(super) leaves: u64,
    /// Triangles prepared for a tile.
    pub(super) prepared: u64,
    /// Of those: may block one of its samples.
    pub(super) kept: u64,
    /// Blocks tested against leaves.
    pub(super) leaf_box_tests: u64,
    /// Tiles and leaves that one triangle covers.
    pub(super) node_accept: u64,
    /// Triangles tested against the samples of a leaf; in dense tiles also of leaves that have been done meanwhile.
    pub(super) pairs: u64,
    pub(super) leaf: LeafCounts,
    /// Pairs whose plane went to f64, eight samples at a time.
    pub(super) plane_f64: u64,
}

/// A worker's scratch memory. Cache lines come in pairs, and no two workers should write to one.
#[derive(Debug, Default)]
#[repr(align(128))]
pub(super) struct Scratch {
    pub(super) counts: Counts,
    /// One word a block: samples that this worker has found in shadow. Words for all would have to be changed by atomic instructions, which wait for one another.
    pub(super) words: Vec<u32>,
    /// Triangles of the tile's list: those on their own, and several of eight that follow one another.
    entries: Vec<Entry>,
    mixed_eights: Vec<Eight>,
    /// The same, sorted.
    eights: Vec<Eight>,
    entry_keys: Vec<u32>,
    ids: Vec<u32>,
    chunk: Box<Chunk>,
    /// Leaves of the tile; loose samples are [`LOOSE`] and the first of sixteen in `loose`.
    leaves: Vec<Leaf>,
    loose: Vec<Loose>,
    /// The same before they are sorted.
    mixed_loose: Vec<Loose>,
    keys: Vec<u32>,
    state: State,
    memory: Box<Memory>,
}

impl Scratch {
    /// Triangles in the list of the tile, at most.
    fn triangles(&self) -> usize {
        self.entries.len() + 8 * self.mixed_eights.len()
    }
}

/// Tiles until none is left.
#[inline(always)]
pub(super) fn work<S: Simd>(s: S, pass: &Pass<'_>, scratch: &mut Scratch) {
    loop {
        let tile = pass.next.fetch_add(1, Relaxed);
        if tile >= pass.tiles.len() {
            return;
        }
        for worker in pass.gathered {
            worker.leaves.ask_for(tile + 1);
        }
        let next = pass.tiles.list.get(tile + 1).map_or(0, |list| *list as usize);
        for worker in pass.binned {
            worker.ids.ask_for_more(next);
            worker.eights.ask_for_more(next);
        }
        one_tile(s, pass, tile, scratch);
    }
}

#[inline(always)]
fn one_tile<S: Simd>(s: S, pass: &Pass<'_>, tile: usize, scratch: &mut Scratch) {
    let region = pass.tiles.region[tile];
    if region.lo[0] > region.hi[0] {
        return;
    }
    let list = pass.tiles.list[tile] as usize;
    if pass.covered[list].load(Relaxed) {
        cover(pass, tile, &mut scratch.words);
        scratch.counts.node_accept += 1;
        return;
    }
    scratch.entries.clear();
    scratch.mixed_eights.clear();
    for worker in pass.binned {
        worker.ids.each(list, |entries| scratch.entries.extend_from_slice(entries));
        worker.eights.each(list, |eights| scratch.mixed_eights.extend_from_slice(eights));
    }
    if scratch.triangles() == 0 {
        return;
    }
    let sort = scratch.triangles() > FEW;
    // Functions of their own: compilers take far more than twice the time for twice the length.
    let dense = apart(
        s,
        #[inline(always)]
        || collect(s, pass, tile, sort, scratch),
    );
    if scratch.leaves.is_empty() {
        return;
    }
    scratch.counts.leaves += scratch.leaves.len() as u64;
    let Scratch {
        entries,
        mixed_eights,
        eights,
        entry_keys,
        ids,
        chunk,
        leaves,
        loose,
        state,
        memory,
        words,
        counts,
        ..
    } = scratch;
    let setup = Setup::new(pass, tile);
    apart(
        s,
        #[inline(always)]
        || sort_singles(s, pass, tile, entries, entry_keys, ids),
    );
    front_first(mixed_eights, eights);
    // Large ones come first: one may cover the tile.
    let large = entries.iter().filter(|entry| entry.at == LARGE).count();
    let eights = Eights { ids: ids.as_chunks().0, count: entries.len(), more: eights };
    let at_once = if sort { large.div_ceil(8) } else { eights.len() };
    for leaves in leaves.chunks(MOST_LEAVES) {
        // Chunk by chunk: its triangles stay in the first cache while all leaves go by. Samples are loaded with the first one.
        let mut next = 0;
        while next == 0 || (next < eights.len() && state.find_alive(s)) {
            let is_first = next == 0;
            if is_first {
                ask_for(pass, leaves.iter().take(if dense { 2 * AHEAD } else { AHEAD }));
            }
            if apart(
                s,
                #[inline(always)]
                || chunk.fill(s, pass, &setup, &eights, &mut next, at_once, state, counts),
            ) {
                cover(pass, tile, words);
                counts.node_accept += 1;
                return;
            }
            if is_first && dense {
                apart(
                    s,
                    #[inline(always)]
                    || state.start_dense(s, pass, &setup, leaves, loose),
                );
            } else if is_first {
                apart(
                    s,
                    #[inline(always)]
                    || state.start(s, &setup, leaves),
                );
            }
            for first in (0..leaves.len()).step_by(LEAVES) {
                let range = first..leaves.len().min(first + LEAVES);
                if is_first && !dense {
                    let range = range.clone();
                    apart(
                        s,
                        #[inline(always)]
                        || state.load(s, pass, leaves, loose, range),
                    );
                }
                if dense {
                    apart(
                        s,
                        #[inline(always)]
                        || test::<_, true>(s, pass, &setup, chunk, range, state, memory, counts),
                    );
                } else {
                    apart(
                        s,
                        #[inline(always)]
                        || test::<_, false>(s, pass, &setup, chunk, range, state, memory, counts),
                    );
                }
            }
        }
        apart(
            s,
            #[inline(always)]
            || state.finish(s, pass, leaves, loose, words, counts),
        );
    }
}

/// Triangles on their own, by place: up to whole eights, the last once more.
#[inline(always)]
fn sort_singles<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    tile: usize,
    entries: &[Entry],
    keys: &mut Vec<u32>,
    ids: &mut Vec<u32>,
) {
    entry_keys(s, pass.tiles, tile, entries, keys);
    counting_sort::<_, _, 128>(entries, ids, |i| keys[i], |e| e.id);
    ids.resize(ids.len().next_multiple_of(8), ids.last().copied().unwrap_or(0));
}

/// Calls a function that is compiled for the instruction set, and by itself.
#[inline(never)]
fn apart<S: Simd, R>(s: S, f: impl FnOnce() -> R) -> R {
    s.vectorize(f)
}

/// All samples of a tile are in shadow.
fn cover(pass: &Pass<'_>, tile: usize, words: &mut [u32]) {
    for worker in pass.gathered {
        worker.leaves.each(tile, |leaves| {
            for leaf in leaves {
                words[leaf.block() as usize] |= leaf.mask();
            }
        });
        worker.loose.each(tile, |loose| {
            for (block, sample) in loose.iter().map(Loose::slot) {
                words[block] |= 1 << sample;
            }
        });
    }
}

/// The samples of these leaves will be needed soon.
#[inline(always)]
pub(super) fn ask_for<'a>(pass: &Pass<'_>, leaves: impl IntoIterator<Item = &'a Leaf>) {
    for leaf in leaves.into_iter().filter(|leaf| leaf.block() & LOOSE == 0) {
        let (start, line) = pass.layout.corner(leaf.block() as usize);
        for y in 0..4 {
            // A row is one and a half cache lines.
            prefetch_second(pass.positions, start + y * line);
            prefetch_second(pass.positions, start + y * line + 7);
        }
    }
}

/// The leaves of a tile whose samples are not all in shadow yet. `sort` says that there are many triangles. True if the tile is dense: no leaf
/// has more than sixteen samples then.
#[inline(always)]
fn collect<S: Simd>(s: S, pass: &Pass<'_>, tile: usize, sort: bool, scratch: &mut Scratch) -> bool {
    let triangles = scratch.triangles();
    let Scratch { leaves, loose, mixed_loose, keys, .. } = scratch;
    leaves.clear();
    mixed_loose.clear();
    let sight = &pass.tiles.sights.faces[pass.tiles.face[tile] as usize];
    let place = LeafPlace::new(&pass.tiles.region[tile]);
    let mut blocks = 0;
    for worker in pass.gathered {
        worker.leaves.each(tile, |of_worker| blocks += of_worker.len());
    }
    let dense = sort && triangles > DENSE * blocks;
    for worker in pass.gathered {
        worker.leaves.each(tile, |of_worker| {
            if !dense && !pass.again {
                leaves.extend_from_slice(of_worker);
                return;
            }
            for leaf in of_worker {
                let leaf = if pass.again {
                    leaf.with_mask(leaf.mask() & !pass.words[leaf.block() as usize])
                } else {
                    *leaf
                };
                if dense && leaf.is_whole() {
                    // Their bounds are made narrower when the samples are loaded.
                    for half in 0..2 {
                        leaves.push(leaf.with_mask(leaf.mask() & (LOW << (HALF * half))));
                    }
                } else if leaf.mask() != 0 {
                    leaves.push(leaf);
                }
            }
        });
        worker.loose.each(tile, |of_worker| {
            if !pass.again {
                mixed_loose.extend_from_slice(of_worker);
                return;
            }
            mixed_loose.extend(of_worker.iter().filter(|l| {
                let (block, sample) = l.slot();
                pass.words[block] >> sample & 1 == 0
            }));
        });
    }
    if sort {
        keys.clear();
        for sixteen in mixed_loose.chunks(HALF) {
            let p = load_loose(s, sixteen);
            let found = place.sixteen(s, sight, &p);
            keys.extend_from_slice(&found);
        }
        counting_sort::<_, _, 1024>(mixed_loose, loose, |i| keys[i], |l| *l);
    } else {
        std::mem::swap(loose, mixed_loose);
    }
    for (i, sixteen) in loose.chunks(HALF).enumerate() {
        let sides = bounds_of(s, sight, &load_loose(s, sixteen));
        let mask = LOW >> (HALF - sixteen.len());
        leaves.push(Leaf::new(s, sides, LOOSE | (i * HALF) as u32, mask));
    }
    dense
}
