//! A furnished room around a lattice lantern: the first picture.

use super::Arguments;
use super::build::{Builder, Place};
use super::math::{Rng, V3, around, lerp, turn, wave};

const LAMP: V3 = [0.15, 2.3, -0.25];
const LO: V3 = [-3.4, 0.0, -3.2];
const HI: V3 = [3.4, 3.5, 4.6];

pub(super) fn room(arguments: &Arguments, b: &mut Builder) {
    let mut rng = Rng::new(arguments.seed, 0);
    walls(b);
    window(b);
    lantern(b);
    stairs(b, &mut rng);
    shelves(b, &mut rng);
    b.object("rug").paint("rug", 0x9c3b34);
    b.within(Place::at([0.15, 0.0, -0.2]), |b| {
        b.lathe(&[[0.0, 0.012], [1.72, 0.012], [1.75, 0.0]], 64);
        b.paint("rug border", 0xe2c391).lathe(&[[1.48, 0.014], [1.58, 0.014]], 64);
    });
    table(b, &mut rng);
    let first = rng.range(0.02, 0.08);
    for (k, turns) in [0.08, 0.40, 0.72].into_iter().enumerate() {
        let turns = turns + first + rng.range(-0.02, 0.02);
        let foot = around(rng.range(1.12, 1.22), turns, 0.012);
        b.object(format!("chair {}", k + 1));
        let place = Place::at([LAMP[0] + foot[0], foot[1], LAMP[2] + foot[2]]);
        b.within(place.turned(0.75 - turns), chair);
    }
    b.object("ball").paint("ball", 0xe8e2d6).sphere([-1.75, 0.34, 1.35], 0.34, 36);
    b.object("small ball").paint("small ball", 0xd9a13b).sphere([-1.18, 0.17, 1.75], 0.17, 24);
    plant(b, &mut rng);
    b.light(LAMP, 0xfff1dc, 2.4).camera([1.75, 1.72, 4.35], [-0.32, 1.22, -1.0], 58.0);
}

fn walls(b: &mut Builder) {
    let (lo, hi) = (LO, HI);
    b.object("floor").tiles(
        [lo[0], lo[2]],
        [hi[0], hi[2]],
        0.0,
        [14, 16],
        [("oak", 0xb98a5e), ("walnut", 0x94673f)],
    );
    b.object("walls").paint("terracotta", 0xc9694a);
    b.quad([[lo[0], 0.0, hi[2]], [lo[0], 0.0, lo[2]], [lo[0], hi[1], lo[2]], [lo[0], hi[1], hi[2]]]);
    b.paint("teal", 0x3f8f93);
    b.quad([[hi[0], 0.0, lo[2]], [hi[0], 0.0, hi[2]], [hi[0], hi[1], hi[2]], [hi[0], hi[1], lo[2]]]);
    b.paint("cream", 0xefe3cc);
    b.quad([[hi[0], 0.0, hi[2]], [lo[0], 0.0, hi[2]], [lo[0], hi[1], hi[2]], [hi[0], hi[1], hi[2]]]);
    // The wall at the back, around the window.
    for (from, to) in [([lo[0], 0.0], [WINDOW[0], hi[1]]), ([WINDOW[2], 0.0], [hi[0], hi[1]])] {
        back(b, from, to);
    }
    back(b, [WINDOW[0], 0.0], [WINDOW[2], WINDOW[1]]);
    back(b, [WINDOW[0], WINDOW[3]], [WINDOW[2], hi[1]]);
    b.object("ceiling").paint("ceiling", 0xf2ece0);
    b.quad([[lo[0], hi[1], lo[2]], [hi[0], hi[1], lo[2]], [hi[0], hi[1], hi[2]], [lo[0], hi[1], hi[2]]]);
    b.object("beams").paint("beam", 0x7a5234);
    for k in 0..6 {
        let z = lerp(lo[2] + 0.5, hi[2] - 0.5, f64::from(k) / 5.0);
        b.block([lo[0], hi[1] - 0.22, z - 0.09], [hi[0], hi[1], z + 0.09]);
    }
    b.object("skirting").paint("skirting", 0xf5f0e4);
    b.block([lo[0], 0.0, lo[2]], [hi[0], 0.14, lo[2] + 0.03]);
    b.block([lo[0], 0.0, lo[2]], [lo[0] + 0.03, 0.14, hi[2]]);
    b.block([hi[0] - 0.03, 0.0, lo[2]], [hi[0], 0.14, hi[2]]);
}

/// Left, bottom, right and top of the window in the back wall.
const WINDOW: [f64; 4] = [-0.75, 1.05, 1.15, 2.55];

