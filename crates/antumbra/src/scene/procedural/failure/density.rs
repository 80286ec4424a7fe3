//! Very many triangles where there is little to see.

use super::super::Arguments;
use super::super::build::Builder;
use super::super::math::{around, fractal, scale, turn};
use super::ground;

pub(in super::super) fn tiny(arguments: &Arguments, b: &mut Builder) {
    // Some ten triangles a pixel in a common picture, and as many under one sample of the shadow.
    ground(b, 4.0, 0.0);
    b.object("pebble").paint("blue", 0x5a79b8);
    b.surface([136, 66], [true, false], |u, v| {
        let (cos, sin) = turn(0.5 * v);
        let p = around(sin, -u, -cos);
        let p = scale(p, 0.11 * (1.0 + 0.25 * fractal(scale(p, 2.5), arguments.seed)));
        [p[0], p[1] + 0.6, p[2]]
    });
    b.light([0.6, 3.6, 0.8], 0xffffff, 3.4).camera([2.0, 2.4, 3.4], [-0.05, 0.3, 0.0], 34.0);
}
