//! Eight boxes a vector, tested against planes: the tile test (methods.md 3.4).

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::frustum::Plane;

/// Boxes of a vector.
pub(crate) const LANES: usize = 8;

/// Coordinates beyond this could overflow in the plane test: the boxes of such a group are never decided.
const SAFE: f32 = (1u64 << 60) as f32;

/// A box in box coordinates. All numbers are rounded outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aabb {
    pub(crate) lo: [f32; 3],
    pub(crate) hi: [f32; 3],
}

/// The largest f32 that is not above `v`.
fn down(v: f64) -> f32 {
    let r = v as f32;
    if f64::from(r) > v { r.next_down() } else { r }
}

impl Aabb {
    pub(crate) const EMPTY: Aabb = Aabb { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    /// From f64 bounds, outwards.
    pub(crate) fn around(lo: [f64; 3], hi: [f64; 3]) -> Aabb {
        Aabb { lo: lo.map(down), hi: hi.map(|v| -down(-v)) }
    }

    pub(crate) fn union(self, other: Aabb) -> Aabb {
        Aabb {
            lo: [0, 1, 2].map(|k| self.lo[k].min(other.lo[k])),
            hi: [0, 1, 2].map(|k| self.hi[k].max(other.hi[k])),
        }
    }

    /// Bounds the absolute coordinates; infinite where the plane test could overflow.
    pub(crate) fn reach(&self) -> [f32; 3] {
        let reach = [0, 1, 2].map(|k| self.lo[k].abs().max(self.hi[k].abs()));
        // Written so that NaN is out of bounds.
        if reach.iter().all(|&r| r <= SAFE) { reach } else { [f32::INFINITY; 3] }
    }
}

/// Eight boxes, lane by lane: `bound[0]` the lower corners, `bound[1]` the upper.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Box8 {
    pub(crate) bound: [[[f32; LANES]; 3]; 2],
}

impl Box8 {
    pub(crate) const ZERO: Box8 = Box8 { bound: [[[0.0; LANES]; 3]; 2] };

    pub(crate) fn set(&mut self, lane: usize, b: &Aabb) {
        for k in 0..3 {
            self.bound[0][k][lane] = b.lo[k];
            self.bound[1][k][lane] = b.hi[k];
        }
    }
}

/// A plane made ready for the boxes of one group.
#[derive(Clone, Copy, Debug)]
struct Ready {
    c: [f32; 4],
    margin: f32,
}

#[inline(always)]
fn ready(plane: &Plane, reach: [f32; 3]) -> Ready {
    let m = &plane.margin;
    // No term can be NaN: margins are positive, so an infinite reach makes an infinite margin.
    Ready { c: plane.c, margin: m[0] * reach[0] + m[1] * reach[1] + m[2] * reach[2] + m[3] }
}

/// The value at the corner where the plane is largest (`far` true) or smallest.
#[inline(always)]
fn corner<S: Simd>(s: S, boxes: &Box8, c: &[f32; 4], far: bool) -> f32x8<S> {
    let at = |k: usize| f32x8::load_array_ref(s, &boxes.bound[usize::from((c[k] > 0.0) == far)][k]);
    let w = f32x8::splat(s, c[3]);
    at(0).mul_add(c[0], at(1).mul_add(c[1], at(2).mul_add(c[2], w)))
}

/// Which boxes (one bit each) lie outside one plane for certain, and which inside all four.
#[inline(always)]
pub(crate) fn test_main<S: Simd>(
    s: S,
    boxes: &[Box8],
    planes: &[Plane; 4],
    reach: [f32; 3],
    asked: u32,
) -> (u32, u32) {
    let planes = [0, 1, 2, 3].map(|k| ready(&planes[k], reach));
    let (mut reject, mut accept) = (0, 0);
    for (i, b) in boxes.iter().enumerate() {
        let shift = LANES * i;
        if asked >> shift & 0xff == 0 {
            continue;
        }
        let (mut out, mut inside) = (0u64, 0xffu64);
        for p in &planes {
            out |= corner(s, b, &p.c, true).simd_lt(-p.margin).to_bitmask();
            inside &= corner(s, b, &p.c, false).simd_gt(p.margin).to_bitmask();
        }
        reject |= (out as u32) << shift;
        accept |= (inside as u32) << shift;
    }
    (reject & asked, accept & asked & !reject)
}

/// Which boxes lie outside one of the planes for certain.
#[inline(always)]
pub(crate) fn test_extra<S: Simd>(
    s: S,
    boxes: &[Box8],
    planes: &[Plane],
    reach: [f32; 3],
    asked: u32,
) -> u32 {
    let mut reject = 0;
    for p in planes {
        let p = ready(p, reach);
        for (i, b) in boxes.iter().enumerate() {
            let shift = LANES * i;
            if (asked & !reject) >> shift & 0xff != 0 {
                reject |= (corner(s, b, &p.c, true).simd_lt(-p.margin).to_bitmask() as u32) << shift;
            }
        }
    }
    reject & asked
}
