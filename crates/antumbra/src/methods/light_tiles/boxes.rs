//! Bounds of eight blocks of triangles, which are held against a leaf at once.

use antumbra_predicates::tile::Part;
use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};

/// Bounds: least x, largest x, least y, largest y, largest r.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Boxes([[f32; 8]; 5]);

impl Boxes {
    /// They meet nothing.
    pub(super) const NOWHERE: Boxes = Boxes([
        [f32::INFINITY; 8],
        [f32::NEG_INFINITY; 8],
        [f32::INFINITY; 8],
        [f32::NEG_INFINITY; 8],
        [f32::NEG_INFINITY; 8],
    ]);

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, bounds: [f32; 5]) {
        for (lanes, bound) in self.0.iter_mut().zip(bounds) {
            lanes[lane] = bound;
        }
    }

    /// Which of them meet a part of the tile; bits.
    #[inline(always)]
    pub(super) fn near<S: Simd>(&self, s: S, part: &Part) -> u8 {
        let Boxes([x_lo, x_hi, y_lo, y_hi, r_hi]) = self;
        let near = f32x8::load_array_ref(s, x_lo).simd_le(part.hi[0])
            & f32x8::load_array_ref(s, x_hi).simd_ge(part.lo[0])
            & f32x8::load_array_ref(s, y_lo).simd_le(part.hi[1])
            & f32x8::load_array_ref(s, y_hi).simd_ge(part.lo[1])
            & f32x8::load_array_ref(s, r_hi).simd_ge(part.lo[2]);
        near.to_bitmask() as u8
    }
}
