//! Where light, eye and casters stand to one another.

use super::super::Arguments;
use super::super::build::Builder;
use super::super::math::{add, around, cross, scale, sub, unit};
use super::ground;

/// A triangle at breast height and a box, for the scenes whose point is the light or the eye.
fn company(b: &mut Builder) {
    ground(b, 4.0, 0.0);
    b.object("box").paint("blue", 0x5a79b8).block([-1.5, 0.25, -1.0], [-0.5, 1.25, 0.0]);
    b.object("triangle").paint("red", 0xc8553d).triangle([
        [0.0, 1.0, 1.0],
        [1.5, 1.25, 0.5],
        [0.75, 1.5, -1.0],
    ]);
}

pub(in super::super) fn in_plane(_: &Arguments, b: &mut Builder) {
    // Every number is exact in binary: the light lies in the planes of the upright triangles and of two box faces.
    company(b);
    let light = [-0.5, 3.0, 0.5];
    b.object("in the plane").paint("yellow", 0xe8cf4a);
    b.triangle([[-0.5, 0.0, 2.0], [-0.5, 1.5, 1.5], [-0.5, 0.5, 3.0]]);
    b.triangle([[0.5, 0.0, 0.5], [2.0, 1.5, 0.5], [2.5, 0.25, 0.5]]);
    b.triangle([[-0.5, 2.5, 0.0], [-0.5, 2.0, 1.0], [-0.5, 3.5, 1.0]]);
    b.object("level").paint("green", 0x4f8a4b).triangle([
        [-3.0, 3.0, -3.0],
        [-2.0, 3.0, -3.0],
        [-3.0, 3.0, -1.5],
    ]);
    b.light(light, 0xffffff, 3.0).camera([3.5, 4.0, 5.5], [-0.2, 0.9, 0.2], 44.0);
}

pub(in super::super) fn on_vertex(_: &Arguments, b: &mut Builder) {
    // A tent whose top is the light: every one of its triangles has the light as a corner and blocks nothing.
    company(b);
    let light = [0.0, 3.0, 0.0];
    b.object("tent").paint("yellow", 0xe8cf4a);
    for k in 0..5 {
        let corner = |k: i32| around(0.6, f64::from(k) / 5.0, 2.25);
        b.triangle([light, corner(k), corner(k + 1)]);
    }
    b.light(light, 0xffffff, 3.0).camera([3.0, 3.6, 5.2], [-0.1, 0.9, 0.0], 44.0);
}

pub(in super::super) fn inside(_: &Arguments, b: &mut Builder) {
    // Light, eye and two casters in a closed ball: from here all cones end on the ball, and none leaves it.
    b.object("ball").paint("cream", 0xefe3cc).sphere([0.0, 1.5, 0.0], 3.0, 32);
    b.object("box").paint("blue", 0x5a79b8).block([-1.5, 0.25, -1.0], [-0.5, 1.25, 0.0]);
    b.object("small ball").paint("red", 0xc8553d).sphere([0.6, 1.3, -0.9], 0.4, 16);
    ground(b, 6.0, -2.0);
    b.light([0.1, 2.6, 0.05], 0xffffff, 2.4).camera([0.9, 2.3, 2.4], [-0.2, 0.8, -0.6], 70.0);
}

pub(in super::super) fn at_eye(_: &Arguments, b: &mut Builder) {
    // Nothing that is seen is shadowed, and each silhouette is a tie.
    company(b);
    let eye = [3.0, 3.5, 5.0];
    b.light(eye, 0xffffff, 6.0).camera(eye, [-0.1, 0.6, 0.0], 42.0);
}

pub(in super::super) fn behind_eye(_: &Arguments, b: &mut Builder) {
    // Half of the cones point at the eye, and one caster is behind it.
    company(b);
    b.object("behind").paint("yellow", 0xe8cf4a).triangle([
        [4.5, 4.3, 6.0],
        [5.0, 5.2, 5.9],
        [4.4, 4.9, 7.0],
    ]);
    b.light([7.5, 7.8, 11.0], 0xffffff, 13.0).camera([3.0, 3.0, 4.6], [-0.1, 0.6, 0.0], 44.0);
}

