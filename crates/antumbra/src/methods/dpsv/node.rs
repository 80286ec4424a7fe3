//! One triangle in the tree: four planes with their error bounds, two links a plane, and what its subtrees hold.
//!
//! All numbers are relative to the light. A plane is stored as a unit normal `ν` in f32 (and an offset for the cap), with the
//! triangle's inside positive: the shadow volume is where all four are positive.
//!
//! **Signs.** Let u = 2^-24 and `q` be the f32 difference of sample and light, each component off by at most a factor
//! `1 + u` (a difference of floats is rounded once; underflow is exact). The true normal `m` comes from f64 with an error
//! per component of at most `16 · 2^-53 · mag` (the bound of the predicates' second stage), so with `λ = |m|` the stored
//! `ν` differs from `m / λ` by at most `u + δ` per component, `δ = 16 · 2^-53 · max(mag) / λ`. No component exceeds 1, so
//! with `|q|₁` the sum of absolute components
//!
//! ```text
//! |ν·q + d  computed - exact| ≤ (1 + 1 + 4) u |q|₁ + δ |q|₁ + (1 + 4) u |d| + 16 · 2^-53 · mag(d) / λ
//!                                ν   q  sums                  d   sums
//! ```
//!
//! plus second-order terms; four sums cover the products, too, fused or not. We use 8 u in both places, which also covers
//! the rounding of the bound itself, and [`TINY`] for products that vanish (at most 2^-149 each). A value inside the bound,
//! an infinity or a NaN is not certain and goes to exact arithmetic.

use std::sync::atomic::{AtomicU32, Ordering};

use antumbra_predicates::exact;

use crate::scene::Triangle;

/// No child here.
pub(super) const NONE: u32 = u32::MAX;
/// Rounding of sums in f32, see above.
pub(super) const ROUNDING: f32 = 8.0 * 0.5 * f32::EPSILON;
/// Covers products that vanish.
pub(super) const TINY: f32 = 1.0 / (1u128 << 120) as f32;
/// Relative error of f64 determinants in units of their sums of absolute products (`antumbra-predicates`, `resolve`).
const KAPPA: f64 = antumbra_predicates::resolve::KAPPA_F64;
/// Planes 0 to 2 are shadow planes through light and edge, plane 3 is the cap: the triangle's own.
pub(super) const CAP: usize = 3;

/// 128 bytes a triangle, as in the paper; nodes lie in the order of insertion.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// By axis, by plane.
    normal: [[f32; 4]; 3],
    /// Of the cap; the shadow planes go through the light.
    offset: f32,
    /// What a value may be off by, per unit of `|q|₁`; for the cap plus `cap_error`.
    error: f32,
    cap_error: f32,
    /// Lower bound of the distance from the light to everything in the subtree, as bits (not negative: they compare
    /// like the number).
    pub(super) nearest: AtomicU32,
    /// First triangle that lies outside plane k.
    pub(super) outside: [AtomicU32; 4],
    /// First triangle that meets both sides of plane k (section 5.2: "intersection child").
    pub(super) crossing: [AtomicU32; 4],
    /// Upper bound of `|ν·D| / |D|` over all directions `D` to triangles in the crossing subtree of shadow plane k, as bits.
    pub(super) wedge: [AtomicU32; 3],
    /// Node and plane (`4 node + plane`) whose crossing link was taken last on the way here, `NONE` if none was.
    pub(super) back: AtomicU32,
    /// Place in the soup.
    pub(super) triangle: u32,
    /// `sign det[A, B, C]`; 0: degenerate or edge-on, never linked.
    pub(super) facing: i8,
}

type V3 = [f64; 3];

pub(super) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn cross_abs(a: V3, b: V3) -> V3 {
    let (a, b) = (a.map(f64::abs), b.map(f64::abs));
    [a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2], a[0] * b[1] + a[1] * b[0]]
}

/// Rounded up, for non-negative numbers: conversion rounds to nearest, or overflows to infinity.
pub(super) fn up(v: f64) -> f32 {
    (v as f32) * (1.0 + 4.0 * f32::EPSILON) + TINY
}

/// Corners relative to the light. Differences of f32 in f64 are exact but for extreme gaps between exponents, where they are
/// rounded once; they vanish only where the numbers are equal.
pub(super) fn relative(t: &Triangle, light: [f32; 3]) -> [V3; 3] {
    t.map(|v| [0, 1, 2].map(|k| f64::from(v[k]) - f64::from(light[k])))
}

impl Node {
    /// The planes of a triangle, no children yet. `nearest` is its own distance, rounded down.
    pub(super) fn new(index: u32, triangles: &[Triangle], light: [f32; 3]) -> Node {
        let t = &triangles[index as usize];
        let facing = exact::facing(t, light);
        let rel = relative(t, light);
        let wide = t.map(|v| v.map(f64::from));
        let edge = [sub(wide[1], wide[0]), sub(wide[2], wide[1]), sub(wide[0], wide[2])];
        let sign = f64::from(facing);
        let mut normal = [[0.0f32; 4]; 3];
        let mut error = 0.0f64;
        let mut length = [0.0; 4];
        // No product of three differences of f32 overflows in f64, nor do these squares of products of two, nor vanish.
        for k in 0..4 {
            let (a, b) = if k == CAP { (edge[2], edge[0]) } else { (rel[k], edge[k]) };
            let (m, mag) = (cross(a, b), cross_abs(a, b));
            length[k] = dot(m, m).sqrt();
            let off = KAPPA * mag[0].max(mag[1]).max(mag[2]) / length[k];
            if off < 0.5 {
                error = error.max(off);
                for axis in 0..3 {
                    normal[axis][k] = (sign * m[axis] / length[k]) as f32;
                }
            } else {
                // Seen so edge-on that f64 does not know the normal: nothing is certain about this triangle.
                error = f64::INFINITY;
            }
        }
        let n = cross(edge[2], edge[0]);
        let (offset, cap_error) = if error.is_finite() {
            let offset = -sign * dot(n, rel[0]) / length[CAP];
            let mag = dot(cross_abs(edge[2], edge[0]), rel[0].map(f64::abs));
            (offset, f64::from(ROUNDING) * offset.abs() + KAPPA * mag / length[CAP])
        } else {
            (0.0, f64::INFINITY)
        };
        let none = || AtomicU32::new(NONE);
        Node {
            normal,
            offset: offset as f32,
            error: up(error) + ROUNDING,
            cap_error: up(cap_error),
            nearest: AtomicU32::new(super::bounds::nearest(&rel).to_bits()),
            outside: [none(), none(), none(), none()],
            crossing: [none(), none(), none(), none()],
            wedge: [AtomicU32::new(0), AtomicU32::new(0), AtomicU32::new(0)],
            back: none(),
            triangle: index,
            facing,
        }
    }

