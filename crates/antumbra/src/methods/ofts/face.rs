//! Six faces without matrices: which face a direction belongs to, and where on it (methods 6.1).

use antumbra_predicates::Triangle;

/// Faces of the cube around the light: +x, -x, +y, -y, +z, -z.
pub(super) const FACES: usize = 6;

/// Twice the unit roundoff of f64 is its epsilon.
const U: f64 = 0.5 * f64::EPSILON;

/// Bound of every rounding between a sample's true direction and the cell that it is counted in, in units of u and v
/// (which lie in [-1, 1]), with U = 2^-53:
///
/// - 4 U: `u` itself (two differences and a quotient);
/// - 32 U: where a cell of a grid begins ([`super::grid::Axis`]);
/// - 32 U more for each earlier grid whose cells became the ends of this one: at most `ZOOMS` + 1 = 5.
///
/// That is 196 U; 512 U = 2^-44 leaves a factor of two, and no cell is so small that it would matter. It only ever
/// enlarges what a triangle covers.
pub(super) const PAD: f64 = 512.0 * U;

/// The axis that a face is perpendicular to, the two others, and the sign of the direction along the first.
#[inline(always)]
pub(super) fn axes(face: usize) -> (usize, [usize; 2], f64) {
    let major = face / 2;
    let others = [[1, 2], [0, 2], [0, 1]][major];
    (major, others, if face.is_multiple_of(2) { 1.0 } else { -1.0 })
}

/// A sample as seen from the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Direction {
    /// The one face that the sample belongs to.
    pub(super) face: usize,
    /// The other components over the absolute value of the major one, in [-1, 1].
    pub(super) uv: [f64; 2],
    /// The absolute value of the major component.
    pub(super) depth: f64,
}

#[inline(always)]
pub(super) fn relative(p: [f32; 3], light: [f32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(light[k]))
}

/// The face of a sample: the axis of its largest component (x before y before z) and that component's sign, so exactly
/// one, whatever is rounded. `None` for background, and for a sample that is at the light: nothing can be strictly between.
///
/// f64 differences and quotients of f32 numbers neither overflow nor vanish.
#[inline(always)]
pub(super) fn direction(p: [f32; 3], light: [f32; 3]) -> Option<Direction> {
    let r = relative(p, light);
    let size = r.map(f64::abs);
    let major = match (size[0] >= size[1], size[0] >= size[2], size[1] >= size[2]) {
        (true, true, _) => 0,
        (_, _, true) => 1,
        _ => 2,
    };
    // False for NaN, too; a NaN in a minor component is found by the sum.
    if !(size[major] > 0.0 && (size[0] + size[1] + size[2]).is_finite()) {
        return None;
    }
    let face = 2 * major + usize::from(r[major] < 0.0);
    let (_, [i, j], _) = axes(face);
    Some(Direction { face, uv: [r[i] / size[major], r[j] / size[major]], depth: size[major] })
}

/// A triangle's shadow as four linear functions on a face, each raised by the bound of its rounding (methods 6.3).
///
/// With the light at the origin, the direction of the sample at (u, v) is `d(u, v)`: u and v on the minor axes and ±1 on
/// the major one. Then `det[A, B, P] = depth * (A × (B - A)) · d(u, v)`: an edge is linear in (u, v), no corner is
/// projected, no near plane is needed, and a triangle that reaches around or behind the light is like any other.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceTriangle {
    /// Edge functions `[u, v, 1]`; a blocked sample has all three `>= 0`.
    pub(super) edge: [[f64; 3]; 3],
    /// `1 / edge[k][0]`.
    pub(super) inverse: [f64; 3],
    /// The plane's normal in the same form: a blocked sample has `depth * plane(u, v) >= det`.
    pub(super) plane: [f64; 3],
    /// `|det[A, B, C]|`, less the bound of its rounding.
    pub(super) det: f64,
    /// u and v of a blocked sample lie between these (infinite where the corners say nothing).
    pub(super) lo: [f64; 2],
    pub(super) hi: [f64; 2],
}

