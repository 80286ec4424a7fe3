//! First stage: f32, eight lanes at a time, with a proven bound.
//!
//! Work is shared between many samples: [`TriangleBlock::against`] prepares eight triangles for one *group* of samples
//! (a box), throws out those that block none of them for certain, and finds those that block all; [`Coefficients::test`]
//! then tests one triangle against eight samples. All four tests are linear in `Q = p - a`, taken from raw coordinates:
//!
//! ```text
//! det[A, B, P] = A × (B - A) · Q        det[B, C, P] = B × (C - B) · Q + det[A, B, C]
//! det[C, A, P] = C × (A - C) · Q        plane        = (B - A) × (C - A) · Q
//! ```
//!
//! so that the error scales with the triangle and its distance to the sample, not with the distance to the origin or to
//! the light squared. `bounds.md` derives the constant [`KAPPA`].

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use crate::vector::{abs, cross, cross_abs, dot, load3, max3, splat3, store3, sub};

/// Relative bound of one test, in units of the sum of absolute products: 16 u with u = 2^-24. `bounds.md` needs 12.
pub const KAPPA: f32 = 16.0 * 0.5 * f32::EPSILON;
/// Added to sums of absolute products: covers underflow of products (each at most 2^-150). See `bounds.md`. Its product with
/// [`KAPPA`] is a normal number: many processors stop for a hundred cycles and more at every subnormal one, and triangles
/// parallel to an axis have sums that are nothing but this.
pub const TINY: f32 = 1.0 / (1u128 << 104) as f32;
/// Coordinates (relative to light or sample) over this make products that may overflow: nothing is certain then.
pub const LIMIT: f32 = (1u64 << 40) as f32;

/// Samples that are looked at together: every sample lies in the box `center ± half`, in real arithmetic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleGroup {
    /// Middle of the box, world space.
    pub center: [f32; 3],
    /// Half its size, rounded up.
    pub half: [f32; 3],
}

impl SampleGroup {
    /// The group whose samples lie between `lo` and `hi`, componentwise, bounds included. Both must be finite; `half` may
    /// come out infinite, which makes everything uncertain but nothing wrong.
    pub fn from_bounds(lo: [f32; 3], hi: [f32; 3]) -> SampleGroup {
        let center = [0, 1, 2].map(|k| lo[k] * 0.5 + hi[k] * 0.5);
        // Both differences are rounded once; one more ulp each way covers that.
        let half = [0, 1, 2].map(|k| {
            let h = (hi[k] - center[k]).max(center[k] - lo[k]);
            h + h * f32::EPSILON
        });
        SampleGroup { center, half }
    }
}

/// Eight triangles in structure-of-arrays form: `corner[i][axis][lane]`. What unused lanes hold does not matter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    /// World coordinates.
    pub corner: [[[f32; 8]; 3]; 3],
}

/// What a block of triangles does to a group of samples; bits are lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlockVerdict {
    /// Triangles that may block some sample of the group.
    pub maybe: u8,
    /// Triangles that block every sample of the group, for certain.
    pub covers: u8,
    /// Of `maybe`: triangles seen so nearly edge-on that f32 cannot tell their facing. Ask [`crate::exact::facing`]; drop
    /// those with 0 and [`Coefficients::flip`] those with -1.
    pub edge_on: u8,
}

/// The four linear tests of eight triangles, oriented so that "blocks" is "all four positive", with their bounds for one
/// group of samples.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Coefficients {
    /// First corner, world space.
    a: [[f32; 8]; 3],
    /// Normals of the tests: edges ab, bc, ca, then the plane.
    m: [[[f32; 8]; 3]; 4],
    /// `det[A, B, C]`, the constant of edge bc.
    det: [f32; 8],
    /// A value within `± bound` is not certain.
    bound: [[f32; 8]; 4],
}

/// What one triangle does to eight samples; bits are lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lanes {
    /// Blocked for certain.
    pub blocked: u8,
    /// Not decided.
    pub unsure: u8,
}

