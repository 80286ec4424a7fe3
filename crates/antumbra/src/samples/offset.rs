//! Moves a rounded surface point strictly to the eye's side of its own triangle: once, for all methods.
//!
//! Source: Wächter and Binder 2019, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems,
//! chapter 6 (an offset of the order of the rounding of the position); here enlarged until exact arithmetic agrees.

use antumbra_predicates::{Triangle, exact};

/// First offset, in units of the last place of the largest coordinate. Rounding moves a point by at most 0.87 of
/// them, so two nearly always suffice.
const FIRST: f64 = 2.0;

/// The spacing of floats at magnitude `v`.
fn ulp(v: f32) -> f64 {
    f64::from(v.abs().next_up()) - f64::from(v.abs())
}

/// Rounds `position`, a point on (or by rounding near) `triangle`, to `f32`, moved along `normal` (unit, towards the eye)
/// until it lies strictly on the side of the plane that `side` names (the sign of [`exact::beyond`] there).
///
/// `None` if no representable point near by does: only where coordinates are so large that the next float is infinite.
pub fn to_side(position: [f64; 3], normal: [f64; 3], triangle: &Triangle, side: i8) -> Option<[f32; 3]> {
    let largest = position.iter().fold(0.0f32, |m, v| m.max(v.abs() as f32));
    let mut distance = FIRST * ulp(largest);
    for _ in 0..64 {
        let p = [0, 1, 2].map(|k| (position[k] + normal[k] * distance) as f32);
        if !p.iter().all(|v| v.is_finite()) {
            return None;
        }
        if exact::beyond(triangle, p) == side {
            return Some(p);
        }
        distance *= 2.0;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_point_is_strictly_in_front_even_where_floats_are_coarse() {
        for scale in [1e-30f32, 1e-3, 1.0, 1e6, 1e12] {
            let t = [[scale, 0.1 * scale, 0.0], [0.0, scale, 0.3 * scale], [0.2 * scale, 0.0, scale]];
            let center = [0, 1, 2].map(|k| t.iter().map(|v| f64::from(v[k])).sum::<f64>() / 3.0);
            for side in [-1i8, 1] {
                let n = [0.6, 0.6, 0.53]
                    .map(|v: f64| v * f64::from(side) * f64::from(exact::beyond(&t, [scale; 3])));
                let p = to_side(center, n, &t, side).expect("a float in front");
                assert_eq!(exact::beyond(&t, p), side);
                let moved = (0..3).map(|k| (f64::from(p[k]) - center[k]).abs()).fold(0.0, f64::max);
                assert!(moved <= 8.0 * ulp(scale), "moved {moved} at scale {scale}");
            }
        }
    }
}
