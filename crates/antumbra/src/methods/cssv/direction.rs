//! The one predicate that is not an orientation of four input points: the sign of `det[a - l, b - l, p - e]`.
//!
//! It says on which side of the plane through light, `a` and `b` the *direction* from the eye `e` to the sample `p`
//! points: where an eye ray ends up at infinity. Filtered in f64; then expansions (Shewchuk 1997, "Adaptive Precision
//! Floating-Point Arithmetic", sections 2.4 and 2.6), which f64 holds without overflow or underflow: all parts are
//! multiples of 2^-447 and the whole is smaller than 2^390.

use antumbra_predicates::resolve::KAPPA_F64;

/// A difference of two input points: `to - from`.
pub(super) type Difference = ([f32; 3], [f32; 3]);

/// The sign of the determinant of three differences of input points, each given as (to, from). Exact.
pub(super) fn orientation(rows: [Difference; 3]) -> i8 {
    let d = rows.map(|(to, from)| [0, 1, 2].map(|k| f64::from(to[k]) - f64::from(from[k])));
    let (mut value, mut magnitude) = (0.0, 0.0);
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        value += d[2][k] * (d[0][i] * d[1][j] - d[0][j] * d[1][i]);
        magnitude += (d[2][k] * d[0][i] * d[1][j]).abs() + (d[2][k] * d[0][j] * d[1][i]).abs();
    }
    // Three differences, two products and three sums: nine roundings; the constant allows for sixteen.
    if value.abs() > KAPPA_F64 * magnitude {
        return if value > 0.0 { 1 } else { -1 };
    }
    exact(rows)
}

fn exact(rows: [Difference; 3]) -> i8 {
    let d = rows.map(|(to, from)| [0, 1, 2].map(|k| two_diff(f64::from(to[k]), f64::from(from[k]))));
    let mut sum = Expansion::default();
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        sum.add_product(d[0][i], d[1][j], d[2][k], 1.0);
        sum.add_product(d[0][j], d[1][i], d[2][k], -1.0);
    }
    sum.sign()
}

fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let x = a + b;
    let b_part = x - a;
    [x, (a - (x - b_part)) + (b - b_part)]
}

fn two_diff(a: f64, b: f64) -> [f64; 2] {
    two_sum(a, -b)
}

fn two_product(a: f64, b: f64) -> [f64; 2] {
    let x = a * b;
    // Exact: a fused multiply-add rounds once, and the error of a product is representable.
    [x, a.mul_add(b, -x)]
}

/// A sum of non-overlapping parts, smallest first.
#[derive(Default)]
struct Expansion(Vec<f64>);

impl Expansion {
    /// Grow-Expansion with zero elimination.
    fn add(&mut self, value: f64) {
        let mut q = value;
        let mut kept = 0;
        for i in 0..self.0.len() {
            let [sum, error] = two_sum(q, self.0[i]);
            q = sum;
            if error != 0.0 {
                self.0[kept] = error;
                kept += 1;
            }
        }
        self.0.truncate(kept);
        if q != 0.0 {
            self.0.push(q);
        }
    }

    fn add_product(&mut self, a: [f64; 2], b: [f64; 2], c: [f64; 2], sign: f64) {
        for a in a {
            for b in b {
                for ab in two_product(a * sign, b) {
                    for c in c {
                        for part in two_product(ab, c) {
                            if part != 0.0 {
                                self.add(part);
                            }
                        }
                    }
                }
            }
        }
    }

    fn sign(&self) -> i8 {
        self.0.last().map_or(0, |v| if *v > 0.0 { 1 } else { -1 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const O: [f32; 3] = [0.0; 3];

    /// A small generator; the tests need variety, not quality.
    fn next(state: &mut u64) -> u64 {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        *state >> 33
    }

    #[test]
    fn agrees_with_integers_on_a_lattice() {
        let mut state = 7;
        let mut zeros = 0;
        for _ in 0..40_000 {
            let mut point = || [0; 3].map(|_: i32| (next(&mut state) % 9) as i64 - 4);
            let rows = [(point(), point()), (point(), point()), (point(), point())];
            let d = rows.map(|(t, f)| [t[0] - f[0], t[1] - f[1], t[2] - f[2]]);
            let det = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1])
                - d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0])
                + d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
            // Powers of two change nothing, and take the coordinates to both ends of f32.
            for scale in [1.0f32, 2f32.powi(-149), 2f32.powi(120)] {
                let rows = rows.map(|(t, f)| (t.map(|v| v as f32 * scale), f.map(|v| v as f32 * scale)));
                assert_eq!(i64::from(orientation(rows)), det.signum());
                assert_eq!(i64::from(exact(rows)), det.signum());
            }
            zeros += i32::from(det == 0);
        }
        assert!(zeros > 500, "{zeros}");
    }

    #[test]
    fn sees_what_f64_cannot() {
        let tiny = f32::from_bits(1);
        let big = f32::MAX;
        // (big - tiny) rounds to big in f64; the determinant is tiny * big * big or its negative.
        let rows = |v: f32| [([big, big, 0.0], [v, 0.0, 0.0]), ([big, big, 0.0], O), ([0.0, 0.0, big], O)];
        assert_eq!(orientation(rows(tiny)), -1);
        assert_eq!(orientation(rows(-tiny)), 1);
        assert_eq!(orientation(rows(0.0)), 0);
    }
}
