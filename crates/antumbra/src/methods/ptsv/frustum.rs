//! The shadow frustum of a triangle as planes over box coordinates, and planes that cut its false positives away.
//!
//! Made in f64 with forward error bounds, then scaled by a power of two and rounded to f32 together with all that is needed
//! to bound every later rounding: see [`Plane`].

use antumbra_predicates::exact;

use super::space::{Space, U64, V3, abs, cross, dot, sub, wide};
use crate::scene::Triangle;

/// A half space `c · (x, y, z, 1) >= 0`, known to within a margin.
///
/// Let `X, Y, Z` bound `|x|, |y|, |z|` in some boxes. Rounding c to f32 costs u = 2^-24 of each term, a product u, the
/// (at most) three additions u each, with or without fma: with `γ = 5 u` plus terms of order u² the evaluated value is within
/// `γ (|c0| X + |c1| Y + |c2| Z + |c3|)` of the rounded-free one. `margin` holds `8 u |c| + error`, where `error` is
/// the f64 bound of [`Space::plane`]; the 3 u to spare cover the five roundings (of the margin, thus relative to something of
/// order u) in evaluating the margin itself, and [`TINY`] covers all underflow.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plane {
    pub(crate) c: [f32; 4],
    pub(crate) margin: [f32; 4],
}

/// Added to every margin: products of coefficients up to 2 with coordinates up to 2^60 that underflow lose under 2^-148 each.
const TINY: f64 = 1.0 / (1u128 << 120) as f64;

impl Plane {
    /// Neither rejects nor accepts anything.
    const UNKNOWN: Plane = Plane { c: [0.0; 4], margin: [f32::INFINITY; 4] };

    #[inline(always)]
    fn round((c, error): ([f64; 4], [f64; 4])) -> Plane {
        let size = c.iter().zip(&error).fold(0.0f64, |m, (c, e)| m.max(c.abs()).max(*e));
        // Far from both ends of f64, so that underflow in the bounds (under 2^-940: 2^-1074 times factors of at most 2^130)
        // is nothing beside 2^-24 of the largest coefficient, and the power of two below exists. NaN fails too.
        if !(size > f64::from_bits(223 << 52) && size < f64::from_bits(1823 << 52)) {
            return Plane::UNKNOWN;
        }
        let scale = f64::from_bits((2046 - (size.to_bits() >> 52)) << 52);
        let unit = 0.5 * f64::from(f32::EPSILON);
        let mut plane = Plane::default();
        for k in 0..4 {
            let value = c[k] * scale;
            plane.c[k] = value as f32;
            plane.margin[k] = (8.0 * unit * value.abs() + 1.001 * error[k] * scale + TINY) as f32;
        }
        plane
    }
}

/// Edge planes and cap of a shadow frustum, and further planes that bound it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    /// A sample is blocked if it is inside all four: three sides, then the cap (the triangle's plane).
    pub(crate) main: [Plane; 4],
    extra: [Plane; MAX_EXTRA],
    extra_count: u8,
    /// Corners relative to the light.
    rel: [V3; 3],
    light: V3,
    /// 1 if the triangle's normal (counter-clockwise corners) points away from the light, -1 towards it.
    pub(crate) facing: i8,
    done: bool,
}

/// Two eye planes and three wedge planes.
const MAX_EXTRA: usize = 5;

#[inline(always)]
fn cross_abs(a: V3, b: V3) -> V3 {
    let (a, b) = (abs(a), abs(b));
    [a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2], a[0] * b[1] + a[1] * b[0]]
}

/// `a × b` of two vectors that carry one rounding each, and a bound of its error: two roundings of the factors, one of
/// the product, one of the difference make 4 u of the absolute products.
#[inline(always)]
fn rounded_cross(a: V3, b: V3) -> (V3, V3) {
    (cross(a, b), cross_abs(a, b).map(|v| 8.0 * U64 * v))
}