pub(in super::super) fn eye_in_shadow(_: &Arguments, b: &mut Builder) {
    // The eye is inside the volumes of a panel and of a closed box: counting starts at 4 there.
    company(b);
    b.object("panel").paint("yellow", 0xe8cf4a);
    b.quad([[0.6, 4.2, 2.9], [2.9, 4.2, 1.2], [4.6, 4.5, 4.0], [2.4, 4.5, 5.6]]);
    b.object("box above").paint("green", 0x4f8a4b).block([2.2, 4.8, 3.0], [3.6, 5.2, 4.4]);
    b.light([2.6, 7.5, 3.2], 0xffffff, 7.0).camera([3.0, 3.2, 4.4], [-0.1, 0.6, 0.0], 46.0);
}

pub(in super::super) fn near_caster(_: &Arguments, b: &mut Builder) {
    // Four millimetres before the eye, nearer than any sensible near plane; the light is as near, beside the eye, and so
    // the speck's shadow is as large as the box.
    company(b);
    let (eye, target) = ([3.0, 3.0, 5.0], [-0.2, 0.5, -0.2]);
    let forward = unit(sub(target, eye));
    let right = unit(cross(forward, [0.0, 1.0, 0.0]));
    let at = |f: f64, r: f64, up: f64| add(eye, add(add(scale(forward, f), scale(right, r)), [0.0, up, 0.0]));
    b.object("speck").paint("yellow", 0xe8cf4a);
    b.triangle([at(0.004, 0.002, 0.0), at(0.004, 0.0028, 0.0002), at(0.0042, 0.0022, -0.0008)]);
    b.light(at(0.0, 0.004, 0.0), 0xffffff, 6.0).camera(eye, target, 44.0);
}

pub(in super::super) fn far(_: &Arguments, b: &mut Builder) {
    // All cones are nearly parallel, and a sample's distance to the light says nothing about its place any more.
    company(b);
    b.light([25_000.0, 60_000.0, 30_000.0], 0xffffff, 71_600.0).camera(
        [3.2, 3.4, 5.0],
        [-0.1, 0.6, 0.0],
        42.0,
    );
}

pub(in super::super) fn close_large(_: &Arguments, b: &mut Builder) {
    // Triangles thousands of times larger than their distance to the light: cones of nearly a half space.
    ground(b, 6.0, 0.0);
    b.object("box").paint("blue", 0x5a79b8).block([-1.5, 0.0, -1.0], [-0.5, 1.0, 0.0]);
    b.object("sheets").paint("red", 0xc8553d);
    b.triangle([[-0.001, 1.998, -3.0], [-0.001, 2.5, 4.0], [4.0, 2.2, -2.5]]);
    b.triangle([[-3.0, 1.999, -3.5], [3.0, 2.001, -3.0], [0.0, 1.9, -0.01]]);
    b.triangle([[-5.0, 1.7, 0.5], [0.002, 1.998, 0.002], [-4.0, 2.05, 4.0]]);
    b.light([0.0, 2.0, 0.0], 0xffffff, 2.6).camera([1.0, 6.5, 8.0], [-0.2, 0.6, 0.0], 46.0);
}

pub(in super::super) fn one_cell(_: &Arguments, b: &mut Builder) {
    // As seen from the light all samples are in a cone of 1e-4: one cell of any map around the light.
    company(b);
    b.object("veil").paint("green", 0x4f8a4b);
    for k in 0..200 {
        let place = around(0.2 + 0.016 * f64::from(k), f64::from(k) * 0.381_966, 2.2 + 0.002 * f64::from(k));
        b.triangle([
            place,
            [place[0] + 0.09, place[1], place[2]],
            [place[0], place[1] + 0.02, place[2] + 0.09],
        ]);
    }
    b.light([9_000.0, 60_000.0, 20_000.0], 0xffffff, 63_900.0).camera(
        [3.2, 3.6, 5.2],
        [-0.1, 0.7, 0.0],
        42.0,
    );
}

pub(in super::super) fn two_clumps(_: &Arguments, b: &mut Builder) {
    // Two little tables, 1e-4 apart as seen from the light, and nothing between or around them.
    for (name, x, y) in [("near clump", -1.5, 0.5), ("far clump", 1.5, -0.5)] {
        b.object(name).paint("red", 0xc8553d);
        b.quad([[x - 0.5, y, -0.5], [x - 0.5, y, 0.5], [x + 0.5, y, 0.5], [x + 0.5, y, -0.5]]);
        b.paint("blue", 0x5a79b8).sphere([x, y + 0.4, 0.0], 0.2, 24);
    }
    b.light([6_000.0, 28_000.0, 9_000.0], 0xffffff, 30_000.0).camera([0.0, 2.6, 4.5], [0.0, 0.0, 0.0], 40.0);
}