impl TriangleBlock {
    /// Prepares the tests of eight triangles for a light and a group of samples.
    ///
    /// `live` says which lanes hold triangles. The verdict is certain: a triangle that is not in `maybe` blocks no sample
    /// of the group, one in `covers` blocks all of them.
    #[inline(always)]
    pub fn against<S: Simd>(
        &self,
        s: S,
        live: u8,
        light: [f32; 3],
        group: &SampleGroup,
        out: &mut Coefficients,
    ) -> BlockVerdict {
        let l = splat3(s, light);
        let tiny = f32x8::splat(s, TINY);
        let kappa = f32x8::splat(s, KAPPA);
        let raw = [load3(s, &self.corner[0]), load3(s, &self.corner[1]), load3(s, &self.corner[2])];
        let rel = [sub(raw[0], l), sub(raw[1], l), sub(raw[2], l)];
        let edge = [sub(raw[1], raw[0]), sub(raw[2], raw[1]), sub(raw[0], raw[2])];
        let rel_abs = [abs(rel[0]), abs(rel[1]), abs(rel[2])];
        let edge_abs = [abs(edge[0]), abs(edge[1]), abs(edge[2])];

        let half = splat3(s, group.half);
        let q = sub(splat3(s, group.center), raw[0]);
        let q_abs = abs(q);
        let q_max = [q_abs[0] + half[0], q_abs[1] + half[1], q_abs[2] + half[2]];

        // N = (B - A) × (C - A) = (A - C) × (B - A); det[A, B, C] = N · A.
        let n = cross(edge[2], edge[0]);
        let n_mag = cross_abs(edge_abs[2], edge_abs[0], tiny);
        let det = dot(n, rel[0]);
        let det_bound = kappa.mul_add(dot(n_mag, rel_abs[0]), tiny);
        // Lanes whose facing is open keep the orientation of the corners: the caller finds the facing and flips.
        let sign = det.simd_lt(-det_bound).select(f32x8::splat(s, -1.0), f32x8::splat(s, 1.0));

        let m = [cross(rel[0], edge[0]), cross(rel[1], edge[1]), cross(rel[2], edge[2]), n];
        let mag = [
            cross_abs(rel_abs[0], edge_abs[0], tiny),
            cross_abs(rel_abs[1], edge_abs[1], tiny),
            cross_abs(rel_abs[2], edge_abs[2], tiny),
            n_mag,
        ];
        let zero = f32x8::splat(s, 0.0);
        let largest = max3(rel_abs[0]).max(max3(rel_abs[1])).max(max3(rel_abs[2])).max(max3(q_max));
        let wild = largest.simd_gt(LIMIT);
        let infinity = f32x8::splat(s, f32::INFINITY);

        // Some test is certainly negative, some is certainly positive, all are certainly positive.
        let (mut negative, mut positive, mut covers) = (0u8, 0u8, live);
        store3(raw[0], &mut out.a);
        (det * sign).store_array(&mut out.det);
        for k in 0..4 {
            let oriented = [m[k][0] * sign, m[k][1] * sign, m[k][2] * sign];
            let constant = if k == 1 { det * sign } else { zero };
            let more = if k == 1 { det_bound } else { tiny };
            let bound = wild.select(infinity, kappa.mul_add(dot(mag[k], q_max), more));
            let value =
                oriented[2].mul_add(q[2], oriented[1].mul_add(q[1], oriented[0].mul_add(q[0], constant)));
            let reach = dot(abs(oriented), half) + bound;
            negative |= (value + reach).simd_lt(0.0).to_bitmask() as u8;
            let above = (value - reach).simd_gt(0.0).to_bitmask() as u8;
            positive |= above;
            covers &= above;
            store3(oriented, &mut out.m[k]);
            bound.store_array(&mut out.bound[k]);
        }
        let faces = det.abs().simd_gt(det_bound).to_bitmask() & !wild.to_bitmask();
        let edge_on = live & !(faces as u8);
        // Whichever way an edge-on triangle faces, it blocks nothing if its tests certainly differ in sign.
        let maybe = (live & !negative) | (edge_on & !positive);
        BlockVerdict { maybe, covers: covers & !edge_on, edge_on: edge_on & maybe }
    }
}

