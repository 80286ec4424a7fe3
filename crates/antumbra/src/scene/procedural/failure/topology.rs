//! How triangles meet: shared edges, ties, edges with many triangles, cracks, meshes through each other.

use super::super::Arguments;
use super::super::build::{Builder, Place};
use super::super::math::{Rng, around, lerp};
use super::ground;

pub(in super::super) fn fan(_: &Arguments, b: &mut Builder) {
    // Seen from the light, thousands of shared edges cross each row of samples in the shadow.
    ground(b, 4.0, 0.0);
    b.object("sphere").paint("blue", 0x5a79b8).sphere([0.0, 1.3, 0.0], 0.9, 64);
    b.light([0.7, 4.6, 0.9], 0xffffff, 3.8).camera([2.6, 3.4, 3.8], [-0.2, 0.7, -0.2], 40.0);
}

pub(in super::super) fn fan_rotated(arguments: &Arguments, b: &mut Builder) {
    fan(arguments, b);
    let soup = &mut b.scene.soup;
    soup.normals.resize(soup.positions.len(), [[0.0; 3]; 3]);
    for (k, (corners, normals)) in soup.positions.iter_mut().zip(&mut soup.normals).enumerate() {
        corners.rotate_left(k % 3);
        normals.rotate_left(k % 3);
    }
}

pub(in super::super) fn lattice(_: &Arguments, b: &mut Builder) {
    // Light, cubes and ground have integer coordinates, so that cube edges project onto one another exactly. The
    // ground is level with the light's lattice too: samples meet edges of cones wherever rounding leaves them on it.
    b.object("ground");
    b.tiles([-8.0, -8.0], [8.0, 8.0], 0.0, [8, 8], [("light tile", 0xd8d2c2), ("dark tile", 0x9b978c)]);
    b.object("cubes").paint("red", 0xc8553d);
    for (x, z) in (-1..=1).flat_map(|x| (-1..=1).map(move |z| (f64::from(x) * 3.0, f64::from(z) * 3.0))) {
        b.block([x - 1.0, 1.0, z - 1.0], [x + 1.0, 3.0, z + 1.0]);
    }
    b.paint("blue", 0x5a79b8)
        .block([-1.0, 3.0, -1.0], [1.0, 5.0, 1.0])
        .block([1.0, 3.0, 1.0], [3.0, 5.0, 3.0]);
    b.light([-3.0, 9.0, 3.0], 0xffffff, 9.0).camera([9.0, 13.0, 14.0], [0.0, 0.5, 0.0], 36.0);
}

pub(in super::super) fn seams(_: &Arguments, b: &mut Builder) {
    // A cubic room about the light on the integer lattice: its edges, and the steps along them, lie exactly on the
    // planes |x| = |y|, |y| = |z| and |z| = |x| where the faces of a cube map meet.
    b.object("room");
    let colours = [("terracotta", 0xc9694a), ("teal", 0x3f8f93), ("cream", 0xefe3cc)];
    for axis in 0..3 {
        b.paint(colours[axis].0, colours[axis].1);
        for (side, i, j) in
            [-8.0, 8.0].iter().flat_map(|s| (-4..4).flat_map(move |i| (-4..4).map(move |j| (*s, i, j))))
        {
            let corner = |u: i32, v: i32| {
                let mut p = [side; 3];
                p[(axis + 1) % 3] = 2.0 * f64::from(i + u);
                p[(axis + 2) % 3] = 2.0 * f64::from(j + v);
                p
            };
            let flip = i32::from(side > 0.0);
            // All look inwards.
            b.quad([corner(0, 0), corner(1 - flip, flip), corner(1, 1), corner(flip, 1 - flip)]);
        }
    }
    b.object("cubes").paint("yellow", 0xe8cf4a);
    for k in 0..8 {
        let at = |bit: usize| if k >> bit & 1 == 0 { -4.0 } else { 3.0 };
        let lo = [at(0), at(1), at(2)];
        b.block(lo, lo.map(|c| c + 1.0));
    }
    b.object("diagonals").paint("blue", 0x5a79b8);
    for k in 0..4 {
        // Plates in the planes themselves, seen edge-on from the light, and plates across them.
        b.within(Place::at([0.0; 3]).turned(0.25 * f64::from(k)), |b| {
            b.quad([[2.0, -1.0, 2.0], [5.0, -1.0, 5.0], [5.0, 1.0, 5.0], [2.0, 1.0, 2.0]]);
            b.quad([[4.0, 5.0, -1.0], [6.0, 5.0, -1.0], [6.0, 5.0, 1.0], [4.0, 5.0, 1.0]]);
        });
    }
    b.light([0.0; 3], 0xffffff, 7.0).camera([6.5, 5.5, 7.0], [-3.0, -3.5, -4.0], 74.0);
}

