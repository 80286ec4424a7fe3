//! Bounds of a triangle as seen from the light: how near it is, and how far it sticks out of a plane through the light.
//!
//! Both are taken over the whole triangle, not over its corners (defect 5.4-2 of the published code). All numbers are
//! f64, relative to the light; [`SLACK`] covers their rounding.

use super::node::{cross, dot, sub, up};

type V3 = [f64; 3];

/// Dot products of vectors of length 1 (rounded) are off by at most `(3 + 3 + 2) 2^-53 · √3 < 1.6e-15`; this is more.
const SLACK: f64 = 4e-15;

/// Lower bound of the distance from the light (the origin) to a triangle.
///
/// For any vector `c` all points `X` of the triangle have `c·X >= min over the corners`, hence `|X| >= min / |c|`: however
/// `c` was rounded, the bound holds. It is tight for the `c` that points to the nearest point, which is the foot on the
/// plane or on an edge; so we try those four.
pub(super) fn nearest(rel: &[V3; 3]) -> f32 {
    let edge = [sub(rel[1], rel[0]), sub(rel[2], rel[1]), sub(rel[0], rel[2])];
    let foot = |k: usize| {
        let t = (-dot(rel[k], edge[k]) / dot(edge[k], edge[k])).clamp(0.0, 1.0);
        [0, 1, 2].map(|axis| rel[k][axis] + t * edge[k][axis])
    };
    let n = cross(edge[2], edge[0]);
    let n = if dot(n, rel[0]) < 0.0 { n.map(|v| -v) } else { n };
    let mut best = 0.0f64;
    for c in [n, foot(0), foot(1), foot(2)] {
        let length = dot(c, c).sqrt();
        let least = rel.iter().map(|v| dot(c, *v) / length - SLACK * dot(*v, *v).sqrt());
        // NaN (no such foot) loses every comparison.
        best = best.max(least.fold(f64::INFINITY, |a, b| if a < b { a } else { b }));
    }
    // Rounded down (but for subnormal numbers: no sample is taken to be that near, see `Sample::length`); more than f32
    // can say is cut to what it can.
    ((best * (1.0 - 4.0 * f64::from(f32::EPSILON))) as f32).min(f32::MAX)
}

/// The directions from the light to a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions {
    /// Unit vectors to the corners.
    corner: [V3; 3],
    /// Lower bound of the distance from the light to the triangle that the unit vectors span.
    inner: f64,
}

/// From where on the chord bound is used: it is within 1 / 0.95 of the exact one.
const NARROW: f64 = 0.95;

impl Directions {
    /// The corners must not be at the light.
    pub(super) fn new(rel: &[V3; 3]) -> Directions {
        let corner = rel.map(|v| {
            let inverse = 1.0 / dot(v, v).sqrt();
            v.map(|x| x * inverse)
        });
        let sum = [0, 1, 2].map(|k| corner[0][k] + corner[1][k] + corner[2][k]);
        Directions { corner, inner: chord(sum, &corner) }
    }

    /// Upper bound of `|ν·D| / |D|` over all directions `D` to the triangle, for `ν` of length 1 (rounded), as f32
    /// rounded up.
    ///
    /// Every direction is, up to length, a point `X` of the triangle of unit vectors; there the linear `|ν·X|` is largest
    /// at a corner, and `|X| >= inner`. For triangles that look small that is nearly exact. For wide ones we take the maximum
    /// over the spherical triangle itself: 1 if it may contain `ν` or `-ν`, else it lies on one of the arcs.
    pub(super) fn wedge(&self, normal: [f32; 3]) -> f32 {
        let n = normal.map(f64::from);
        let at = self.corner.map(|c| dot(n, c).abs() + SLACK);
        let w = if self.inner > NARROW { at[0].max(at[1]).max(at[2]) / self.inner } else { self.wide(n, at) };
        up(w.min(1.0 + 1e-6))
    }