impl Coefficients {
    /// All zero: to be filled by [`TriangleBlock::against`].
    pub const ZERO: Coefficients =
        Coefficients { a: [[0.0; 8]; 3], m: [[[0.0; 8]; 3]; 4], det: [0.0; 8], bound: [[0.0; 8]; 4] };

    /// Turns triangle `lane` to the other facing.
    pub fn flip(&mut self, lane: usize) {
        for m in self.m.iter_mut().flatten() {
            m[lane] = -m[lane];
        }
        self.det[lane] = -self.det[lane];
    }

    /// The four tests of triangle `lane` at eight samples, rounded.
    #[inline(always)]
    fn values<S: Simd>(&self, s: S, lane: usize, p: [f32x8<S>; 3]) -> [f32x8<S>; 4] {
        let q = [0, 1, 2].map(|k| p[k] - self.a[k][lane]);
        let at = |k: usize, constant: f32x8<S>| {
            let m = &self.m[k];
            q[2].mul_add(m[2][lane], q[1].mul_add(m[1][lane], q[0].mul_add(m[0][lane], constant)))
        };
        let zero = f32x8::splat(s, 0.0);
        [at(0, zero), at(1, f32x8::splat(s, self.det[lane])), at(2, zero), at(3, zero)]
    }

    /// Which of the triangles may block some sample of `part`, and which block all of them, for certain; bits are lanes.
    ///
    /// `part` must lie within the group that the coefficients were made for: its bounds then hold for `part` as well. The
    /// facing of edge-on triangles must have been settled before ([`Coefficients::flip`]). The sums are those of
    /// [`TriangleBlock::against`], so `bounds.md` covers them.
    #[inline(always)]
    pub fn refine<S: Simd>(&self, s: S, part: &SampleGroup) -> (u8, u8) {
        let half = splat3(s, part.half);
        let q = sub(splat3(s, part.center), load3(s, &self.a));
        let (mut maybe, mut covers) = (0xffu64, 0xffu64);
        for k in 0..4 {
            let m = load3(s, &self.m[k]);
            let constant = if k == 1 { f32x8::load_array_ref(s, &self.det) } else { f32x8::splat(s, 0.0) };
            let value = m[2].mul_add(q[2], m[1].mul_add(q[1], m[0].mul_add(q[0], constant)));
            let reach = dot(abs(m), half) + f32x8::load_array_ref(s, &self.bound[k]);
            maybe &= !(value + reach).simd_lt(0.0).to_bitmask();
            covers &= (value - reach).simd_gt(0.0).to_bitmask();
        }
        (maybe as u8, covers as u8)
    }

    /// Tests triangle `lane` against eight samples (world coordinates) of the group that the coefficients were made for.
    /// A sample of NaN ("no sample here") comes back unsure: leave such lanes out.
    #[inline(always)]
    pub fn test<S: Simd>(&self, s: S, lane: usize, p: [f32x8<S>; 3]) -> Lanes {
        let values = self.values(s, lane, p);
        let (mut blocked, mut out) = (0xffu64, 0u64);
        for k in 0..4 {
            let bound = self.bound[k][lane];
            blocked &= values[k].simd_gt(bound).to_bitmask();
            out |= values[k].simd_lt(-bound).to_bitmask();
        }
        Lanes { blocked: blocked as u8, unsure: !(blocked | out) as u8 }
    }

    /// The plane test's value and `det[A, B, C]` for triangle `lane`: their ratio says where on the ray from the light
    /// to `p` the triangle's plane lies, `t = det / (det + plane)`. Rounded, not certain.
    #[inline(always)]
    pub fn depth<S: Simd>(&self, s: S, lane: usize, p: [f32x8<S>; 3]) -> f32x8<S> {
        let q = [0, 1, 2].map(|k| p[k] - self.a[k][lane]);
        let m = &self.m[3];
        let det = f32x8::splat(s, self.det[lane]);
        det / q[2].mul_add(m[2][lane], q[1].mul_add(m[1][lane], q[0].mul_add(m[0][lane], det)))
    }
}

#[cfg(test)]
#[path = "filter_tests.rs"]
mod tests;
