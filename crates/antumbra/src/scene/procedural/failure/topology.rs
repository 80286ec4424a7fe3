//! How triangles meet: shared edges, ties, edges with many triangles, cracks, meshes through each other.

use super::super::Arguments;
use super::super::build::Builder;
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
