//! Bounds of sixteen leaves, which are held against those of a block of triangles at once.

use antumbra_predicates::tile::Part;
use fearless_simd::{Simd, SimdBase, SimdMask, f32x16};

/// Bounds of a block of triangles: least x, largest x, least y, largest y, largest r.
pub(super) type Hull = [f32; 5];

/// Leaves that are held against a block at once.
pub(super) const SIXTEEN: usize = 16;

/// Least x, largest x, least y, largest y, least r.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Boxes([[f32; SIXTEEN]; 5]);

impl Boxes {
    /// What is in them does not matter.
    pub(super) const ZERO: Boxes = Boxes([[0.0; SIXTEEN]; 5]);

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, part: &Part) {
        let [x_lo, x_hi, y_lo, y_hi, r_lo] = &mut self.0;
        x_lo[lane] = part.lo[0];
        x_hi[lane] = part.hi[0];
        y_lo[lane] = part.lo[1];
        y_hi[lane] = part.hi[1];
        r_lo[lane] = part.lo[2];
    }

    /// Which of them the triangles of a block may meet; bits.
    #[inline(always)]
    pub(super) fn near<S: Simd>(&self, s: S, [x_lo, x_hi, y_lo, y_hi, r_hi]: Hull) -> u32 {
        let at = |k: usize| f32x16::load_array_ref(s, &self.0[k]);
        let near = at(1).simd_ge(x_lo)
            & at(0).simd_le(x_hi)
            & at(3).simd_ge(y_lo)
            & at(2).simd_le(y_hi)
            & at(4).simd_le(r_hi);
        near.to_bitmask() as u32
    }
}
