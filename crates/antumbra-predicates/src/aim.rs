//! Where the directions of samples and triangles are measured from: the axis of a cube face around the light, or a point that a far light looks at.
//! `bounds.md` ("Aims") derives what rounds them.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f32x8};

use crate::filter::{LIMIT, TINY};
use crate::tile::{NEAREST, Region, WIDEN};
use crate::vector::{V3, splat3, sub};

/// Where directions are measured from, in the frame of a face: its axis, or a point (the anchor) that a far light looks at.
///
/// With the anchor at `k` from the light, directions are `x - k.u / k.w` and `y - k.v / k.w`: a shear of space that leaves all tests as they
/// are, but for constants. They are computed from differences to the anchor, so that their rounding is in proportion to how close together the samples are,
/// not to how far away the light is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Aim {
    light: [f32; 3],
    /// What directions are measured from: a point, or the light itself if there is none.
    anchor: [f32; 3],
    /// Direction of the anchor, rounded; at most 1.
    slope: [f32; 2],
    /// Distance of the anchor along `w`, rounded; 0 if there is none.
    reach: f32,
    /// Covers the rounding of relative depths.
    least: f32,
}

/// Relative depths are off by some u (`bounds.md`, "Aims"), which is more than nothing where all is at one depth.
const DEPTH_LEAST: f32 = 16.0 * 0.5 * f32::EPSILON;

impl Aim {
    /// Directions as they are.
    pub fn straight(light: [f32; 3]) -> Aim {
        Aim { light, anchor: light, slope: [0.0; 2], reach: 0.0, least: 0.0 }
    }

    /// From about a direction `x`, `y` at nearness `r`. Straight if that is no point of the face.
    pub fn at(light: [f32; 3], [x, y, r]: [f32; 3]) -> Aim {
        let l = light.map(f64::from);
        let w = 1.0 / f64::from(r);
        let anchor = [l[0] + f64::from(x) * w, l[1] + f64::from(y) * w, l[2] + w].map(|c| c as f32);
        let k = [0, 1, 2].map(|i| f64::from(anchor[i]) - l[i]);
        let (slope, reach) = ([(k[0] / k[2]) as f32, (k[1] / k[2]) as f32], k[2] as f32);
        if !(slope[0].abs() <= 1.0 && slope[1].abs() <= 1.0 && (NEAREST..=LIMIT).contains(&reach)) {
            return Aim::straight(light);
        }
        Aim { light, anchor, slope, reach, least: DEPTH_LEAST }
    }

    /// The light.
    pub fn light(&self) -> [f32; 3] {
        self.light
    }

    /// What directions are measured from.
    pub fn anchor(&self) -> [f32; 3] {
        self.anchor
    }

    /// The direction of the anchor.
    pub fn slope(&self) -> [f32; 2] {
        self.slope
    }

    /// The distance of the anchor along `w`; 0 if there is none.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// Whether directions are measured from the axis of the face.
    #[inline(always)]
    pub fn is_straight(&self) -> bool {
        self.reach == 0.0
    }

    /// How far from the anchor, in depth and relative to their own, the samples of a region are, at most: it scales the rounding of their directions.
    /// 1 if there is no anchor.
    pub fn depth_of(&self, region: &Region) -> f32 {
        let [least, most] = [region.lo[2], region.hi[2]];
        (1.0 - self.reach * least).abs().max((1.0 - self.reach * most).abs()) + self.least
    }

    /// What the bounds of tests are multiplied with along x and y, in a region: the largest direction in it, or what rounds it.
    pub fn weight(&self, region: &Region) -> [f32; 2] {
        let depth = self.depth_of(region);
        [0, 1].map(|k| region.lo[k].abs().max(region.hi[k].abs()).max(depth))
    }

    /// x, y and r of one point of the face, in its frame.
    pub fn seen(&self, p: [f32; 3]) -> [f32; 3] {
        let r = 1.0 / (p[2] - self.light[2]);
        let d = [0, 1, 2].map(|k| p[k] - self.anchor[k]);
        [(d[0] - self.slope[0] * d[2]) * r, (d[1] - self.slope[1] * d[2]) * r, r]
    }

    /// u and v of eight points, in the frame: not yet divided by w.
    #[inline(always)]
    fn lean<S: Simd>(&self, p: &V3<S>) -> [f32x8<S>; 2] {
        // Without an anchor the slope is zero: no branch.
        let w = p[2] - self.anchor[2];
        [w.mul_add(-self.slope[0], p[0] - self.anchor[0]), w.mul_add(-self.slope[1], p[1] - self.anchor[1])]
    }

