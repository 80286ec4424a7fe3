//! Blocks of houses around a square, with a light above the street.

use super::Arguments;
use super::build::{Builder, Place};
use super::math::{Rng, V3, add, around, lerp};

const PITCH: f64 = 34.0;
const BLOCK: f64 = 23.0;
const FLOOR: f64 = 3.3;
const BAY: f64 = 2.9;
const LIGHT: V3 = [8.0, 35.0, 9.0];

pub(super) fn city(arguments: &Arguments, b: &mut Builder) {
    let size = arguments.size;
    b.object("streets").paint("asphalt", 0x6a6c70);
    b.quad([[-130.0, 0.0, -130.0], [-130.0, 0.0, 130.0], [130.0, 0.0, 130.0], [130.0, 0.0, -130.0]]);
    square(b);
    // From the square outwards, so that a smaller city is its middle.
    let mut blocks: Vec<[i32; 2]> = (-4..=4).flat_map(|i| (-4..=4).map(move |j| [i, j])).collect();
    blocks.sort_by_key(|[i, j]| (i * i + j * j, *i, *j));
    'town: for (k, [i, j]) in blocks.into_iter().enumerate().skip(1) {
        let mut rng = Rng::new(arguments.seed, k as u64);
        let middle = [f64::from(i) * PITCH, 0.0, f64::from(j) * PITCH];
        b.object(format!("block {k}")).paint("pavement", 0xb3aea4);
        b.block_on(middle, [BLOCK + 3.0, 0.18, BLOCK + 3.0]);
        street_life(b, &mut rng, middle);
        let far = ((i * i + j * j) as f64).sqrt();
        for lot in lots(&mut rng) {
            if b.len() + 1_000 > size {
                break 'town;
            }
            b.object(format!("house {k}.{}", b.len()));
            b.within(Place::at(add(middle, [0.0, 0.18, 0.0])), |b| house(b, &mut rng, lot, far));
        }
    }
    b.light(LIGHT, 0xffe3b8, 44.0).camera([58.0, 64.0, 88.0], [-3.0, 4.0, 0.0], 40.0);
}

/// How a block is divided: one to four lots `[x0, z0, x1, z1]`.
fn lots(rng: &mut Rng) -> Vec<[f64; 4]> {
    let (h, gap) = (BLOCK / 2.0, 0.6);
    let (x, z) = (rng.range(-3.0, 3.0), rng.range(-3.0, 3.0));
    match rng.below(6) {
        0 => vec![[-h + 2.0, -h + 2.0, h - 2.0, h - 2.0]],
        1 => vec![[-h, -h, x - gap, h], [x + gap, -h, h, h]],
        2 => vec![[-h, -h, h, z - gap], [-h, z + gap, x - gap, h], [x + gap, z + gap, h, h]],
        _ => vec![
            [-h, -h, x - gap, z - gap],
            [x + gap, -h, h, z - gap],
            [-h, z + gap, x - gap, h],
            [x + gap, z + gap, h, h],
        ],
    }
}

fn house(b: &mut Builder, rng: &mut Rng, lot: [f64; 4], far: f64) {
    let wall = rng.pick(&[
        ("brick", 0xa8583f),
        ("sandstone", 0xd8bf94),
        ("plaster", 0xe6dccb),
        ("slate blue", 0x7c8fa3),
        ("ochre", 0xd09a4c),
        ("rose", 0xc98b82),
    ]);
    // Low around the square, towers further out.
    let tower = rng.unit() < 0.12 * far;
    let floors = if tower { 8 + rng.below(6) } else { 3 + rng.below(4) };
    let [x0, z0, x1, z1] = lot;
    let top = storeys(b, rng, lot, 0.0, floors, wall);
    let mut roof = lot;
    let mut y = top;
    if tower {
        let inset = 2.2;
        roof = [x0 + inset, z0 + inset, x1 - inset, z1 - inset];
        if roof[2] - roof[0] > 4.0 && roof[3] - roof[1] > 4.0 {
            let more = 2 + rng.below(3);
            y = storeys(b, rng, roof, top, more, wall);
        } else {
            roof = lot;
        }
    }
    rooftop(b, rng, roof, y);
}

