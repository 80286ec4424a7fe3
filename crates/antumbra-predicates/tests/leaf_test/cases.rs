//! Inputs made to break the stages: eight triangles, one light and a box of samples at a time.

use crate::oracle::{Oracle, Truth};

pub(crate) type Point = [f32; 3];
pub(crate) type Triangle = [Point; 3];

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): small, seeded, the same on every machine.
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Between `lo` and `hi`, both included.
    pub(crate) fn int(&mut self, lo: i32, hi: i32) -> i32 {
        lo + (self.next() % (hi - lo + 1) as u64) as i32
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn one_in(&mut self, n: u64) -> bool {
        self.next().is_multiple_of(n)
    }
}

/// How one coordinate is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Law {
    /// Small integers: ties galore.
    Lattice,
    /// Small integers times one power of two, from the smallest to the largest there is.
    Scaled(i32),
    /// A huge common offset and a few units in its last place.
    Offset(i32),
    /// Uniform in -1..1.
    Uniform,
    /// Uniform over the whole range, up to 3.4e38.
    Huge,
    /// Subnormals, and the smallest normal numbers.
    Subnormal,
    /// Any finite bit pattern.
    Bits,
    /// Magnitudes about the filter's `LIMIT`.
    Limit,
}

impl Law {
    fn pick(rng: &mut Rng) -> Law {
        match rng.int(0, 10) {
            0 => Law::Lattice,
            1 => Law::Scaled(rng.int(-149, 124)),
            2 => Law::Offset(rng.int(-20, 120)),
            3 => Law::Uniform,
            4 => Law::Huge,
            5 => Law::Subnormal,
            6 => Law::Bits,
            7 => Law::Limit,
            // Tame ones again, so that the filter has something to be certain of.
            8 => Law::Scaled(rng.int(-20, 20)),
            _ => Law::Uniform,
        }
    }

    fn coordinate(self, rng: &mut Rng) -> f32 {
        match self {
            Law::Lattice => rng.int(-3, 3) as f32,
            Law::Scaled(k) => finite(f64::from(rng.int(-6, 6)) * 2f64.powi(k)),
            Law::Offset(k) => finite(2f64.powi(k) * (1.0 + f64::from(rng.int(0, 9)) * 2f64.powi(-23))),
            Law::Uniform => (rng.unit() * 2.0 - 1.0) as f32,
            Law::Huge => finite((rng.unit() * 2.0 - 1.0) * f64::from(f32::MAX)),
            Law::Subnormal => {
                let x = f32::from_bits(rng.next() as u32 & 0x01ff_ffff);
                if rng.one_in(2) { -x } else { x }
            }
            Law::Bits => loop {
                let x = f32::from_bits(rng.next() as u32);
                if x.is_finite() {
                    return x;
                }
            },
            Law::Limit => finite((rng.unit() * 2.0 - 1.0) * 2f64.powi(rng.int(37, 42))),
        }
    }

    fn point(self, rng: &mut Rng) -> Point {
        [0; 3].map(|_| self.coordinate(rng))
    }
}

/// To `f32`, the largest finite one at most: sums of inputs must stay inputs.
pub(crate) fn finite(x: f64) -> f32 {
    (x as f32).clamp(-f32::MAX, f32::MAX)
}

/// `u + t (v - u)`, rounded.
pub(crate) fn between(u: Point, v: Point, t: f64) -> Point {
    [0, 1, 2].map(|k| finite(f64::from(u[k]) + t * (f64::from(v[k]) - f64::from(u[k]))))
}

/// Each coordinate moved by up to `steps` units in its last place.
pub(crate) fn nudge(p: Point, rng: &mut Rng, steps: i32) -> Point {
    p.map(|x| {
        let mut x = x;
        for _ in 0..rng.int(0, steps) {
            x = if rng.one_in(2) { x.next_up() } else { x.next_down() };
        }
        x.clamp(-f32::MAX, f32::MAX)
    })
}

/// Eight triangles against the samples of one box.
pub(crate) struct Case {
    pub(crate) law: Law,
    pub(crate) light: Point,
    pub(crate) triangles: [Triangle; 8],
    /// The first eight are the corners of the box.
    pub(crate) samples: [Point; 16],
    pub(crate) lo: Point,
    pub(crate) hi: Point,
}

