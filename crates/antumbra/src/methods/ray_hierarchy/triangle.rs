//! A triangle as the node tests want it: unit vectors, each with the bound of its own rounding error.

use antumbra_predicates::{Resolver, Triangle};

use super::cone::U;
use super::vector::{cross, dot, length, sub};

/// Absolute error that every node test allows for, beyond the errors of the triangle's own normals: 512 u.
///
/// Derivation. All operands are components of vectors of about unit length: axes (off by 3 u, and what the cone stands for
/// is the direction of the stored axis), directions of corners (difference 1, length 3, division 1: 5 u), cosines and sines
/// (4 u). The longest chain is that of the separating tangents: `d = p·w` is off by 5 + 3 + 3 = 11 u; a component of
/// `r = p - d w` by 5 + 11 + 3 + 2 = 21 u, so `r` by 37 u; `r_i·r_j` by 2·37 + 3 u; `|r_i| d_j` by 37 + 11 + 3 u; times
/// cosine or sine, and subtracted, under 145 u. The residue `r·w`, which should be 0, moves the tangent plane by another
/// 40 u. All other tests have shorter chains. In sum under 200 u.
pub(super) const MARGIN: f64 = 512.0 * U;

/// Relative error of a cross product of two differences of f32 coordinates, in units of the product of their lengths.
///
/// Each factor is rounded once (u), each product once, their difference once: a component is off by at most 4 u times the sum of
/// the absolute products, which by Cauchy and Schwarz is at most the product of the lengths; three components: 7 u.
/// The lengths themselves are off by 3 u relative, and bringing the normal to unit length adds 5 u. 16 u covers it.
const CROSS: f64 = 16.0 * U;

/// A plane through the light: the rays inside are where `normal · direction > 0`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    /// Unit.
    pub(super) normal: [f64; 3],
    /// `normal · direction` is off by at most this much; NaN or infinite if nothing is known.
    pub(super) margin: f64,
}

/// What the node tests need. All values that are compared are bounds in the safe direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Caster {
    /// Directions of the corners as seen from the light.
    pub(super) corner: [[f64; 3]; 3],
    /// Edges ab, bc, ca.
    pub(super) side: [Side; 3],
    /// The plane of the triangle; the normal points away from the light.
    pub(super) plane: Side,
    /// The plane is at least this far from the light...
    pub(super) near: f64,
    /// ... and at most this far.
    pub(super) far: f64,
    /// No point of the triangle is nearer to the light than this.
    pub(super) distance: f64,
    /// The bounding sphere.
    pub(super) sphere: Sphere,
    /// The sign of `det[A, B, C]`: 1 if the side where the corners run counter-clockwise is turned away from the light.
    pub(super) facing: i8,
}

/// A sphere around a triangle as seen from the light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sphere {
    /// Direction of the centre.
    pub(super) direction: [f64; 3],
    /// Sine of half the angle that it fills, rounded up; over 1 if the light may be inside.
    pub(super) sin: f64,
    /// The cosine rounded down and up.
    pub(super) cos: [f64; 2],
    /// Distance of the nearest point, rounded down.
    pub(super) distance: f64,
}

fn scaled(v: [f64; 3], by: f64) -> [f64; 3] {
    v.map(|x| x / by)
}

impl Caster {
    /// `None` if the triangle is degenerate or edge-on: then it blocks nothing.
    pub(super) fn new(t: &Triangle, light: [f32; 3], spheres: bool) -> Option<Caster> {
        let facing = Resolver::new(t, light)?.facing();
        let s = f64::from(facing);
        let wide = |p: [f32; 3]| p.map(f64::from);
        let raw = [wide(t[0]), wide(t[1]), wide(t[2])];
        let p = raw.map(|v| sub(v, wide(light)));
        let size = p.map(length);
        let edge = [sub(raw[1], raw[0]), sub(raw[2], raw[1]), sub(raw[0], raw[2])];
        let edge_size = edge.map(length);
        let normal = |a: [f64; 3], b: [f64; 3], lengths: f64| {
            let m = cross(a, b);
            let l = length(m);
            Side { normal: scaled(m, s * l), margin: CROSS * lengths / l + MARGIN }
        };
        let side = [0, 1, 2].map(|k| {
            // A × (B - A) = B × (B - A): the nearer corner has the smaller error.
            let next = (k + 1) % 3;
            let from = if size[k] <= size[next] { k } else { next };
            normal(p[from], edge[k], size[from] * edge_size[k])
        });
        // The cross product of any two consecutive edges is the same: without the longest the error is least.
        let mut longest = 0;
        for k in 1..3 {
            if edge_size[k] > edge_size[longest] {
                longest = k;
            }
        }
        let (i, j) = ((longest + 1) % 3, (longest + 2) % 3);
        let plane = normal(edge[i], edge[j], edge_size[i] * edge_size[j]);
        let mut nearest = 0;
        for k in 1..3 {
            if size[k] < size[nearest] {
                nearest = k;
            }
        }
        // The normal is off by the margin; the corner and the product of both by u and 3 u, covered by MARGIN.
        let height = dot(plane.normal, p[nearest]);
        let error = size[nearest] * plane.margin;
        Some(Caster {
            corner: [0, 1, 2].map(|k| scaled(p[k], size[k])),
            side,
            plane,
            near: height - error,
            far: height + error,
            distance: distance(&p, &size, &edge, plane.normal),
            sphere: if spheres {
                Sphere::around(&raw, &p, &edge, &edge_size, wide(light))
            } else {
                Sphere::default()
            },
            facing,
        })
    }
}

