//! A face of the boundary of the shadow volumes, ready to be crossed by eye rays.
//!
//! With `p` a sample relative to the reference point E, a face is three linear functionals `n1 p > 0, n2 p > 0, n3 p > 0`
//! (does the line through E and the sample pass through the face?) and a fourth, `n4 p` against a constant `K > 0`: where the line
//! meets the face; `n4 = n1 + n2 + τ n3`. With A, B, C, E, P relative to the light and σ = sign det[A, B, E]:
//!
//! ```text
//!            side of edge AB                   triangle, facing F = sign det[A-E, B-E, C-E]   far cap, facing D
//! n1        -σ A × E      (ray of A)           F (A-E) × (B-E)                              D A × B
//! n2         σ B × E      (ray of B)           F (B-E) × (C-E)                              D B × C
//! n3         σ (A-E) × (B-E)  (edge)           F (C-E) × (A-E)                              D C × A
//! τ, n4     -1, -σ A × B                       +1, F (B-A) × (C-A)                           +1, positive anyway
//! K          |det[A, B, E]|                    |det[A-E, B-E, C-E]|                          ∞
//! ```
//!
//! The face lies between E and the sample iff `n4 p > K`, beyond the sample iff `0 < n4 p < K`.
//!
//! Everything is in camera axes (right, up, forward), so that a tile of pixels is a box in `(x / w, y / w)`.
//!
//! # Error bound
//!
//! u = 2^-53, `mag` the sum of the absolute products that make up a cross product. Differences of inputs carry one
//! rounding, a cross product four: its error is at most 4.01 u mag. Turning it into axes adds 3 u, so a component
//! of `n` is within 8 u mag; a coordinate of `p` within 4.1 u |p|₁. Three products and sums of those stay within
//! (3 · 12.3 + 9) u mag |p|₁ < 48 u mag |p|₁ = 2^-47.4. The axes are orthonormal to 2^-48 ([`SKEW`]), which moves `n · p` by at most
//! 3 · 2^-48 mag |p|₂. Together 2^-45.8 mag |p|₁, and |p|₁ ≤ 1.74 (|x| + |y| + |w|): 2^-45 mag s with `s = |x| + |y| + |w|`.
//! Dividing by `w`, and the middles and halves of intervals, cost a handful of u more. [`MARGIN`] = 2^-43 is four times
//! that. `mag` is taken as the sum over n1, n2, n3, which serves n4, too. `K` is within 12 u of its own sum of products,
//! `k_mag`, for which the same margin is ample. Nothing can over- or underflow: inputs are multiples of 2^-149 below
//! 2^128, and no product has more than six such factors.

use antumbra_predicates::exact;
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f64x4, mask64x4};

use super::direction;
use super::reference::{Reference, SKEW};
use super::silhouette::SilhouetteEdge;
use super::tiles::Region;
use crate::scene::Triangle;

type V3 = [f64; 3];

/// Relative error of a functional: see the derivation above.
pub(super) const MARGIN: f64 = 32.0 * SKEW;

/// What a face was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// The side of a silhouette edge.
    Side(u32),
    /// A triangle where it is.
    Cap(u32),
    /// A triangle pushed to infinity, away from the light.
    FarCap(u32),
}

/// One face: four functionals, a place, and what crossing it is worth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// By axis, then by functional: four lanes are one face.
    pub(super) n: [[f64; 4]; 3],
    pub(super) k: f64,
    pub(super) mag: f64,
    pub(super) k_mag: f64,
    pub(super) weight: i32,
    pub(super) source: Source,
}

/// What a face does to all samples of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Crossed by none of them.
    Reject,
    /// Crossed by all of them.
    Accept,
    /// Not known.
    Refine,
}

fn wide(to: [f32; 3], from: [f32; 3]) -> V3 {
    [0, 1, 2].map(|k| f64::from(to[k]) - f64::from(from[k]))
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Sums of absolute products, component by component.
fn cross_mag(a: V3, b: V3) -> V3 {
    let (a, b) = (a.map(f64::abs), b.map(f64::abs));
    [a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2], a[0] * b[1] + a[1] * b[0]]
}

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sum(a: V3) -> f64 {
    a[0] + a[1] + a[2]
}

/// Makes and decides faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Faces<'a> {
    /// Count between eye and sample (z-pass), otherwise beyond the sample (z-fail).
    pub(super) pass: bool,
    pub(super) reference: Reference,
    pub(super) light: [f32; 3],
    pub(super) triangles: &'a [Triangle],
    pub(super) facing: &'a [i8],
    pub(super) edges: &'a [SilhouetteEdge],
}