pub(in super::super) fn interpenetrating(arguments: &Arguments, b: &mut Builder) {
    let mut rng = Rng::new(arguments.seed, 0);
    ground(b, 4.0, 0.0);
    for (name, rgb) in [("red", 0xc8553d), ("blue", 0x5a79b8), ("yellow", 0xe8cf4a)] {
        b.object(format!("{name} triangles")).paint(name, rgb);
        for _ in 0..100 {
            let corner = |rng: &mut Rng| {
                let d = rng.direction();
                [1.1 * d[0], 1.4 + 0.9 * d[1], 1.1 * d[2]]
            };
            b.triangle([corner(&mut rng), corner(&mut rng), corner(&mut rng)]);
        }
    }
    b.object("ball through the ground").paint("green", 0x4f8a4b).sphere([1.8, 0.1, 1.0], 0.6, 20);
    b.light([0.9, 4.6, 1.2], 0xffffff, 4.0).camera([3.2, 3.6, 4.8], [-0.1, 0.7, -0.1], 42.0);
}

pub(in super::super) fn edge_fan(_: &Arguments, b: &mut Builder) {
    // Sails about a mast: the mast is an edge of 3, 5 and 12 triangles, without any two that make a surface.
    ground(b, 4.0, 0.0);
    for (k, sails) in [3, 5, 12].into_iter().enumerate() {
        let x = 1.7 * (k as f64 - 1.0);
        b.object(format!("{sails} sails"))
            .paint(["red", "blue", "yellow"][k], [0xc8553d, 0x5a79b8, 0xe8cf4a][k]);
        b.within(Place::at([x, 0.5, 0.0]), |b| {
            for s in 0..sails {
                b.triangle([[0.0; 3], [0.0, 1.6, 0.0], around(0.7, f64::from(s) / f64::from(sails), 0.5)]);
            }
        });
    }
    b.light([0.6, 4.6, 1.6], 0xffffff, 4.0).camera([2.4, 3.4, 5.2], [-0.1, 0.5, -0.3], 42.0);
}

pub(in super::super) fn layers(_: &Arguments, b: &mut Builder) {
    // 300 closed plates between light and ground: 8 bits of a stencil overflow at 256.
    ground(b, 4.0, 0.0);
    b.object("plates");
    for k in 0..300 {
        let (name, rgb) = [("red", 0xc8553d), ("blue", 0x5a79b8), ("yellow", 0xe8cf4a)][k % 3];
        let y = 0.5 + 0.005 * k as f64;
        // The stack leans, so that its shadow has every depth from 0 to 300.
        let x = lerp(-0.8, 0.8, k as f64 / 299.0);
        b.paint(name, rgb).block([x - 0.6, y, -0.6], [x + 0.6, y + 0.003, 0.6]);
    }
    b.light([0.3, 5.0, 0.5], 0xffffff, 4.4).camera([2.8, 3.2, 4.8], [0.0, 0.7, 0.0], 42.0);
}

pub(in super::super) fn cracks(_: &Arguments, b: &mut Builder) {
    // A roof whose halves are divided differently: the corners of the fine half are T-junctions on the edges of the
    // coarse one, on thirds that no f32 hits, so hair-wide lit lines are right here.
    ground(b, 4.0, 0.0);
    let height = |x: f64, z: f64| 1.5 + 0.2 * x - 0.1 * z;
    let sheet = |b: &mut Builder, z0: f64, z1: f64, n: [i32; 2]| {
        let p = |i: i32, j: i32| {
            let (x, z) = (
                lerp(-1.5, 1.5, f64::from(i) / f64::from(n[0])),
                lerp(z0, z1, f64::from(j) / f64::from(n[1])),
            );
            [x, height(x, z), z]
        };
        for (i, j) in (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| (i, j))) {
            b.quad([p(i, j), p(i, j + 1), p(i + 1, j + 1), p(i + 1, j)]);
        }
    };
    b.object("coarse").paint("red", 0xc8553d);
    sheet(b, -1.2, 0.0, [4, 2]);
    b.object("fine").paint("blue", 0x5a79b8);
    sheet(b, 0.0, 1.2, [12, 6]);
    // And a real crack, a hundred-thousandth wide.
    b.object("apart").paint("yellow", 0xe8cf4a);
    sheet(b, 1.200_01, 2.0, [7, 3]);
    b.light([0.5, 4.4, 0.3], 0xffffff, 3.8).camera([3.4, 3.4, 5.2], [-0.1, 0.6, 0.2], 44.0);
}