    /// Normal of plane k: exactly the numbers that [`Node::value`] uses.
    #[inline(always)]
    pub(super) fn normal(&self, k: usize) -> [f32; 3] {
        [self.normal[0][k], self.normal[1][k], self.normal[2][k]]
    }

    /// Constant of plane k.
    #[inline(always)]
    pub(super) fn offset(&self, k: usize) -> f32 {
        if k == CAP { self.offset } else { 0.0 }
    }

    /// What the value of plane k may be off by: `.0 |q|₁ + .1`.
    #[inline(always)]
    pub(super) fn error(&self, k: usize) -> (f32, f32) {
        (self.error, if k == CAP { self.cap_error } else { TINY })
    }

    /// Value of plane k at `q` and the bound of its error.
    #[inline(always)]
    pub(super) fn value(&self, k: usize, q: [f32; 3], q_sum: f32) -> (f32, f32) {
        let m = self.normal(k);
        let value = m[2] * q[2] + (m[1] * q[1] + (m[0] * q[0] + self.offset(k)));
        let (relative, absolute) = self.error(k);
        (value, relative * q_sum + absolute)
    }

    /// Inside shadow plane k, or beyond the cap? In exact arithmetic, ties broken as the definition says. `p` is in
    /// world space.
    #[cold]
    pub(super) fn exactly_inside(
        &self,
        k: usize,
        triangles: &[Triangle],
        light: [f32; 3],
        p: [f32; 3],
    ) -> bool {
        let t = &triangles[self.triangle as usize];
        let sign = if k == CAP { exact::beyond(t, p) } else { exact::side(t[k], t[(k + 1) % 3], p, light) };
        sign == self.facing
    }

    /// Which side of plane k is a point on: 1 inside, -1 outside, 0 exactly on it? Exact; `p` is in world space, `q`
    /// is `p` relative to the light.
    #[inline(always)]
    pub(super) fn sign(
        &self,
        k: usize,
        triangles: &[Triangle],
        light: [f32; 3],
        p: [f32; 3],
        q: [f32; 3],
    ) -> i8 {
        let (value, error) = self.value(k, q, q[0].abs() + q[1].abs() + q[2].abs());
        if value > error {
            1
        } else if value < -error {
            -1
        } else {
            self.exact_sign(k, triangles, light, p)
        }
    }

    #[inline(never)]
    fn exact_sign(&self, k: usize, triangles: &[Triangle], light: [f32; 3], p: [f32; 3]) -> i8 {
        let t = &triangles[self.triangle as usize];
        let (a, b) = (t[k % 3], t[(k + 1) % 3]);
        // Corners shared with neighbours: by far the most frequent reason to be here.
        if p == a || p == b || (k == CAP && p == t[2]) {
            return 0;
        }
        let sign = if k == CAP { exact::beyond(t, p) } else { exact::orientation(a, b, p, light) };
        sign * self.facing
    }

    #[inline(always)]
    pub(super) fn nearest(&self) -> f32 {
        f32::from_bits(self.nearest.load(Ordering::Relaxed))
    }

    #[inline(always)]
    pub(super) fn wedge(&self, k: usize) -> f32 {
        f32::from_bits(self.wedge[k].load(Ordering::Relaxed))
    }

    #[inline(always)]
    pub(super) fn outside(&self, k: usize) -> u32 {
        self.outside[k].load(Ordering::Relaxed)
    }

    #[inline(always)]
    pub(super) fn crossing(&self, k: usize) -> u32 {
        self.crossing[k].load(Ordering::Relaxed)
    }

    #[inline(always)]
    pub(super) fn back(&self) -> u32 {
        self.back.load(Ordering::Relaxed)
    }
}

/// A sample as the queries see it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// World space.
    pub(super) p: [f32; 3],
    /// Relative to the light, rounded.
    pub(super) q: [f32; 3],
    /// `|q|₁`; infinite or NaN where the difference overflows: then nothing is certain.
    pub(super) sum: f32,
    /// Upper bound of the distance to the light. Three squares, two sums and a root carry less than 4 u, `q` one more, the
    /// product another; squares that vanish (under 2^-149 each) change the root by less than 2^-73.
    pub(super) length: f32,
}

impl Sample {
    #[inline(always)]
    pub(super) fn new(p: [f32; 3], light: [f32; 3]) -> Sample {
        let q = [p[0] - light[0], p[1] - light[1], p[2] - light[2]];
        let sum = q[0].abs() + q[1].abs() + q[2].abs();
        let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
        let length = square.sqrt() * (1.0 + ROUNDING) + 1.0 / (1u128 << 70) as f32;
        Sample { p, q, sum, length }
    }
}
