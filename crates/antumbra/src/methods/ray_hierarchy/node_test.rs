//! One triangle against four sibling cones: sections 3.2 and 3.3 of the paper, and the sphere test it compares with.
//!
//! The paper projects the triangle with a perspective matrix made from the cone, and compares edge distances with the
//! unit circle. Divided by the projection, its tests become the dot products below, which need no basis and no division, and
//! stay stable up to a half angle of π/2. With w the axis, α the half angle:
//!
//! | paper | here |
//! | --- | --- |
//! | signed distance of an edge > 1: reject | inward edge normal `m·w < -sin α` |
//! | `Z_near > 1` with the far plane at `L_max`: reject | `L_max · max n·g ≤ D` over directions g of the cone |
//! | separating tangents towards the corners | planes `cos α r - sin α w`, r the part of a corner across the axis |
//! | α near or over π/2: corners in the complementary cone | `w·p < min(cos α, 0)` for all corners |
//! | all distances < -1 and `Z_far < -1`: covered | `m·w > sin α` for all edges and `L_min · min n·g > D` |
//!
//! Comparing lengths along the ray where the paper compares depths along the axis is tighter.
//!
//! A rejected cone holds no blocked ray, a covered one only blocked rays, in real arithmetic: each comparison keeps [`MARGIN`] and the
//! error of the normal ([`super::triangle::Side::margin`]) clear. A comparison with NaN fails, which decides nothing. Ties
//! of the definition occur only where a test is zero, inside the margin.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f64x4};

use super::build::Group;
use super::cone::U;
use super::triangle::{Caster, MARGIN, Side};

/// Cones with a smaller cosine are wide: their edges and tangents are not tested. The paper's ε.
const WIDE: f64 = 1e-3;

/// What a triangle does to four cones; bits are siblings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Verdict {
    /// May hold blocked rays, and others.
    pub(super) open: u8,
    /// Every ray is blocked.
    pub(super) covered: u8,
}

type Axis<S> = [f64x4<S>; 3];

#[inline(always)]
fn axis_of<S: Simd>(s: S, group: &Group) -> Axis<S> {
    [
        f64x4::load_array_ref(s, &group.axis[0]),
        f64x4::load_array_ref(s, &group.axis[1]),
        f64x4::load_array_ref(s, &group.axis[2]),
    ]
}

#[inline(always)]
fn along<S: Simd>(w: Axis<S>, v: [f64; 3]) -> f64x4<S> {
    w[2].mul_add(v[2], w[1].mul_add(v[1], w[0] * v[0]))
}

