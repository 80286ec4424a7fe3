//! Cones with the apex at the light, and the smallest cone around four (section 3.1 of the paper).
//!
//! Everything about cones is f64, where no difference, product or square of f32 coordinates can overflow or underflow: a
//! coordinate relative to the light lies between 2^-149 and 2^129 or is zero, so even squared normals of triangles
//! (six factors would be 2^±900) stay in range. All vectors that meet in a test are brought to unit length, so its error is
//! *absolute*: a small multiple of [`U`].

use super::vector::{cross, dot};

/// Unit roundoff of f64.
pub(super) const U: f64 = 0.5 * f64::EPSILON;

/// Half angle that a cone is widened by when it is put around others: 128 u, in radians.
///
/// Derivation. The axes `w` (parent) and `v` (child) are what is stored; their lengths are off by 3 u each. The computed
/// cosine `w·v` and sine `|w × v|` of the angle between them are off by at most 3 u (lengths 6 u more) and 5 u (6 u
/// more). The stored cosine and sine of the child are off by 4 u each. The addition theorem adds the four and rounds
/// thrice: 2 (9 + 4) u + 3 u and 2 (11 + 4) u + 3 u, so the angle is off by less than 35 u; normalising the pair adds 4 u.
/// The child's rays were off the child by what its own widening covers; a ray's own direction is off by 5 u (difference
/// 1, length 3, division 1). The comparison of two spreads by [`spread_key`] may prefer one that is smaller by 8 u. In
/// sum: under 64 u. Twice that is no visible loss at angles that an f32 picture can have.
const WIDEN: f64 = 128.0 * U;

/// Rays of a node: directions within a half angle of the axis, lengths between `min` and `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    /// Unit.
    pub(super) axis: [f64; 3],
    /// Cosine of the half angle, which lies in [0, π].
    pub(super) cos: f64,
    /// Its sine.
    pub(super) sin: f64,
    /// Shortest ray, rounded down.
    pub(super) min: f64,
    /// Longest ray, rounded up; negative if there is no ray.
    pub(super) max: f64,
}

/// Grows with the angle whose cosine and sine (not negative, any common length) are given: 0 at 0, 1 at π/2, 2 at π. Unlike
/// the cosine it tells small angles apart, and it needs no inverse function, which would differ between platforms.
fn spread_key(cos: f64, sin: f64) -> f64 {
    if cos >= 0.0 { sin / (sin + cos) } else { 2.0 - sin / (sin - cos) }
}

/// Cosine and sine.
type Angle = (f64, f64);

/// The sum of two angles in [0, π], at most π.
fn add((c, s): Angle, (d, t): Angle) -> Angle {
    let (cos, sin) = (c * d - s * t, s * d + c * t);
    // Two obtuse angles are over π together; else the sine tells.
    let over = sin < 0.0 || (c < 0.0 && d < 0.0) || (sin == 0.0 && cos < 0.0);
    if over { (-1.0, 0.0) } else { (cos, sin) }
}

fn between(a: [f64; 3], b: [f64; 3]) -> Angle {
    let c = cross(a, b);
    (dot(a, b), dot(c, c).sqrt())
}

impl Cone {
    /// No ray at all.
    pub(super) const EMPTY: Cone = Cone { axis: [1.0, 0.0, 0.0], cos: 1.0, sin: 0.0, min: 0.0, max: -1.0 };

    /// The ray from the light to a sample, which is neither NaN nor the light itself.
    #[inline(always)]
    pub(super) fn ray(p: [f32; 3], light: [f32; 3]) -> Cone {
        let p = [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(light[k]));
        let length = dot(p, p).sqrt();
        // The length is off by 3 u relative; 16 u covers the rounding of the two products too.
        Cone {
            axis: p.map(|v| v / length),
            cos: 1.0,
            sin: 0.0,
            min: length * (1.0 - 16.0 * U),
            max: length * (1.0 + 16.0 * U),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.max < 0.0
    }

    /// The spread of the cone around `axis` that holds all of `cones`, before widening.
    #[inline(always)]
    fn spread(axis: [f64; 3], cones: &[Cone]) -> (f64, Angle) {
        let (mut key, mut angle) = (-1.0, (1.0, 0.0));
        for c in cones {
            let a = add(between(axis, c.axis), (c.cos, c.sin));
            let k = spread_key(a.0, a.1);
            if k > key {
                (key, angle) = (k, a);
            }
        }
        (key, angle)
    }

    /// A small cone that holds all rays of four cones.
    ///
    /// Two axes are tried: the mean of the axes, and the middle of the two cones that lie farthest apart (where two
    /// extreme cones decide, that is the best there is). Correctness does not depend on the axis, as the half angle is
    /// measured from it.
    #[inline(always)]
    pub(super) fn around(four: &[Cone; 4]) -> Cone {
        let mut full = [Cone::EMPTY; 4];
        let mut count = 0;
        for c in four {
            if !c.is_empty() {
                full[count] = *c;
                count += 1;
            }
        }
        let cones = &full[..count];
        if count <= 1 {
            return full[0];
        }
        let min = cones.iter().fold(f64::INFINITY, |m, c| m.min(c.min));
        let max = cones.iter().fold(0.0, |m: f64, c| m.max(c.max));
        let whole = Cone { axis: cones[0].axis, cos: -1.0, sin: 0.0, min, max };
        let sum = cones.iter().fold([0.0; 3], |s, c| [0, 1, 2].map(|k| s[k] + c.axis[k]));
        let mut best: Option<(f64, Angle, [f64; 3])> = None;
        for axis in [unit(sum), middle_of_farthest(cones)].into_iter().flatten() {
            let (key, angle) = Cone::spread(axis, cones);
            if best.is_none_or(|b| key < b.0) {
                best = Some((key, angle, axis));
            }
        }
        let Some((_, (c, s), axis)) = best else { return whole };
        let (c, s) = (c - s * WIDEN, s + c * WIDEN);
        let length = (c * c + s * s).sqrt();
        if s <= 0.0 || !length.is_finite() {
            return whole;
        }
        Cone { axis, cos: c / length, sin: s / length, min, max }
    }
}

/// Unit length, unless there is no clear direction.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 1e-3).then(|| v.map(|x| x / length))
}

/// The axis of the smallest cone around the two cones that together spread the most.
#[inline(always)]
fn middle_of_farthest(cones: &[Cone]) -> Option<[f64; 3]> {
    let (mut far, mut pair) = (-1.0, (0, 0));
    for i in 0..cones.len() {
        for j in 0..i {
            let (a, b) = (&cones[i], &cones[j]);
            let angle = add(add(between(a.axis, b.axis), (a.cos, a.sin)), (b.cos, b.sin));
            let key = spread_key(angle.0, angle.1);
            if key > far {
                (far, pair) = (key, (i, j));
            }
        }
    }
    let (a, b) = (&cones[pair.0], &cones[pair.1]);
    let (c, s) = between(a.axis, b.axis);
    if s < 1e-12 {
        return None;
    }
    // The direction of cone `a` that is farthest from `b`, on the great circle through both axes.
    let away =
        |a: &Cone, b: &Cone| [0, 1, 2].map(|k| a.axis[k] * a.cos - (b.axis[k] - a.axis[k] * c) / s * a.sin);
    let (e, f) = (away(a, b), away(b, a));
    unit([0, 1, 2].map(|k| e[k] + f[k]))
}
