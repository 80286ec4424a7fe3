//! A group of leaves against the triangles that may concern it.
//!
//! Three loops, one after the other: leaves against bounds of blocks of triangles; what is left of that, leaves against blocks; what is
//! left of that, samples against triangles. Loops within loops would do the same work, but each inner loop ends at a moment that no
//! processor can foretell, once a leaf or a block, and that costs more than the tests.

use std::array::from_ref;

use antumbra_predicates::plane::PlaneResolver;
use antumbra_predicates::resolve::{Decided, Resolver};
use antumbra_predicates::tile::Part;
use fearless_simd::{Simd, SimdBase, f32x8};

use super::boxes::Boxes;
use super::frame::Frame;
use super::layout::HALF;
use super::leaves::{LOOSE, LOW, Leaf, Loose, load_loose};
use super::tuning::{FEW_BLOCKS, GROUP};
use super::work::{Counts, Pass, Prepared};

/// A triangle and the samples of a leaf of the group for which f32 was not enough.
#[derive(Clone, Copy, Debug)]
struct Open {
    id: u32,
    leaf: u32,
    plane: u32,
    sides: u32,
}

/// Blocks of triangles that may concern a group of leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocks<'a> {
    pub(super) all: &'a [Prepared],
    /// Number and lanes.
    pub(super) live: &'a [(u32, u8)],
    /// Bounds of those in `live`, if they are more than [`FEW_BLOCKS`].
    pub(super) hulls: &'a Boxes,
}

/// Samples of a leaf: world coordinates of two times sixteen. What lanes without a sample hold does not matter.
type Points = [[[f32; HALF]; 2]; 3];

/// Memory that is not worth clearing for each group.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct Memory {
    points: [Points; GROUP],
    /// Leaf and block: three bits each.
    boxes: [u8; 8 * GROUP],
    /// Leaf, block and lane.
    pairs: [u16; 64 * GROUP],
    /// By leaf and block.
    within: [u8; 8 * GROUP],
    open: Vec<Open>,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            points: [[[[0.0; HALF]; 2]; 3]; GROUP],
            boxes: [0; 8 * GROUP],
            pairs: [0; 64 * GROUP],
            within: [0; 8 * GROUP],
            open: Vec::new(),
        }
    }
}

/// Tests up to [`GROUP`] leaves, and notes their samples that are in shadow.
#[inline(always)]
pub(super) fn test<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    frame: &Frame,
    blocks: &Blocks<'_>,
    leaves: &[Leaf],
    loose: &[Loose],
    memory: &mut Memory,
    words: &mut [u32],
    counts: &mut Counts,
) {
    let Memory { points, boxes, pairs, within, open } = memory;
    let mut parts = [Part::ZERO; GROUP];
    // Samples that are not known to be in shadow. Those of half a block are the first sixteen, whichever half it is.
    let mut alive = [0u32; GROUP];
    for (i, leaf) in leaves.iter().enumerate() {
        parts[i] = Part::new(s, leaf.sides(s));
        alive[i] = leaf.mask() >> shift(leaf);
        load(s, pass, leaf, loose, &mut points[i]);
    }
    open.clear();
    let [u, v, w] = frame.axis;
    for first in (0..blocks.live.len()).step_by(8) {
        let mut count = 0;
        for i in 0..leaves.len() {
            let near = if blocks.live.len() <= FEW_BLOCKS {
                (1 << blocks.live.len()) - 1
            } else {
                blocks.hulls.near(s, first, &parts[i])
            };
            let near = if alive[i] == 0 { 0 } else { near };
            let next = &mut boxes[count..][..8];
            for k in 0..8 {
                next[k] = BITS[near as usize][k] as u8 + 8 * i as u8;
            }
            count += near.count_ones() as usize;
        }
        let mut pair_count = 0;
        for &at in &boxes[..count] {
            let (leaf, block) = (usize::from(at >> 3) % GROUP, usize::from(at & 7));
            if alive[leaf] == 0 {
                continue;
            }
            let (i, lanes) = blocks.live[first + block];
            counts.leaf_box_tests += 1;
            let found = blocks.all[i as usize].block.cull(s, &parts[leaf]);
            if found.covers & lanes != 0 {
                counts.node_accept += 1;
                alive[leaf] = 0;
                continue;
            }
            within[usize::from(at) % within.len()] = found.within;
            let maybe = found.maybe & lanes;
            let next = &mut pairs[pair_count..][..8];
            for k in 0..8 {
                next[k] = BITS[maybe as usize][k] + 8 * u16::from(at);
            }
            pair_count += maybe.count_ones() as usize;
        }
        let (mut tests, mut done) = (0, 0);
        for &pair in &pairs[..pair_count] {
            let (at, lane) = (usize::from(pair >> 3), usize::from(pair & 7));
            let leaf = at / 8 % GROUP;
            let of_leaf = alive[leaf];
            if of_leaf == 0 {
                continue;
            }
            tests += u64::from(of_leaf.count_ones());
            done += 1;
            let prepared = &blocks.all[blocks.live[first + at % 8].0 as usize];
            let inside = within[at % within.len()] >> lane & 1 == 1;
            let p = &points[leaf];
            let tested = if of_leaf <= LOW {
                let first = [from_ref(&p[u][0]), from_ref(&p[v][0]), from_ref(&p[w][0])];
                prepared.block.test(s, lane, first, frame.sign, of_leaf, inside)
            } else {
                prepared.block.test(s, lane, [&p[u], &p[v], &p[w]], frame.sign, of_leaf, inside)
            };
            alive[leaf] = of_leaf & !tested.blocked;
            if tested.plane | tested.sides != 0 {
                let (plane, sides) = (tested.plane, tested.sides);
                open.push(Open { id: prepared.ids[lane], leaf: leaf as u32, plane, sides });
            }
        }
        counts.pairs += done;
        counts.leaf.leaf_tests += tests;
    }
    for o in open.iter() {
        let leaf = o.leaf as usize;
        let (plane, sides) = (o.plane & alive[leaf], o.sides & alive[leaf]);
        if plane | sides != 0 {
            alive[leaf] &= !resolve(s, pass, o.id, &points[leaf], plane, sides, counts);
        }
    }
    for (leaf, alive) in leaves.iter().zip(alive) {
        finish(words, loose, leaf, leaf.mask() & !(alive << shift(leaf)));
    }
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
fn load<S: Simd>(s: S, pass: &Pass<'_>, leaf: &Leaf, loose: &[Loose], points: &mut Points) {
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
fn finish(words: &mut [u32], loose: &[Loose], leaf: &Leaf, shadowed: u32) {
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
