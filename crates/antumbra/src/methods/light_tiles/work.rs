//! The tile pass: the triangles of a tile's list against its leaves.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use antumbra_predicates::tile::{Part, Tile, TileBlock};
use antumbra_predicates::{Triangle, exact};
use fearless_simd::{Simd, SimdBase, f32x8};

use super::bin::{Binned, Entry};
use super::boxes::Boxes;
use super::frame::Frame;
use super::grid::Tiles;
use super::group::{Blocks, Memory, test};
use super::layout::{HALF, Layout};
use super::leaves::{Gathered, LOOSE, LOW, Leaf, Loose, bounds_of, load_loose};
use super::order::{LeafPlace, counting_sort, entry_keys};
use super::prefetch::prefetch;
use super::shuffle::corners;
use super::tuning::{DENSE, FEW_BLOCKS, GROUP};
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
    /// Blocks of eight triangles whose bounds meet those of a group of leaves.
    pub(super) group_tests: u64,
    /// Blocks tested against leaves.
    pub(super) leaf_box_tests: u64,
    /// Tiles and leaves that one triangle covers.
    pub(super) node_accept: u64,
    /// Triangles tested against the samples of a leaf.
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
    /// Triangles of the tile's list: those on their own, and several of eight that follow one another ([`Entry::as_eight`]).
    entries: Vec<Entry>,
    eights: Vec<(u32, u8)>,
    entry_keys: Vec<u32>,
    ids: Vec<u32>,
    /// The first `used` are those of the tile.
    blocks: Vec<Prepared>,
    used: usize,
    /// Bounds of `blocks`.
    hulls: Boxes,
    /// Bounds of those in `live`.
    live_hulls: Boxes,
    /// Leaves of the tile; loose samples are [`LOOSE`] and the first of sixteen in `loose`.
    leaves: Vec<Leaf>,
    loose: Vec<Loose>,
    /// The same before they are sorted.
    mixed_leaves: Vec<Leaf>,
    mixed_loose: Vec<Loose>,
    keys: Vec<u32>,
    live: Vec<(u32, u8)>,
    memory: Box<Memory>,
}

impl Scratch {
    /// Triangles in the list of the tile, at most.
    fn triangles(&self) -> usize {
        self.entries.len() + 8 * self.eights.len()
    }
}

/// Eight triangles of the tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prepared {
    pub(super) block: TileBlock,
    pub(super) ids: [u32; 8],
    live: u8,
}

/// Blocks of triangles that are asked for before they are prepared.
const AHEAD: usize = 3;

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
        for worker in pass.binned {
            worker.ids.ask_for_more(tile + 1);
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
    if pass.covered[tile].load(Relaxed) {
        cover(pass, tile, &mut scratch.words);
        scratch.counts.node_accept += 1;
        return;
    }
    scratch.entries.clear();
    scratch.eights.clear();
    for worker in pass.binned {
        worker.ids.each(tile, |entries| {
            for entry in entries {
                match entry.as_eight() {
                    Some(eight) => scratch.eights.push(eight),
                    None => scratch.entries.push(*entry),
                }
            }
        });
    }
    if scratch.triangles() == 0 {
        return;
    }
    // Nearly all triangles of the list will be kept.
    let sort = scratch.triangles() > 8 * FEW_BLOCKS;
    // Functions of their own: compilers take far more than twice the time for twice the length.
    apart(
        s,
        #[inline(always)]
        || collect(s, pass, tile, sort, scratch),
    );
    if scratch.leaves.is_empty() {
        return;
    }
    ask_for(pass, scratch.leaves.iter().take(GROUP));
    scratch.counts.leaves += scratch.leaves.len() as u64;
    if apart(
        s,
        #[inline(always)]
        || prepare(s, pass, tile, scratch),
    ) {
        cover(pass, tile, &mut scratch.words);
        scratch.counts.node_accept += 1;
        return;
    }
    if scratch.used == 0 {
        return;
    }
    let Scratch { live, blocks, used, .. } = scratch;
    if !sort {
        live.clear();
        live.extend(blocks[..*used].iter().zip(0..).map(|(block, i)| (i, block.live)));
    }
    for first in (0..scratch.leaves.len()).step_by(GROUP) {
        ask_for(pass, scratch.leaves.iter().skip(first + GROUP).take(GROUP));
        let range = first..scratch.leaves.len().min(first + GROUP);
        if !sort || choose(s, range.clone(), scratch) {
            apart(
                s,
                #[inline(always)]
                || group(s, pass, tile, range, scratch),
            );
        }
    }
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
fn ask_for<'a>(pass: &Pass<'_>, leaves: impl Iterator<Item = &'a Leaf>) {
    for leaf in leaves.filter(|leaf| leaf.block() & LOOSE == 0) {
        let (start, line) = pass.layout.corner(leaf.block() as usize);
        for y in 0..4 {
            // A row is one and a half cache lines.
            prefetch(pass.positions, start + y * line);
            prefetch(pass.positions, start + y * line + 7);
        }
    }
}

