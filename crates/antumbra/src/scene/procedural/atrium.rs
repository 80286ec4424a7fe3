//! A courtyard with two storeys of arcades: columns, arches, balusters, cloth.

use super::Arguments;
use super::build::{Builder, Place};
use super::math::{Rng, V3, add, around, lerp, noise, turn, wave};

/// Half the width and half the length of the courtyard, in bays of `BAY`.
const BAYS: [usize; 2] = [4, 8];
const BAY: f64 = 2.2;
const DEEP: f64 = 2.8;
const STOREY: f64 = 4.3;
const SPRING: f64 = 2.75;
const WALL: f64 = 0.42;
const LIGHT: V3 = [0.5, 5.6, -1.2];

/// How finely curves are divided: 1 by default.
#[derive(Clone, Copy)]
struct Detail(f64);

impl Detail {
    fn of(self, n: usize) -> usize {
        ((n as f64 * self.0).round() as usize).max(3)
    }
}

pub(super) fn atrium(arguments: &Arguments, b: &mut Builder) {
    // Triangles grow with the square of the detail above a number that is flat anyway: a secant in the square.
    let target = arguments.size as f64;
    let (mut before, mut square) = ((0.0, 0.0), 1.0);
    for _ in 0..6 {
        *b = Builder::new();
        build(arguments.seed, Detail(f64::sqrt(square)), b);
        let got = b.len() as f64;
        if (got / target - 1.0).abs() < 0.02 {
            break;
        }
        let slope = (got - before.1) / (square - before.0);
        before = (square, got);
        // Never below what keeps a column round.
        square = (square + (target - got) / slope).clamp(0.01, 4_000.0);
        if square == before.0 {
            break;
        }
    }
}

fn build(seed: u64, detail: Detail, b: &mut Builder) {
    let mut rng = Rng::new(seed, 0);
    let half = BAYS.map(|n| n as f64 * BAY / 2.0);
    let outer = half.map(|h| h + DEEP);
    b.object("floor");
    b.tiles(
        [-outer[0], -outer[1]],
        outer,
        0.0,
        [18, 26],
        [("pale stone", 0xd6c8ad), ("red stone", 0xb98368)],
    );
    // Each side looks at the courtyard along +z, its arcade on z = 0.
    for side in 0..4 {
        let (bays, away) = (BAYS[side % 2], half[1 - side % 2]);
        let place = Place::at([0.0; 3]).turned(0.25 * side as f64);
        b.within(place, |b| {
            b.within(Place::at([0.0, 0.0, -away]), |b| arcades(b, side, bays, detail, &mut rng));
        });
    }
    for (k, z) in [-4.6, 3.4].into_iter().enumerate() {
        canopy(b, k, z, half[0], seed, detail);
    }
    fountain(b, detail);
    for (k, [x, z]) in [[-3.2, 5.6], [3.2, 5.6], [-3.2, -5.6], [3.2, -5.6]].into_iter().enumerate() {
        pot(b, k, [x, 0.0, z], detail, &mut rng);
    }
    lamp(b, detail);
    b.light(LIGHT, 0xffedd0, 5.2).camera([-2.7, 1.9, 8.3], [0.7, 3.35, -2.0], 62.0);
}

fn arcades(b: &mut Builder, side: usize, bays: usize, detail: Detail, rng: &mut Rng) {
    let half = bays as f64 * BAY / 2.0;
    for storey in 0..2 {
        let y = STOREY * storey as f64;
        let name = |what: &str| format!("{what} {side}.{storey}");
        b.within(Place::at([0.0, y, 0.0]), |b| {
            b.object(name("columns"));
            for k in 0..=bays {
                // Corners belong to the side that starts there.
                if k < bays {
                    b.within(Place::at([-half + BAY * k as f64, 0.0, 0.0]), |b| column(b, storey, detail));
                }
            }
            b.object(name("arches"));
            for k in 0..bays {
                b.within(Place::at([-half + BAY * (k as f64 + 0.5), 0.0, 0.0]), |b| arch(b, detail));
            }
            b.object(name("wall")).paint(["ochre wall", "rose wall"][storey], [0xd9b47c, 0xd39a82][storey]);
            let far = half + DEEP;
            b.quad([[-far, 0.0, -DEEP], [far, 0.0, -DEEP], [far, STOREY, -DEEP], [-far, STOREY, -DEEP]]);
            doors(b, bays, half);
            // The gallery's barrel vault.
            b.object(name("vault")).paint("vault", 0xe9dfc8);
            b.surface([detail.of(16), detail.of(10)], [false, false], |u, v| {
                let (cos, sin) = turn(0.5 * v);
                let z = -DEEP / 2.0 - (DEEP / 2.0) * cos;
                let run = half - z;
                [lerp(-run, run, u), SPRING + 0.55 + 0.75 * sin, z]
            });
            cornice(b, name("cornice"), half, storey);
            if storey == 1 {
                balustrade(b, name("balustrade"), half, bays, detail);
                drapes(b, side, half, bays, detail, rng);
            }
        });
    }
    roof(b, side, half, detail);
}

