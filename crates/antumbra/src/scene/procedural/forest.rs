//! A clearing among trees whose leaves are pictures on cards: the eye looks through their holes, light does not.

use super::Arguments;
use super::build::{Builder, Place, frame};
use super::math::{Rng, V3, add, around, fractal, lerp, mix, noise, scale, turn, wave};
use crate::scene::Texture;

const HALF: f64 = 17.0;
const LIGHT: V3 = [-0.4, 1.9, -1.4];
const EYE: V3 = [3.2, 2.3, 13.5];

pub(super) fn forest(arguments: &Arguments, b: &mut Builder) {
    let (seed, size) = (arguments.seed, arguments.size);
    let mut rng = Rng::new(seed, 0);
    let cells = ((size as f64 / 40.0).sqrt() as usize).clamp(4, 72);
    b.object("ground").paint("moss", 0x6f7a45);
    b.surface([cells, cells], [false, false], |u, v| {
        let (x, z) = (lerp(-HALF, HALF, u), lerp(HALF, -HALF, v));
        [x, height(x, z, seed), z]
    });
    stones(b, &mut rng, seed, size / 60);
    b.cut_out(leaves("leaf"));
    b.cut_out(fern("fern"));
    // The nearest to the clearing come first: a smaller forest is a smaller wood, not a thinner one.
    let mut feet: Vec<[f64; 2]> = (0..4_000)
        .map(|_| [rng.range(-HALF, HALF), rng.range(-HALF, 9.0)])
        .filter(|&[x, z]| {
            x * x + (z + 1.0) * (z + 1.0) > 11.0 && (x - LIGHT[0]).abs() + (z - LIGHT[2]).abs() > 4.2
        })
        // Nothing stands in the eye's way.
        .filter(|&[x, z]| z < 1.0 || (x - lerp(0.0, EYE[0], z / EYE[2])).abs() > 3.2)
        .collect();
    feet.sort_by(|p, q| (p[0] * p[0] + p[1] * p[1]).total_cmp(&(q[0] * q[0] + q[1] * q[1])));
    let mut spaced: Vec<[f64; 2]> = Vec::new();
    for foot in feet {
        let clear = |other: &[f64; 2]| {
            let d = [foot[0] - other[0], foot[1] - other[1]];
            d[0] * d[0] + d[1] * d[1] > 5.0
        };
        if spaced.iter().all(clear) {
            spaced.push(foot);
        }
    }
    let trees = spaced.len();
    for (k, [x, z]) in spaced.into_iter().enumerate() {
        let room = size.saturating_sub(b.len());
        if room < 1_400 {
            break;
        }
        // What is left over when the wood is full goes into leaves and ferns.
        let cards = if k + 1 == trees { room / 2 } else { 1250.min(room / 2) };
        b.object(format!("tree {}", k + 1));
        tree(b, &mut rng, [x, height(x, z, seed) - 0.1, z], cards);
    }
    b.light(LIGHT, 0xffefcf, 11.0).camera(EYE, [-0.3, 1.9, -2.0], 46.0);
}

fn height(x: f64, z: f64, seed: u64) -> f64 {
    0.9 * noise([x * 0.16, 0.0, z * 0.16], seed + 10) + 0.12 * noise([x * 0.9, 4.0, z * 0.9], seed + 11)
}

fn stones(b: &mut Builder, rng: &mut Rng, seed: u64, budget: usize) {
    b.object("stones").paint("stone", 0x8d8a83);
    // A ring of standing stones about the light, whose shadows reach to the trees.
    for k in 0..9 {
        let [x, _, z] = add(LIGHT, around(2.7, (k as f64 + 0.3) / 9.0, 0.0));
        let size = [rng.range(0.2, 0.32), rng.range(0.7, 1.25), rng.range(0.16, 0.24)];
        let stream = seed + 40 + k;
        let place = Place::at([x, height(x, z, seed) + 0.55 * size[1], z]).turned(rng.unit()).scaled(size);
        b.within(place, |b| stone(b, stream));
    }
    for k in 0..(budget / 190).clamp(1, 14) {
        let [x, _, z] = around(rng.range(1.0, 6.0), rng.unit(), 0.0);
        let size = rng.range(0.15, 0.5);
        let stream = seed + 20 + k as u64;
        let place = Place::at([x, height(x, z, seed) + 0.2 * size, z]).scaled([size, 0.7 * size, size]);
        b.within(place, |b| stone(b, stream));
    }
}

/// A rough ball, closed, of about size 1.
fn stone(b: &mut Builder, seed: u64) {
    b.surface([14, 7], [true, false], |u, v| {
        let (cos, sin) = turn(0.5 * v);
        let p = around(sin, -u, -cos);
        scale(p, 1.0 + 0.3 * fractal(scale(p, 0.8), seed))
    });
}

