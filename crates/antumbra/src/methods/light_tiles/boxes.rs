//! Bounds of 64 leaves, which are held against those of a block of triangles at once.

use antumbra_predicates::tile::Region;
use fearless_simd::{Bytes, Simd, SimdBase, SimdMask, f32x8, u8x64, u32x8};

use super::grid::MAGIC;

/// Bounds of a block of triangles: least x, largest x, least y, largest y, largest r.
pub(super) type Hull = [f32; 5];

/// The same in [`Steps`] of a tile.
pub(super) type Coarse = [u8; 5];

/// Leaves that are held against the blocks of a chunk at once.
pub(super) const LEAVES: usize = 64;

/// Numbers from 0 to 255 for x, y and r of a tile. Each is monotone in what it stands for, whatever is rounded: bounds that overlap do so
/// in steps, too, and nothing is missed. A tile is some eight to twenty leaves wide, so that a step is a tenth
/// of a leaf at most.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Steps {
    lo: [f32; 8],
    scale: [f32; 8],
}

impl Steps {
    pub(super) fn new(Region { lo, hi }: &Region) -> Steps {
        // Never infinite, so that nothing becomes NaN.
        let scale = [0, 1, 2].map(|k| LAST / (hi[k] - lo[k]).max(1e-30));
        let twice = |[x, y, r]: [f32; 3]| [x, y, r, 1.0, x, y, r, 1.0];
        Steps { lo: twice(*lo), scale: twice(scale) }
    }

    /// Of the bounds of a block of triangles.
    #[inline(always)]
    pub(super) fn of<S: Simd>(&self, s: S, [x_lo, x_hi, y_lo, y_hi, r_hi]: Hull) -> Coarse {
        let [x_lo, y_lo, _, _, x_hi, y_hi, r_hi, _] =
            self.steps(s, f32x8::load_array(s, [x_lo, y_lo, 0.0, 0.0, x_hi, y_hi, r_hi, 0.0]));
        [x_lo, x_hi, y_lo, y_hi, r_hi]
    }

    /// Twice x, y, r and a number that means nothing.
    #[inline(always)]
    fn steps<S: Simd>(&self, s: S, at: f32x8<S>) -> [u8; 8] {
        let c = (at - f32x8::load_array_ref(s, &self.lo)) * f32x8::load_array_ref(s, &self.scale);
        let c = c.min(LAST).max(0.0);
        // The sum is rounded to a whole number, which is then in the low bits.
        let whole: u32x8<S> = (c + MAGIC).bitcast();
        whole.to_array().map(|step| step as u8)
    }
}

const LAST: f32 = 255.0;

/// Least x, largest x, least y, largest y, least r.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Boxes([[u8; LEAVES]; 5]);

impl Boxes {
    /// What is in them does not matter.
    pub(super) const ZERO: Boxes = Boxes([[0; LEAVES]; 5]);

    /// Takes packed bounds of a leaf ([`Region::pack`]).
    #[inline(always)]
    pub(super) fn set<S: Simd>(&mut self, s: S, lane: usize, sides: f32x8<S>, steps: &Steps) {
        let sign = f32x8::load_array(s, [1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0]);
        let [x_lo, y_lo, r_lo, _, x_hi, y_hi, _, _] = steps.steps(s, sides * sign);
        let [x_los, x_his, y_los, y_his, r_los] = &mut self.0;
        (x_los[lane], x_his[lane], y_los[lane], y_his[lane], r_los[lane]) = (x_lo, x_hi, y_lo, y_hi, r_lo);
    }

    /// Which of them the triangles of a block may meet; bits.
    #[inline(always)]
    pub(super) fn near<S: Simd>(&self, s: S, [x_lo, x_hi, y_lo, y_hi, r_hi]: Coarse) -> u64 {
        let at = |k: usize| u8x64::load_array_ref(s, &self.0[k]);
        let near = at(1).simd_ge(x_lo)
            & at(0).simd_le(x_hi)
            & at(3).simd_ge(y_lo)
            & at(2).simd_le(y_hi)
            & at(4).simd_le(r_hi);
        near.to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    /// What overlaps in f32 must do so in steps: regions of all sizes, bounds within them, about their borders, and without end.
    #[test]
    fn nothing_that_overlaps_is_missed() {
        let mut state = 1u32;
        let mut next = move |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % n
        };
        let (mut met, mut apart) = (0, 0);
        for _ in 0..20_000 {
            let size = [1.0, 1e-3, 1e-7, 0.0][next(4) as usize];
            let lo: [f32; 3] = std::array::from_fn(|_| next(200) as f32 / 100.0 - 1.0);
            let region = Region { lo, hi: lo.map(|v| v + size) };
            let steps = Steps::new(&region);
            let mut range = |k: usize| {
                let [a, b] = [0, 1].map(|_| lo[k] + size * (next(2_400) as f32 / 2_000.0 - 0.1));
                [a.min(b), a.max(b)]
            };
            let [x, y, r] = [range(0), range(1), range(2)];
            let leaf = Region { lo: [x[0], y[0], r[0]], hi: [x[1], y[1], r[1]] };
            let [x, y, r] = [range(0), range(1), range(2)];
            let hull = match next(16) {
                0 => [f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::INFINITY],
                _ => [x[0], x[1], y[0], y[1], r[1]],
            };
            let meets = leaf.hi[0] >= hull[0]
                && leaf.lo[0] <= hull[1]
                && leaf.hi[1] >= hull[2]
                && leaf.lo[1] <= hull[3]
                && leaf.lo[2] <= hull[4];
            let found = dispatch!(Level::new(), s => {
                let mut boxes = Boxes::ZERO;
                boxes.set(s, 37, f32x8::load_array(s, leaf.pack()), &steps);
                boxes.near(s, steps.of(s, hull)) >> 37 & 1 == 1
            });
            assert!(found || !meets, "{region:?} {leaf:?} {hull:?}");
            met += u32::from(meets);
            apart += u32::from(!found);
        }
        assert!(met > 1_000 && apart > 1_000, "{met} meet, {apart} do not");
    }
}
