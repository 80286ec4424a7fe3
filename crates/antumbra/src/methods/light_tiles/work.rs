//! The tile pass: the triangles of a tile's list against its leaves.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering::Relaxed};

use antumbra_predicates::plane::PlaneResolver;
use antumbra_predicates::resolve::{Decided, Resolver};
use antumbra_predicates::tile::{Region, Tile, TileBlock};
use antumbra_predicates::{Triangle, exact};
use fearless_simd::{Simd, SimdBase, f32x8};

use super::bin::{Binned, Entry, LARGE};
use super::boxes::Boxes;
use super::frame::Frame;
use super::grid::{PLACES, Tiles};
use super::layout::{BLOCK, HALF, Layout, halves};
use super::leaves::{Gathered, Leaf, Loose, direction};
use super::prefetch::prefetch;
use super::tuning::{DENSE, GROUP};
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
    /// One word a block: samples in shadow.
    pub(super) words: &'a [AtomicU32],
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
    /// Blocks of eight triangles tested against groups of leaves, and against leaves.
    pub(super) group_tests: u64,
    pub(super) leaf_box_tests: u64,
    /// Tiles, groups and leaves that one triangle covers.
    pub(super) node_accept: u64,
    /// Triangles tested against the samples of a leaf.
    pub(super) pairs: u64,
    pub(super) leaf: LeafCounts,
    /// Pairs whose plane went to f64, eight samples at a time.
    pub(super) plane_f64: u64,
}

/// A worker's scratch memory.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) counts: Counts,
    entries: Vec<Keyed>,
    ids: Vec<u32>,
    /// The first `used` are those of the tile.
    blocks: Vec<Prepared>,
    used: usize,
    /// Bounds of `blocks`.
    hulls: Boxes,
    /// Bounds of those in `live`.
    live_hulls: Boxes,
    leaves: Vec<Work>,
    sorted: Vec<Work>,
    slots: Vec<Slot>,
    slots_sorted: Vec<Slot>,
    live: Vec<(u32, u8)>,
    open: Vec<Open>,
}

/// Eight triangles of the tile.
#[derive(Clone, Copy, Debug)]
struct Prepared {
    block: TileBlock,
    ids: [u32; 8],
    live: u8,
}

/// A leaf at work.
#[derive(Clone, Copy, Debug)]
struct Work {
    region: Region,
    /// The block; of a loose leaf, [`LOOSE`] and the first of its slots.
    block: u32,
    mask: u32,
    key: u16,
}

impl Work {
    /// Samples of both halves.
    #[inline(always)]
    fn is_whole(&self) -> bool {
        self.mask & LOW != 0 && self.mask & !LOW != 0
    }

    /// The samples as bits of its vectors, and how far the bits of the block are shifted against them.
    #[inline(always)]
    fn vectors(&self) -> (u32, u32) {
        let shift = if self.mask & LOW == 0 { HALF as u32 } else { 0 };
        (shift, self.mask >> shift)
    }
}

const LOOSE: u32 = 1 << 31;

/// The samples of the left half of a block.
const LOW: u32 = (1 << HALF) - 1;

/// Blocks of triangles that are asked for before they are prepared.
const AHEAD: usize = 3;

/// A loose sample.
#[derive(Clone, Copy, Debug)]
struct Slot {
    at: [f32; 3],
    world: [f32; 3],
    slot: u32,
    key: u16,
}

/// A triangle of the tile, and where it goes: large ones first, then by place in the tile.
#[derive(Clone, Copy, Debug)]
struct Keyed {
    id: u32,
    key: u16,
}

