//! The triangles of a tile, in chunks of eight blocks of eight: what stays in the first cache while all leaves go by.

use antumbra_predicates::tile::{Tile, TileBlock};
use antumbra_predicates::{Triangle, exact};
use fearless_simd::Simd;

use super::bin::Eight;
use super::boxes::{Coarse, Steps};
use super::prefetch::{prefetch, prefetch_eight};
use super::shuffle::corners;
use super::sight::Sight;
use super::state::State;
use super::work::{Counts, Pass};

/// Blocks of a chunk.
pub(super) const BLOCKS: usize = 8;

/// Blocks of triangles that are asked for before they are looked at; less than eight.
const AHEAD: usize = 6;

/// The list's triangles, eight by eight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eights<'a> {
    /// Of single ones, `count` in all, up to whole eights.
    pub(super) ids: &'a [[u32; 8]],
    pub(super) count: usize,
    pub(super) more: &'a [Eight],
}

impl Eights<'_> {
    pub(super) fn len(&self) -> usize {
        self.ids.len() + self.more.len()
    }

    /// Eight triangles, which of them count, and their bounds, if they are known.
    #[inline(always)]
    fn get(&self, i: usize) -> ([u32; 8], u8, Option<Coarse>) {
        if let Some(ids) = self.ids.get(i) {
            let there = (self.count - 8 * i).min(8);
            return (*ids, (0xffu32 >> (8 - there)) as u8, None);
        }
        let Eight { first, lanes, hull, .. } = self.more[i - self.ids.len()];
        ([0, 1, 2, 3, 4, 5, 6, 7].map(|k| first + k), lanes, Some(hull))
    }

    /// Bounds, if they are known.
    #[inline(always)]
    fn hull(&self, i: usize) -> Option<Coarse> {
        Some(self.more.get(i.checked_sub(self.ids.len())?)?.hull)
    }

    /// The triangles will be needed soon.
    #[inline(always)]
    fn ask_for(&self, pass: &Pass<'_>, i: usize) {
        if let Some(ids) = self.ids.get(i) {
            let numbers = pass.triangles.as_flattened().as_flattened();
            for &id in ids {
                // More than half of them lie in two cache lines.
                prefetch(numbers, 9 * id as usize);
                prefetch(numbers, 9 * id as usize + 8);
            }
        } else if let Some(eight) = self.more.get(i - self.ids.len()) {
            prefetch_eight(pass.triangles, eight.first as usize);
        }
    }
}

/// What it takes to prepare triangles for a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup<'a> {
    tile: Tile,
    pub(super) steps: Steps,
    pub(super) sight: &'a Sight,
}

impl<'a> Setup<'a> {
    pub(super) fn new(pass: &Pass<'a>, tile: usize) -> Setup<'a> {
        let sight = &pass.tiles.sights.faces[pass.tiles.face[tile] as usize];
        // Bounds in the list are in steps of the tile whose list it is.
        let steps = pass.tiles.steps[pass.tiles.list[tile] as usize];
        Setup { tile: Tile::new(sight.aim, pass.tiles.region[tile]), steps, sight }
    }
}

/// Eight triangles, or their numbers only ([`Chunk`] says which); what bounds do not need is prepared when they meet a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prepared {
    pub(super) block: TileBlock,
    pub(super) ids: [u32; 8],
    /// Those that count, one bit each.
    pub(super) live: u8,
}

impl Prepared {
    /// Reads the triangles, and finds those that may block a sample of the tile by their bounds.
    #[inline(always)]
    fn look<S: Simd>(&mut self, s: S, triangles: &[Triangle], setup: &Setup) {
        let [a, b, c, d, e, f, g, h] = self.ids;
        let at = |id: u32| &triangles[id as usize];
        let mut corner = corners(s, [at(a), at(b), at(c), at(d), at(e), at(f), at(g), at(h)]);
        for corner in &mut corner {
            *corner = setup.sight.frame.turn_eight(*corner);
        }
        self.live = self.block.look(s, corner, self.live, &setup.tile);
    }

