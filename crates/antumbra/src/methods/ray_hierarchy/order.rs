//! The order of the leaves: which ray is next to which (section 3.5 of the paper).
//!
//! Sorted: candidates are compacted, then sorted along a Hilbert curve on each of six faces of direction space, after Arvo and
//! Kirk 1987 ("Fast Ray Tracing by Ray Classification") for the faces. Unsorted: screen order, in which every four leaves are a
//! quad of 2 x 2 pixels, every sixteen a square of 4 x 4, and so on; what is no candidate stays as an empty leaf.
//!
//! A sample at the light itself has no direction. It is never blocked (its plane test is `-det[A, B, C]`), so it is no candidate.

use rayon::prelude::*;
use rdst::RadixSort;

use crate::methods::Samples;

/// A leaf without a ray.
pub(super) const EMPTY: u32 = u32::MAX;

/// Bits of each coordinate on a face: two of them and the face fill 31 bits.
const BITS: u32 = 14;

/// Rows and columns of the squares of 64 leaves that unsorted leaves come in.
const TILE: usize = 8;

#[inline(always)]
fn is_candidate(p: [f32; 3], light: [f32; 3]) -> bool {
    !p.iter().any(|v| v.is_nan()) && p != light
}

/// Position along the Hilbert curve that fills a square of `2^BITS` cells a side.
///
/// The classic conversion: from the coarsest bit to the finest, number the quadrant, then turn and mirror the rest so that
/// the curve inside starts where the last quadrant ended.
pub(super) fn hilbert(mut x: u32, mut y: u32) -> u32 {
    let n = 1u32 << BITS;
    let mut d = 0;
    let mut s = n / 2;
    while s > 0 {
        let (rx, ry) = (u32::from(x & s != 0), u32::from(y & s != 0));
        d += s * s * ((3 * rx) ^ ry);
        if ry == 0 {
            if rx == 1 {
                (x, y) = (n - 1 - x, n - 1 - y);
            }
            (x, y) = (y, x);
        }
        s /= 2;
    }
    d
}

/// The sorting key of a candidate: face of its major axis, then position on the face's curve.
pub(super) fn direction_key(p: [f32; 3], light: [f32; 3]) -> u32 {
    let d = [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(light[k]));
    let [x, y, z] = d.map(f64::abs);
    let (major, u, v) = if x >= y && x >= z {
        (0, 1, 2)
    } else if y >= z {
        (1, 2, 0)
    } else {
        (2, 0, 1)
    };
    let face = 2 * major as u32 + u32::from(d[major] < 0.0);
    let length = d[major].abs();
    let cell = |k: usize| {
        let half = f64::from(1u32 << (BITS - 1));
        (((d[k] / length + 1.0) * half) as u32).min((1 << BITS) - 1)
    };
    face << (2 * BITS) | hilbert(cell(u), cell(v))
}

/// Fills `order` with the candidates, neighbours in direction side by side. `keys` is scratch memory.
pub(super) fn by_direction(
    positions: &[[f32; 3]],
    light: [f32; 3],
    keys: &mut Vec<u64>,
    order: &mut Vec<u32>,
) {
    keys.clear();
    keys.par_extend(
        positions
            .par_iter()
            .enumerate()
            .filter(|(_, p)| is_candidate(**p, light))
            .map(|(i, p)| u64::from(direction_key(*p, light)) << 32 | i as u64),
    );
    // The index breaks ties: the tree does not depend on the number of threads.
    keys.radix_sort_unstable();
    order.clear();
    order.par_extend(keys.par_iter().map(|key| *key as u32));
}

/// The bits of `v` at even places.
fn spread(v: u32) -> u64 {
    let mut v = u64::from(v);
    for shift in [16, 8, 4, 2, 1] {
        let mask = u64::MAX / ((1 << shift) + 1);
        v = (v | v << shift) & mask;
    }
    v
}

/// Fills `order` with all samples in screen order, or for a list in list order, [`EMPTY`] where there is no candidate.
pub(super) fn by_screen(samples: Samples<'_>, light: [f32; 3], keys: &mut Vec<u64>, order: &mut Vec<u32>) {
    let positions = samples.positions;
    let entry = |i: usize| if is_candidate(positions[i], light) { i as u32 } else { EMPTY };
    order.clear();
    let width = samples.width.max(1);
    if width >= positions.len() {
        order.par_extend((0..positions.len()).into_par_iter().map(entry));
        return;
    }
    let height = positions.len().div_ceil(width);
    let columns = width.div_ceil(TILE);
    keys.clear();
    keys.extend((0..columns * height.div_ceil(TILE)).map(|tile| {
        let (x, y) = ((tile % columns) as u32, (tile / columns) as u32);
        // Tiles are fewer than 2^26, so that 16 bits of each coordinate do unless the picture is a ribbon, whose far tiles
        // then sort by their low bits: another order, no other answer.
        (spread(x & 0xffff) | spread(y & 0xffff) << 1) << 32 | tile as u64
    }));
    keys.radix_sort_unstable();
    order.resize(keys.len() * TILE * TILE, EMPTY);
    order.par_chunks_mut(TILE * TILE).zip(keys.par_iter()).for_each(|(leaves, key)| {
        let tile = (*key & 0xffff_ffff) as usize;
        let (left, top) = (tile % columns * TILE, tile / columns * TILE);
        for (i, leaf) in leaves.iter_mut().enumerate() {
            let bit = |b: usize| i >> b & 1;
            let x = left + (bit(0) | bit(2) << 1 | bit(4) << 2);
            let y = top + (bit(1) | bit(3) << 1 | bit(5) << 2);
            let index = y * width + x;
            *leaf = if x < width && index < positions.len() { entry(index) } else { EMPTY };
        }
    });
}