/// A triangle and the samples of a leaf for which f32 was not enough.
#[derive(Clone, Copy, Debug)]
struct Open {
    id: u32,
    plane: u32,
    sides: u32,
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
        for worker in pass.binned {
            worker.ids.ask_for(tile + 1);
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
    let covered = pass.covered[tile].load(Relaxed);
    scratch.entries.clear();
    if !covered {
        let place = Place::of(pass.tiles, tile);
        for worker in pass.binned {
            worker.ids.each(tile, |entries| scratch.entries.extend(entries.iter().map(|e| place.key(e))));
        }
        if scratch.entries.is_empty() {
            return;
        }
    }
    collect(pass, tile, scratch);
    ask_for(pass, scratch.leaves.iter().take(GROUP));
    if covered || prepare(s, pass, tile, scratch) {
        scratch.counts.node_accept += 1;
        for i in 0..scratch.leaves.len() {
            let leaf = scratch.leaves[i];
            finish(pass, &scratch.slots_sorted, &leaf, leaf.mask);
        }
        return;
    }
    if scratch.used == 0 {
        return;
    }
    for first in (0..scratch.leaves.len()).step_by(GROUP) {
        ask_for(pass, scratch.leaves.iter().skip(first + GROUP).take(GROUP));
        group(s, pass, tile, first..scratch.leaves.len().min(first + GROUP), scratch);
    }
}

/// The samples of these leaves will be needed soon.
#[inline(always)]
fn ask_for<'a>(pass: &Pass<'_>, leaves: impl Iterator<Item = &'a Work>) {
    for leaf in leaves.filter(|leaf| leaf.block & LOOSE == 0) {
        let (start, line) = pass.layout.corner(leaf.block as usize);
        for y in 0..4 {
            // A row is one and a half cache lines.
            prefetch(pass.positions, start + y * line);
            prefetch(pass.positions, start + y * line + 7);
        }
    }
}

/// The leaves of a tile whose samples are not all in shadow yet, near ones together.
#[inline(always)]
fn collect(pass: &Pass<'_>, tile: usize, scratch: &mut Scratch) {
    let Scratch { entries, leaves, sorted, slots, slots_sorted, counts, .. } = scratch;
    sorted.clear();
    slots.clear();
    let region = pass.tiles.region[tile];
    // Part of the tile's extent, rounded to a number below `steps`: the sum is whole, its low bits are the number.
    let step = |k: usize, x: f32, steps: f32| {
        let scale = (steps - 1.0) / (region.hi[k] - region.lo[k]).max(f32::MIN_POSITIVE);
        ((x - region.lo[k]) * scale + 8_388_608.0).to_bits() as u16 & (steps as u16 - 1)
    };
    // Depth first: what mixes near and far is tested most.
    let key = |[x, y, r]: [f32; 3]| step(2, r, 4.0) << 4 | step(1, y, 4.0) << 2 | step(0, x, 4.0);
    let mut blocks = 0;
    for worker in pass.gathered {
        worker.leaves.each(tile, |leaves| blocks += leaves.len());
    }
    let dense = entries.len() > DENSE * blocks;
    for worker in pass.gathered {
        worker.leaves.each(tile, |leaves| {
            for &Leaf { regions: [left, right], block, mask } in leaves {
                let mask = if pass.again { mask & !pass.words[block as usize].load(Relaxed) } else { mask };
                let (low, high) = (mask & LOW, mask & !LOW);
                if !dense && low != 0 && high != 0 {
                    let region = left.union(&right);
                    sorted.push(Work { region, block, mask, key: key(region.lo) });
                    continue;
                }
                if low != 0 {
                    sorted.push(Work { region: left, block, mask: low, key: key(left.lo) });
                }
                if high != 0 {
                    sorted.push(Work { region: right, block, mask: high, key: key(right.lo) });
                }
            }
        });
        worker.loose.each(tile, |samples| {
            for &Loose { at: world, slot } in samples {
                let (block, sample) = (slot as usize / BLOCK, slot as usize % BLOCK);
                if pass.again && pass.words[block].load(Relaxed) >> sample & 1 == 1 {
                    continue;
                }
                let Some((_, at)) = direction(world, pass.light) else { continue };
                // Two bits of depth over four bits each of a curve through the directions.
                let (x, y) = (step(0, at[0], 16.0), step(1, at[1], 16.0));
                let spread = |v: u16| (v & 1) | (v & 2) << 1 | (v & 4) << 2 | (v & 8) << 3;
                let key = step(2, at[2], 4.0) << 8 | spread(y) << 1 | spread(x);
                slots.push(Slot { at, world, slot, key });
            }
        });
    }
    counting_sort::<_, _, 1024>(slots, slots_sorted, |s| s.key, |s| *s);
    for (i, sixteen) in slots_sorted.chunks(HALF).enumerate() {
        let mut region = Region::EMPTY;
        for slot in sixteen {
            region = region.union(&Region { lo: slot.at, hi: slot.at });
        }
        let key = slots_sorted[i * HALF].key;
        let key = (key >> 8) << 4 | (key >> 4 & 0xf);
        let mask = LOW >> (HALF - sixteen.len());
        sorted.push(Work { region, block: LOOSE | (i * HALF) as u32, mask, key });
    }
    counting_sort::<_, _, 64>(sorted, leaves, |w| w.key, |w| *w);
    counts.leaves += leaves.len() as u64;
}