    /// 5.4-2 with margins.
    fn wide(&self, n: V3, at: [f64; 3]) -> f64 {
        let mut all: f64 = 0.0;
        // ±ν certainly outside the cone: for some side, on the other side than the opposite corner.
        let (mut above_outside, mut below_outside) = (false, false);
        for k in 0..3 {
            let (a, b, c) = (self.corner[k], self.corner[(k + 1) % 3], self.corner[(k + 2) % 3]);
            let q = cross(a, b);
            let sine = dot(q, q).sqrt();
            let middle = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
            let inner = chord(middle, &[a, b]);
            // The cross product of unit vectors is off by at most 4 · 2^-53 a component, relative to its length by
            // `SLACK / sine`. Arcs near 0 or 180 degrees are not trusted with a plane.
            let side = dot(q, c);
            let across = dot(q, n);
            if side.abs() > 2.0 * SLACK && across.abs() > 2.0 * SLACK {
                above_outside |= (across > 0.0) != (side > 0.0);
                below_outside |= (across < 0.0) != (side > 0.0);
            }
            let here = if inner > NARROW {
                at[k].max(at[(k + 1) % 3]) / inner
            } else if sine > 1e-3 {
                // Largest on the great circle at the projection of ±ν, if that lies on the arc, else at an end.
                let q = q.map(|v| v / sine);
                let along = dot(n, q);
                let peak = [0, 1, 2].map(|i| n[i] - along * q[i]);
                let margin = SLACK / 1e-3 * 8.0;
                let (from_a, to_b) = (dot(cross(a, peak), q), dot(cross(peak, b), q));
                let off = |s: f64| s * from_a < -margin || s * to_b < -margin;
                if off(1.0) && off(-1.0) {
                    at[k].max(at[(k + 1) % 3])
                } else {
                    dot(peak, peak).sqrt() + margin
                }
            } else {
                1.0
            };
            all = all.max(here);
        }
        if above_outside && below_outside { all } else { f64::INFINITY }
    }
}

/// Lower bound of the distance from the origin to the hull of unit vectors, by the argument of [`nearest`]; at most 1.
fn chord(c: V3, corners: &[V3]) -> f64 {
    let length = dot(c, c).sqrt();
    let least = corners.iter().map(|v| dot(c, *v) / length - SLACK).fold(1.0, f64::min);
    if length > 1e-6 { least.max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::dpsv::tests::Random;

    /// A random triangle: near, far, small, large, sliver.
    fn random_triangle(random: &mut Random) -> [V3; 3] {
        let size = 10f64.powi(random.below(7) as i32 - 5);
        let around = [0; 3].map(|_: i32| random.signed());
        let mut t = [0; 3].map(|_: i32| [0, 1, 2].map(|k| around[k] + size * random.signed()));
        if random.below(4) == 0 {
            let s = random.signed();
            t[2] = [0, 1, 2].map(|k| t[0][k] + s * (t[1][k] - t[0][k]) + 1e-7 * random.signed());
        }
        t
    }

    #[test]
    fn nothing_is_nearer_than_nearest_and_something_is_nearly_as_near() {
        let mut random = Random::new(1);
        for _ in 0..2000 {
            let t = random_triangle(&mut random);
            let bound = f64::from(nearest(&t));
            let mut least = f64::INFINITY;
            for i in 0..=30 {
                for j in 0..=30 - i {
                    let (u, v) = (f64::from(i) / 30.0, f64::from(j) / 30.0);
                    let x = [0, 1, 2].map(|k| t[0][k] * (1.0 - u - v) + t[1][k] * u + t[2][k] * v);
                    least = least.min(dot(x, x).sqrt());
                }
            }
            assert!(bound <= least, "{bound} {least} {t:?}");
            let size = (0..3).map(|k| dot(sub(t[k], t[(k + 1) % 3]), sub(t[k], t[(k + 1) % 3])).sqrt());
            let size = size.fold(0.0, f64::max);
            assert!(least - bound <= 0.06 * size + 1e-5 * least, "{bound} {least} {t:?}");
        }
    }

    #[test]
    fn no_direction_sticks_out_more_than_the_wedge_and_some_nearly_as_much() {
        let mut random = Random::new(2);
        for round in 0..4000 {
            let t = random_triangle(&mut random);
            let n = [0; 3].map(|_: i32| random.signed());
            let length = dot(n, n).sqrt();
            let normal = n.map(|v| (v / length) as f32);
            let wedge = f64::from(Directions::new(&t).wedge(normal));
            let mut largest = 0.0f64;
            for i in 0..=24 {
                for j in 0..=24 - i {
                    let (u, v) = (f64::from(i) / 24.0, f64::from(j) / 24.0);
                    let x = [0, 1, 2].map(|k| t[0][k] * (1.0 - u - v) + t[1][k] * u + t[2][k] * v);
                    largest = largest.max(dot(normal.map(f64::from), x).abs() / dot(x, x).sqrt());
                }
            }
            assert!(largest <= wedge, "round {round}: {largest} {wedge} {t:?} {normal:?}");
            // Small triangles: sampled densely enough to see that the bound is tight.
            let d = Directions::new(&t);
            if d.inner > NARROW {
                assert!(wedge <= largest * 1.1 + 1e-6, "round {round}: {largest} {wedge} {t:?}");
            }
        }
    }

    #[test]
    fn a_triangle_around_the_normal_fills_the_wedge() {
        let t = [[1.0, 0.0, 0.5], [-1.0, 1.0, 0.5], [-1.0, -1.0, 0.5]];
        let d = Directions::new(&t);
        // All corners are at 27 degrees or less from the plane z = 0, the middle is at 90.
        assert!(d.wedge([0.0, 0.0, 1.0]) >= 1.0);
        assert!(d.wedge([0.0, 0.0, -1.0]) >= 1.0);
    }
}
