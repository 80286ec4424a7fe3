//! First stage for methods that bring samples to one triangle, with no group of samples known beforehand.
//!
//! The tests are those of [`crate::filter`]; the bound is evaluated sample by sample, which costs as much again
//! but needs nothing to be known about the samples. The facing is exact.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use crate::filter::{KAPPA, LIMIT, Lanes, TINY};
use crate::resolve::Resolver;
use crate::{Triangle, exact};

/// One triangle, ready to be tested against any samples.
#[derive(Clone, Copy, Debug)]
pub struct TriangleTest {
    a: [f32; 3],
    m: [[f32; 3]; 4],
    /// [`KAPPA`] times the sums of absolute products; infinite where nothing may be trusted.
    mag: [[f32; 3]; 4],
    det: f32,
    det_bound: f32,
}

impl TriangleTest {
    /// Prepares a triangle. `None` if it is degenerate or edge-on: then it blocks nothing.
    #[inline]
    pub fn new(t: &Triangle, light: [f32; 3]) -> Option<TriangleTest> {
        let sub = |a: [f32; 3], b: [f32; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let abs = |a: [f32; 3]| a.map(f32::abs);
        let cross = |a: [f32; 3], b: [f32; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let cross_abs = |a: [f32; 3], b: [f32; 3]| {
            let (a, b) = (abs(a), abs(b));
            [
                a[1] * b[2] + a[2] * b[1] + TINY,
                a[2] * b[0] + a[0] * b[2] + TINY,
                a[0] * b[1] + a[1] * b[0] + TINY,
            ]
        };
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let rel = [sub(t[0], light), sub(t[1], light), sub(t[2], light)];
        let edge = [sub(t[1], t[0]), sub(t[2], t[1]), sub(t[0], t[2])];
        let n = cross(edge[2], edge[0]);
        let n_mag = cross_abs(edge[2], edge[0]);
        let det = dot(n, rel[0]);
        let det_bound = KAPPA * dot(n_mag, abs(rel[0])) + TINY;
        let tame = rel.as_flattened().iter().all(|v| v.abs() <= LIMIT);
        let facing = if tame && det > det_bound {
            1
        } else if tame && det < -det_bound {
            -1
        } else {
            exact::facing(t, light)
        };
        if facing == 0 {
            return None;
        }
        let s = f32::from(facing);
        let scale = if tame { KAPPA } else { f32::INFINITY };
        let m = [cross(rel[0], edge[0]), cross(rel[1], edge[1]), cross(rel[2], edge[2]), n];
        let mag = [cross_abs(rel[0], edge[0]), cross_abs(rel[1], edge[1]), cross_abs(rel[2], edge[2]), n_mag];
        Some(TriangleTest {
            a: t[0],
            m: m.map(|v| v.map(|x| x * s)),
            mag: mag.map(|v| v.map(|x| x * scale)),
            det: det * s,
            det_bound: if tame { det_bound } else { f32::INFINITY },
        })
    }

    /// Tests eight samples, world coordinates.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, s: S, p: [f32x8<S>; 3]) -> Lanes {
        let q = [p[0] - self.a[0], p[1] - self.a[1], p[2] - self.a[2]];
        let q_abs = [q[0].abs(), q[1].abs(), q[2].abs()];
        let linear = |m: [f32; 3], q: [f32x8<S>; 3], constant: f32| {
            let c = f32x8::splat(s, constant);
            q[2].mul_add(m[2], q[1].mul_add(m[1], q[0].mul_add(m[0], c)))
        };
        let (mut blocked, mut out) = (0xffu64, 0u64);
        for k in 0..4 {
            let (constant, more) = if k == 1 { (self.det, self.det_bound) } else { (0.0, TINY) };
            let value = linear(self.m[k], q, constant);
            let bound = linear(self.mag[k], q_abs, more);
            blocked &= value.simd_gt(bound).to_bitmask();
            out |= value.simd_lt(-bound).to_bitmask();
        }
        // Far samples may overflow the products: nothing is certain then.
        let far = q_abs[0].max(q_abs[1]).max(q_abs[2]).simd_le(LIMIT).to_bitmask() as u8;
        Lanes { blocked: blocked as u8 & far, unsure: !(blocked | out) as u8 | !far }
    }
}

/// The f64 and exact stages of one triangle, prepared when first needed.
#[derive(Clone, Copy, Debug)]
pub struct LazyResolver {
    light: [f32; 3],
    made: Option<(u32, Option<Resolver>)>,
}

impl LazyResolver {
    /// For one light.
    pub fn new(light: [f32; 3]) -> LazyResolver {
        LazyResolver { light, made: None }
    }

    /// The resolver of triangle `index`; the last one is kept.
    #[inline]
    pub fn get(&mut self, index: u32, triangle: &Triangle) -> Option<&Resolver> {
        if !matches!(self.made, Some((i, _)) if i == index) {
            self.made = Some((index, Resolver::new(triangle, self.light)));
        }
        self.made.as_ref().and_then(|(_, r)| r.as_ref())
    }
}