/// Puts what `get` gives of `from` into `to`, sorted by a small key.
#[inline(always)]
fn counting_sort<T, U: Copy, const KEYS: usize>(
    from: &[T],
    to: &mut Vec<U>,
    key: impl Fn(&T) -> u16,
    get: impl Fn(&T) -> U,
) {
    to.clear();
    let Some(any) = from.first() else { return };
    if from.len() <= 8 {
        // One vector or group: nothing to part.
        to.extend(from.iter().map(get));
        return;
    }
    to.resize(from.len(), get(any));
    let mut start = [0u32; KEYS];
    for item in from {
        start[key(item) as usize] += 1;
    }
    let mut sum = 0;
    for s in &mut start {
        (*s, sum) = (sum, sum + *s);
    }
    for item in from {
        let at = &mut start[key(item) as usize];
        to[*at as usize] = get(item);
        *at += 1;
    }
}

/// Keys of triangles within a tile.
#[derive(Clone, Copy, Debug)]
struct Place {
    first: [u16; 2],
    shift: u32,
}

/// Places of 8 x 8 parts of a tile (column, row times 8) along a curve.
const CURVE: [u8; 64] = {
    let mut curve = [0; 64];
    let mut i = 0;
    while i < 64 {
        let (x, y) = (i % 8, i / 8);
        curve[i] = ((x & 1) | (y & 1) << 1 | (x & 2) << 1 | (y & 2) << 2 | (x & 4) << 2 | (y & 4) << 3) as u8;
        i += 1;
    }
    curve
};

impl Place {
    fn of(tiles: &Tiles, tile: usize) -> Place {
        let [x, _, y, _] = tiles.cells[tile];
        Place { first: [x * PLACES as u16, y * PLACES as u16], shift: tiles.shift(tile) + 1 }
    }

    /// Large triangles first, they may cover all; then neighbours together, so that blocks of eight have narrow bounds.
    #[inline(always)]
    fn key(&self, e: &Entry) -> Keyed {
        let [x, y] =
            [0, 1].map(|k| usize::from((e.at[k].saturating_sub(self.first[k]) >> self.shift).min(7)));
        let key = if e.at[0] == LARGE { 0 } else { 1 + u16::from(CURVE[y << 3 | x]) };
        Keyed { id: e.id, key }
    }
}