    /// True if one of them covers the tile.
    #[inline(never)]
    fn make_ready<S: Simd>(
        &mut self,
        s: S,
        triangles: &[Triangle],
        setup: &Setup<'_>,
        counts: &mut Counts,
    ) -> bool {
        s.vectorize(
            #[inline(always)]
            || {
                counts.prepared += u64::from(self.live.count_ones());
                let verdict = self.block.prepare(s, self.live, &setup.tile);
                self.live = verdict.maybe;
                let mut edge_on = verdict.edge_on;
                while edge_on != 0 {
                    let lane = edge_on.trailing_zeros() as usize;
                    edge_on &= edge_on - 1;
                    let triangle = &triangles[self.ids[lane] as usize];
                    match exact::facing(&triangle.map(|p| setup.sight.frame.turn(p)), setup.sight.aim.light())
                    {
                        0 => self.live &= !(1 << lane),
                        1 => {}
                        _ => self.block.flip(lane),
                    }
                }
                counts.kept += u64::from(self.live.count_ones());
                verdict.covers & self.live != 0
            },
        )
    }
}

/// Eight blocks.
#[derive(Debug)]
pub(super) struct Chunk {
    pub(super) blocks: [Prepared; BLOCKS],
    pub(super) hulls: [Coarse; BLOCKS],
    /// Blocks in use.
    pub(super) used: usize,
    /// Not prepared yet; bits are blocks.
    fresh: u8,
    /// Not read yet; bits are blocks.
    unread: u8,
    /// Eights of the list that meet no leaf, as far as was looked ahead; by their numbers modulo eight.
    skip: u8,
}

impl Default for Chunk {
    fn default() -> Chunk {
        let empty = Prepared { block: TileBlock::ZERO, ids: [0; 8], live: 0 };
        Chunk { blocks: [empty; BLOCKS], hulls: [[0; 5]; BLOCKS], used: 0, fresh: 0, unread: 0, skip: 0 }
    }
}

impl Chunk {
    /// Takes the next triangles, from eight `next` on, that may block a sample of the tile; those before eight `at_once` are prepared, those whose
    /// common bounds are known are not read yet. True if one covers the tile.
    #[inline(always)]
    pub(super) fn fill<S: Simd>(
        &mut self,
        s: S,
        pass: &Pass<'_>,
        setup: &Setup<'_>,
        eights: &Eights<'_>,
        next: &mut usize,
        at_once: usize,
        state: &State,
        counts: &mut Counts,
    ) -> bool {
        (self.fresh, self.unread) = (0, 0);
        let mut used = 0;
        let is_first = *next == 0;
        if is_first {
            self.skip = 0;
            for i in 0..AHEAD {
                eights.ask_for(pass, i);
            }
        }
        while used < BLOCKS && *next < eights.len() {
            let (bit, ahead) = (1 << (*next % 8), *next + AHEAD);
            let skip = self.skip & bit != 0;
            self.skip &= !bit;
            // Leaves are known from the second chunk on.
            if !is_first
                && let Some(hull) = eights.hull(ahead)
                && !state.meets(s, hull)
            {
                self.skip |= 1 << (ahead % 8);
            } else {
                eights.ask_for(pass, ahead);
            }
            if skip {
                *next += 1;
                continue;
            }
            let (eight, live, hull) = eights.get(*next);
            let prepared = &mut self.blocks[used];
            (prepared.ids, prepared.live) = (eight, live);
            if let Some(hull) = hull
                && *next >= at_once
            {
                *next += 1;
                self.hulls[used] = hull;
                self.fresh |= 1 << used;
                self.unread |= 1 << used;
                used += 1;
                continue;
            }
            prepared.look(s, pass.triangles, setup);
            let now = *next < at_once && prepared.live != 0;
            if now && prepared.make_ready(s, pass.triangles, setup, counts) {
                return true;
            }
            *next += 1;
            if prepared.live != 0 {
                self.hulls[used] = setup.steps.of(s, prepared.block.hull(s, prepared.live));
                self.fresh |= u8::from(!now) << used;
                used += 1;
            }
        }
        self.used = used;
        false
    }

    /// Prepares what is not yet of some of the blocks.
    #[inline(always)]
    pub(super) fn make_ready<S: Simd>(
        &mut self,
        s: S,
        pass: &Pass<'_>,
        setup: &Setup<'_>,
        blocks: u8,
        counts: &mut Counts,
    ) {
        let mut left = self.fresh & blocks;
        self.fresh &= !blocks;
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            if self.unread >> i & 1 == 1 {
                self.blocks[i].look(s, pass.triangles, setup);
            }
            self.blocks[i].make_ready(s, pass.triangles, setup, counts);
        }
    }
}
