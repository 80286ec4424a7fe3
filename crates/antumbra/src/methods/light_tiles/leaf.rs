//! What a tile holds: leaves, which are samples of one block of pixels, and samples on their own.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdMask, f32x8, mask32x8, u32x8};

use super::layout::{BLOCK, HALF};
use super::shuffle::{columns, two};

/// Samples of one block that the light sees close together: packed bounds ([`antumbra_predicates::tile::Region::pack`]), with the block as number 3, and one
/// bit a sample of the block as number 7.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Leaf([u32; 8]);

/// Marks the "block" of a leaf that is samples on their own: the rest is the first of sixteen.
pub(super) const LOOSE: u32 = 1 << 31;

/// The samples of the left half of a block.
pub(super) const LOW: u32 = (1 << HALF) - 1;

impl Leaf {
    #[inline(always)]
    pub(super) fn new<S: Simd>(s: S, sides: f32x8<S>, block: u32, mask: u32) -> Leaf {
        // In vectors: a vector of numbers that have just been written one by one has to wait for them.
        let (at_3, at_7) = (mask32x8::from_bitmask(s, 1 << 3), mask32x8::from_bitmask(s, 1 << 7));
        let with_block = at_3.select(u32x8::splat(s, block), sides.bitcast());
        Leaf(at_7.select(u32x8::splat(s, mask), with_block).to_array())
    }

    /// Packed bounds; numbers 3 and 7 are zero. (What is in their place would be subnormal numbers, for which processors stop.)
    #[inline(always)]
    pub(super) fn sides<S: Simd>(&self, s: S) -> f32x8<S> {
        let bounds = u32x8::load_array(s, [u32::MAX, u32::MAX, u32::MAX, 0, u32::MAX, u32::MAX, u32::MAX, 0]);
        (u32x8::load_array_ref(s, &self.0) & bounds).bitcast()
    }

    #[inline(always)]
    pub(super) fn block(&self) -> u32 {
        self.0[3]
    }

    #[inline(always)]
    pub(super) fn mask(&self) -> u32 {
        self.0[7]
    }

    /// Samples of both halves.
    #[inline(always)]
    pub(super) fn is_whole(&self) -> bool {
        self.mask() & LOW != 0 && self.mask() & !LOW != 0
    }

    /// With fewer samples.
    #[inline(always)]
    pub(super) fn with_mask(&self, mask: u32) -> Leaf {
        let mut leaf = *self;
        leaf.0[7] = mask;
        leaf
    }
}

/// A sample on its own: world coordinates (kept here, as neighbours in a tile are far apart in memory), then block times 32
/// plus sample.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub(super) struct Loose([u32; 4]);

impl Loose {
    #[inline(always)]
    pub(super) fn new(at: [f32; 3], slot: usize) -> Loose {
        Loose([at[0].to_bits(), at[1].to_bits(), at[2].to_bits(), slot as u32])
    }

    /// Block and sample.
    #[inline(always)]
    pub(super) fn slot(&self) -> (usize, usize) {
        (self.0[3] as usize / BLOCK, self.0[3] as usize % BLOCK)
    }
}

/// Coordinates of up to sixteen samples; what is missing repeats the last.
#[inline(always)]
pub(super) fn load_loose<S: Simd>(s: S, loose: &[Loose]) -> [[f32x8<S>; 2]; 3] {
    let last = loose.len().saturating_sub(1);
    let at = |i: usize| loose[i.min(last)].0.map(f32::from_bits);
    let eight =
        |i: usize| [at(i), at(i + 1), at(i + 2), at(i + 3), at(i + 4), at(i + 5), at(i + 6), at(i + 7)];
    let [x, y, z] = points(s, &eight(0));
    let [x2, y2, z2] = points(s, &eight(8));
    [[x, x2], [y, y2], [z, z2]]
}

/// The first three columns of eight rows.
#[inline(always)]
fn points<S: Simd>(s: S, rows: &[[f32; 4]; 8]) -> [f32x8<S>; 3] {
    let [a, b, c, d, e, f, g, h] = rows;
    let [x, y, z, _] = columns(s, [two(s, a, e), two(s, b, f), two(s, c, g), two(s, d, h)]);
    [x, y, z]
}