/// A lower bound of the distance from the light to the triangle.
///
/// For any unit vector `v` the smallest `v · corner` is such a bound, and for `v` towards the nearest point of the
/// triangle it is the distance itself. That point is the foot of the perpendicular on the plane, or lies on an edge: so the
/// best of four directions is tight, and right however they are rounded.
fn distance(p: &[[f64; 3]; 3], size: &[f64; 3], edge: &[[f64; 3]; 3], normal: [f64; 3]) -> f64 {
    // `v` is unit to 4 u, the dot product off by 3 u, the corner by u. A vector without direction is NaN: no bound.
    let bound = |v: [f64; 3]| {
        let [a, b, c] = [0, 1, 2].map(|k| dot(v, p[k]) - 16.0 * U * size[k]);
        if a.is_nan() || b.is_nan() || c.is_nan() { 0.0 } else { a.min(b).min(c) }
    };
    let mut best = f64::max(0.0, bound(normal));
    for k in 0..3 {
        let along = (-dot(p[k], edge[k]) / dot(edge[k], edge[k])).clamp(0.0, 1.0);
        let foot = [0, 1, 2].map(|i| p[k][i] + along * edge[k][i]);
        best = best.max(bound(scaled(foot, length(foot))));
    }
    best
}

impl Sphere {
    /// The sphere over the longest edge if it holds the third corner, else the circumscribed one, unless that comes out
    /// larger than the sphere around the centroid. The radius is measured, so any centre is right.
    fn around(
        raw: &[[f64; 3]; 3],
        p: &[[f64; 3]; 3],
        edge: &[[f64; 3]; 3],
        edge_size: &[f64; 3],
        light: [f64; 3],
    ) -> Sphere {
        let radius = |c: [f64; 3]| (0..3).fold(0.0, |r: f64, k| r.max(length(sub(raw[k], c))));
        let centroid = [0, 1, 2].map(|k| (raw[0][k] + raw[1][k] + raw[2][k]) / 3.0);
        let mut best = (centroid, radius(centroid));
        let mut consider = |c: [f64; 3]| {
            let r = radius(c);
            if c.iter().all(|v| v.is_finite()) && r < best.1 {
                best = (c, r);
            }
        };
        for k in 0..3 {
            let next = (k + 1) % 3;
            consider([0, 1, 2].map(|i| (raw[k][i] + raw[next][i]) / 2.0));
        }
        // Circumcentre from barycentric weights a² (b² + c² - a²), with a the edge opposite the corner.
        let square = edge_size.map(|v| v * v / (edge_size[0] * edge_size[0]).max(f64::MIN_POSITIVE));
        let opposite = [square[1], square[2], square[0]];
        let weight =
            [0, 1, 2].map(|k| opposite[k] * (opposite[(k + 1) % 3] + opposite[(k + 2) % 3] - opposite[k]));
        let total: f64 = weight.iter().sum();
        consider([0, 1, 2].map(|i| raw[0][i] + (weight[1] * edge[0][i] - weight[2] * edge[2][i]) / total));
        let (centre, r) = best;
        let c = sub(centre, light);
        let far = length(c);
        // Distances are off by a few u of the coordinates' differences; the centre is what is stored. `centre - light`
        // is rounded once more, by u times the far side of the sphere at most.
        let largest = p.iter().fold(far, |m, v| m.max(length(*v)));
        let r = r * (1.0 + 16.0 * U) + 16.0 * U * largest;
        let sin = r / far * (1.0 + 8.0 * U);
        if sin.is_nan() || sin >= 1.0 {
            // The light may be inside: every cone meets the sphere.
            return Sphere { direction: [1.0, 0.0, 0.0], sin: 2.0, cos: [0.0, 0.0], distance: 0.0 };
        }
        let square = 1.0 - sin * sin;
        Sphere {
            direction: scaled(c, far),
            sin,
            cos: [(square - 8.0 * U).max(0.0).sqrt(), (square + 8.0 * U).sqrt()],
            distance: (far * (1.0 - 8.0 * U) - r).max(0.0),
        }
    }
}