/// A storey after the other from height `y`, with a cornice and a parapet; gives the height of the roof.
fn storeys(b: &mut Builder, rng: &mut Rng, lot: [f64; 4], y: f64, floors: usize, wall: (&str, u32)) -> f64 {
    let [x0, z0, x1, z1] = lot;
    let corners = [[x0, z1], [x1, z1], [x1, z0], [x0, z0]];
    for k in 0..4 {
        facade(b, rng, corners[k], corners[(k + 1) % 4], y, floors, wall);
    }
    let top = y + FLOOR * floors as f64;
    b.paint("cornice", 0xe9e2d4);
    b.block([x0 - 0.3, top - 0.35, z0 - 0.3], [x1 + 0.3, top, z1 + 0.3]);
    for (lo, hi) in [
        ([x0, z0], [x1, z0 + 0.3]),
        ([x0, z1 - 0.3], [x1, z1]),
        ([x0, z0 + 0.3], [x0 + 0.3, z1 - 0.3]),
        ([x1 - 0.3, z0 + 0.3], [x1, z1 - 0.3]),
    ] {
        b.block([lo[0], top, lo[1]], [hi[0], top + 0.8, hi[1]]);
    }
    top
}

/// A wall of windows, each set back into it.
fn facade(
    b: &mut Builder,
    rng: &mut Rng,
    from: [f64; 2],
    to: [f64; 2],
    y: f64,
    floors: usize,
    wall: (&str, u32),
) {
    let d = [to[0] - from[0], to[1] - from[1]];
    let long = (d[0] * d[0] + d[1] * d[1]).sqrt();
    let bays = ((long / BAY).round() as usize).max(1);
    let [dx, dz] = d.map(|c| c / long);
    // `s` along the wall, `t` upwards, `depth` into it.
    let at = |s: f64, t: f64, depth: f64| -> V3 {
        [from[0] + dx * s + dz * depth, t, from[1] + dz * s - dx * depth]
    };
    for (bay, floor) in (0..bays).flat_map(|i| (0..floors).map(move |j| (i, j))) {
        let s = [bay, bay + 1].map(|i| long * i as f64 / bays as f64);
        let t = [floor, floor + 1].map(|j| y + FLOOR * j as f64);
        let shop = floor == 0 && y == 0.0;
        let (side, sill, head) = if shop { (0.25, 0.3, 0.6) } else { (0.75, 0.95, 0.55) };
        let outer = [(s[0], t[0]), (s[1], t[0]), (s[1], t[1]), (s[0], t[1])];
        let inner = [
            (s[0] + side, t[0] + sill),
            (s[1] - side, t[0] + sill),
            (s[1] - side, t[1] - head),
            (s[0] + side, t[1] - head),
        ];
        b.paint(wall.0, wall.1);
        for k in 0..4 {
            let (p, q, r, o) = (outer[k], outer[(k + 1) % 4], inner[(k + 1) % 4], inner[k]);
            b.quad([at(p.0, p.1, 0.0), at(q.0, q.1, 0.0), at(r.0, r.1, 0.0), at(o.0, o.1, 0.0)]);
            b.quad([at(o.0, o.1, 0.0), at(r.0, r.1, 0.0), at(r.0, r.1, 0.35), at(o.0, o.1, 0.35)]);
        }
        if rng.unit() < 0.16 {
            b.glow("lit window", 0xffd48a, 0.7);
        } else {
            b.paint("glass", 0x4a5f78);
        }
        b.quad(inner.map(|(s, t)| at(s, t, 0.35)));
    }
}

fn rooftop(b: &mut Builder, rng: &mut Rng, [x0, z0, x1, z1]: [f64; 4], y: f64) {
    let spot =
        |rng: &mut Rng| [lerp(x0 + 1.8, x1 - 1.8, rng.unit()), y, lerp(z0 + 1.8, z1 - 1.8, rng.unit())];
    match rng.below(3) {
        0 => {
            let [x, _, z] = spot(rng);
            b.paint("tank", 0x7a5234);
            for k in 0..4 {
                let leg = around(0.8, 0.125 + f64::from(k) / 4.0, 0.0);
                b.bar([x + leg[0], y, z + leg[2]], [x + leg[0], y + 1.8, z + leg[2]], 0.08, 4);
            }
            b.cone([x, y + 1.7, z], [1.2, 1.15], 2.2, 16).cone([x, y + 3.9, z], [1.35, 0.0], 0.9, 16);
        }
        1 => {
            b.paint("stair house", 0xb9b1a3).block_on(spot(rng), [2.4, 2.3, 2.8]);
            let mast = spot(rng);
            b.paint("steel", 0x8f979d).bar(mast, add(mast, [0.0, 5.0, 0.0]), 0.06, 5);
            for k in 0..3 {
                let at = add(mast, [0.0, 3.4 + 0.6 * f64::from(k), 0.0]);
                b.bar(add(at, [-0.7, 0.0, 0.0]), add(at, [0.7, 0.0, 0.0]), 0.03, 4);
            }
        }
        _ => {}
    }
    b.paint("steel", 0x8f979d);
    for _ in 0..1 + rng.below(4) {
        let foot = spot(rng);
        b.block_on(foot, [1.3, 0.9, 1.0]);
        b.cone(add(foot, [0.0, 0.9, 0.0]), [0.4, 0.4], 0.12, 10);
    }
}

