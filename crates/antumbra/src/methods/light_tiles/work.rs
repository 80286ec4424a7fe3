//! The tile pass: the triangles of a tile's list against its leaves.

use std::sync::atomic::{AtomicBool, AtomicU16, AtomicUsize, Ordering::Relaxed};

use antumbra_predicates::plane::PlaneResolver;
use antumbra_predicates::resolve::{Decided, Resolver};
use antumbra_predicates::tile::{Region, Tile, TileBlock};
use antumbra_predicates::{Triangle, exact};
use fearless_simd::{Simd, SimdBase, f32x8};

use super::bin::{Binned, Entry, LARGE};
use super::boxes::Boxes;
use super::frame::Frame;
use super::grid::{PLACES, Tiles};
use super::layout::{BLOCK, Layout, halves};
use super::leaves::{Gathered, Leaf, Loose, direction};
use super::prefetch::prefetch;
use super::tuning::GROUP;
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
    pub(super) words: &'a [AtomicU16],
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
    mask: u16,
    key: u16,
}

const LOOSE: u32 = 1 << 31;

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
    plane: u16,
    sides: u16,
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
            prefetch(pass.positions, start + y * line);
        }
    }
}

/// The leaves of a tile whose samples are not all in shadow yet, near ones together.
#[inline(always)]
fn collect(pass: &Pass<'_>, tile: usize, scratch: &mut Scratch) {
    let Scratch { leaves, sorted, slots, slots_sorted, counts, .. } = scratch;
    sorted.clear();
    slots.clear();
    let region = pass.tiles.region[tile];
    // Part of the tile's extent, rounded to a number below `steps`: the sum is whole, its low bits are the number.
    let step = |k: usize, x: f32, steps: f32| {
        let scale = (steps - 1.0) / (region.hi[k] - region.lo[k]).max(f32::MIN_POSITIVE);
        ((x - region.lo[k]) * scale + 8_388_608.0).to_bits() as u16 & (steps as u16 - 1)
    };
    for worker in pass.gathered {
        worker.leaves.each(tile, |leaves| {
            for &Leaf { region, block, mask } in leaves {
                let mask = if pass.again { mask & !pass.words[block as usize].load(Relaxed) } else { mask };
                if mask != 0 {
                    // Depth first: what mixes near and far is tested most.
                    let [x, y, r] = region.lo;
                    let key = step(2, r, 4.0) << 4 | step(1, y, 4.0) << 2 | step(0, x, 4.0);
                    sorted.push(Work { region, block, mask, key });
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
    for (i, sixteen) in slots_sorted.chunks(BLOCK).enumerate() {
        let mut region = Region::EMPTY;
        for slot in sixteen {
            region = region.union(&Region { lo: slot.at, hi: slot.at });
        }
        let key = slots_sorted[i * BLOCK].key;
        let key = (key >> 8) << 4 | (key >> 4 & 0xf);
        let mask = (0xffff_u32 >> (BLOCK - sixteen.len())) as u16;
        sorted.push(Work { region, block: LOOSE | (i * BLOCK) as u32, mask, key });
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
    for leaf in leaves {
        let p = frame.turn_sixteen(load(s, pass, slots_sorted, leaf));
        let mut alive = leaf.mask;
        open.clear();
        'blocks: for first in (0..live.len()).step_by(8) {
            let mut near = live_hulls.near(s, first, &leaf.region);
            while near != 0 {
                let (i, mask) = live[first + near.trailing_zeros() as usize];
                near &= near - 1;
                let prepared = &blocks[i as usize];
                counts.leaf_box_tests += 1;
                let (maybe, covers) = prepared.block.cull(s, &leaf.region);
                if covers & mask != 0 {
                    counts.node_accept += 1;
                    alive = 0;
                    break 'blocks;
                }
                let mut maybe = maybe & mask;
                while maybe != 0 {
                    let lane = maybe.trailing_zeros() as usize;
                    maybe &= maybe - 1;
                    counts.pairs += 1;
                    counts.leaf.leaf_tests += u64::from(alive.count_ones());
                    let a = prepared.block.lanes(s, lane, [p[0][0], p[1][0], p[2][0]], alive as u8);
                    let b = prepared.block.lanes(s, lane, [p[0][1], p[1][1], p[2][1]], (alive >> 8) as u8);
                    alive &= !(u16::from(a.blocked) | u16::from(b.blocked) << 8);
                    if alive == 0 {
                        break 'blocks;
                    }
                    let plane = u16::from(a.plane) | u16::from(b.plane) << 8;
                    let sides = u16::from(a.sides) | u16::from(b.sides) << 8;
                    if plane | sides != 0 {
                        open.push(Open { id: prepared.ids[lane], plane, sides });
                    }
                }
            }
        }
        for o in open.iter() {
            if alive == 0 {
                break;
            }
            if (o.plane | o.sides) & alive != 0 {
                alive &= !resolve(s, pass, leaf, slots_sorted, o, alive, counts);
            }
        }
        finish(pass, slots_sorted, leaf, leaf.mask & !alive);
    }
}

/// The samples of a leaf that an open triangle blocks: f64, then exact arithmetic.
#[inline(never)]
fn resolve<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    leaf: &Work,
    slots: &[Slot],
    open: &Open,
    alive: u16,
    counts: &mut Counts,
) -> u16 {
    s.vectorize(
        #[inline(always)]
        || {
            let triangle = &pass.triangles[open.id as usize];
            let p = load(s, pass, slots, leaf);
            let mut blocked = 0;
            let mut hard = open.sides & alive;
            let plane = open.plane & alive;
            counts.leaf.filter_f64 += u64::from((plane | hard).count_ones());
            if plane != 0 {
                if let Some(resolver) = PlaneResolver::new(triangle, pass.light) {
                    for half in 0..2 {
                        if plane >> (8 * half) & 0xff == 0 {
                            continue;
                        }
                        counts.plane_f64 += 1;
                        let (beyond, unsure) = resolver.lanes(s, [p[0][half], p[1][half], p[2][half]]);
                        blocked |= plane & u16::from(beyond) << (8 * half);
                        hard |= plane & u16::from(unsure) << (8 * half);
                    }
                } else {
                    hard |= plane;
                }
            }
            if hard != 0
                && let Some(resolver) = Resolver::new(triangle, pass.light)
            {
                for i in (0..BLOCK).filter(|i| hard >> i & 1 == 1) {
                    let (blocks, decided) =
                        resolver.blocks([p[0][i / 8][i % 8], p[1][i / 8][i % 8], p[2][i / 8][i % 8]]);
                    counts.leaf.filter_exact += u64::from(decided == Decided::Exact);
                    blocked |= u16::from(blocks) << i;
                }
            }
            blocked
        },
    )
}

/// World coordinates of a leaf's samples. What lanes without a sample hold does not matter.
#[inline(always)]
fn load<S: Simd>(s: S, pass: &Pass<'_>, slots: &[Slot], leaf: &Work) -> [[f32x8<S>; 2]; 3] {
    if leaf.block & LOOSE == 0 {
        return pass.layout.load(s, pass.positions, leaf.block as usize);
    }
    let first = (leaf.block & !LOOSE) as usize;
    let mut at = [[0.0; BLOCK]; 3];
    for (i, slot) in slots[first..].iter().take(BLOCK).enumerate() {
        (at[0][i], at[1][i], at[2][i]) = (slot.world[0], slot.world[1], slot.world[2]);
    }
    let [x, y, z] = &at;
    [halves(s, x), halves(s, y), halves(s, z)]
}

/// Notes samples of a leaf that are in shadow.
#[inline(always)]
fn finish(pass: &Pass<'_>, slots: &[Slot], leaf: &Work, shadowed: u16) {
    if shadowed == 0 {
        return;
    }
    if leaf.block & LOOSE == 0 {
        pass.words[leaf.block as usize].fetch_or(shadowed, Relaxed);
        return;
    }
    let first = (leaf.block & !LOOSE) as usize;
    for i in (0..BLOCK).filter(|i| shadowed >> i & 1 == 1) {
        let slot = slots[first + i].slot as usize;
        pass.words[slot / BLOCK].fetch_or(1 << (slot % BLOCK), Relaxed);
    }
}