fn tree(b: &mut Builder, rng: &mut Rng, foot: V3, cards: usize) {
    let tall = rng.range(5.5, 8.5);
    let lean = around(rng.range(0.0, 0.9), rng.unit(), tall);
    let bend = around(0.25, rng.unit(), 0.0);
    let spine = |t: f64| add(add(foot, scale(lean, t)), scale(bend, wave(0.5 * t)));
    let trunk: Vec<V3> = (0..=9).map(|k| spine(f64::from(k) / 9.0)).collect();
    let thick = tall * 0.028;
    let (name, rgb) = rng.pick(&[("bark", 0x6b5140), ("beech", 0x8a8478), ("pine", 0x7c5237)]);
    b.paint(name, rgb);
    b.tube(&trunk, 9, |t| thick * (1.0 - 0.9 * t) + 0.6 * thick * (1.0 - 8.0 * t).max(0.0));
    let mut twigs = Vec::new();
    for k in 0..15 {
        let t = 0.36 + 0.6 * f64::from(k) / 14.0;
        let from = spine(t);
        let long = tall * 0.36 * (1.15 - t) + 0.3;
        let out = around(long, f64::from(k) * 0.381_966 + rng.range(-0.05, 0.05), long * rng.range(0.2, 0.7));
        let sag = rng.range(0.0, 0.25) * long;
        let at = |s: f64| add(add(from, scale(out, s)), [0.0, -sag * s * s, 0.0]);
        let path: Vec<V3> = (0..=4).map(|i| at(f64::from(i) / 4.0)).collect();
        let root = 0.45 * thick * (1.1 - t);
        b.tube(&path, 5, |s| root * (1.0 - 0.85 * s));
        twigs.push(path);
    }
    b.with_material("leaf");
    for _ in 0..(cards * 9 / 10).saturating_sub(465) {
        let twig = &twigs[rng.below(twigs.len())];
        let s = rng.range(0.9, 4.0);
        let k = (s as usize).min(3);
        let near = mix(twig[k], twig[k + 1], s - k as f64);
        let middle = add(near, scale(rng.direction(), rng.range(0.0, 0.42)));
        card(b, rng, middle);
    }
    b.with_material("fern");
    for _ in 0..cards / 10 {
        let [x, _, z] = around(rng.range(0.3, 2.2), rng.unit(), 0.0);
        let (half, tall) = (rng.range(0.14, 0.28), rng.range(0.25, 0.6));
        let (cos, sin) = turn(rng.unit());
        let root = [foot[0] + x, foot[1] + 0.08, foot[2] + z];
        let tip = add(root, around(rng.range(0.0, 0.3), rng.unit(), tall));
        let across = [half * cos, 0.0, half * sin];
        let back = scale(across, -1.0);
        b.textured_quad([add(root, back), add(root, across), add(tip, across), add(tip, back)]);
    }
}

/// A square card of a random size that looks in a random direction.
fn card(b: &mut Builder, rng: &mut Rng, middle: V3) {
    let size = rng.range(0.15, 0.25);
    let [x, y] = frame(rng.direction()).map(|axis| scale(axis, size));
    let corner = |s: f64, t: f64| add(middle, add(scale(x, s), scale(y, t)));
    b.textured_quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
}

/// Paints leaves given by root, tip and half width (in pictures of size 1, y down) on nothing.
fn paint(name: &str, greens: [[u8; 3]; 3], shapes: &[([f64; 2], [f64; 2], f64)]) -> Texture {
    const SIDE: u32 = 128;
    let pixel = |x: u32, y: u32| {
        let p = [x, y].map(|c| (f64::from(c) + 0.5) / f64::from(SIDE));
        for (k, &(root, tip, half)) in shapes.iter().enumerate() {
            let axis = [tip[0] - root[0], tip[1] - root[1]];
            let long = (axis[0] * axis[0] + axis[1] * axis[1]).sqrt();
            let d = [p[0] - root[0], p[1] - root[1]];
            let s = (d[0] * axis[0] + d[1] * axis[1]) / (long * long);
            let w = (d[0] * axis[1] - d[1] * axis[0]).abs() / long;
            // Widest a third of the way along.
            if (0.0..=1.0).contains(&s) && w <= half * 2.6 * s.sqrt() * (1.0 - s) {
                let [r, g, b] = greens[k % 3];
                let vein = if w < 0.006 { 24 } else { 0 };
                return [r + vein, g + vein, b + vein, 255];
            }
        }
        let [r, g, b] = greens[0];
        [r, g, b, 0]
    };
    let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
    let wrap = [crate::scene::Wrap::Clamp; 2];
    Texture { name: name.into(), width: SIDE, height: SIDE, pixels, wrap }
}

/// A sprig of leaves.
fn leaves(name: &str) -> Texture {
    let mut shapes = Vec::new();
    for k in 0..5 {
        let y = 0.92 - 0.16 * f64::from(k);
        for side in [-1.0, 1.0] {
            shapes.push(([0.5, y], [0.5 + side * (0.46 - 0.05 * f64::from(k)), y - 0.22], 0.085));
        }
    }
    shapes.push(([0.5, 0.32], [0.5, 0.0], 0.09));
    shapes.push(([0.5, 1.0], [0.5, 0.1], 0.012));
    paint(name, [[96, 138, 58], [124, 158, 62], [78, 120, 56]], &shapes)
}

/// A fern's frond.
fn fern(name: &str) -> Texture {
    let mut shapes = vec![([0.5, 1.0], [0.5, 0.0], 0.02)];
    for k in 0..11 {
        let t = f64::from(k) / 11.0;
        for side in [-1.0, 1.0] {
            shapes.push(([0.5, 0.95 - 0.86 * t], [0.5 + side * 0.48 * (1.0 - t), 0.85 - 0.86 * t], 0.036));
        }
    }
    paint(name, [[88, 128, 62], [104, 142, 66], [92, 134, 58]], &shapes)
}
