//! Which samples belong together: tiles of the picture, cut into depth slices where asked for, each with its box.

use fearless_simd::dispatch;
use rayon::prelude::*;

use super::boxes::Aabb;
use super::space::{Space, V3};
use crate::Isa;
use crate::samples::View;

/// How samples become tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tiling {
    /// A picture in tiles of `tile` pixels.
    Picture { width: usize, tile: [usize; 2] },
    /// A sorted list in runs.
    Runs { length: usize },
}

impl Tiling {
    /// Samples of a row of tiles (of 64 runs): what one task takes.
    pub(crate) fn band(&self) -> usize {
        match *self {
            Tiling::Picture { width, tile } => width.max(1) * tile[1],
            Tiling::Runs { length } => length * 64,
        }
    }

    /// Tiles of a band of `len` samples.
    fn tiles(&self, len: usize) -> usize {
        match *self {
            Tiling::Picture { width, tile } => width.div_ceil(tile[0]),
            Tiling::Runs { length } => len.div_ceil(length),
        }
    }

    /// Calls `each(bit, index)` for the samples of a tile; `index` counts within the band.
    #[inline(always)]
    pub(crate) fn for_each(&self, len: usize, tile: usize, mut each: impl FnMut(usize, usize)) {
        match *self {
            Tiling::Picture { width, tile: [w, h] } => {
                for row in 0..h.min(len / width) {
                    for column in tile * w..width.min((tile + 1) * w) {
                        each(row * w + column - tile * w, row * width + column);
                    }
                }
            }
            Tiling::Runs { length } => {
                for i in tile * length..len.min((tile + 1) * length) {
                    each(i - tile * length, i);
                }
            }
        }
    }
}

/// Depth slices of exponentially growing thickness, about as deep as a tile of the picture is high.
///
/// methods.md 4.1 numbers slices by `ln(w / near) / ln(1 + 2 tan(fov / 2) / tiles)`. Here a piecewise linear logarithm (the
/// bits of an f32) does: slices are at most 1.45 times thicker or thinner than meant, and no logarithm is taken per sample.
/// Numbers are counted from the nearest sample's slice and as wide as they need to be: nothing saturates (4.2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slices {
    per_bit: f64,
}

impl Slices {
    /// For a picture of `tiles` rows of tiles.
    pub(crate) fn new(view: &View, tiles: usize) -> Slices {
        let length = |v: V3| super::space::dot(v, v).sqrt();
        let ratio = (2.0 * length(view.up) / length(view.forward) / tiles.max(1) as f64).ln_1p();
        let per_octave = (2f64.ln() / ratio).clamp(1.0, 65536.0);
        Slices { per_bit: per_octave / f64::from(1u32 << 23) }
    }

    /// The slice of a sample at `w = 1 / z`.
    #[inline(always)]
    fn slice(&self, z: f64) -> u32 {
        (f64::from(((1.0 / z) as f32).to_bits()) * self.per_bit) as u32
    }
}

/// A tile, or the part of a tile that lies in one slice: a leaf of the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    /// Which samples of the tile: bit = place in the tile.
    pub(crate) mask: u64,
    pub(crate) slice: u32,
    pub(crate) bounds: Aabb,
    /// The leaf that it became.
    pub(crate) leaf: u32,
}

/// The records of a row of tiles. Memory is kept between frames.
#[derive(Debug, Default)]
pub(crate) struct Band {
    pub(crate) records: Vec<Record>,
    /// Where the records of each tile end.
    pub(crate) ends: Vec<u32>,
    residual: V3,
    good: bool,
}

/// Slots of a tile at most: one bit each.
pub(crate) const MAX_TILE: usize = 64;

/// What all tiles of a frame share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan<'a> {
    pub(crate) isa: Isa,
    pub(crate) tiling: Tiling,
    pub(crate) slices: Option<Slices>,
    pub(crate) space: &'a Space,
}

/// Like `f64::max`, but a single instruction: NaN in `a` does not count.
#[inline(always)]
fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Band {
    #[inline(always)]
    fn collect(&mut self, positions: &[[f32; 3]], plan: &Plan<'_>) {
        let Plan { tiling, slices, space, .. } = *plan;
        self.records.clear();
        self.ends.clear();
        self.residual = [0.0; 3];
        self.good = true;
        let mut points = [[0f32; MAX_TILE]; 3];
        let mut at = [[0f64; MAX_TILE]; 3];
        let mut place = [0u8; MAX_TILE];
        let mut slice = [0u32; MAX_TILE];
        for tile in 0..tiling.tiles(positions.len()) {
            let mut count = 0;
            tiling.for_each(positions.len(), tile, |bit, index| {
                let p = positions[index];
                for k in 0..3 {
                    points[k][count] = p[k];
                }
                place[count] = bit as u8;
                count += usize::from(!(p[0].is_nan() | p[1].is_nan() | p[2].is_nan()));
            });
            for i in 0..count {
                let c = space.coordinates([points[0][i], points[1][i], points[2][i]]);
                self.good &= c.good;
                for k in 0..3 {
                    self.residual[k] = max(c.residual[k], self.residual[k]);
                    at[k][i] = c.at[k];
                }
            }
            if !self.good {
                return;
            }
            if let Some(s) = slices {
                for i in 0..count {
                    slice[i] = s.slice(at[2][i]);
                }
            }
            // One record a distinct slice: take the lowest sample that has none and all its like.
            let mut left = u64::MAX.checked_shr((MAX_TILE - count) as u32).unwrap_or(0);
            while left != 0 {
                let this = slice[left.trailing_zeros() as usize];
                let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
                let (mut mask, mut rest) = (0u64, left);
                while rest != 0 {
                    let i = rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    if slice[i] == this {
                        mask |= 1 << place[i];
                        left &= !(1 << i);
                        for k in 0..3 {
                            lo[k] = -max(-at[k][i], -lo[k]);
                            hi[k] = max(at[k][i], hi[k]);
                        }
                    }
                }
                self.records.push(Record { mask, slice: this, bounds: Aabb::around(lo, hi), leaf: 0 });
            }
            self.ends.push(self.records.len() as u32);
        }
    }
}