fn back(b: &mut Builder, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) {
    b.quad([[x0, y0, LO[2]], [x1, y0, LO[2]], [x1, y1, LO[2]], [x0, y1, LO[2]]]);
}

fn window(b: &mut Builder) {
    let [x0, y0, x1, y1] = WINDOW;
    let z = LO[2];
    b.object("window").paint("night", 0x27406b);
    b.quad([[x0, y0, z - 0.2], [x1, y0, z - 0.2], [x1, y1, z - 0.2], [x0, y1, z - 0.2]]);
    b.paint("frame", 0xf5f0e4);
    let thick = 0.07;
    for x in [x0, x1] {
        b.block([x - thick, y0 - thick, z - 0.22], [x + thick, y1 + thick, z + 0.05]);
    }
    for y in [y0, y1] {
        b.block([x0, y - thick, z - 0.22], [x1, y + thick, z + 0.05]);
    }
    for k in 1..4 {
        let x = lerp(x0, x1, f64::from(k) / 4.0);
        b.block([x - 0.02, y0, z - 0.16], [x + 0.02, y1, z - 0.1]);
    }
    for k in 1..3 {
        let y = lerp(y0, y1, f64::from(k) / 3.0);
        b.block([x0, y - 0.02, z - 0.165], [x1, y + 0.02, z - 0.105]);
    }
    b.block([x0 - 0.2, y0 - 0.12, z], [x1 + 0.2, y0 - 0.06, z + 0.24]);
}

/// A drum of two families of helical strips: the walls get a net of shadows, the floor stays in clear light.
fn lantern(b: &mut Builder) {
    const STRIPS: usize = 18;
    let height = |t: f64| lerp(-0.16, 0.34, t);
    let radius = |t: f64| 0.21 + 0.09 * wave(0.06 + 0.40 * t);
    b.object("lantern").paint("brass", 0xc9a24b);
    b.within(Place::at(LAMP), |b| {
        for (k, way) in (0..STRIPS).flat_map(|k| [(k, 1.0), (k, -1.0)]) {
            let path: Vec<V3> = (0..=12)
                .map(|i| {
                    let t = f64::from(i) / 12.0;
                    around(radius(t), k as f64 / STRIPS as f64 + way * 0.19 * t, height(t))
                })
                .collect();
            b.tube(&path, 4, |_| 0.0046);
        }
        b.ring([0.0, height(0.0), 0.0], radius(0.0), 0.011, [48, 6]);
        b.ring([0.0, height(1.0), 0.0], radius(1.0), 0.009, [48, 6]);
        for k in 0..3 {
            let t = f64::from(k) / 3.0;
            b.bar(around(radius(1.0), t, height(1.0)), [0.0, 0.55, 0.0], 0.006, 6);
        }
        b.bar([0.0, 0.55, 0.0], [0.0, HI[1] - LAMP[1], 0.0], 0.01, 6);
        b.cone([0.0, 0.5, 0.0], [0.06, 0.02], 0.08, 16);
        b.cone([0.0, HI[1] - LAMP[1] - 0.06, 0.0], [0.1, 0.1], 0.06, 24);
    });
}

fn stairs(b: &mut Builder, rng: &mut Rng) {
    const STEPS: usize = 11;
    let (x0, x1) = (LO[0], LO[0] + 1.05);
    let edge = |k: usize| (0.19 * k as f64, 0.7 - 0.29 * k as f64);
    b.object("stairs");
    for k in 0..STEPS {
        let (y, z) = edge(k);
        b.paint("riser", 0xf2ead8).block([x0, 0.0, z - 0.29], [x1, y + 0.15, z]);
        b.paint("tread", 0x8b5a35).block([x0, y + 0.15, z - 0.29], [x1 + 0.04, y + 0.19, z + 0.03]);
    }
    let (top, end) = edge(STEPS);
    b.block([x0, top - 0.04, LO[2]], [x1 + 0.04, top, end]);
    b.object("railing").paint("baluster", 0xf5efe2);
    let baluster = [
        [0.0, 0.0],
        [0.028, 0.0],
        [0.028, 0.06],
        [0.014, 0.09],
        [0.03, 0.2],
        [0.022, 0.34],
        [0.012, 0.5],
        [0.012, 0.66],
        [0.026, 0.7],
        [0.012, 0.74],
        [0.014, 0.82],
        [0.0, 0.82],
    ];
    for k in 0..STEPS {
        let (y, z) = edge(k);
        b.within(Place::at([x1 - 0.06, y + 0.19, z - 0.14]), |b| {
            b.lathe(&baluster, 8);
        });
    }
    let rail = |k: usize| [x1 - 0.06, edge(k).0 + 1.01, edge(k).1 - 0.14];
    b.paint("rail", 0x7a4a2b).tube(&[rail(0), rail(STEPS - 1)], 10, |_| 0.035);
    let (foot, head) = (rail(0), rail(STEPS - 1));
    b.block_on([foot[0], 0.0, foot[2] + 0.17], [0.1, 1.12, 0.1]).sphere(
        [foot[0], 1.18, foot[2] + 0.17],
        0.08,
        20,
    );
    b.block_on([head[0], top - 0.1, head[2] - 0.17], [0.1, 1.1, 0.1]);
    b.object("ball on the stairs").paint("marble", 0x5a79b8);
    let step = 3 + rng.below(3);
    let (y, z) = edge(step);
    b.sphere([x0 + 0.6, y + 0.19 + 0.13, z - 0.13], 0.13, 28);
}

