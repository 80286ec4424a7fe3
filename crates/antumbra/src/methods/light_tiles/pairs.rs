//! Leaves against eight blocks of eight triangles, in three flat loops: leaves against the bounds of blocks; what is left of that against the
//! triangles of the blocks; what is left of that, pairs of a leaf and a triangle, sample by sample. Loops within loops would end at moments
//! that no processor can foretell.

use std::array::from_ref;

use antumbra_predicates::plane::PlaneResolver;
use antumbra_predicates::resolve::{Decided, Resolver};
use antumbra_predicates::tile::Part;
use fearless_simd::{Simd, SimdBase, f32x8};

use super::chunk::{Chunk, Setup};
use super::layout::HALF;
use super::leaves::{LOOSE, LOW, Leaf, Loose, load_loose};
use super::tuning::LEAVES;
use super::work::{Counts, Pass};

/// A triangle and the samples of a leaf for which f32 was not enough.
#[derive(Clone, Copy, Debug)]
struct Open {
    id: u32,
    leaf: u32,
    plane: u32,
    sides: u32,
}

/// Samples of a leaf: world coordinates of two times sixteen. What lanes without a sample hold does not matter.
type Points = [[[f32; HALF]; 2]; 3];

/// The leaves of a tile while its triangles go by.
#[derive(Debug, Default)]
pub(super) struct State {
    parts: Vec<Part>,
    /// Samples that are not known to be in shadow. Those of half a block are the first sixteen, whichever half it is.
    alive: Vec<u32>,
    points: Vec<Points>,
    open: Vec<Open>,
}

impl State {
    /// Nothing is known yet.
    #[inline(always)]
    pub(super) fn start<S: Simd>(&mut self, s: S, leaves: &[Leaf]) {
        self.parts.clear();
        self.alive.clear();
        self.open.clear();
        for leaf in leaves {
            self.parts.push(Part::new(s, leaf.sides(s)));
            self.alive.push(leaf.mask() >> shift(leaf));
        }
        // What is in them does not matter yet.
        if self.points.len() < leaves.len() {
            self.points.resize(leaves.len(), [[[0.0; HALF]; 2]; 3]);
        }
    }

    /// Whether some sample is not known to be in shadow.
    pub(super) fn is_alive(&self) -> bool {
        self.alive.iter().any(|alive| *alive != 0)
    }

    /// Decides what f32 could not, and notes the samples that are in shadow.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(
        &mut self,
        s: S,
        pass: &Pass<'_>,
        leaves: &[Leaf],
        loose: &[Loose],
        words: &mut [u32],
        counts: &mut Counts,
    ) {
        let State { alive, points, open, .. } = self;
        for o in open.iter() {
            let leaf = o.leaf as usize;
            let (plane, sides) = (o.plane & alive[leaf], o.sides & alive[leaf]);
            if plane | sides != 0 {
                alive[leaf] &= !resolve(s, pass, o.id, &points[leaf], plane, sides, counts);
            }
        }
        for (leaf, alive) in leaves.iter().zip(alive) {
            note(words, loose, leaf, leaf.mask() & !(*alive << shift(leaf)));
        }
    }
}

/// Memory that is not worth clearing each time.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct Memory {
    /// Leaf, and three bits of the block.
    boxes: [u16; 8 * LEAVES],
    /// The same, and three bits of the lane.
    pairs: [u16; 64 * LEAVES],
    /// By leaf and block.
    within: [u8; 8 * LEAVES],
}

impl Default for Memory {
    fn default() -> Memory {
        Memory { boxes: [0; 8 * LEAVES], pairs: [0; 64 * LEAVES], within: [0; 8 * LEAVES] }
    }
}