/// The leaves of a tile whose samples are not all in shadow yet; near ones together, if they are to be sorted.
#[inline(always)]
fn collect<S: Simd>(s: S, pass: &Pass<'_>, tile: usize, sort: bool, scratch: &mut Scratch) {
    let triangles = scratch.triangles();
    let Scratch { leaves, loose, mixed_leaves, mixed_loose, keys, .. } = scratch;
    leaves.clear();
    mixed_leaves.clear();
    mixed_loose.clear();
    let face = pass.tiles.face[tile] as usize;
    let place = LeafPlace::new(&pass.tiles.region[tile]);
    let mut blocks = 0;
    for worker in pass.gathered {
        worker.leaves.each(tile, |leaves| blocks += leaves.len());
    }
    let dense = sort && triangles > DENSE * blocks;
    for worker in pass.gathered {
        worker.leaves.each(tile, |of_worker| {
            if !dense && !pass.again {
                mixed_leaves.extend_from_slice(of_worker);
                return;
            }
            if dense {
                ask_for(pass, of_worker.iter());
            }
            for leaf in of_worker {
                let block = leaf.block();
                let leaf = if pass.again {
                    leaf.with_mask(leaf.mask() & !pass.words[block as usize])
                } else {
                    *leaf
                };
                if dense && leaf.is_whole() {
                    for half in 0..2 {
                        let p = pass.layout.load_half(s, pass.positions, block as usize, half);
                        let sides = bounds_of(s, face, pass.light, &p);
                        mixed_leaves.push(Leaf::new(sides, block, leaf.mask() & (LOW << (HALF * half))));
                    }
                } else if leaf.mask() != 0 {
                    mixed_leaves.push(leaf);
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
            let found = place.sixteen(s, face, pass.light, &p);
            keys.extend_from_slice(&found);
        }
        counting_sort::<_, _, 1024>(mixed_loose, loose, |i| keys[i], |l| *l);
    } else {
        std::mem::swap(loose, mixed_loose);
    }
    for (i, sixteen) in loose.chunks(HALF).enumerate() {
        let sides = bounds_of(s, face, pass.light, &load_loose(s, sixteen));
        let mask = LOW >> (HALF - sixteen.len());
        mixed_leaves.push(Leaf::new(sides, LOOSE | (i * HALF) as u32, mask));
    }
    if sort {
        keys.clear();
        for leaf in mixed_leaves.iter() {
            keys.push(place.leaf(s, leaf));
        }
        counting_sort::<_, _, 64>(mixed_leaves, leaves, |i| keys[i], |l| *l);
    } else {
        std::mem::swap(leaves, mixed_leaves);
    }
}

/// The list's triangles, eight by eight.
#[derive(Clone, Copy, Debug)]
struct Eights<'a> {
    /// Of single ones, `count` in all, up to whole eights.
    ids: &'a [[u32; 8]],
    count: usize,
    more: &'a [(u32, u8)],
}

impl Eights<'_> {
    fn len(&self) -> usize {
        self.ids.len() + self.more.len()
    }

    /// Eight triangles, and which of them count.
    #[inline(always)]
    fn get(&self, i: usize) -> ([u32; 8], u8) {
        if let Some(ids) = self.ids.get(i) {
            let there = (self.count - 8 * i).min(8);
            return (*ids, (0xffu32 >> (8 - there)) as u8);
        }
        let (first, lanes) = self.more[i - self.ids.len()];
        ([0, 1, 2, 3, 4, 5, 6, 7].map(|k| first + k), lanes)
    }

    /// The triangles will be needed soon.
    #[inline(always)]
    fn ask_for(&self, pass: &Pass<'_>, i: usize) {
        let numbers = pass.triangles.as_flattened().as_flattened();
        if let Some(ids) = self.ids.get(i) {
            for &id in ids {
                // More than half of them lie in two cache lines.
                prefetch(numbers, 9 * id as usize);
                prefetch(numbers, 9 * id as usize + 8);
            }
        } else if let Some((first, _)) = self.more.get(i - self.ids.len()) {
            for line in 0..5 {
                prefetch(numbers, 9 * *first as usize + 16 * line);
            }
        }
    }
}

/// Prepares the triangles of the list. True if one covers the tile.
#[inline(always)]
fn prepare<S: Simd>(s: S, pass: &Pass<'_>, tile: usize, scratch: &mut Scratch) -> bool {
    let frame = Frame::of(pass.tiles.face[tile] as usize);
    let light = frame.turn(pass.light);
    let prepared_for = Tile::new(light, pass.tiles.region[tile]);
    let Scratch { entries, eights, entry_keys: keys, ids, blocks, used, hulls, counts, .. } = scratch;
    *used = 0;
    hulls.clear();
    entry_keys(s, pass.tiles, tile, entries, keys);
    counting_sort::<_, _, 128>(entries, ids, |i| keys[i], |e| e.id);
    let Frame { axis, sign } = frame;
    // Up to whole blocks: the last once more.
    let count = ids.len();
    ids.resize(count.next_multiple_of(8), ids.last().copied().unwrap_or(0));
    let eights = Eights { ids: ids.as_chunks().0, count, more: eights };
    for i in 0..AHEAD {
        eights.ask_for(pass, i);
    }
    for i in 0..eights.len() {
        eights.ask_for(pass, i + AHEAD);
        let (eight, live) = eights.get(i);
        let [a, b, c, d, e, f, g, h] = eight;
        let at = |id: u32| &pass.triangles[id as usize];
        let mut corner = corners(s, [at(a), at(b), at(c), at(d), at(e), at(f), at(g), at(h)]);
        for corner in &mut corner {
            *corner = [corner[axis[0]], corner[axis[1]], corner[axis[2]] * sign];
        }
        counts.prepared += u64::from(live.count_ones());
        // Blocks are used again and again: filling them with zeros each time would cost as much as preparing them.
        if blocks.len() == *used {
            blocks.push(Prepared { block: TileBlock::ZERO, ids: [0; 8], live: 0 });
        }
        let prepared = &mut blocks[*used];
        let verdict = prepared.block.prepare(s, corner, live, &prepared_for);
        let mut live = verdict.maybe;
        let mut edge_on = verdict.edge_on;
        while edge_on != 0 {
            let lane = edge_on.trailing_zeros() as usize;
            edge_on &= edge_on - 1;
            match exact::facing(&at(eight[lane]).map(|p| frame.turn(p)), light) {
                0 => live &= !(1 << lane),
                1 => {}
                _ => prepared.block.flip(lane),
            }
        }
        if live == 0 {
            continue;
        }
        *used += 1;
        counts.kept += u64::from(live.count_ones());
        prepared.live = live;
        prepared.ids = eight;
        hulls.push(prepared.block.hull(s, live));
        if verdict.covers & live != 0 {
            return true;
        }
    }
    false
}

/// Tests a group of leaves.
#[inline(always)]
fn group<S: Simd>(s: S, pass: &Pass<'_>, tile: usize, range: std::ops::Range<usize>, scratch: &mut Scratch) {
    let Scratch { blocks, leaves, loose, live, live_hulls, memory, words, counts, .. } = scratch;
    let frame = Frame::of(pass.tiles.face[tile] as usize);
    let blocks = Blocks { all: blocks, live, hulls: live_hulls };
    test(s, pass, &frame, &blocks, &leaves[range], loose, memory, words, counts);
}

/// Finds the blocks of triangles that may concern a group of leaves: those whose bounds meet the group's. False if there are none.
#[inline(always)]
fn choose<S: Simd>(s: S, range: std::ops::Range<usize>, scratch: &mut Scratch) -> bool {
    let Scratch { blocks, used, hulls, leaves, live, live_hulls, counts, .. } = scratch;
    let mut sides = f32x8::splat(s, f32::INFINITY);
    for leaf in &leaves[range] {
        sides = sides.min(leaf.sides(s));
    }
    let part = Part::new(s, sides);
    live.clear();
    live_hulls.clear();
    for first in (0..*used).step_by(8) {
        let mut near = hulls.near(s, first, &part);
        while near != 0 {
            let i = first + near.trailing_zeros() as usize;
            near &= near - 1;
            live.push((i as u32, blocks[i].live));
            live_hulls.push(hulls.get(i));
        }
    }
    counts.group_tests += live.len() as u64;
    !live.is_empty()
}