fn column(b: &mut Builder, storey: usize, detail: Detail) {
    let stone = [("travertine", 0xd9cba9), ("white stone", 0xe8e1d0)][storey];
    b.paint(stone.0, stone.1).block_on([0.0; 3], [0.62, 0.14, 0.62]);
    let base = [
        [0.0, 0.14],
        [0.3, 0.14],
        [0.31, 0.19],
        [0.29, 0.23],
        [0.25, 0.25],
        [0.27, 0.29],
        [0.24, 0.33],
        [0.0, 0.33],
    ];
    b.lathe(&base, detail.of(24));
    // The shaft: fluted below, twisted above, thinner towards the top.
    let twist = [0.0, 1.0][storey];
    b.surface([detail.of(36), detail.of(14)], [true, false], |u, v| {
        let (cos, sin) = turn(-u);
        let flute = 1.0 - 0.055 * (1.0 + wave([12.0, 6.0][storey] * (u + twist * v * 0.5)));
        let r = lerp(0.23, 0.19, v * v) * flute;
        [r * cos, lerp(0.33, SPRING - 0.5, v), r * sin]
    });
    let capital = [
        [0.0, SPRING - 0.5],
        [0.21, SPRING - 0.5],
        [0.23, SPRING - 0.47],
        [0.2, SPRING - 0.44],
        [0.21, SPRING - 0.36],
        [0.26, SPRING - 0.24],
        [0.35, SPRING - 0.14],
        [0.0, SPRING - 0.14],
    ];
    b.lathe(&capital, detail.of(24));
    for k in 0..8 {
        // Leaves that curl outwards.
        let (cos, sin) = turn(f64::from(k) / 8.0);
        b.surface([2, detail.of(6)], [false, false], |u, v| {
            let r = 0.215 + 0.16 * v * v * v;
            let w = 0.075 * (2.0 * u - 1.0) * (1.0 - v * v);
            [r * cos - w * sin, SPRING - 0.46 + 0.3 * v * (1.15 - 0.35 * v), r * sin + w * cos]
        });
    }
    b.block_on([0.0, SPRING - 0.14, 0.0], [0.66, 0.14, 0.66]);
}

/// The wall over one bay with its arch cut out, as thick as `WALL`.
fn arch(b: &mut Builder, detail: Detail) {
    let (h, r, n) = (BAY / 2.0, BAY / 2.0 - 0.27, detail.of(20));
    b.paint("masonry", 0xd8c6a2);
    let rim = |u: f64, r: f64| {
        let (cos, sin) = turn(0.5 * u);
        [-r * cos, SPRING + r * sin]
    };
    for z in [-WALL / 2.0, WALL / 2.0] {
        b.surface([n, 2], [false, false], |u, v| {
            let [x, y] = rim(u, r);
            // Outside the arch the grid runs straight up to the storey's top.
            [lerp(x, h * x / r, v), lerp(y, STOREY, v), z]
        });
        for side in [-1.0, 1.0] {
            b.triangle([[side * r, SPRING, z], [side * h, SPRING, z], [side * h, STOREY, z]]);
        }
        // A moulding around the arch.
        b.surface([n, detail.of(6)], [false, true], |u, v| {
            let (cos, sin) = turn(v);
            let [x, y] = rim(u, r + 0.07 + 0.045 * cos);
            [x, y, z + 0.035 * sin]
        });
    }
    b.surface([n, 2], [false, false], |u, v| {
        let [x, y] = rim(u, r);
        [x, y, lerp(-WALL / 2.0, WALL / 2.0, v)]
    });
    for side in [-1.0, 1.0] {
        let (a, c) = (side * r, side * h);
        b.quad([
            [a, SPRING, -WALL / 2.0],
            [c, SPRING, -WALL / 2.0],
            [c, SPRING, WALL / 2.0],
            [a, SPRING, WALL / 2.0],
        ]);
    }
    b.paint("keystone", 0xe8dcc2)
        .block([-0.09, SPRING + r - 0.03, -WALL / 2.0 - 0.06], [0.09, SPRING + r + 0.26, WALL / 2.0 + 0.06]);
}

