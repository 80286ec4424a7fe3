//! Second stage for samples that are inside all three sides of a triangle for certain: its plane in f64, many samples at a
//! time. That is what a lit sample on a large triangle of its own needs.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8, f64x4};

use crate::Triangle;
use crate::resolve::KAPPA_F64;

/// The plane test of one triangle, oriented so that "beyond" is positive.
#[derive(Clone, Copy, Debug)]
pub struct PlaneResolver {
    a: [f64; 3],
    n: [f64; 3],
    /// Sums of absolute products, times [`KAPPA_F64`].
    mag: [f64; 3],
}

impl PlaneResolver {
    /// Prepares a triangle. `None` where f64 cannot tell its facing: ask [`crate::Resolver`].
    #[inline(always)]
    pub fn new(triangle: &Triangle, light: [f32; 3]) -> Option<PlaneResolver> {
        let wide = |p: [f32; 3]| [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])];
        let [a, b, c] = [wide(triangle[0]), wide(triangle[1]), wide(triangle[2])];
        let l = wide(light);
        let sub = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let (u, v, w) = (sub(a, c), sub(b, a), sub(a, l));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let (ua, va) = (u.map(f64::abs), v.map(f64::abs));
        let mag =
            [ua[1] * va[2] + ua[2] * va[1], ua[2] * va[0] + ua[0] * va[2], ua[0] * va[1] + ua[1] * va[0]];
        let det = n[0] * w[0] + n[1] * w[1] + n[2] * w[2];
        let bound = KAPPA_F64 * (mag[0] * w[0].abs() + mag[1] * w[1].abs() + mag[2] * w[2].abs());
        let sign = if det > bound {
            1.0
        } else if det < -bound {
            -1.0
        } else {
            return None;
        };
        Some(PlaneResolver { a, n: n.map(|x| x * sign), mag: mag.map(|x| x * KAPPA_F64) })
    }

    /// Of eight samples: which lie beyond the plane for certain, and which are not decided; bits are lanes.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, s: S, p: [f32x8<S>; 3]) -> (u8, u8) {
        let [x, y, z] = [s.widen_f32x8(p[0]), s.widen_f32x8(p[1]), s.widen_f32x8(p[2])];
        let (b0, u0) = self.four([x.0, y.0, z.0]);
        let (b1, u1) = self.four([x.1, y.1, z.1]);
        (b0 | b1 << 4, u0 | u1 << 4)
    }

    #[inline(always)]
    fn four<S: Simd>(&self, p: [f64x4<S>; 3]) -> (u8, u8) {
        let q = [p[0] - self.a[0], p[1] - self.a[1], p[2] - self.a[2]];
        // No fused operations: the bound is that of `bounds.md` for f64, which counts them all.
        let value = q[0] * self.n[0] + q[1] * self.n[1] + q[2] * self.n[2];
        let bound = q[0].abs() * self.mag[0] + q[1].abs() * self.mag[1] + q[2].abs() * self.mag[2];
        let beyond = value.simd_gt(bound).to_bitmask() as u8;
        let before = value.simd_lt(-bound).to_bitmask() as u8;
        (beyond, !(beyond | before) & 0xf)
    }
}