impl Case {
    pub(crate) fn random(rng: &mut Rng) -> Case {
        let law = Law::pick(rng);
        let other = if rng.one_in(4) { Law::pick(rng) } else { law };
        let light = if rng.one_in(4) { other.point(rng) } else { law.point(rng) };
        let base = match rng.int(0, 9) {
            0 => light,
            _ => law.point(rng),
        };
        let spread = rng.int(0, 4);
        let shrink = 2f64.powi(-rng.int(1, 24));
        let mut samples = [base; 16];
        for s in &mut samples[8..] {
            *s = match spread {
                0 => base,
                1 => nudge(base, rng, 3),
                2 | 3 => between(base, law.point(rng), shrink),
                _ => law.point(rng),
            };
        }
        let mut lo = samples[8];
        let mut hi = samples[8];
        for s in &samples[8..] {
            lo = [0, 1, 2].map(|k| lo[k].min(s[k]));
            hi = [0, 1, 2].map(|k| hi[k].max(s[k]));
        }
        for (i, s) in samples[..8].iter_mut().enumerate() {
            *s = [0, 1, 2].map(|k| if i >> k & 1 == 0 { lo[k] } else { hi[k] });
        }
        let triangles = [0; 8].map(|_| {
            let target = samples[rng.int(0, 15) as usize];
            triangle(rng, law, other, light, target)
        });
        Case { law, light, triangles, samples, lo, hi }
    }

    /// The truth for every triangle and sample.
    pub(crate) fn truth(&self) -> [[Truth; 16]; 8] {
        self.triangles.map(|t| {
            let oracle = Oracle::new(&t, self.light);
            self.samples.map(|p| oracle.ask(p))
        })
    }
}

/// A triangle with some malicious relation to the light and to a sample.
fn triangle(rng: &mut Rng, law: Law, other: Law, light: Point, sample: Point) -> Triangle {
    let mut t = [law.point(rng), law.point(rng), other.point(rng)];
    // Where the ray from the light to the sample meets the triangle, roughly.
    let depth = [0.25, 0.5, 0.75, 1.0, 1.0, 1.5, rng.unit(), 1.0 - 2f64.powi(-20)][rng.int(0, 7) as usize];
    let hit = between(light, sample, depth);
    let size = 2f64.powi(-rng.int(0, 24));
    match rng.int(0, 13) {
        // As it is: everything independent.
        0 => {}
        // A blocker around the ray, of any size: the third corner balances the other two.
        1..=4 => {
            t[0] = between(hit, t[0], size);
            t[1] = between(hit, t[1], size);
            t[2] =
                [0, 1, 2].map(|k| finite(3.0 * f64::from(hit[k]) - f64::from(t[0][k]) - f64::from(t[1][k])));
        }
        // An edge through the ray: the sample is on the side plane.
        5 | 6 => {
            t[0] = between(hit, t[0], size);
            t[1] = between(hit, t[0], -1.0);
            t[2] = between(hit, t[2], size);
        }
        // A corner on the ray.
        7 => {
            t[0] = hit;
            t[1] = between(hit, t[1], size);
            t[2] = between(hit, t[2], size);
        }
        // The light in the plane of the triangle, or nearly.
        8 => t[2] = between(between(t[0], t[1], rng.unit()), light, [-1.0, 0.5, 2.0][rng.int(0, 2) as usize]),
        // The sample in the plane of the triangle, or nearly.
        9 => {
            t[2] = between(between(t[0], t[1], rng.unit()), sample, [-1.0, 0.5, 2.0][rng.int(0, 2) as usize]);
        }
        // A sliver.
        10 => t[2] = between(t[0], t[1], rng.unit()),
        // A corner is the light, or the sample.
        11 => t[2] = if rng.one_in(2) { light } else { sample },
        // Two corners are one.
        12 => t[2] = t[1],
        // Tiny, anywhere.
        _ => {
            t[1] = between(t[0], t[1], size);
            t[2] = between(t[0], t[2], size);
        }
    }
    if rng.one_in(3) {
        t = t.map(|p| nudge(p, rng, 2));
    }
    t.rotate_left(rng.int(0, 2) as usize);
    if rng.one_in(2) {
        t.swap(0, 1);
    }
    t
}

/// One line of a fixture file: the input in hexadecimal bit patterns, then the verdict.
pub(crate) fn line(t: &Triangle, light: Point, sample: Point, truth: &Truth) -> String {
    let words: Vec<String> = t
        .iter()
        .chain([&light, &sample])
        .map(|p| p.map(|x| format!("{:08x}", x.to_bits())).join(" "))
        .collect();
    let [ab, bc, ca] = truth.sides;
    format!(
        "{} | {} {ab} {bc} {ca} {} {}",
        words.join("  "),
        truth.facing,
        truth.beyond,
        u8::from(truth.blocks)
    )
}