impl Frustum {
    /// `None` if the triangle is degenerate or edge-on: then it blocks nothing.
    #[inline]
    pub(crate) fn new(triangle: &Triangle, light: [f32; 3], space: &Space, residual: V3) -> Option<Frustum> {
        let corner = triangle.map(wide);
        let l = wide(light);
        let rel = corner.map(|p| sub(p, l));
        let edge = [sub(corner[1], corner[0]), sub(corner[2], corner[1]), sub(corner[0], corner[2])];
        let (n, n_error) = rounded_cross(edge[2], edge[0]);
        let det = dot(n, rel[0]);
        let det_bound = dot(n_error, abs(rel[0])) + 8.0 * U64 * dot(abs(n), abs(rel[0]));
        let facing = if det > 1.001 * det_bound {
            1
        } else if det < -1.001 * det_bound {
            -1
        } else {
            exact::facing(triangle, light)
        };
        if facing == 0 {
            return None;
        }
        let s = f64::from(facing);
        let plane = |(m, error): (V3, V3), base: V3| {
            Plane::round(space.plane(m.map(|v| s * v), error, base, residual))
        };
        let side = |k: usize| plane(rounded_cross(rel[k], edge[k]), l);
        let main = [side(0), side(1), side(2), plane((n, n_error), corner[0])];
        let extra = [Plane::UNKNOWN; MAX_EXTRA];
        Some(Frustum { main, extra, extra_count: 0, rel, light: l, facing, done: false })
    }

    /// The further planes, made when first asked for.
    #[inline]
    pub(crate) fn extra(&mut self, space: &Space, residual: V3, wedges: bool) -> &[Plane] {
        if !self.done {
            self.done = true;
            self.add_eye_planes(space, residual);
            if wedges {
                self.add_wedge_planes(space, residual);
            }
        }
        &self.extra[..usize::from(self.extra_count)]
    }

    fn push(&mut self, plane: Plane) {
        if usize::from(self.extra_count) < MAX_EXTRA {
            self.extra[usize::from(self.extra_count)] = plane;
            self.extra_count += 1;
        }
    }

    /// Planes through eye, light and a corner, with both other corners on one side for certain (methods.md 3.3: there
    /// are none or two of them, where the oriented edges change sides as seen from the eye).
    ///
    /// All that the triangle shadows lies in the cone of sums `Σ t_i v_i`, `t_i >= 0`, over its corners (light at the origin);
    /// with `N = e × v_i` the value `N · v_i` is zero in real arithmetic, and the others are positive.
    fn add_eye_planes(&mut self, space: &Space, residual: V3) {
        let Some(eye) = space.eye() else { return };
        let e = sub(eye, self.light);
        for i in 0..3 {
            let (n, error) = rounded_cross(e, self.rel[i]);
            let side = |v: V3| {
                let bound = 1.001 * (dot(error, abs(v)) + 8.0 * U64 * dot(abs(n), abs(v)));
                let value = dot(n, v);
                // Not comparable (NaN): neither.
                if value > bound {
                    1
                } else if value < -bound {
                    -1
                } else {
                    0
                }
            };
            let s = side(self.rel[(i + 1) % 3]);
            if s != 0 && s == side(self.rel[(i + 2) % 3]) && self.extra_count < 2 {
                let n = n.map(|v| f64::from(s) * v);
                self.push(Plane::round(space.plane(n, error, self.light, residual)));
            }
        }
    }

    /// Planes through the light ray of a corner, across the bisector of the two edges *as seen from the light* (methods.md
    /// 4.6 in its corrected form: project first, then bisect).
    ///
    /// The computed normal n stands for the real normal `N = n - (n·v / v·v) v`, for which `N · v = 0` holds; no component
    /// differs by more than `|n·v| / |v|`. The plane is used only if both other corners are certainly inside.
    fn add_wedge_planes(&mut self, space: &Space, residual: V3) {
        for i in 0..3 {
            let v = self.rel[i];
            let length = dot(v, v).sqrt();
            let l = v.map(|x| x / length);
            let others = [self.rel[(i + 1) % 3], self.rel[(i + 2) % 3]];
            let project = |o: V3| {
                let e = sub(o, v);
                let along = dot(e, l);
                let p = [0, 1, 2].map(|k| e[k] - along * l[k]);
                let size = dot(p, p).sqrt();
                p.map(|x| x / size)
            };
            let (a, b) = (project(others[0]), project(others[1]));
            let n = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
            // v carries one rounding, the dot product three; the length is good to a few u.
            let tilt = 1.001 * (dot(n, v).abs() + 8.0 * U64 * dot(abs(n), abs(v))) / length;
            let error = [tilt; 3];
            let inside = |o: V3| dot(n, o) > 1.001 * (dot(error, abs(o)) + 8.0 * U64 * dot(abs(n), abs(o)));
            // False for NaN, as it comes from a corner at the light; tilt must be small for the plane to be of use.
            if tilt < 1e-3 && length > 1e-100 && inside(others[0]) && inside(others[1]) {
                self.push(Plane::round(space.plane(n, error, self.light, residual)));
            }
        }
    }
}