/// Fills `bands` and returns a bound of all residuals; `None` if some sample has no place in this space.
pub(crate) fn collect(bands: &mut Vec<Band>, positions: &[[f32; 3]], plan: &Plan<'_>) -> Option<V3> {
    let level = plan.isa.level().unwrap_or_else(fearless_simd::Level::new);
    let size = plan.tiling.band();
    bands.resize_with(positions.len().div_ceil(size), Band::default);
    bands.par_iter_mut().zip(positions.par_chunks(size)).for_each(|(band, positions)| {
        dispatch!(level, _s => band.collect(positions, plan));
    });
    bands.iter().try_fold([0.0; 3], |r: V3, b| b.good.then(|| [0, 1, 2].map(|k| max(b.residual[k], r[k]))))
}

/// Where a leaf comes from, and its place in the tree: the path from the root, five bits a level.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Item {
    pub(crate) key: u64,
    pub(crate) band: u32,
    pub(crate) record: u32,
    pub(crate) tile: u32,
}

impl rdst::RadixKey for Item {
    const LEVELS: usize = 8;

    #[inline]
    fn get_level(&self, level: usize) -> u8 {
        (self.key >> (8 * level)) as u8
    }
}

/// The path to tile (x, y) when levels combine 4 x 8 and 8 x 4 nodes in turn (methods.md 3.2): 8 x 4 pixels, 32 x 32 pixels,
/// 256 x 128, 1024 x 1024, ...
fn alternating(mut x: u32, mut y: u32) -> u64 {
    let (mut key, mut shift) = (0u64, 0);
    let mut wide = 2;
    while x | y != 0 {
        let tall = 5 - wide;
        key |= u64::from(x & ((1 << wide) - 1) | (y & ((1 << tall) - 1)) << wide) << shift;
        (x, y) = (x >> wide, y >> tall);
        wide = tall;
        shift += 5;
    }
    key
}

/// Bits in turn from x, y, z, lowest first; an axis drops out when its `bits` are used up (methods.md 4.1).
fn interleaved(at: [u32; 3], bits: [u32; 3]) -> u64 {
    let (mut key, mut shift) = (0u64, 0);
    for bit in 0..bits[0].max(bits[1]).max(bits[2]) {
        for k in 0..3 {
            if bit < bits[k] {
                key |= u64::from(at[k] >> bit & 1) << shift;
                shift += 1;
            }
        }
    }
    key
}

/// Lists all records with their keys, sorted by key. Returns the bits that x, y and slice take in an interleaved key.
pub(crate) fn order(bands: &[Band], tiling: Tiling, sliced: bool, items: &mut Vec<Item>) -> [u32; 3] {
    use rdst::RadixSort;
    let slices = || bands.iter().flat_map(|b| &b.records).map(|r| r.slice);
    let first = slices().min().unwrap_or(0);
    let width = |n: usize| usize::BITS - n.saturating_sub(1).leading_zeros();
    let across = bands.first().map_or(0, |b| b.ends.len());
    // Together at most 64: a picture has under 2^32 pixels, thus under 2^26 tiles and 2^31 slices (of 31-bit numbers
    // scaled by under 2^-7: 2^24).
    let bits = [width(across), width(bands.len()), width((slices().max().unwrap_or(0) - first) as usize + 1)];
    items.clear();
    for (y, band) in bands.iter().enumerate() {
        let mut record = 0;
        for (x, &end) in band.ends.iter().enumerate() {
            while record < end {
                let key = match tiling {
                    Tiling::Runs { .. } => y as u64 * 64 + x as u64,
                    Tiling::Picture { .. } if sliced => {
                        let z = band.records[record as usize].slice - first;
                        interleaved([x as u32, y as u32, z], bits)
                    }
                    Tiling::Picture { .. } => alternating(x as u32, y as u32),
                };
                items.push(Item { key, band: y as u32, record, tile: x as u32 });
                record += 1;
            }
        }
    }
    items.radix_sort_unstable();
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_paths_and_all_different() {
        let mut seen = std::collections::BTreeSet::new();
        for y in 0..80 {
            for x in 0..80 {
                assert!(seen.insert(alternating(x, y)));
                // A tile of 32 x 32 pixels holds 4 x 8 tiles of 8 x 4; one of 256 x 128 holds 32 x 32.
                assert_eq!(alternating(x, y) >> 5, alternating(x & !3, y & !7) >> 5);
                assert_eq!(alternating(x, y) >> 10, alternating(x & !31, y & !31) >> 10);
            }
        }
        seen.clear();
        for i in 0..1024 {
            assert!(seen.insert(interleaved([i & 7, i >> 3 & 31, i >> 8], [3, 5, 2])));
        }
        assert_eq!(seen.last(), Some(&1023));
    }
}