/// Tests up to [`LEAVES`] leaves, from number `first` on. If `load`, their samples have not been loaded yet.
#[inline(always)]
pub(super) fn test<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    setup: &Setup,
    chunk: &mut Chunk,
    leaves: &[Leaf],
    loose: &[Loose],
    first: usize,
    load: bool,
    state: &mut State,
    memory: &mut Memory,
    counts: &mut Counts,
) {
    let Memory { boxes, pairs, within } = memory;
    let State { parts, alive, points, open } = state;
    let (parts, alive, points) = (&parts[first..], &mut alive[first..], &mut points[first..]);
    if load {
        for (leaf, points) in leaves.iter().zip(&mut *points) {
            load_points(s, pass, leaf, loose, points);
        }
    }
    let (mut count, mut all_near) = (0, 0);
    for i in 0..leaves.len() {
        let near = if alive[i] == 0 { 0 } else { chunk.boxes.near(s, &parts[i]) };
        let next = &mut boxes[count..][..8];
        for k in 0..8 {
            next[k] = BITS[near as usize][k] + 8 * i as u16;
        }
        count += near.count_ones() as usize;
        all_near |= near;
    }
    chunk.make_ready(s, pass, setup, all_near, counts);
    let mut pair_count = 0;
    for &at in &boxes[..count] {
        let (leaf, block) = (usize::from(at >> 3), usize::from(at & 7));
        if alive[leaf] == 0 {
            continue;
        }
        let prepared = &chunk.blocks[block];
        counts.leaf_box_tests += 1;
        let found = prepared.block.cull(s, &parts[leaf]);
        if found.covers & prepared.live != 0 {
            counts.node_accept += 1;
            alive[leaf] = 0;
            continue;
        }
        within[usize::from(at) % within.len()] = found.within;
        let maybe = found.maybe & prepared.live;
        let next = &mut pairs[pair_count..][..8];
        for k in 0..8 {
            next[k] = BITS[maybe as usize][k] + 8 * at;
        }
        pair_count += maybe.count_ones() as usize;
    }
    let [u, v, w] = setup.frame.axis;
    let sign = setup.frame.sign;
    let (mut tests, mut done) = (0, 0);
    for &pair in &pairs[..pair_count] {
        let (at, lane) = (usize::from(pair >> 3), usize::from(pair & 7));
        let leaf = at >> 3;
        let of_leaf = alive[leaf];
        if of_leaf == 0 {
            continue;
        }
        tests += u64::from(of_leaf.count_ones());
        done += 1;
        let prepared = &chunk.blocks[at & 7];
        let inside = within[at % within.len()] >> lane & 1 == 1;
        let p = &points[leaf];
        let tested = if of_leaf <= LOW {
            let first = [from_ref(&p[u][0]), from_ref(&p[v][0]), from_ref(&p[w][0])];
            prepared.block.test(s, lane, first, sign, of_leaf, inside)
        } else {
            prepared.block.test(s, lane, [&p[u], &p[v], &p[w]], sign, of_leaf, inside)
        };
        alive[leaf] = of_leaf & !tested.blocked;
        if tested.plane | tested.sides != 0 {
            let (plane, sides) = (tested.plane, tested.sides);
            open.push(Open { id: prepared.ids[lane], leaf: (first + leaf) as u32, plane, sides });
        }
    }
    counts.pairs += done;
    counts.leaf.leaf_tests += tests;
}

/// Of half a block that is the right one, how far its samples are moved to be the first.
#[inline(always)]
fn shift(leaf: &Leaf) -> usize {
    if leaf.mask() & LOW == 0 { HALF } else { 0 }
}

/// The numbers of the bits that are set.
const BITS: [[u16; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut at) = (0, 0);
        while bit < 8 {
            if mask >> bit & 1 == 1 {
                table[mask][at] = bit;
                at += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
};

#[inline(always)]
fn load_points<S: Simd>(s: S, pass: &Pass<'_>, leaf: &Leaf, loose: &[Loose], points: &mut Points) {
    let block = leaf.block();
    let half = if block & LOOSE != 0 {
        let first = (block & !LOOSE) as usize;
        load_loose(s, &loose[first..loose.len().min(first + HALF)])
    } else if leaf.is_whole() {
        let whole = pass.layout.load(s, pass.positions, block as usize);
        for k in 0..3 {
            for i in 0..2 {
                s.combine_f32x8(whole[k][2 * i], whole[k][2 * i + 1]).store_array(&mut points[k][i]);
            }
        }
        return;
    } else {
        pass.layout.load_half(s, pass.positions, block as usize, usize::from(leaf.mask() & LOW == 0))
    };
    for k in 0..3 {
        s.combine_f32x8(half[k][0], half[k][1]).store_array(&mut points[k][0]);
    }
}

/// The samples that an open triangle blocks: f64, then exact arithmetic. `plane` and `sides` are those to decide.
#[inline(never)]
fn resolve<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    id: u32,
    p: &Points,
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
                    for v in 0..2 {
                        for half in 0..2 {
                            let shift = HALF * v + 8 * half;
                            if plane >> shift & 0xff == 0 {
                                continue;
                            }
                            counts.plane_f64 += 1;
                            let at = |v: &[f32; HALF]| f32x8::from_slice(s, &v[8 * half..8 * half + 8]);
                            let (beyond, unsure) =
                                resolver.lanes(s, [at(&p[0][v]), at(&p[1][v]), at(&p[2][v])]);
                            blocked |= plane & u32::from(beyond) << shift;
                            hard |= plane & u32::from(unsure) << shift;
                        }
                    }
                } else {
                    hard |= plane;
                }
            }
            if hard != 0
                && let Some(resolver) = Resolver::new(triangle, pass.light)
            {
                for i in (0..2 * HALF).filter(|i| hard >> i & 1 == 1) {
                    let (blocks, decided) = resolver.blocks([
                        p[0][i / HALF][i % HALF],
                        p[1][i / HALF][i % HALF],
                        p[2][i / HALF][i % HALF],
                    ]);
                    counts.leaf.filter_exact += u64::from(decided == Decided::Exact);
                    blocked |= u32::from(blocks) << i;
                }
            }
            blocked
        },
    )
}

/// Notes samples of a leaf that are in shadow.
#[inline(always)]
fn note(words: &mut [u32], loose: &[Loose], leaf: &Leaf, shadowed: u32) {
    if shadowed == 0 {
        return;
    }
    if leaf.block() & LOOSE == 0 {
        words[leaf.block() as usize] |= shadowed;
        return;
    }
    let first = (leaf.block() & !LOOSE) as usize;
    for i in (0..HALF).filter(|i| shadowed >> i & 1 == 1) {
        let (block, sample) = loose[first + i].slot();
        words[block] |= 1 << sample;
    }
}
