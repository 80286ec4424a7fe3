//! Where floating-point numbers run out: degenerate triangles, huge and tiny ones, far offsets.

use super::super::Arguments;
use super::super::build::{Builder, Place};
use super::super::math::{Rng, add, around, scale};
use super::ground;

pub(in super::super) fn degenerate(arguments: &Arguments, b: &mut Builder) {
    let mut rng = Rng::new(arguments.seed, 0);
    ground(b, 4.0, 0.0);
    let light = [0.5, 4.0, 0.75];
    let proper = [[-1.0, 1.0, 0.5], [0.5, 1.25, 1.0], [0.0, 1.5, -1.0]];
    b.object("proper").paint("red", 0xc8553d).triangle(proper);
    b.object("duplicates").paint("blue", 0x5a79b8);
    for order in [[0, 1, 2], [1, 2, 0], [2, 1, 0], [0, 2, 1]] {
        b.triangle(order.map(|k| proper[k]));
    }
    // Points, doubled corners and corners in one line: none of them blocks anything.
    b.object("zero area").paint("yellow", 0xe8cf4a);
    for _ in 0..8 {
        let p = [rng.range(-2.0, 2.0), rng.range(0.2, 2.0), rng.range(-2.0, 2.0)];
        let step = [0.25, 0.5, -0.125];
        b.triangle([p, p, p]).triangle([p, p, add(p, step)]).triangle([p, add(p, step), p]);
        b.triangle([proper[0], add(proper[0], step), add(proper[0], scale(step, 2.0))]);
    }
    b.object("tiny").paint("green", 0x4f8a4b);
    for _ in 0..8 {
        let p = [rng.range(-1.5, 1.5), rng.range(0.5, 2.0), rng.range(-1.5, 1.5)];
        b.triangle([p, add(p, [1e-6, 0.0, 0.0]), add(p, [0.0, 1e-6, 1e-6])]);
    }
    // Seen edge-on from the light, or nearly so, and a million units long.
    b.object("huge").paint("grey", 0x88929c);
    b.triangle([light, [1e6, 1e6, -2e6], [-1e6, 1e6, -2e6]]);
    b.triangle([[-1e6, 0.5, -1e6], [1e6, 0.5, -1e6 - 1.0], [0.0, 0.5, -1.5]]);
    b.triangle([[-1e6, -3.0, 1e6], [1e6, -3.0, 1e6], [0.0, -3.0, -1e6]]);
    b.light(light, 0xffffff, 3.8).camera([3.2, 3.4, 5.0], [-0.2, 0.4, -0.2], 44.0);
}

pub(in super::super) fn offset(_: &Arguments, b: &mut Builder) {
    // At a million units the lattice of f32 has a pitch of 1/16: the ball's corners snap to it, edges and all.
    let origin = [1_048_576.0, 2_097_152.0, -1_048_576.0];
    b.within(Place::at(origin), |b| {
        ground(b, 8.0, 0.0);
        b.object("ball").paint("blue", 0x5a79b8).sphere([0.0, 3.0, 0.0], 1.75, 20);
        b.object("triangle").paint("red", 0xc8553d).triangle([
            [2.0, 1.5, 2.0],
            [4.5, 2.0, 1.0],
            [3.0, 3.5, -2.0],
        ]);
    });
    let at = |p| add(origin, p);
    b.light(at([1.5, 9.0, 2.0]), 0xffffff, 8.0).camera(at([6.0, 7.0, 10.0]), at([0.0, 1.5, 0.0]), 42.0);
}

pub(in super::super) fn depth_range(_: &Arguments, b: &mut Builder) {
    // Casters and samples from a tenth to a hundred thousand from the light, along one line of sight.
    ground(b, 100_000.0, 0.0);
    b.object("posts");
    let mut d = 0.1;
    for k in 0..21 {
        let (name, rgb) = [("red", 0xc8553d), ("blue", 0x5a79b8), ("yellow", 0xe8cf4a)][k % 3];
        let [x, _, z] = around(d, 0.62 + 0.021 * (k % 7) as f64, 0.0);
        let high = 0.2 + 0.45 * d;
        b.paint(name, rgb).block_on([x, 0.0, z], [0.1 * d, high, 0.1 * d]);
        d *= 2.0;
    }
    b.object("grain").paint("green", 0x4f8a4b).triangle([
        [0.02, 0.93, -0.05],
        [0.05, 0.9, -0.02],
        [-0.01, 0.9, -0.04],
    ]);
    b.light([0.0, 1.0, 0.0], 0xffffff, 4.0).camera([1.0, 3.0, 3.5], [-0.2, 1.0, -2.0], 60.0);
}

pub(in super::super) fn slivers(arguments: &Arguments, b: &mut Builder) {
    let mut rng = Rng::new(arguments.seed, 0);
    ground(b, 4.0, 0.0);
    b.object("slivers");
    for k in 0..3_000 {
        if k % 1_000 == 0 {
            let (name, rgb) = [("red", 0xc8553d), ("blue", 0x5a79b8), ("yellow", 0xe8cf4a)][k / 1_000];
            b.paint(name, rgb);
        }
        // Up to six units long and a thousandth to a millionth wide.
        let middle = [rng.range(-1.5, 1.5), rng.range(0.4, 2.2), rng.range(-1.5, 1.5)];
        let along = scale(rng.direction(), rng.range(0.2, 0.8));
        let along = [along[0], 0.2 * along[1], along[2]];
        let width = rng.pick(&[4e-3, 1e-3, 1e-4, 1e-5, 1e-6]);
        let side = scale(rng.direction(), width);
        b.triangle([add(middle, along), add(middle, scale(along, -1.0)), add(middle, side)]);
    }
    b.light([0.6, 4.5, 0.8], 0xffffff, 4.0).camera([3.0, 3.4, 4.6], [-0.1, 0.7, 0.0], 42.0);
}