/// What is the same for all faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shadow {
    corner: [[f64; 3]; 3],
    /// Normals of the three edge planes and of the triangle, oriented so that "blocks" is "positive".
    m: [[f64; 3]; 4],
    /// What each function on a face may be off by.
    margin: [f64; 4],
    det: f64,
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn cross_abs(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let (a, b) = (a.map(f64::abs), b.map(f64::abs));
    [a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2], a[0] * b[1] + a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Shadow {
    /// `None` if the triangle is degenerate or edge-on: then it blocks nothing.
    ///
    /// Bounds: corners and edges are f64 differences of f32 numbers, so each component is off by a factor of 1 ± U.
    /// A component of a cross product is a difference of two products of those: off by at most 4.01 U times the
    /// sum of the absolute products, `mag`. On a face |u|, |v| <= 1, so a function is off by at most 4.01 U times the sum `S`
    /// of the three `mag`; evaluating it takes another six roundings of values below `S`; and moving (u, v) by [`PAD`]
    /// = 512 U (a rounded direction, a rounded cell) changes it by at most 1024 U `S`. 1024 + 11 < 2048 U = 4 `PAD`.
    /// Products of two differences of f32 numbers lie between 2^-298 and 2^258: no overflow, no underflow.
    #[inline]
    pub(super) fn new(t: &Triangle, light: [f32; 3]) -> Option<Shadow> {
        let wide = t.map(|c| c.map(f64::from));
        let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let corner = t.map(|c| relative(c, light));
        let edge = [sub(wide[1], wide[0]), sub(wide[2], wide[1]), sub(wide[0], wide[2])];
        let n = cross(edge[2], edge[0]);
        let n_mag = cross_abs(edge[2], edge[0]);
        let det = dot(n, corner[0]);
        // 4.01 U of the normal, one of the corner, one of the product, two of the sum: under 16 U.
        let det_bound = 16.0 * U * dot(n_mag, corner[0].map(f64::abs));
        let facing = if det > det_bound {
            1
        } else if det < -det_bound {
            -1
        } else {
            antumbra_predicates::exact::facing(t, light)
        };
        if facing == 0 {
            return None;
        }
        let s = f64::from(facing);
        let m = [cross(corner[0], edge[0]), cross(corner[1], edge[1]), cross(corner[2], edge[2]), n];
        let mag = [
            cross_abs(corner[0], edge[0]),
            cross_abs(corner[1], edge[1]),
            cross_abs(corner[2], edge[2]),
            n_mag,
        ];
        Some(Shadow {
            corner,
            m: m.map(|v| v.map(|x| x * s)),
            margin: mag.map(|v| 4.0 * PAD * (v[0] + v[1] + v[2])),
            det: det * s - det_bound,
        })
    }

    /// The shadow on one face; `None` if it certainly misses `window` (least and largest u, least and largest v).
    ///
    /// A blocked sample is a sum of the corners with weights that are not negative. So what holds for all three corners
    /// and is kept by such sums holds for the sample: being behind the face, being on one side of a plane through
    /// the light. The signs of differences are exact, quotients are not: those bounds are moved by `PAD (1 + |x|)`.
    #[inline]
    pub(super) fn on_face(&self, face: usize, window: [[f64; 2]; 2]) -> Option<FaceTriangle> {
        let (major, minor, sign) = axes(face);
        let c = &self.corner;
        let front = [0, 1, 2].map(|k| c[k][major] * sign);
        if front.iter().all(|&f| f <= 0.0) {
            return None;
        }
        let all_front = front.iter().all(|&f| f > 0.0);
        let (mut lo, mut hi) = ([f64::NEG_INFINITY; 2], [f64::INFINITY; 2]);
        for axis in 0..2 {
            let x = [0, 1, 2].map(|k| c[k][minor[axis]]);
            if all_front {
                let q = [0, 1, 2].map(|k| x[k] / front[k]);
                let (least, most) = (q[0].min(q[1]).min(q[2]), q[0].max(q[1]).max(q[2]));
                lo[axis] = least - PAD * (1.0 + least.abs());
                hi[axis] = most + PAD * (1.0 + most.abs());
            } else {
                // x - w * front, the side of a plane through the light and the window's border.
                let [w0, w1] = window[axis];
                let outside = |w: f64, sign: f64| {
                    (0..3).all(|k| sign * (x[k] - w * front[k]) > 4.0 * PAD * (x[k].abs() + front[k].abs()))
                };
                if outside(w0, -1.0) || outside(w1, 1.0) {
                    return None;
                }
                if x.iter().all(|&x| x >= 0.0) {
                    lo[axis] = -PAD;
                }
                if x.iter().all(|&x| x <= 0.0) {
                    hi[axis] = PAD;
                }
            }
            if lo[axis] > window[axis][1] + PAD || hi[axis] < window[axis][0] - PAD {
                return None;
            }
        }
        let function = |k: usize| {
            let m = &self.m[k];
            [m[minor[0]], m[minor[1]], m[major] * sign + self.margin[k]]
        };
        let edge = [function(0), function(1), function(2)];
        Some(FaceTriangle {
            edge,
            inverse: edge.map(|e| 1.0 / e[0]),
            plane: function(3),
            det: self.det,
            lo,
            hi,
        })
    }
}

impl FaceTriangle {
    /// The values of u that a blocked sample with v in `v` can have: `None` if there are none.
    ///
    /// `edge` holds margins already; the quotient is rounded three times, which `PAD (1 + |x|)` covers.
    #[inline(always)]
    pub(super) fn span(&self, v: [f64; 2]) -> Option<[f64; 2]> {
        let (mut lo, mut hi) = (self.lo[0], self.hi[0]);
        for k in 0..3 {
            let [a, b, c] = self.edge[k];
            let rest = b * if b > 0.0 { v[1] } else { v[0] } + c;
            if a == 0.0 {
                if rest < 0.0 {
                    return None;
                }
                continue;
            }
            let x = -rest * self.inverse[k];
            let pad = PAD * (1.0 + x.abs());
            if a > 0.0 {
                lo = lo.max(x - pad);
            } else {
                hi = hi.min(x + pad);
            }
        }
        (lo <= hi).then_some([lo, hi])
    }

    /// True if every sample between the given u and v, no deeper than `depth`, is certainly not beyond the plane.
    #[inline(always)]
    pub(super) fn in_front_of_plane(&self, u: [f64; 2], v: [f64; 2], depth: f64) -> bool {
        let [a, b, c] = self.plane;
        let most = a * if a > 0.0 { u[1] } else { u[0] } + b * if b > 0.0 { v[1] } else { v[0] } + c;
        depth * most < self.det
    }
}