/// Prepares the triangles of the list. True if one covers the tile.
#[inline(always)]
fn prepare<S: Simd>(s: S, pass: &Pass<'_>, tile: usize, scratch: &mut Scratch) -> bool {
    let frame = Frame::of(pass.tiles.face[tile] as usize);
    let light = frame.turn(pass.light);
    let prepared_for = Tile::new(light, pass.tiles.region[tile]);
    let Scratch { entries, ids, blocks, used, hulls, counts, .. } = scratch;
    *used = 0;
    hulls.clear();
    counting_sort::<_, _, 128>(entries, ids, |e| e.key, |e| e.id);
    let Frame { axis, sign } = frame;
    let sign = [1.0, 1.0, sign];
    for &id in ids.iter().take(8 * AHEAD) {
        prefetch(pass.triangles, id as usize);
    }
    let mut ahead = ids.chunks(8).skip(AHEAD);
    for eight in ids.chunks(8) {
        for &id in ahead.next().unwrap_or_default() {
            prefetch(pass.triangles, id as usize);
        }
        // Short at the end: the last repeats the first.
        let mut at = [eight[0] as usize; 8];
        for (at, &id) in at.iter_mut().zip(eight) {
            *at = id as usize;
        }
        let t = pass.triangles;
        let [t0, t1, t2, t3, t4, t5, t6, t7] =
            [&t[at[0]], &t[at[1]], &t[at[2]], &t[at[3]], &t[at[4]], &t[at[5]], &t[at[6]], &t[at[7]]];
        let mut corner = [[f32x8::splat(s, 0.0); 3]; 3];
        for c in 0..3 {
            for k in 0..3 {
                let a = axis[k];
                let v = [t0[c][a], t1[c][a], t2[c][a], t3[c][a], t4[c][a], t5[c][a], t6[c][a], t7[c][a]];
                corner[c][k] = f32x8::load_array(s, v) * sign[k];
            }
        }
        let live = (0xffu32 >> (8 - eight.len())) as u8;
        counts.prepared += eight.len() as u64;
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
            match exact::facing(&pass.triangles[at[lane]].map(|p| frame.turn(p)), light) {
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
        prepared.ids[..eight.len()].copy_from_slice(eight);
        hulls.push(prepared.block.hull(s, live));
        if verdict.covers & live != 0 {
            return true;
        }
    }
    false
}

/// Up to [`GROUP`] leaves.
#[inline(always)]
fn group<S: Simd>(s: S, pass: &Pass<'_>, tile: usize, range: std::ops::Range<usize>, scratch: &mut Scratch) {
    let Scratch { blocks, used, hulls, leaves, slots_sorted, live, live_hulls, open, counts, .. } = scratch;
    let leaves = &leaves[range];
    let mut region = Region::EMPTY;
    for leaf in leaves {
        region = region.union(&leaf.region);
    }
    live.clear();
    live_hulls.clear();
    for first in (0..*used).step_by(8) {
        let mut near = hulls.near(s, first, &region);
        while near != 0 {
            let i = first + near.trailing_zeros() as usize;
            near &= near - 1;
            let prepared = &blocks[i];
            counts.group_tests += 1;
            let (maybe, covers) = prepared.block.cull(s, &region);
            if covers & prepared.live != 0 {
                counts.node_accept += 1;
                for leaf in leaves {
                    finish(pass, slots_sorted, leaf, leaf.mask);
                }
                return;
            }
            let maybe = maybe & prepared.live;
            if maybe != 0 {
                live.push((i as u32, maybe));
                live_hulls.push(hulls.get(i));
            }
        }
    }
    if live.is_empty() {
        return;
    }
    let frame = Frame::of(pass.tiles.face[tile] as usize);
    let blocks = Blocks { all: blocks, live, hulls: live_hulls };
    for leaf in leaves {
        open.clear();
        // Whole blocks are four vectors, all others two; which samples of the block those are is in the mask.
        let (shift, mut alive) = leaf.vectors();
        if leaf.is_whole() {
            let p = frame.turn_all(load_whole(s, pass, leaf));
            alive = pairs(s, &blocks, &leaf.region, &p, alive, open, counts);
        } else {
            let p = frame.turn_all(load_half(s, pass, slots_sorted, leaf));
            alive = pairs(s, &blocks, &leaf.region, &p, alive, open, counts);
        }
        for o in open.iter() {
            if alive == 0 {
                break;
            }
            let (plane, sides) = (o.plane & alive, o.sides & alive);
            if plane | sides != 0 {
                let blocked = if leaf.is_whole() {
                    let p = load_whole(s, pass, leaf);
                    resolve(s, pass, o.id, &p, plane, sides, counts)
                } else {
                    let p = load_half(s, pass, slots_sorted, leaf);
                    resolve(s, pass, o.id, &p, plane, sides, counts)
                };
                alive &= !blocked;
            }
        }
        finish(pass, slots_sorted, leaf, leaf.mask & !(alive << shift));
    }
}

/// Blocks of triangles that may concern a group of leaves.
#[derive(Clone, Copy, Debug)]
struct Blocks<'a> {
    all: &'a [Prepared],
    /// Number and lanes.
    live: &'a [(u32, u8)],
    /// Bounds of those in `live`.
    hulls: &'a Boxes,
}

/// The samples of a leaf (`V` vectors, those in `alive` count) that no triangle is certain to block; what f32 leaves open is
/// noted.
#[inline(always)]
fn pairs<S: Simd, const V: usize>(
    s: S,
    blocks: &Blocks<'_>,
    region: &Region,
    p: &[[f32x8<S>; V]; 3],
    mut alive: u32,
    open: &mut Vec<Open>,
    counts: &mut Counts,
) -> u32 {
    for first in (0..blocks.live.len()).step_by(8) {
        let mut near = blocks.hulls.near(s, first, region);
        while near != 0 {
            let (i, mask) = blocks.live[first + near.trailing_zeros() as usize];
            near &= near - 1;
            let prepared = &blocks.all[i as usize];
            counts.leaf_box_tests += 1;
            let (maybe, covers) = prepared.block.cull(s, region);
            if covers & mask != 0 {
                counts.node_accept += 1;
                return 0;
            }
            let mut maybe = maybe & mask;
            while maybe != 0 {
                let lane = maybe.trailing_zeros() as usize;
                maybe &= maybe - 1;
                counts.pairs += 1;
                counts.leaf.leaf_tests += u64::from(alive.count_ones());
                let (mut plane, mut sides) = (0, 0);
                for v in 0..V {
                    let live = (alive >> (8 * v)) as u8;
                    // Two vectors are tested faster than asked about.
                    if V > 2 && live == 0 {
                        continue;
                    }
                    let lanes = prepared.block.lanes(s, lane, [p[0][v], p[1][v], p[2][v]], live);
                    alive &= !(u32::from(lanes.blocked) << (8 * v));
                    plane |= u32::from(lanes.plane) << (8 * v);
                    sides |= u32::from(lanes.sides) << (8 * v);
                }
                if alive == 0 {
                    return 0;
                }
                if plane | sides != 0 {
                    open.push(Open { id: prepared.ids[lane], plane, sides });
                }
            }
        }
    }
    alive
}

