//! Vectors, angles, random numbers and noise from `+ - * /` and square roots alone, so that a scene has the same bits
//! on every platform (the C libraries' sines differ in the last bit).

use std::f64::consts::TAU;

/// A point or direction.
pub(super) type V3 = [f64; 3];

pub(super) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scale(a: V3, s: f64) -> V3 {
    a.map(|v| v * s)
}

pub(super) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a` at length 1; a zero vector stays.
pub(super) fn unit(a: V3) -> V3 {
    let length = dot(a, a).sqrt();
    if length > 0.0 { scale(a, 1.0 / length) } else { a }
}

/// From `a` at `t = 0` to `b` at `t = 1`.
pub(super) fn mix(a: V3, b: V3, t: f64) -> V3 {
    add(scale(a, 1.0 - t), scale(b, t))
}

/// From `a` at `t = 0` to `b` at `t = 1`.
pub(super) fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

/// 0 before `a`, 1 after `b`, smooth between.
pub(super) fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Cosine and sine of an angle in turns; quarter turns are exact.
pub(super) fn turn(turns: f64) -> (f64, f64) {
    let quarter = (turns * 4.0).round();
    // |x| <= TAU / 8: the first term that is left out is under 1e-17.
    let x = (turns - quarter * 0.25) * TAU;
    let (mut cos, mut sin) = (1.0, 1.0);
    for k in (1..=8).rev() {
        let n = f64::from(2 * k);
        cos = 1.0 - x * x / (n * (n - 1.0)) * cos;
        sin = 1.0 - x * x / (n * (n + 1.0)) * sin;
    }
    sin *= x;
    match quarter.rem_euclid(4.0) as u8 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// Sine of an angle in turns.
pub(super) fn wave(turns: f64) -> f64 {
    turn(turns).1
}

/// The point at `turns` on a circle in the ground plane.
pub(super) fn around(radius: f64, turns: f64, y: f64) -> V3 {
    let (cos, sin) = turn(turns);
    [radius * cos, y, radius * sin]
}

/// The finaliser of SplitMix64: every bit of the input reaches every bit of the output.
fn scramble(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// SplitMix64 (Steele, Lea and Flood 2014): one stream for each seed and purpose.
pub(super) struct Rng(u64);

impl Rng {
    pub(super) fn new(seed: u64, stream: u64) -> Rng {
        Rng(scramble(seed ^ scramble(stream.wrapping_add(0x9e37_79b9_7f4a_7c15))))
    }

    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        scramble(self.0)
    }

    /// Uniform in `[0, 1)`.
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in `[lo, hi)`.
    pub(super) fn range(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// Uniform in `0..n`.
    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    pub(super) fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// A uniform direction (Archimedes: slices of a sphere have areas as their heights).
    pub(super) fn direction(&mut self) -> V3 {
        let y = self.range(-1.0, 1.0);
        around((1.0 - y * y).max(0.0).sqrt(), self.unit(), y)
    }
}

/// Smooth value noise in `[-1, 1]` with features of size 1.
pub(super) fn noise(p: V3, seed: u64) -> f64 {
    let cell = p.map(f64::floor);
    let f = [0, 1, 2].map(|k| {
        let t = p[k] - cell[k];
        t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
    });
    let corner = |dx: i64, dy: i64, dz: i64| {
        let [x, y, z] = [cell[0] as i64 + dx, cell[1] as i64 + dy, cell[2] as i64 + dz];
        let key = (x as u64).wrapping_mul(0x8da6_b343)
            ^ (y as u64).wrapping_mul(0xd816_3841_0000_0001)
            ^ (z as u64).wrapping_mul(0xcb1a_b31f_0000);
        (scramble(key.wrapping_add(seed)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let along_x = |dy, dz| lerp(corner(0, dy, dz), corner(1, dy, dz), f[0]);
    lerp(lerp(along_x(0, 0), along_x(1, 0), f[1]), lerp(along_x(0, 1), along_x(1, 1), f[1]), f[2])
}

/// Four octaves of [`noise`].
pub(super) fn fractal(p: V3, seed: u64) -> f64 {
    [(1.0, 0.53), (2.03, 0.27), (4.11, 0.13), (8.27, 0.07)]
        .iter()
        .zip(seed..)
        .map(|(&(frequency, weight), seed)| weight * noise(scale(p, frequency), seed))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_sines_and_cosines() {
        for k in -400..400 {
            let t = f64::from(k) / 97.0;
            let (cos, sin) = turn(t);
            assert!((cos - (t * TAU).cos()).abs() < 1e-14 && (sin - (t * TAU).sin()).abs() < 1e-14, "{t}");
        }
        assert_eq!(
            [turn(0.0), turn(0.25), turn(0.5), turn(0.75)],
            [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]
        );
    }

    #[test]
    fn noise_is_bounded_and_not_flat() {
        let values: Vec<f64> = (0..1000).map(|k| fractal(scale([1.3, 0.7, 2.1], f64::from(k)), 7)).collect();
        assert!(values.iter().all(|v| v.abs() <= 1.0));
        assert!(values.iter().any(|&v| v > 0.2) && values.iter().any(|&v| v < -0.2));
    }
}