impl Faces<'_> {
    fn face(&self, pairs: [[V3; 2]; 3], signs: [i8; 3], tau: f64, weight: i32, source: Source) -> Face {
        let mut n = [[0.0; 4]; 3];
        let mut mag = 0.0;
        for i in 0..3 {
            let [a, b] = pairs[i];
            let world = cross(a, b);
            for (axis, n) in self.reference.axes.iter().zip(&mut n) {
                n[i] = dot(world, *axis) * f64::from(signs[i]);
            }
            mag += sum(cross_mag(a, b));
        }
        for n in &mut n {
            n[3] = n[0] + n[1] + tau * n[2];
        }
        Face { n, k: f64::INFINITY, mag, k_mag: 0.0, weight, source }
    }

    /// The side of silhouette edge `index`.
    pub(super) fn side(&self, index: u32) -> Face {
        let edge = &self.edges[index as usize];
        let (point, light) = (self.reference.point, self.light);
        let sigma = exact::orientation(edge.a, edge.b, point, light);
        let (a, b, e) = (wide(edge.a, light), wide(edge.b, light), wide(point, light));
        let (ae, be) = (wide(edge.a, point), wide(edge.b, point));
        // z-pass enters the sample's side of the plane, which is not the eye's; beyond the sample both are one.
        let weight = edge.multiplicity * i32::from(if self.pass { -sigma } else { sigma });
        let pairs = [[a, e], [b, e], [ae, be]];
        let k = dot(cross(a, b), e).abs();
        let k_mag = dot(cross_mag(a, b), e.map(f64::abs));
        let face = self.face(pairs, [-sigma, sigma, sigma], -1.0, weight, Source::Side(index));
        Face { k, k_mag, ..face }
    }

    /// Triangle `index` itself; it must not be edge-on.
    pub(super) fn cap(&self, index: u32) -> Face {
        let t = &self.triangles[index as usize];
        let point = self.reference.point;
        let f = exact::facing(t, point);
        let [a, b, c] = t.map(|v| wide(v, point));
        let d = self.facing[index as usize];
        let weight = i32::from(if self.pass { d * f } else { -d * f });
        let k = dot(cross(a, b), c).abs();
        let k_mag = dot(cross_mag(a, b), c.map(f64::abs));
        let face = self.face([[a, b], [b, c], [c, a]], [f; 3], 1.0, weight, Source::Cap(index));
        Face { k, k_mag, ..face }
    }

    /// Triangle `index` at infinity.
    pub(super) fn far_cap(&self, index: u32) -> Face {
        let [a, b, c] = self.triangles[index as usize].map(|v| wide(v, self.light));
        let d = self.facing[index as usize];
        self.face([[a, b], [b, c], [c, a]], [d; 3], 1.0, 1, Source::FarCap(index))
    }

    /// Is the face crossed on the way of sample `p`? Exact; `mod.rs` derives the tie-breaks.
    pub(super) fn decide(&self, source: Source, p: [f32; 3]) -> bool {
        let (e, light) = (self.reference.point, self.light);
        let or = |sign: i8, other: &dyn Fn() -> i8| if sign == 0 { other() } else { sign };
        // Which side of the line through `a` and `b` the eye ray passes on.
        let passes = |a: [f32; 3], b: [f32; 3]| {
            or(exact::orientation(a, b, p, e), &|| {
                or(-exact::orientation(a, b, e, light), &|| exact::tie_break(a, b, e))
            })
        };
        // Where the eye ray ends up: which side of the plane through light, `a` and `b`.
        let ends = |a: [f32; 3], b: [f32; 3]| {
            or(direction::orientation([(a, light), (b, light), (p, e)]), &|| {
                or(-exact::orientation(a, b, e, light), &|| exact::tie_break(a, b, light))
            })
        };
        match source {
            Source::Side(index) => {
                let SilhouetteEdge { a, b, .. } = self.edges[index as usize];
                let sigma = exact::orientation(a, b, e, light);
                let beyond_plane = exact::side(a, b, p, light) == -sigma;
                beyond_plane == self.pass
                    && exact::side(a, e, p, light) == -sigma
                    && exact::side(b, e, p, light) == sigma
                    && passes(a, b) == sigma
                    && (self.pass || ends(a, b) == -sigma)
            }
            Source::Cap(index) => {
                let t = &self.triangles[index as usize];
                let f = exact::facing(t, e);
                // Touching the plane counts as the light's side.
                let plane = or(exact::beyond(t, p), &|| -self.facing[index as usize]);
                (plane == f) == self.pass
                    && passes(t[0], t[1]) == f
                    && passes(t[1], t[2]) == f
                    && passes(t[2], t[0]) == f
            }
            Source::FarCap(index) => {
                let t = &self.triangles[index as usize];
                let d = self.facing[index as usize];
                ends(t[0], t[1]) == d && ends(t[1], t[2]) == d && ends(t[2], t[0]) == d
            }
        }
    }
}

impl Face {
    /// What the face does to every sample of `region`. Certain.
    #[inline(always)]
    pub(super) fn against<S: Simd>(&self, s: S, pass: bool, region: &Region) -> Verdict {
        let [x, y, w] = [0, 1, 2].map(|k| f64x4::load_array_ref(s, &self.n[k]));
        let middle = y.mul_add(region.middle[1], x.mul_add(region.middle[0], w));
        let margin = MARGIN * (self.mag * region.scale + self.k_mag * region.inverse[1]);
        let margin = f64x4::splat(s, margin);
        let reach = y.abs().mul_add(region.half[1], x.abs().mul_add(region.half[0], margin));
        let (low, high) = (middle - reach, middle + reach);
        // Of the fourth functional: certainly under, over the place of the face.
        let under = f64x4::splat(s, self.k * region.inverse[0]);
        let over = f64x4::splat(s, self.k * region.inverse[1]);
        let bits = |m: mask64x4<S>| m.to_bitmask() as u8;
        let (negative, positive) = (bits(high.simd_lt(0.0)), bits(low.simd_gt(0.0)));
        let (under, over) = (bits(high.simd_lt(under)) & 8, bits(low.simd_gt(over)) & 8);
        let (out, all) = if pass {
            (negative & 7 | under, positive & 7 | over)
        } else {
            (negative | over, if under != 0 { positive } else { 0 })
        };
        if out != 0 {
            Verdict::Reject
        } else if all == 15 {
            Verdict::Accept
        } else {
            Verdict::Refine
        }
    }
}

#[cfg(test)]
mod tests;
