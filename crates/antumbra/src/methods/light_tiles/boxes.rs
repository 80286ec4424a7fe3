//! Bounds of blocks of triangles, eight of which are tested at once.

use antumbra_predicates::tile::Region;
use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};

/// Bounds: least x, largest x, least y, largest y, largest r.
#[derive(Debug, Default)]
pub(super) struct Boxes {
    bounds: [Vec<f32>; 5],
}

/// Meets nothing.
const NOWHERE: [f32; 5] =
    [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY];

impl Boxes {
    pub(super) fn clear(&mut self) {
        self.bounds.iter_mut().for_each(Vec::clear);
    }

    #[inline(always)]
    pub(super) fn push(&mut self, bounds: [f32; 5]) {
        for (list, bound) in self.bounds.iter_mut().zip(bounds) {
            list.push(bound);
        }
    }

    /// Fills up to whole vectors with bounds that meet nothing.
    pub(super) fn pad(&mut self) {
        while !self.bounds[0].len().is_multiple_of(8) {
            self.push(NOWHERE);
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> [f32; 5] {
        let [a, b, c, d, e] = &self.bounds;
        [a[i], b[i], c[i], d[i], e[i]]
    }

    /// Which of the eight from `first` on (a multiple of 8) meet a region; bits.
    #[inline(always)]
    pub(super) fn near<S: Simd>(&self, s: S, first: usize, region: &Region) -> u8 {
        let [x_lo, x_hi, y_lo, y_hi, r_hi] = &self.bounds;
        let range = first..first + 8;
        let near = f32x8::from_slice(s, &x_lo[range.clone()]).simd_le(region.hi[0])
            & f32x8::from_slice(s, &x_hi[range.clone()]).simd_ge(region.lo[0])
            & f32x8::from_slice(s, &y_lo[range.clone()]).simd_le(region.hi[1])
            & f32x8::from_slice(s, &y_hi[range.clone()]).simd_ge(region.lo[1])
            & f32x8::from_slice(s, &r_hi[range]).simd_ge(region.lo[2]);
        near.to_bitmask() as u8
    }
}
