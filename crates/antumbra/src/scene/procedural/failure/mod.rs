//! One tiny scene for each way in which a shadow method can fail, with a light and a camera that see the place where it
//! would. All are small enough for the oracle.

pub(super) mod density;
pub(super) mod lights;
pub(super) mod numbers;
pub(super) mod simple;
pub(super) mod topology;

use super::build::Builder;

/// A square ground about the origin at height `y`, as two triangles.
fn ground(b: &mut Builder, half: f64, y: f64) {
    b.object("ground").paint("ground", 0xb9b4a7);
    b.quad([[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]]);
}
