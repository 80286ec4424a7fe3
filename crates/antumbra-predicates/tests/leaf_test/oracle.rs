//! The definition of the crate's head, word for word, in integers of any size.
//!
//! Nothing here is shared with the crate: coordinates become integers times one power of two, the light is moved to the
//! origin, and the tie-break moves the sample by an actual `(ε, ε², ε³)` with an ε that is small enough.

use num_bigint::{BigInt, Sign};

type Point = [BigInt; 3];

/// The signs of all tests, and the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Truth {
    /// Sign of `det[A, B, C]`.
    pub(crate) facing: i8,
    /// Signs of the sides ab, bc, ca, ties broken.
    pub(crate) sides: [i8; 3],
    /// Sign of the plane test.
    pub(crate) beyond: i8,
    /// A side test was zero before the tie was broken, or the plane test was.
    pub(crate) tie: bool,
    /// The triangle blocks the sample.
    pub(crate) blocks: bool,
}

/// One triangle and one light, ready to be asked about samples.
pub(crate) struct Oracle {
    corners: [[f32; 3]; 3],
    light: [f32; 3],
}

impl Oracle {
    pub(crate) fn new(corners: &[[f32; 3]; 3], light: [f32; 3]) -> Oracle {
        Oracle { corners: *corners, light }
    }

    pub(crate) fn ask(&self, sample: [f32; 3]) -> Truth {
        let [a, b, c] = self.corners;
        let [a, b, c, l, p] = integers([a, b, c, self.light, sample]);
        let [a, b, c, p] = [minus(&a, &l), minus(&b, &l), minus(&c, &l), minus(&p, &l)];
        let volume = det(&a, &b, &c);
        let facing = sign(&volume);
        let mut tie = false;
        let mut side = |u: &Point, v: &Point| {
            let s = sign(&det(u, v, &p));
            tie |= s == 0;
            if s == 0 { sign(&det(u, v, &moved(&p, u, v))) } else { s }
        };
        let sides = [side(&a, &b), side(&b, &c), side(&c, &a)];
        let normal = cross(&minus(&b, &a), &minus(&c, &a));
        let beyond = sign(&(dot(&normal, &p) - volume));
        tie |= beyond == 0;
        let blocks = facing != 0 && sides == [facing; 3] && beyond == facing;
        Truth { facing, sides, beyond, tie, blocks }
    }
}

pub(crate) fn ask(corners: &[[f32; 3]; 3], light: [f32; 3], sample: [f32; 3]) -> Truth {
    Oracle::new(corners, light).ask(sample)
}

/// Is `x` in `center ± half`, in real arithmetic?
pub(crate) fn within(x: f32, center: f32, half: f32) -> bool {
    let [[x, c, h], ..] = integers([[x, center, half]; 5]);
    (&x - &c) <= h && (c - x) <= h
}

/// `p + (ε, ε², ε³)`, times `1/ε³`, with `ε = 2^-k` below half of the inverse of any component of `u × v`.
fn moved(p: &Point, u: &Point, v: &Point) -> Point {
    let size = |q: &Point| q.iter().map(|x| x.bits()).max().unwrap_or(0);
    let k = size(u) + size(v) + 4;
    let one = BigInt::from(1);
    [(&p[0] << (3 * k)) + (&one << (2 * k)), (&p[1] << (3 * k)) + (&one << k), (&p[2] << (3 * k)) + one]
}

/// Value = mantissa · 2^exponent, the mantissa odd or zero.
fn decode(x: f32) -> (i64, i32) {
    assert!(x.is_finite());
    let bits = x.to_bits();
    let field = (bits >> 23 & 0xff) as i32;
    let fraction = i64::from(bits & 0x7f_ffff);
    let (m, e) = if field == 0 { (fraction, -149) } else { (fraction | 0x80_0000, field - 150) };
    if m == 0 {
        return (0, i32::MAX);
    }
    let m_signed = if bits >> 31 == 1 { -m } else { m };
    (m_signed >> m.trailing_zeros(), e + m.trailing_zeros() as i32)
}

/// The points times one common power of two.
fn integers(points: [[f32; 3]; 5]) -> [Point; 5] {
    let least = points.iter().flatten().map(|&x| decode(x).1).min().unwrap_or(0);
    points.map(|p| {
        p.map(|x| match decode(x) {
            (0, _) => BigInt::from(0),
            (m, e) => BigInt::from(m) << (e - least),
        })
    })
}

fn sign(v: &BigInt) -> i8 {
    match v.sign() {
        Sign::Minus => -1,
        Sign::NoSign => 0,
        Sign::Plus => 1,
    }
}

fn minus(a: &Point, b: &Point) -> Point {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn dot(a: &Point, b: &Point) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Point, b: &Point) -> Point {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

fn det(a: &Point, b: &Point, c: &Point) -> BigInt {
    dot(&cross(a, b), c)
}