fn shelves(b: &mut Builder, rng: &mut Rng) {
    let (x0, x1, z0, z1) = (HI[0] - 0.36, HI[0], -2.9, 0.4);
    let level = |k: usize| 0.14 + 0.5 * k as f64;
    b.object("shelves").paint("shelf", 0x6d4529);
    for k in 0..5 {
        b.block([x0, level(k) - 0.035, z0], [x1, level(k), z1]);
    }
    for k in 0..4 {
        let z = lerp(z0, z1 - 0.04, f64::from(k) / 3.0);
        b.block([x0 - 0.01, 0.0, z], [x1, level(4), z + 0.04]);
    }
    b.object("books");
    let colours = [0x8c2f39, 0x2f5d62, 0xd8a657, 0x3d405b, 0xa8b5a2, 0xe07a5f, 0x574b90, 0xf2cc8f];
    for (level_index, bay) in (0..4).flat_map(|k| (0..3).map(move |j| (k, j))) {
        let (y, from) = (level(level_index), lerp(z0, z1 - 0.04, f64::from(bay) / 3.0) + 0.05);
        if rng.unit() < 0.25 {
            vase(
                b,
                [x0 + 0.18, y, from + 0.5],
                rng.range(0.8, 1.1),
                rng.pick(&[0xe9e1d0, 0x49759c, 0xb5523b]),
            );
            continue;
        }
        let (mut z, end) = (from, from + rng.range(0.55, 0.98));
        while z < end {
            let (thick, height) = (rng.range(0.025, 0.06), rng.range(0.25, 0.4));
            let colour = rng.below(colours.len());
            b.paint(&format!("book {colour}"), colours[colour]);
            b.block([x0 + rng.range(0.02, 0.08), y, z], [x1 - 0.06, y + height, z + thick - 0.003]);
            z += thick;
        }
    }
    vase(b, [x0 + 0.18, level(4), -2.2], 1.3, 0x49759c);
    b.object("globe").paint("globe", 0xd9c8a0).sphere([x0 + 0.17, level(4) + 0.2, -0.6], 0.17, 32);
    b.paint("brass", 0xc9a24b).cone([x0 + 0.17, level(4), -0.6], [0.1, 0.02], 0.06, 20);
}

fn vase(b: &mut Builder, foot: V3, size: f64, rgb: u32) {
    let profile = [
        [0.0, 0.0],
        [0.06, 0.0],
        [0.09, 0.05],
        [0.105, 0.11],
        [0.09, 0.18],
        [0.05, 0.24],
        [0.035, 0.28],
        [0.05, 0.32],
        [0.04, 0.315],
        [0.025, 0.28],
        [0.0, 0.26],
    ];
    b.object("vase").paint(&format!("vase {rgb:06x}"), rgb);
    b.within(Place::at(foot).scaled([size; 3]), |b| {
        b.lathe(&profile, 20);
    });
}