fn doors(b: &mut Builder, bays: usize, half: f64) {
    for k in 0..bays {
        let x = -half + BAY * (k as f64 + 0.5);
        b.paint("door frame", 0xe8dcc2);
        for side in [-0.55, 0.55] {
            b.block([x + side - 0.08, 0.0, -DEEP], [x + side + 0.08, 2.3, -DEEP + 0.1]);
        }
        b.block([x - 0.7, 2.3, -DEEP], [x + 0.7, 2.5, -DEEP + 0.16]);
        b.paint("door", 0x5b4636).block([x - 0.47, 0.0, -DEEP], [x + 0.47, 2.3, -DEEP + 0.03]);
        for (u, v) in [(-0.23, 0.3), (0.23, 0.3), (-0.23, 1.3), (0.23, 1.3)] {
            b.block([x + u - 0.16, v, -DEEP + 0.03], [x + u + 0.16, v + 0.8, -DEEP + 0.05]);
        }
    }
}

/// The band between the storeys, on brackets.
fn cornice(b: &mut Builder, name: String, half: f64, storey: usize) {
    let out = [0.34, 0.46][storey];
    b.object(name).paint("cornice", 0xe8dcc2);
    b.block([-half, STOREY - 0.16, -DEEP], [half, STOREY, out]);
    b.block([-half, STOREY - 0.3, WALL / 2.0], [half, STOREY - 0.16, WALL / 2.0 + 0.06]);
    let n = (half / 0.17) as usize;
    for k in 0..n {
        let x = lerp(-half, half, (k as f64 + 0.5) / n as f64);
        b.block([x - 0.05, STOREY - 0.28, WALL / 2.0], [x + 0.05, STOREY - 0.16, out - 0.05]);
    }
}

fn balustrade(b: &mut Builder, name: String, half: f64, bays: usize, detail: Detail) {
    b.object(name).paint("white stone", 0xe8e1d0);
    let profile = [
        [0.0, 0.1],
        [0.055, 0.1],
        [0.055, 0.14],
        [0.03, 0.18],
        [0.06, 0.3],
        [0.045, 0.42],
        [0.025, 0.55],
        [0.025, 0.66],
        [0.045, 0.7],
        [0.03, 0.74],
        [0.055, 0.78],
        [0.055, 0.82],
        [0.0, 0.82],
    ];
    for k in 0..bays {
        let x0 = -half + BAY * k as f64;
        b.block([x0, 0.0, -0.09], [x0 + BAY, 0.1, 0.09]).block([x0, 0.82, -0.11], [x0 + BAY, 0.93, 0.11]);
        for i in 0..6 {
            b.within(Place::at([x0 + BAY * (f64::from(i) + 1.0) / 7.0, 0.0, 0.0]), |b| {
                b.lathe(&profile, detail.of(10));
            });
        }
    }
}

/// Cloth that hangs in some of the upper arches.
fn drapes(b: &mut Builder, side: usize, half: f64, bays: usize, detail: Detail, rng: &mut Rng) {
    let colours = [("crimson cloth", 0xa32f36), ("indigo cloth", 0x344b8c), ("green cloth", 0x3f7d5a)];
    for k in 0..bays {
        let ((name, rgb), phase, wind) = (rng.pick(&colours), rng.unit(), rng.range(0.6, 1.2));
        if (k + side).is_multiple_of(2) {
            continue;
        }
        let middle = -half + BAY * (k as f64 + 0.5);
        b.object(format!("drape {side}.{k}")).paint(name, rgb);
        b.surface([detail.of(36), detail.of(22)], [false, false], |u, v| {
            let fold =
                wave(5.0 * u + phase + 0.3 * v) * (0.04 + 0.07 * v) + 0.03 * wave(11.0 * u - phase) * v;
            let x = lerp(-0.62, 0.62, u) * (1.0 - 0.22 * wave(0.5 * v));
            [
                middle + x,
                lerp(3.3, 0.35, v) - 1.4 * v * wave(0.5 * u) * 0.1,
                0.34 + fold + 0.25 * wind * wave(0.32 * v),
            ]
        });
        b.paint("brass", 0xc9a24b).bar([middle - 0.75, 3.3, 0.34], [middle + 0.75, 3.3, 0.34], 0.025, 8);
    }
}

/// A sail across the courtyard, tied to both sides.
fn canopy(b: &mut Builder, k: usize, z: f64, half: f64, seed: u64, detail: Detail) {
    b.object(format!("canopy {k}")).paint(["saffron cloth", "crimson cloth"][k], [0xe0a13a, 0xa32f36][k]);
    b.surface([detail.of(64), detail.of(28)], [false, false], |u, v| {
        let sag = 4.0 * u * (1.0 - u);
        let width = lerp(1.1, 0.75, sag);
        let ripple = 0.06 * noise([9.0 * u, 3.0 * v, k as f64], seed) + 0.05 * wave(3.0 * v + 2.0 * u) * sag;
        [
            lerp(-half, half, u),
            2.0 * STOREY - 0.5 - 1.3 * sag + ripple,
            z + width * (2.0 * v - 1.0) + 0.2 * wave(u),
        ]
    });
}

