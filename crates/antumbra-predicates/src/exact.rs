//! The definition in exact arithmetic: signs of determinants of the input coordinates, never of rounded differences.
//!
//! With the light at the origin (`A = a - l`, …) every determinant of the definition is an orientation of input points:
//! `det[A, B, C] = orient3d(a, b, c, l)`, `det[A, B, P] = orient3d(a, b, p, l)`, and the plane test
//! `(B - A) × (C - A) · (P - A) = orient3d(b, c, p, a)`. Products of three differences of `f32` values lie between 2^-447
//! and 2^387 and fit an `f64` expansion without underflow or overflow, so the adaptive predicate of Shewchuk 1997
//! ("Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", sections 4.3-4.4; crate `robust`)
//! gives the right sign for every finite `f32` input.

use robust::{Coord, Coord3D, orient2d, orient3d};

fn c3(p: [f32; 3]) -> Coord3D<f64> {
    Coord3D { x: f64::from(p[0]), y: f64::from(p[1]), z: f64::from(p[2]) }
}

fn sign(v: f64) -> i8 {
    (v > 0.0) as i8 - (v < 0.0) as i8
}

/// The sign of `det[a - d, b - d, c - d]`: -1, 0 or 1.
pub fn orientation(a: [f32; 3], b: [f32; 3], c: [f32; 3], d: [f32; 3]) -> i8 {
    sign(orient3d(c3(a), c3(b), c3(c), c3(d)))
}

/// Step 1: the side of the triangle that faces the light, 0 if it is degenerate or seen edge-on.
pub fn facing(t: &[[f32; 3]; 3], light: [f32; 3]) -> i8 {
    orientation(t[0], t[1], t[2], light)
}

/// Step 2: the side of the plane through light, `a` and `b` that the sample `p` is on. A zero is broken as if the sample
/// were moved by `(ε, ε², ε³)`; 0 comes back only where `a`, `b` and the light are collinear.
pub fn side(a: [f32; 3], b: [f32; 3], p: [f32; 3], light: [f32; 3]) -> i8 {
    match orientation(a, b, p, light) {
        0 => tie_break(a, b, light),
        s => s,
    }
}

/// The sign of the first non-zero component of `(a - l) × (b - l)`.
pub fn tie_break(a: [f32; 3], b: [f32; 3], light: [f32; 3]) -> i8 {
    let minor = |i: usize, j: usize| {
        let c2 = |p: [f32; 3]| Coord { x: f64::from(p[i]), y: f64::from(p[j]) };
        sign(orient2d(c2(a), c2(b), c2(light)))
    };
    match (minor(1, 2), minor(2, 0)) {
        (0, 0) => minor(0, 1),
        (0, y) => y,
        (x, _) => x,
    }
}

/// Step 3: the side of the triangle's plane that `p` is on; equal to [`facing`] when `p` is beyond it as seen from the
/// light, 0 when it touches.
pub fn beyond(t: &[[f32; 3]; 3], p: [f32; 3]) -> i8 {
    orientation(t[1], t[2], p, t[0])
}

/// Steps 1 to 4: does the triangle block the sample? All inputs must be finite.
pub fn blocks(t: &[[f32; 3]; 3], light: [f32; 3], p: [f32; 3]) -> bool {
    let facing = facing(t, light);
    facing != 0
        && side(t[0], t[1], p, light) == facing
        && side(t[1], t[2], p, light) == facing
        && side(t[2], t[0], p, light) == facing
        && beyond(t, p) == facing
}