    /// Of eight triangles, the third coordinate of the normal of test `k` (sides ab, bc, ca, then the plane) once space is sheared, and its sum of absolute
    /// products: the first two stay the same. `edge` holds b - a, c - b, a - c.
    #[inline(always)]
    pub fn constant<S: Simd>(
        &self,
        s: S,
        raw: &[V3<S>; 3],
        edge: &[V3<S>; 3],
        k: usize,
    ) -> (f32x8<S>, f32x8<S>) {
        let ([a, a_mag], [b, b_mag]) = if k < 3 {
            (self.bend(&sub(raw[k], splat3(s, self.anchor))), self.bend(&edge[k]))
        } else {
            (self.bend(&edge[2]), self.bend(&edge[0]))
        };
        let mag = a_mag[0].mul_add(b_mag[1], a_mag[1].mul_add(b_mag[0], f32x8::splat(s, TINY)));
        (a[0].mul_sub(b[1], a[1] * b[0]), mag)
    }

    /// As [`Aim::lean`] of vectors, and what bounds their rounding ([`LEAN`]).
    #[inline(always)]
    fn bend<S: Simd>(&self, v: &V3<S>) -> [[f32x8<S>; 2]; 2] {
        let at = [v[2].mul_add(-self.slope[0], v[0]), v[2].mul_add(-self.slope[1], v[1])];
        let w = v[2].abs();
        let more = [LEAN * self.slope[0].abs(), LEAN * self.slope[1].abs()];
        [at, [w.mul_add(more[0], at[0].abs()), w.mul_add(more[1], at[1].abs())]]
    }
}

/// The rounding of what the slope takes away, in units of that of what is left: `bounds.md` needs 2.5.
const LEAN: f32 = 3.0;

/// Bounds of eight triangles as seen from the light: least x, largest x, least y, largest y, largest r, all widened. Open
/// where a corner lies beside or behind the light. `depth` is that of the samples ([`Aim::depth_of`]).
///
/// `FAR` may be false if the aim is straight: less work.
#[inline(always)]
pub fn seen_bounds<S: Simd, const FAR: bool>(
    s: S,
    aim: &Aim,
    depth: f32,
    corners: &[V3<S>; 3],
) -> [f32x8<S>; 5] {
    let one = f32x8::splat(s, 1.0);
    let infinity = f32x8::splat(s, f32::INFINITY);
    let l = splat3(s, aim.light);
    let rel = [sub(corners[0], l), sub(corners[1], l), sub(corners[2], l)];
    let front = rel[0][2].min(rel[1][2]).min(rel[2][2]).simd_ge(NEAREST);
    let r = [one / rel[0][2], one / rel[1][2], one / rel[2][2]];
    let r_hi = r[0].max(r[1]).max(r[2]);
    let (x, y, widen);
    if FAR {
        let [a, b, c] = [aim.lean(&corners[0]), aim.lean(&corners[1]), aim.lean(&corners[2])];
        (x, y) = ([a[0] * r[0], b[0] * r[1], c[0] * r[2]], [a[1] * r[0], b[1] * r[1], c[1] * r[2]]);
        widen = depth_between(s, aim, r[0].min(r[1]).min(r[2]), r_hi).max(depth) * WIDEN;
    } else {
        x = [rel[0][0] * r[0], rel[1][0] * r[1], rel[2][0] * r[2]];
        y = [rel[0][1] * r[0], rel[1][1] * r[1], rel[2][1] * r[2]];
        widen = f32x8::splat(s, WIDEN);
    }
    [
        front.select(widened_least(x, widen), -infinity),
        front.select(widened_most(x, widen), infinity),
        front.select(widened_least(y, widen), -infinity),
        front.select(widened_most(y, widen), infinity),
        front.select(r_hi.mul_add(f32x8::splat(s, WIDEN), r_hi), infinity),
    ]
}

/// [`Aim::depth_of`] what lies between two numbers of nearness, eight times.
#[inline(always)]
fn depth_between<S: Simd>(s: S, aim: &Aim, least: f32x8<S>, most: f32x8<S>) -> f32x8<S> {
    let one = f32x8::splat(s, 1.0);
    (one - least * aim.reach).abs().max((one - most * aim.reach).abs()) + aim.least
}

/// `widen` is added, and [`WIDEN`] of the bound itself.
#[inline(always)]
fn widened_least<S: Simd>(c: V3<S>, widen: f32x8<S>) -> f32x8<S> {
    let c = c[0].min(c[1]).min(c[2]);
    c - c.abs().mul_add(WIDEN, widen)
}

#[inline(always)]
fn widened_most<S: Simd>(c: V3<S>, widen: f32x8<S>) -> f32x8<S> {
    let c = c[0].max(c[1]).max(c[2]);
    c + c.abs().mul_add(WIDEN, widen)
}
