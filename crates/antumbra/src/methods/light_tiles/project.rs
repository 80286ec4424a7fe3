//! Eight triangles of the triangle pass as seen from the light: faces, and bounds of directions.

use antumbra_predicates::filter::LIMIT;
use antumbra_predicates::tile::{NEAREST, Region, WIDEN};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};

use super::bin::{Binned, Pass};
use super::boxes::Hull;
use super::shuffle::corners;
use super::sight::{Sight, Sights};

/// Eight triangles as seen from the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projected<S: Simd> {
    pub(super) seen: SeenEight<S>,
    pub(super) face: f32x8<S>,
    /// Triangles that count; bits.
    pub(super) live: u32,
    /// Within one face, with room to spare.
    pub(super) simple: u32,
}

impl<S: Simd> Projected<S> {
    /// No triangles.
    #[inline(always)]
    pub(super) fn none(s: S) -> Self {
        let zero = f32x8::splat(s, 0.0);
        Self { seen: SeenEight { x: [zero; 2], y: [zero; 2], r: zero }, face: zero, live: 0, simple: 0 }
    }
}

/// Up to eight triangles.
#[inline(always)]
pub(super) fn project<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    first: usize,
    count: usize,
    out: &mut Binned,
) -> Projected<S> {
    let zero = f32x8::splat(s, 0.0);
    let one = f32x8::splat(s, 1.0);
    let raw = match pass.triangles[first..].first_chunk() {
        Some([a, b, c, d, e, f, g, h]) => corners(s, [a, b, c, d, e, f, g, h]),
        None => {
            let at = |i: usize| &pass.triangles[first + i.min(count - 1)];
            corners(s, [at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)])
        }
    };
    // Infinity and NaN times zero are NaN. What is behind `count` is the last again: no harm.
    let mut finite = zero;
    for v in raw.as_flattened() {
        finite = v.mul_add(zero, finite);
    }
    out.broken |= finite.simd_eq(zero).to_bitmask() as u8 != 0xff;
    let degenerate = same(raw[0], raw[1]) | same(raw[1], raw[2]) | same(raw[2], raw[0]);
    let live = !degenerate & ((1 << count) - 1);
    out.counts.setup_tris += u64::from(live.count_ones());
    let mut rel = raw;
    for v in &mut rel {
        *v = [v[0] - pass.light[0], v[1] - pass.light[1], v[2] - pass.light[2]];
    }
    let [(f0, w0), (f1, w1), (f2, w2)] = [face(s, rel[0]), face(s, rel[1]), face(s, rel[2])];
    let r = [one / w0, one / w1, one / w2];
    let ([x_lo, x_hi, y_lo, y_hi], within) = if pass.tiles.sights.any_far {
        bounds_far(s, &pass.tiles.sights, f0, live, &raw, &r)
    } else {
        let is_x = f0.simd_lt(2.0);
        let is_z = f0.simd_ge(4.0);
        let (mut x, mut y) = ([zero; 3], [zero; 3]);
        for c in 0..3 {
            x[c] = is_x.select(rel[c][1], rel[c][0]) * r[c];
            y[c] = is_z.select(rel[c][1], rel[c][2]) * r[c];
        }
        let widen = 2.0 * WIDEN;
        let x_lo = x[0].min(x[1]).min(x[2]) - widen;
        let x_hi = x[0].max(x[1]).max(x[2]) + widen;
        let y_lo = y[0].min(y[1]).min(y[2]) - widen;
        let y_hi = y[0].max(y[1]).max(y[2]) + widen;
        let within = x_lo.simd_gt(-1.0) & x_hi.simd_lt(1.0) & y_lo.simd_gt(-1.0) & y_hi.simd_lt(1.0);
        ([x_lo, x_hi, y_lo, y_hi], within)
    };
    let r_hi = r[0].max(r[1]).max(r[2]) * (1.0 + WIDEN);
    // Inside one face with room to spare, and no coordinate that rounds badly.
    let simple = f0.simd_eq(f1)
        & f0.simd_eq(f2)
        & within
        & w0.min(w1).min(w2).simd_ge(NEAREST)
        & w0.max(w1).max(w2).simd_le(LIMIT);
    let simple = simple.to_bitmask() as u32;
    let seen = SeenEight { x: [x_lo, x_hi], y: [y_lo, y_hi], r: r_hi };
    Projected { seen, face: f0, live, simple }
}

/// Bounds of eight triangles, where some face measures directions from a point: least x, largest x, least y, largest y, with room for rounding; and
/// which of them are within the face, if their corners are.
#[inline(always)]
fn bounds_far<S: Simd>(
    s: S,
    sights: &Sights,
    faces: f32x8<S>,
    live: u32,
    raw: &[[f32x8<S>; 3]; 3],
    r: &[f32x8<S>; 3],
) -> ([f32x8<S>; 4], mask32x8<S>) {
    let one = f32x8::splat(s, 1.0);
    let is_x = faces.simd_lt(2.0);
    let is_z = faces.simd_ge(4.0);
    let aims = Aims::of(s, sights, faces, live);
    let (mut x, mut y) = (*r, *r);
    for c in 0..3 {
        let [u, v, w] = [
            is_x.select(raw[c][1], raw[c][0]),
            is_z.select(raw[c][1], raw[c][2]),
            is_x.select(raw[c][0], is_z.select(raw[c][2], raw[c][1])),
        ];
        let from = w.mul_sub(aims.sign, aims.anchor[2]);
        x[c] = (u - aims.anchor[0] - from * aims.slope[0]) * r[c];
        y[c] = (v - aims.anchor[1] - from * aims.slope[1]) * r[c];
    }
    let (least, most) = (r[0].min(r[1]).min(r[2]), r[0].max(r[1]).max(r[2]));
    let depth = (one - least * aims.reach).abs().max((one - most * aims.reach).abs()).max(aims.depth);
    let ([x_lo, x_hi], x_within) = sides_far(x, depth, aims.slope[0]);
    let ([y_lo, y_hi], y_within) = sides_far(y, depth, aims.slope[1]);
    ([x_lo, x_hi, y_lo, y_hi], x_within & y_within)
}