/// Trees, lamps and cars along the four sides of a block.
fn street_life(b: &mut Builder, rng: &mut Rng, middle: V3) {
    for k in 0..4 {
        let place = Place::at(middle).turned(0.25 * f64::from(k));
        b.within(place, |b| {
            let edge = BLOCK / 2.0 + 0.9;
            for x in [-7.5, 0.0, 7.5] {
                if rng.unit() < 0.5 {
                    let x = x + rng.range(-1.0, 1.0);
                    tree(b, rng, [x, 0.18, edge]);
                }
            }
            b.paint("iron", 0x3a3f44);
            b.tube(
                &[[4.0, 0.18, edge], [4.0, 4.6, edge], [4.0, 5.0, edge + 0.3], [4.0, 5.0, edge + 1.0]],
                6,
                |_| 0.07,
            );
            b.block([3.85, 4.86, edge + 0.7], [4.15, 4.96, edge + 1.3]);
            for _ in 0..2 {
                let x = rng.range(-11.0, 11.0);
                car(b, rng, [x, 0.0, edge + 2.4]);
            }
        });
    }
}

fn tree(b: &mut Builder, rng: &mut Rng, foot: V3) {
    let tall = rng.range(3.4, 5.0);
    b.paint("trunk", 0x6b4a33).bar(foot, add(foot, [0.0, 0.6 * tall, 0.0]), 0.13, 6);
    b.paint("crown", 0x5f8a4c);
    for (dx, dy, r) in [(0.0, 0.75, 0.95), (0.5, 0.62, 0.7), (-0.45, 0.66, 0.75)] {
        let side = around(dx, rng.unit(), tall * dy);
        b.sphere(add(foot, side), r, 10);
    }
}

fn car(b: &mut Builder, rng: &mut Rng, foot: V3) {
    let (name, rgb) = rng.pick(&[
        ("red car", 0xb0332e),
        ("white car", 0xe4e4e0),
        ("blue car", 0x2e5c94),
        ("black car", 0x2c2e33),
        ("taxi", 0xe6b32e),
    ]);
    b.within(Place::at(foot), |b| {
        b.paint(name, rgb)
            .block_on([0.0, 0.3, 0.0], [4.2, 0.55, 1.75])
            .block_on([-0.2, 0.85, 0.0], [2.2, 0.5, 1.5]);
        b.paint("tyre", 0x26262a);
        for (x, z) in [(-1.3, -0.8), (1.3, -0.8), (-1.3, 0.8), (1.3, 0.8)] {
            b.bar([x, 0.33, z - 0.1], [x, 0.33, z + 0.1], 0.33, 10);
        }
    });
}

/// The square in the middle: a monument, trees around it, and steps.
fn square(b: &mut Builder) {
    b.object("square").paint("pavement", 0xb3aea4);
    for k in 0..3 {
        let (r, y) = (9.0 - 1.2 * f64::from(k), 0.25 * f64::from(k));
        b.cone([0.0, y, 0.0], [r, r], 0.25, 40);
    }
    b.object("monument").paint("bronze", 0x5f7d6b);
    let profile = [
        [0.0, 0.75],
        [2.0, 0.75],
        [2.0, 1.4],
        [1.4, 1.6],
        [1.3, 4.0],
        [1.6, 4.3],
        [0.8, 4.6],
        [0.6, 9.5],
        [0.9, 10.0],
        [0.0, 10.0],
    ];
    b.lathe(&profile, 24).sphere([0.0, 10.9, 0.0], 1.0, 20);
    let mut rng = Rng::new(0, 99);
    for k in 0..14 {
        b.object(format!("tree {}", k + 1));
        tree(b, &mut rng, around(11.5, f64::from(k) / 14.0, 0.0));
    }
}
