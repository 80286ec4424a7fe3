//! Packets of neighbouring pixels, tile by tile.

use antumbra::mask::{LIT, NONE, SHADOWED};
use bench_common::{Case, Tile, for_each_tile};

use crate::ffi::{Query, Rays, Scene, Valid};
use crate::options::Options;

/// Asks one ray a sample.
pub(crate) fn trace(case: &Case, scene: &Scene, options: &Options, mask: &mut [u8]) {
    for_each_tile(mask, case.width, |tile| {
        let query = Query::new(scene, options.coherent);
        match options.packet {
            16 => packets(case, options, tile, query, Query::occluded16),
            _ => packets(case, options, tile, query, Query::occluded8),
        }
    });
}

/// Cuts a tile into packets 4 pixels wide (runs, in a bare list).
fn packets<'a, const K: usize>(
    case: &Case,
    options: &Options,
    tile: &mut Tile<'_>,
    mut query: Query<'a>,
    occluded: impl Fn(&mut Query<'a>, &Valid<K>, &mut Rays<K>),
) {
    let columns = if tile.height == 1 { K } else { 4 };
    let rows = K / columns;
    let mut rays = Rays::<K>::new();
    if options.from_light {
        rays.origin = case.light.map(|v| [v; K]);
    } else {
        rays.near = [options.epsilon; K];
    }
    let far = if options.from_light { 1.0 - options.epsilon } else { 1.0 };
    for y in (0..tile.height).step_by(rows) {
        for x in (0..tile.width).step_by(columns) {
            let mut valid = Valid([0; K]);
            for k in 0..K {
                let (x, y) = (x + k % columns, y + k / columns);
                let inside = x < tile.width && y < tile.height;
                let p = if inside { case.samples[tile.sample(x, y)] } else { [f32::NAN; 3] };
                // NaN in any coordinate means that there is no sample.
                let there = !(p[0] + p[1] + p[2]).is_nan();
                valid.0[k] = -i32::from(there);
                for axis in 0..3 {
                    // Embree looks at all lanes of a vector, so those without a ray hold a harmless one.
                    let away = if there { p[axis] - case.light[axis] } else { 1.0 };
                    rays.direction[axis][k] = if options.from_light { away } else { -away };
                    if there && !options.from_light {
                        rays.origin[axis][k] = p[axis];
                    }
                }
                rays.far[k] = far;
            }
            if valid.0 == [0; K] {
                continue;
            }
            occluded(&mut query, &valid, &mut rays);
            for k in 0..K {
                let (x, y) = (x + k % columns, y + k / columns);
                if x < tile.width && y < tile.height {
                    tile.mask[y * tile.width + x] = match (valid.0[k], rays.far[k] < 0.0) {
                        (0, _) => NONE,
                        (_, true) => SHADOWED,
                        (_, false) => LIT,
                    };
                }
            }
        }
    }
}
