//! Where floating-point numbers run out: degenerate triangles, huge and tiny ones, far offsets.

use super::super::Arguments;
use super::super::build::Builder;
use super::super::math::{Rng, add, scale};
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