fn table(b: &mut Builder, rng: &mut Rng) {
    let (x, z, top) = (LAMP[0], LAMP[2], 0.78);
    b.object("table").paint("table", 0x9a6236);
    b.within(Place::at([x, 0.012, z]), |b| {
        b.lathe(&[[0.0, 0.735], [0.78, 0.735], [0.8, 0.75], [0.79, 0.768], [0.0, 0.768]], 56);
        b.lathe(
            &[[0.0, 0.0], [0.07, 0.1], [0.05, 0.2], [0.09, 0.4], [0.05, 0.55], [0.16, 0.735], [0.0, 0.735]],
            20,
        );
        for k in 0..4 {
            let t = 0.09 + f64::from(k) / 4.0;
            b.tube(
                &[around(0.03, t, 0.26), around(0.2, t, 0.2), around(0.38, t, 0.06), around(0.47, t, 0.03)],
                8,
                |_| 0.03,
            );
        }
    });
    b.object("bowl").paint("bowl", 0xece5d8);
    let bowl = [
        [0.0, 0.0],
        [0.09, 0.0],
        [0.1, 0.02],
        [0.17, 0.06],
        [0.215, 0.12],
        [0.23, 0.15],
        [0.22, 0.15],
        [0.2, 0.12],
        [0.15, 0.07],
        [0.08, 0.035],
        [0.0, 0.03],
    ];
    b.within(Place::at([x + 0.22, top, z + 0.16]), |b| {
        b.lathe(&bowl, 32);
        for k in 0..6 {
            let (name, rgb) = rng.pick(&[("orange", 0xe6892e), ("lemon", 0xe8cf4a), ("apple", 0xb8372f)]);
            let ring = if k == 0 { 0.0 } else { 0.115 };
            let [px, _, pz] = around(ring, f64::from(k) / 5.0, 0.0);
            b.paint(name, rgb).sphere([px, if k == 0 { 0.19 } else { 0.125 }, pz], 0.062, 16);
        }
    });
    vase(b, [x - 0.32, top, z - 0.25], 1.15, 0x49759c);
    b.object("cups");
    for k in 0..3 {
        let foot = around(0.52, 0.15 + f64::from(k) / 3.0 + rng.range(-0.03, 0.03), 0.0);
        let cup =
            [[0.0, 0.0], [0.03, 0.0], [0.045, 0.05], [0.048, 0.09], [0.043, 0.09], [0.04, 0.05], [0.0, 0.01]];
        b.paint("cup", 0xf4f1ea).within(Place::at([x + foot[0], top, z + foot[2]]), |b| {
            b.lathe(&cup, 16).lathe(&[[0.0, 0.0], [0.05, 0.0], [0.085, 0.012], [0.0, 0.006]], 16);
        });
    }
}

/// A chair that looks along +z, its seat over the origin.
fn chair(b: &mut Builder) {
    b.paint("chair", 0x54341f);
    for x in [-0.2, 0.2] {
        b.bar([x, 0.0, 0.21], [x * 0.92, 0.46, 0.19], 0.02, 8);
        b.tube(
            &[[x, 0.0, -0.22], [x * 0.95, 0.45, -0.19], [x * 0.95, 0.75, -0.21], [x * 0.9, 1.02, -0.27]],
            8,
            |_| 0.02,
        );
        b.bar([x * 0.96, 0.2, 0.2], [x * 0.96, 0.2, -0.2], 0.013, 6);
    }
    b.bar([-0.2, 0.26, 0.2], [0.2, 0.26, 0.2], 0.013, 6);
    for k in 0..5 {
        let x = lerp(-0.13, 0.13, f64::from(k) / 4.0);
        b.bar([x, 0.5, -0.195], [x, 0.95, -0.25], 0.011, 6);
    }
    b.block([-0.2, 0.93, -0.265], [0.2, 1.0, -0.235]).block([-0.2, 0.5, -0.205], [0.2, 0.54, -0.18]);
    b.paint("cushion", 0xc8553d).block([-0.22, 0.45, -0.21], [0.22, 0.49, 0.22]);
}

fn plant(b: &mut Builder, rng: &mut Rng) {
    let foot = [2.55, 0.0, 1.25];
    b.object("plant").paint("pot", 0xb5653f);
    b.within(Place::at(foot), |b| {
        b.lathe(
            &[
                [0.0, 0.0],
                [0.16, 0.0],
                [0.22, 0.36],
                [0.25, 0.36],
                [0.25, 0.42],
                [0.21, 0.42],
                [0.2, 0.36],
                [0.0, 0.36],
            ],
            28,
        );
        b.paint("leaf", 0x4f8a4b);
        for k in 0..22 {
            let turns = f64::from(k) * 0.381_966 + rng.range(-0.03, 0.03);
            let (long, lift) = (rng.range(0.45, 0.8), rng.range(0.3, 1.0));
            // A bent blade: wide in the middle, pointed at both ends.
            b.surface([4, 10], [false, false], |u, v| {
                let width = 0.07 * long * wave(v / 2.0) * (2.0 * u - 1.0);
                let fold = 0.4 * width.abs();
                let along = long * v;
                let y = 0.36 + lift * v * (1.6 - 1.1 * v) + fold;
                let (cos, sin) = turn(turns);
                [cos * along - sin * width, y, sin * along + cos * width]
            });
        }
    });
}
