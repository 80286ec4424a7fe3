//! The smallest scenes.

use super::super::Arguments;
use super::super::build::Builder;
use super::ground;

pub(in super::super) fn single(_: &Arguments, b: &mut Builder) {
    ground(b, 4.0, 0.0);
    b.object("triangle").paint("red", 0xc8553d);
    b.triangle([[-1.0, 1.0, 0.6], [1.1, 1.3, 0.4], [0.1, 1.7, -1.0]]);
    b.light([0.8, 4.0, 0.5], 0xffffff, 3.6).camera([3.2, 3.0, 4.6], [-0.2, 0.5, -0.1], 42.0);
}

pub(in super::super) fn empty(_: &Arguments, b: &mut Builder) {
    b.light([0.0, 4.0, 0.0], 0xffffff, 4.0).camera([3.2, 3.0, 4.6], [0.0; 3], 42.0);
}