/// Least and largest of three directions, and whether they are within a face whose point has direction `slope`.
#[inline(always)]
fn sides_far<S: Simd>(v: [f32x8<S>; 3], depth: f32x8<S>, slope: f32x8<S>) -> ([f32x8<S>; 2], mask32x8<S>) {
    let (least, most) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
    // Twice what is needed.
    let widen = (least.abs().max(most.abs()) + depth + WIDEN) * (2.0 * WIDEN);
    let (lo, hi) = (least - widen, most + widen);
    // A few ulp within, as the slope is rounded.
    let edge = 1.0 - 12.0 * f32::EPSILON;
    ([lo, hi], lo.simd_gt(-slope - edge) & hi.simd_lt(-slope + edge))
}

/// How the faces of eight triangles see them ([`super::sight::Sight`]): one face or several.
#[derive(Clone, Copy, Debug)]
struct Aims<S: Simd> {
    sign: f32x8<S>,
    anchor: [f32x8<S>; 3],
    slope: [f32x8<S>; 2],
    reach: f32x8<S>,
    depth: f32x8<S>,
}

impl<S: Simd> Aims<S> {
    /// `faces` as numbers, of which those in `live` count.
    #[inline(always)]
    fn of(s: S, sights: &Sights, faces: f32x8<S>, live: u32) -> Self {
        let first = faces[live.trailing_zeros() as usize % 8];
        if faces.simd_eq(first).to_bitmask() as u32 & live == live {
            let n = Self::numbers(&sights.faces[first as usize]);
            let all = |k: usize| f32x8::splat(s, n[k]);
            return Self::new([all(0), all(1), all(2), all(3), all(4), all(5), all(6), all(7)]);
        }
        let mut at = [[0.0; 8]; 8];
        for (lane, face) in faces.to_array().into_iter().enumerate() {
            let numbers = Self::numbers(&sights.faces[face as usize]);
            for k in 0..8 {
                at[k][lane] = numbers[k];
            }
        }
        let each = |k: usize| f32x8::load_array_ref(s, &at[k]);
        Self::new([each(0), each(1), each(2), each(3), each(4), each(5), each(6), each(7)])
    }

    #[inline(always)]
    fn new([sign, u, v, w, x, y, reach, depth]: [f32x8<S>; 8]) -> Self {
        Self { sign, anchor: [u, v, w], slope: [x, y], reach, depth }
    }

    #[inline(always)]
    fn numbers(sight: &Sight) -> [f32; 8] {
        let ([u, v, w], [x, y]) = (sight.aim.anchor(), sight.aim.slope());
        [sight.frame.sign, u, v, w, x, y, sight.aim.reach(), sight.depth]
    }
}

/// Bounds of eight triangles as seen from the light, within one face.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenEight<S: Simd> {
    pub(super) x: [f32x8<S>; 2],
    pub(super) y: [f32x8<S>; 2],
    pub(super) r: f32x8<S>,
}

impl<S: Simd> SeenEight<S> {
    /// Which of them may block some sample of a region; bits.
    #[inline(always)]
    pub(super) fn near(&self, region: &Region) -> u32 {
        let near = self.r.simd_ge(region.lo[2])
            & self.x[0].simd_le(region.hi[0])
            & self.x[1].simd_ge(region.lo[0])
            & self.y[0].simd_le(region.hi[1])
            & self.y[1].simd_ge(region.lo[1]);
        near.to_bitmask() as u32
    }

    /// Bounds of some of them.
    #[inline(always)]
    pub(super) fn hull(&self, s: S, lanes: u32) -> Hull {
        let lanes = mask32x8::from_bitmask(s, u64::from(lanes));
        let infinity = f32x8::splat(s, f32::INFINITY);
        [
            lanes.select(self.x[0], infinity).reduce_min(),
            lanes.select(self.x[1], -infinity).reduce_max(),
            lanes.select(self.y[0], infinity).reduce_min(),
            lanes.select(self.y[1], -infinity).reduce_max(),
            lanes.select(self.r, -infinity).reduce_max(),
        ]
    }
}

/// Lanes in which two corners are one point.
#[inline(always)]
fn same<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> u32 {
    (a[0].simd_eq(b[0]) & a[1].simd_eq(b[1]) & a[2].simd_eq(b[2])).to_bitmask() as u32
}

/// The face a vector points through (0, 2, 4 by axis, one more on the negative side), and its largest coordinate.
#[inline(always)]
fn face<S: Simd>(s: S, q: [f32x8<S>; 3]) -> (f32x8<S>, f32x8<S>) {
    let zero = f32x8::splat(s, 0.0);
    let a = [q[0].abs(), q[1].abs(), q[2].abs()];
    let x = a[0].simd_ge(a[1]) & a[0].simd_ge(a[2]);
    let y = a[1].simd_ge(a[2]);
    let major = x.select(q[0], y.select(q[1], q[2]));
    let axis = x.select(zero, y.select(f32x8::splat(s, 2.0), f32x8::splat(s, 4.0)));
    (axis + major.simd_lt(0.0).select(f32x8::splat(s, 1.0), zero), major.abs())
}