#[inline(always)]
fn dot<S: Simd>(a: Axis<S>, b: Axis<S>) -> f64x4<S> {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

#[inline(always)]
fn bits<S: Simd, M: SimdMask<S>>(m: M) -> u8 {
    m.to_bitmask() as u8
}

/// Largest and smallest `n·g` over the directions of each cone, before the margin.
#[inline(always)]
fn reach<S: Simd>(s: S, w: Axis<S>, cos: f64x4<S>, sin: f64x4<S>, plane: &Side) -> [f64x4<S>; 2] {
    let one = f64x4::splat(s, 1.0);
    let c = along(w, plane.normal);
    // The sine of the angle between normal and axis, rounded up: `c` is off by 10 u, so `1 - c²` by 22 u. The root
    // would magnify that near zero, and rounding up is safe for both results.
    let t = ((one - c * c).max(0.0) + 32.0 * U).sqrt();
    let inside = c.simd_ge(cos - MARGIN);
    let most = inside.select(one, c * cos + t * sin);
    [most, c * cos - t * sin]
}

/// The precise test. `accept`: look for covered cones too.
#[inline(always)]
pub(super) fn precise<S: Simd>(s: S, group: &Group, t: &Caster, accept: bool) -> Verdict {
    let w = axis_of(s, group);
    let cos = f64x4::load_array_ref(s, &group.cos);
    let sin = f64x4::load_array_ref(s, &group.sin);
    let min = f64x4::load_array_ref(s, &group.min);
    let max = f64x4::load_array_ref(s, &group.max);

    // Range: the triangle is farther away than any ray is long. Siblings that do not exist have a negative length.
    let mut reject = bits(max.simd_lt(t.distance));
    // Plane: the rays end before it, or lead away from it.
    let [most, least] = reach(s, w, cos, sin, &t.plane);
    let most = most + t.plane.margin;
    reject |= bits(most.simd_lt(0.0)) | bits((max * most).simd_lt(t.near));
    if reject == 0b1111 {
        return Verdict::default();
    }

    let wide = bits(cos.simd_lt(WIDE));
    let (mut outside, mut inside) = (0, 0b1111);
    for side in &t.side {
        let e = along(w, side.normal);
        outside |= bits((e + side.margin).simd_lt(-sin));
        inside &= bits((e - side.margin).simd_gt(sin));
    }
    reject |= outside & !wide;
    let mut covered = 0;
    if accept {
        let all_beyond = bits((min * (least - t.plane.margin)).simd_gt(t.far));
        covered = inside & all_beyond & !wide & !reject;
    }
    let open = !reject & !covered & 0b1111;
    if open == 0 {
        return Verdict { open, covered };
    }

    let d = [along(w, t.corner[0]), along(w, t.corner[1]), along(w, t.corner[2])];
    if open & wide != 0 {
        let limit = cos.min(0.0) - MARGIN;
        reject |= wide & bits(d[0].simd_lt(limit)) & bits(d[1].simd_lt(limit)) & bits(d[2].simd_lt(limit));
    }
    if open & !wide != 0 {
        reject |= separated(w, cos, sin, &t.corner, d) & !wide;
    }
    Verdict { open: open & !reject, covered }
}

/// The part of a corner that is perpendicular to each axis, `d` being the part along it.
#[inline(always)]
fn across<S: Simd>(w: Axis<S>, d: f64x4<S>, corner: &[f64; 3]) -> Axis<S> {
    [-(d * w[0]) + corner[0], -(d * w[1]) + corner[1], -(d * w[2]) + corner[2]]
}

/// Cones that a tangent plane through the light separates from all three corners.
///
/// For corner i let `r_i = p_i - (p_i·w) w`. The plane with normal `cos α r_i/|r_i| - sin α w` touches the cone and has all of it on
/// its negative side; corner j lies on the positive side if `cos α r_i·p_j > sin α |r_i| (p_j·w)`, where `r_i·p_j = r_i·r_j`.
/// Multiplied by |r_i| there is nothing to divide by, so a corner on the axis needs no special case.
#[inline(always)]
fn separated<S: Simd>(
    w: Axis<S>,
    cos: f64x4<S>,
    sin: f64x4<S>,
    corner: &[[f64; 3]; 3],
    d: [f64x4<S>; 3],
) -> u8 {
    // Spelled out: closures and `map` are compiled without the instruction set, and their calls cost more than the tests.
    let r = [across(w, d[0], &corner[0]), across(w, d[1], &corner[1]), across(w, d[2], &corner[2])];
    let product = [dot(r[0], r[1]), dot(r[1], r[2]), dot(r[2], r[0])];
    let mut found = 0;
    for i in 0..3 {
        let square = dot(r[i], r[i]);
        let size = sin * square.sqrt();
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        found |= bits(
            (cos * square - size * d[i]).simd_gt(MARGIN)
                & (cos * product[i] - size * d[j]).simd_gt(MARGIN)
                & (cos * product[k] - size * d[k]).simd_gt(MARGIN),
        );
    }
    found
}

/// The sphere test: a cone meets the bounding sphere if the angle between axis and centre is at most α plus the
/// angle θ that the sphere fills.
#[inline(always)]
pub(super) fn sphere<S: Simd>(s: S, group: &Group, t: &Caster) -> Verdict {
    let max = f64x4::load_array_ref(s, &group.max);
    let beyond = bits(max.simd_lt(t.sphere.distance));
    if t.sphere.sin > 1.0 || beyond == 0b1111 {
        return Verdict { open: !beyond & 0b1111, covered: 0 };
    }
    let w = axis_of(s, group);
    let cos = f64x4::load_array_ref(s, &group.cos);
    let sin = f64x4::load_array_ref(s, &group.sin);
    let [low, high] = t.sphere.cos;
    let obtuse = cos.simd_lt(0.0);
    // cos(α + θ), rounded down; and whether α + θ may reach π, which only an obtuse α can.
    let theta = obtuse.select(f64x4::splat(s, high), f64x4::splat(s, low));
    let limit = cos * theta - sin * t.sphere.sin;
    let all_round = bits((sin * low + cos * t.sphere.sin).simd_le(MARGIN)) & bits(obtuse);
    let apart = bits((along(w, t.sphere.direction) + MARGIN).simd_lt(limit - MARGIN));
    Verdict { open: !(beyond | (apart & !all_round)) & 0b1111, covered: 0 }
}