/// The samples that an open triangle blocks: f64, then exact arithmetic. `plane` and `sides` are those to decide.
#[inline(never)]
fn resolve<S: Simd, const V: usize>(
    s: S,
    pass: &Pass<'_>,
    id: u32,
    p: &[[f32x8<S>; V]; 3],
    plane: u32,
    sides: u32,
    counts: &mut Counts,
) -> u32 {
    s.vectorize(
        #[inline(always)]
        || {
            let triangle = &pass.triangles[id as usize];
            let mut blocked = 0;
            let mut hard = sides;
            counts.leaf.filter_f64 += u64::from((plane | hard).count_ones());
            if plane != 0 {
                if let Some(resolver) = PlaneResolver::new(triangle, pass.light) {
                    for v in 0..V {
                        if plane >> (8 * v) & 0xff == 0 {
                            continue;
                        }
                        counts.plane_f64 += 1;
                        let (beyond, unsure) = resolver.lanes(s, [p[0][v], p[1][v], p[2][v]]);
                        blocked |= plane & u32::from(beyond) << (8 * v);
                        hard |= plane & u32::from(unsure) << (8 * v);
                    }
                } else {
                    hard |= plane;
                }
            }
            if hard != 0
                && let Some(resolver) = Resolver::new(triangle, pass.light)
            {
                for i in (0..8 * V).filter(|i| hard >> i & 1 == 1) {
                    let (blocks, decided) =
                        resolver.blocks([p[0][i / 8][i % 8], p[1][i / 8][i % 8], p[2][i / 8][i % 8]]);
                    counts.leaf.filter_exact += u64::from(decided == Decided::Exact);
                    blocked |= u32::from(blocks) << i;
                }
            }
            blocked
        },
    )
}

/// World coordinates of the samples of a whole block.
#[inline(always)]
fn load_whole<S: Simd>(s: S, pass: &Pass<'_>, leaf: &Work) -> [[f32x8<S>; 4]; 3] {
    pass.layout.load(s, pass.positions, leaf.block as usize)
}

/// World coordinates of the samples of half a block, or of loose ones. What lanes without a sample hold does not matter.
#[inline(always)]
fn load_half<S: Simd>(s: S, pass: &Pass<'_>, slots: &[Slot], leaf: &Work) -> [[f32x8<S>; 2]; 3] {
    if leaf.block & LOOSE == 0 {
        let half = usize::from(leaf.mask & LOW == 0);
        return pass.layout.load_half(s, pass.positions, leaf.block as usize, half);
    }
    let first = (leaf.block & !LOOSE) as usize;
    let mut at = [[0.0; HALF]; 3];
    for (i, slot) in slots[first..].iter().take(HALF).enumerate() {
        (at[0][i], at[1][i], at[2][i]) = (slot.world[0], slot.world[1], slot.world[2]);
    }
    [halves(s, &at[0]), halves(s, &at[1]), halves(s, &at[2])]
}

/// Notes samples of a leaf that are in shadow.
#[inline(always)]
fn finish(pass: &Pass<'_>, slots: &[Slot], leaf: &Work, shadowed: u32) {
    if shadowed == 0 {
        return;
    }
    if leaf.block & LOOSE == 0 {
        pass.words[leaf.block as usize].fetch_or(shadowed, Relaxed);
        return;
    }
    let first = (leaf.block & !LOOSE) as usize;
    for i in (0..HALF).filter(|i| shadowed >> i & 1 == 1) {
        let slot = slots[first + i].slot as usize;
        pass.words[slot / BLOCK].fetch_or(1 << (slot % BLOCK), Relaxed);
    }
}