/// Half-round tiles on a roof that slopes inwards.
fn roof(b: &mut Builder, side: usize, half: f64, detail: Detail) {
    let tiles = (half * 2.0 / 0.28) as usize;
    b.object(format!("roof {side}")).paint("roof tile", 0xb5653f);
    b.surface([tiles * detail.of(6), 6], [false, false], |u, v| {
        let out = lerp(0.6, -DEEP, v);
        let y = 2.0 * STOREY + lerp(0.05, 1.2, v);
        [lerp(-half, half, u), y + 0.05 * wave(tiles as f64 * u).abs(), out]
    });
}

fn fountain(b: &mut Builder, detail: Detail) {
    b.object("fountain").paint("white stone", 0xe8e1d0);
    let basin = [
        [0.0, 0.0],
        [1.5, 0.0],
        [1.5, 0.1],
        [1.4, 0.14],
        [1.36, 0.4],
        [1.45, 0.48],
        [1.45, 0.55],
        [1.25, 0.55],
        [1.22, 0.2],
        [0.3, 0.2],
        [0.2, 0.35],
        [0.14, 0.9],
        [0.22, 1.02],
        [0.6, 1.14],
        [0.74, 1.24],
        [0.68, 1.24],
        [0.2, 1.12],
        [0.1, 1.2],
        [0.08, 1.55],
        [0.3, 1.66],
        [0.34, 1.72],
        [0.08, 1.68],
        [0.05, 1.9],
        [0.09, 2.0],
        [0.0, 2.1],
    ];
    b.lathe(&basin, detail.of(48));
    b.paint("water", 0x6fa3ad).lathe(&[[0.0, 0.42], [1.24, 0.42]], detail.of(48));
}

fn pot(b: &mut Builder, k: usize, foot: V3, detail: Detail, rng: &mut Rng) {
    b.object(format!("tree {k}")).paint("terracotta", 0xb5653f);
    b.within(Place::at(foot), |b| {
        let pot = [
            [0.0, 0.0],
            [0.3, 0.0],
            [0.4, 0.5],
            [0.46, 0.5],
            [0.46, 0.6],
            [0.38, 0.6],
            [0.36, 0.5],
            [0.0, 0.5],
        ];
        b.lathe(&pot, detail.of(24));
        b.paint("trunk", 0x6b4a33).bar([0.0, 0.5, 0.0], [0.05, 1.5, 0.0], 0.05, 8);
        b.paint("leaf", 0x5f8a4c);
        for _ in 0..60 {
            let from = add([0.05, 1.5, 0.0], rng.direction().map(|c| 0.2 * c));
            let (turns, lift) = (rng.unit(), rng.range(-0.5, 1.0));
            let (cos, sin) = turn(turns);
            b.surface([2, detail.of(5)], [false, false], |u, v| {
                let w = 0.07 * (2.0 * u - 1.0) * wave(0.5 * v);
                let r = 0.75 * v;
                add(from, [r * cos - w * sin, lift * v - 0.6 * v * v + 0.3 * w.abs(), r * sin + w * cos])
            });
        }
    });
}

/// A cage of bars around the light, on a chain.
fn lamp(b: &mut Builder, detail: Detail) {
    b.object("lamp").paint("iron", 0x33302e);
    b.within(Place::at(LIGHT), |b| {
        for k in 0..6 {
            let t = f64::from(k) / 6.0;
            b.tube(
                &[around(0.2, t, -0.3), around(0.27, t, 0.0), around(0.2, t, 0.3), [0.0, 0.55, 0.0]],
                5,
                |_| 0.008,
            );
        }
        b.ring([0.0, -0.3, 0.0], 0.2, 0.012, [detail.of(24), 6]).ring(
            [0.0, 0.3, 0.0],
            0.2,
            0.012,
            [detail.of(24), 6],
        );
        b.bar([0.0, 0.55, 0.0], [0.0, 2.0 * STOREY - LIGHT[1], 0.0], 0.012, 6);
        let across = BAYS[0] as f64 * BAY / 2.0;
        let y = 2.0 * STOREY - LIGHT[1];
        b.bar([-across - LIGHT[0], y, 0.0], [across - LIGHT[0], y, 0.0], 0.01, 5);
    });
}
