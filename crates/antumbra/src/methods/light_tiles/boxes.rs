//! Bounds of blocks of triangles, eight of which are tested at once.

use antumbra_predicates::tile::Part;
use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};

/// Bounds: least x, largest x, least y, largest y, largest r.
#[derive(Debug, Default)]
pub(super) struct Boxes {
    eights: Vec<Eight>,
    len: usize,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct Eight([[f32; 8]; 5]);

/// Meets nothing.
const NOWHERE: Eight = Eight([
    [f32::INFINITY; 8],
    [f32::NEG_INFINITY; 8],
    [f32::INFINITY; 8],
    [f32::NEG_INFINITY; 8],
    [f32::NEG_INFINITY; 8],
]);

impl Boxes {
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.eights.clear();
        self.len = 0;
    }

    #[inline(always)]
    pub(super) fn push(&mut self, bounds: [f32; 5]) {
        let lane = self.len % 8;
        if lane == 0 {
            self.eights.push(NOWHERE);
        }
        self.len += 1;
        if let Some(Eight(eight)) = self.eights.last_mut() {
            for (lanes, bound) in eight.iter_mut().zip(bounds) {
                lanes[lane] = bound;
            }
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> [f32; 5] {
        let Eight([a, b, c, d, e]) = &self.eights[i / 8];
        [a[i % 8], b[i % 8], c[i % 8], d[i % 8], e[i % 8]]
    }

    /// Which of the eight from `first` on (a multiple of 8) meet a part of the tile; bits.
    #[inline(always)]
    pub(super) fn near<S: Simd>(&self, s: S, first: usize, part: &Part) -> u8 {
        let Eight([x_lo, x_hi, y_lo, y_hi, r_hi]) = &self.eights[first / 8];
        let near = f32x8::load_array_ref(s, x_lo).simd_le(part.hi[0])
            & f32x8::load_array_ref(s, x_hi).simd_ge(part.lo[0])
            & f32x8::load_array_ref(s, y_lo).simd_le(part.hi[1])
            & f32x8::load_array_ref(s, y_hi).simd_ge(part.lo[1])
            & f32x8::load_array_ref(s, r_hi).simd_ge(part.lo[2]);
        near.to_bitmask() as u8
    }
}
