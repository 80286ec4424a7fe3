//! Second and third stage: f64 with the same bound, then exact arithmetic.
//!
//! For the few (triangle, sample) pairs that [`crate::filter`] leaves open. The linear tests are those of the filter, in
//! f64 from raw coordinates. Products of three differences of `f32` lie between 2^-447 and 2^387, so neither
//! overflow nor underflow can happen and the bound is purely relative.

use crate::{Triangle, exact};

/// Relative bound of one test, in units of the sum of absolute products: 16 u with u = 2^-53. `bounds.md` needs 10.
pub const KAPPA_F64: f64 = 16.0 * 0.5 * f64::EPSILON;

/// Which stage decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decided {
    /// f64 was certain.
    Double,
    /// Expansions were needed.
    Exact,
}

/// One triangle, ready to be asked about samples.
#[derive(Clone, Copy, Debug)]
pub struct Resolver {
    triangle: Triangle,
    light: [f32; 3],
    facing: i8,
    a: [f64; 3],
    m: [[f64; 3]; 4],
    mag: [[f64; 3]; 4],
    det: f64,
    det_mag: f64,
}

type V3 = [f64; 3];

#[inline(always)]
fn wide(p: [f32; 3]) -> V3 {
    [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])]
}

#[inline(always)]
fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn abs(a: V3) -> V3 {
    [a[0].abs(), a[1].abs(), a[2].abs()]
}

#[inline(always)]
fn cross_abs(a: V3, b: V3) -> V3 {
    let (a, b) = (abs(a), abs(b));
    [a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2], a[0] * b[1] + a[1] * b[0]]
}

impl Resolver {
    /// Prepares a triangle. `None` if it is degenerate or edge-on: then it blocks nothing.
    #[inline]
    pub fn new(triangle: &Triangle, light: [f32; 3]) -> Option<Resolver> {
        let raw = [wide(triangle[0]), wide(triangle[1]), wide(triangle[2])];
        let l = wide(light);
        let rel = [sub(raw[0], l), sub(raw[1], l), sub(raw[2], l)];
        let edge = [sub(raw[1], raw[0]), sub(raw[2], raw[1]), sub(raw[0], raw[2])];
        let n = cross(edge[2], edge[0]);
        let n_mag = cross_abs(edge[2], edge[0]);
        let det = dot(n, rel[0]);
        let det_mag = dot(n_mag, abs(rel[0]));
        let facing = if det > KAPPA_F64 * det_mag {
            1
        } else if det < -KAPPA_F64 * det_mag {
            -1
        } else {
            exact::facing(triangle, light)
        };
        if facing == 0 {
            return None;
        }
        let m = [cross(rel[0], edge[0]), cross(rel[1], edge[1]), cross(rel[2], edge[2]), n];
        let mag = [cross_abs(rel[0], edge[0]), cross_abs(rel[1], edge[1]), cross_abs(rel[2], edge[2]), n_mag];
        Some(Resolver { triangle: *triangle, light, facing, a: raw[0], m, mag, det, det_mag })
    }

    /// The sign of `det[A, B, C]`: 1 or -1, exact.
    pub fn facing(&self) -> i8 {
        self.facing
    }

    /// The four tests at `p`, oriented so that "blocks" is "all positive", and how far each may be off.
    #[inline(always)]
    fn values(&self, p: V3) -> ([f64; 4], [f64; 4]) {
        let s = f64::from(self.facing);
        let q = sub(p, self.a);
        let q_abs = abs(q);
        let value = |k: usize| s * dot(self.m[k], q);
        let bound = |k: usize| KAPPA_F64 * dot(self.mag[k], q_abs);
        let values = [value(0), s * (self.det + dot(self.m[1], q)), value(2), value(3)];
        (values, [bound(0), bound(1) + KAPPA_F64 * self.det_mag, bound(2), bound(3)])
    }

    /// Does the triangle block the sample? Exact.
    #[inline]
    pub fn blocks(&self, p: [f32; 3]) -> (bool, Decided) {
        let p64 = wide(p);
        let q = sub(p64, self.a);
        let q_abs = abs(q);
        let s = f64::from(self.facing);
        let mut sure = [false; 4];
        // One test after the other: most pairs miss at the first or second.
        for k in 0..4 {
            let (constant, more) = if k == 1 { (self.det, KAPPA_F64 * self.det_mag) } else { (0.0, 0.0) };
            let value = s * (constant + dot(self.m[k], q));
            let bound = KAPPA_F64 * dot(self.mag[k], q_abs) + more;
            if value < -bound {
                return (false, Decided::Double);
            }
            sure[k] = value > bound;
        }
        if sure == [true; 4] {
            return (true, Decided::Double);
        }
        let [a, b, c] = self.triangle;
        let (t, l, f) = (&self.triangle, self.light, self.facing);
        // Certain signs need not be asked again.
        let blocks = (sure[0] || exact::side(a, b, p, l) == f)
            && (sure[1] || exact::side(b, c, p, l) == f)
            && (sure[2] || exact::side(c, a, p, l) == f)
            && (sure[3] || exact::beyond(t, p) == f);
        (blocks, Decided::Exact)
    }

    /// Where the ray from the origin of the tests ("light") through `p` meets the triangle: the ray parameter (0 at the
    /// light, 1 at `p`) and the weights of corners b and c. Closed: a ray through an edge, to within rounding, hits the
    /// triangles on both sides. `None` if it misses. For primary visibility, which needs no exactness but no cracks.
    #[inline]
    pub fn intersect(&self, p: [f32; 3]) -> Option<(f64, [f64; 2])> {
        let (values, bounds) = self.values(wide(p));
        if (0..3).any(|k| values[k] < -bounds[k]) {
            return None;
        }
        let [ab, bc, ca] = [values[0].max(0.0), values[1].max(0.0), values[2].max(0.0)];
        let sum = ab + bc + ca;
        let det = self.det * f64::from(self.facing);
        let along = values[3] + det;
        if sum <= 0.0 || along <= 0.0 || det <= 0.0 {
            return None;
        }
        Some((det / along, [ca / sum, ab / sum]))
    }
}

/// Does the triangle block the sample? All stages after f32; for callers with a single pair.
pub fn blocks(triangle: &Triangle, light: [f32; 3], p: [f32; 3]) -> bool {
    Resolver::new(triangle, light).is_some_and(|r| r.blocks(p).0)
}
