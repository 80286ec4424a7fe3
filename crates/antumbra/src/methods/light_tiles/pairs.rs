//! Eight blocks of eight triangles against leaves, in flat loops: the bounds of blocks against 64 leaves at a time; what is left of that against the
//! triangles of the blocks; what is left of that, pairs of a leaf and a triangle, sample by sample. Loops within loops would end at moments
//! that no processor can foretell.

use std::array::from_ref;

use fearless_simd::Simd;

use super::boxes::LEAVES;
use super::chunk::{BLOCKS, Chunk, Setup};
use super::frame::Frame;
use super::layout::HALF;
use super::leaf::LOW;
use super::state::{Open, Points, State};
use super::tuning::MOST_LEAVES;
use super::work::{Counts, Pass};

/// Pairs whose samples are first held against the sides alone, in one go.
const PAIRS: usize = 64;

// Three bits of a block and three of a lane, beside the number of a leaf, in sixteen bits.
const _: () = assert!(BLOCKS == 8 && 64 * LEAVES <= 1 << 16);
const _: () = assert!(LEAVES.is_multiple_of(16) && MOST_LEAVES.is_multiple_of(LEAVES));

/// Memory that is not worth clearing each time.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct Memory {
    /// Leaf, and three bits of the block.
    boxes: [u16; 8 * LEAVES + 8],
    /// The same, and three bits of the lane.
    pairs: [u16; 64 * LEAVES],
    /// By leaf and block.
    within: [u8; 8 * LEAVES],
    /// Pairs, and the samples that are not beside the triangle.
    left: [(u16, u16); PAIRS],
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            boxes: [0; 8 * LEAVES + 8],
            pairs: [0; 64 * LEAVES],
            within: [0; 8 * LEAVES],
            left: [(0, 0); PAIRS],
        }
    }
}

/// Tests some leaves of a tile: at most [`LEAVES`], loaded, and the first one's number a multiple of that. In a dense tile, where leaves have sixteen
/// samples at most, pairs are first held against the sides alone: most samples are beside most triangles.
#[inline(always)]
pub(super) fn test<S: Simd, const IS_DENSE: bool>(
    s: S,
    pass: &Pass<'_>,
    setup: &Setup<'_>,
    chunk: &mut Chunk,
    range: std::ops::Range<usize>,
    state: &mut State,
    memory: &mut Memory,
    counts: &mut Counts,
) {
    let Memory { boxes, pairs, within, left } = memory;
    let (first, sixteens) = (range.start, range.len().div_ceil(16));
    debug_assert!(first.is_multiple_of(LEAVES) && range.len() <= LEAVES);
    let State { parts, boxes: bounds, there, alive, points, seen, open } = state;
    let (parts, alive, points) = (&parts[range.clone()], &mut alive[first..], &points[range.clone()]);
    let (bounds, there) = (&bounds[first / LEAVES], there[first / LEAVES]);
    let (mut count, mut all_near) = (0, 0);
    for block in 0..chunk.used {
        let near = bounds.near(s, chunk.hulls[block]) & there;
        for (i, near) in near.to_le_bytes().as_chunks::<2>().0[..sixteens].iter().enumerate() {
            for half in 0..2 {
                let (at, near) = ((128 * i + 64 * half + block) as u16, near[half]);
                let next = &mut boxes[count..][..8];
                for k in 0..8 {
                    next[k] = 8 * BITS[usize::from(near)][k] + at;
                }
                count += near.count_ones() as usize;
            }
        }
        all_near |= u8::from(near != 0) << block;
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
    let pairs = &pairs[..pair_count];
    let found = Found { chunk, within, points, first, frame: setup.sight.frame };
    if IS_DENSE {
        test_left(s, found, pairs, &seen[range], left, alive, open, counts);
    } else {
        test_all(s, found, pairs, alive, open, counts);
    }
}

/// Where pairs lead to.
#[derive(Clone, Copy)]
struct Found<'a> {
    chunk: &'a Chunk,
    within: &'a [u8; 8 * LEAVES],
    points: &'a [Points],
    first: usize,
    frame: Frame,
}

/// Samples of whole and half blocks.
#[inline(always)]
fn test_all<S: Simd>(
    s: S,
    found: Found<'_>,
    pairs: &[u16],
    alive: &mut [u32],
    open: &mut Vec<Open>,
    counts: &mut Counts,
) {
    let (mut tests, mut done) = (0, 0);
    for &pair in pairs {
        let samples = alive[usize::from(pair >> 6)];
        if samples != 0 {
            tests += u64::from(samples.count_ones());
            done += 1;
            found.test::<S, true>(s, pair, samples, alive, open);
        }
    }
    counts.pairs += done;
    counts.leaf.leaf_tests += tests;
}

/// Up to sixteen samples a leaf, and only those that are not beside the triangle by their directions (`seen`).
#[inline(always)]
fn test_left<S: Simd>(
    s: S,
    found: Found<'_>,
    pairs: &[u16],
    seen: &[[[f32; HALF]; 2]],
    left: &mut [(u16, u16); PAIRS],
    alive: &mut [u32],
    open: &mut Vec<Open>,
    counts: &mut Counts,
) {
    let mut tests = 0;
    for pairs in pairs.chunks(PAIRS) {
        let mut count = 0;
        for &pair in pairs {
            let (leaf, lane) = (usize::from(pair >> 6), usize::from(pair & 7));
            let [x, y] = &seen[leaf];
            let block = &found.chunk.blocks[usize::from(pair >> 3) & 7].block;
            let samples = block.not_beside(s, lane, [x, y]) & alive[leaf];
            // Whether any is left cannot be foretold: no branch.
            left[count % PAIRS] = (pair, samples as u16);
            count += usize::from(samples != 0);
        }
        for &(pair, samples) in &left[..count] {
            let samples = u32::from(samples) & alive[usize::from(pair >> 6)];
            if samples != 0 {
                tests += u64::from(samples.count_ones());
                found.test::<S, false>(s, pair, samples, alive, open);
            }
        }
    }
    counts.pairs += pairs.len() as u64;
    counts.leaf.leaf_tests += tests;
}

impl Found<'_> {
    /// Some samples of a leaf, all four tests.
    #[inline(always)]
    fn test<S: Simd, const MAY_BE_WHOLE: bool>(
        self,
        s: S,
        pair: u16,
        samples: u32,
        alive: &mut [u32],
        open: &mut Vec<Open>,
    ) {
        let (at, leaf, lane) = (usize::from(pair >> 3), usize::from(pair >> 6), usize::from(pair & 7));
        let prepared = &self.chunk.blocks[at & 7];
        let inside = self.within[at % self.within.len()] >> lane & 1 == 1;
        let Frame { axis: [u, v, w], sign } = self.frame;
        let p = &self.points[leaf];
        let tested = if MAY_BE_WHOLE && samples > LOW {
            prepared.block.test(s, lane, [&p[u], &p[v], &p[w]], sign, samples, inside)
        } else {
            let first = [from_ref(&p[u][0]), from_ref(&p[v][0]), from_ref(&p[w][0])];
            prepared.block.test(s, lane, first, sign, samples, inside)
        };
        alive[leaf] &= !tested.blocked;
        if tested.plane | tested.sides != 0 {
            let (plane, sides) = (tested.plane, tested.sides);
            open.push(Open { id: prepared.ids[lane], leaf: (self.first + leaf) as u32, plane, sides });
        }
    }
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
