//! Packets of neighbouring pixels, tile by tile.

use antumbra::mask::{LIT, NONE, SHADOWED};
use bench_common::{Case, Tile, for_each_tile};

use crate::ffi::{Query, Rays, Scene, Valid};
use crate::options::Options;

/// Asks one ray a sample. The part `cut` of it, at the sample's end, is left out.
pub(crate) fn trace(case: &Case, scene: &Scene, options: &Options, cut: f32, mask: &mut [u8]) {
    for_each_tile(mask, case.width, |tile| {
        let query = Query::new(scene, options.coherent);
        // Packets are 4 pixels wide, or runs in a bare list.
        match (options.packet, tile.height) {
            (16, 1) => packets::<16, 16>(case, options, cut, tile, query, Query::occluded16),
            (16, _) => packets::<16, 4>(case, options, cut, tile, query, Query::occluded16),
            (_, 1) => packets::<8, 8>(case, options, cut, tile, query, Query::occluded8),
            _ => packets::<8, 4>(case, options, cut, tile, query, Query::occluded8),
        }
    });
}

/// Cuts a tile into packets of `K` samples, `W` wide.
fn packets<'a, const K: usize, const W: usize>(
    case: &Case,
    options: &Options,
    cut: f32,
    tile: &mut Tile<'_>,
    mut query: Query<'a>,
    occluded: impl Fn(&mut Query<'a>, &Valid<K>, &mut Rays<K>),
) {
    let mut rays = Rays::<K>::new();
    if options.from_light {
        rays.origin = case.light.map(|v| [v; K]);
    } else {
        rays.near = [cut; K];
    }
    let far = if options.from_light { 1.0 - cut } else { 1.0 };
    for y in (0..tile.height).step_by(K / W) {
        let rows = (tile.height - y).min(K / W);
        for x in (0..tile.width).step_by(W) {
            let columns = (tile.width - x).min(W);
            let mut points = [[f32::NAN; K]; 3];
            for row in 0..rows {
                let at = tile.sample(x, y + row);
                let samples = &case.samples[at..at + columns];
                // The usual case has a constant length, for the compiler's sake.
                match <&[[f32; 3]; W]>::try_from(samples) {
                    Ok(samples) => spread(samples, row * W, &mut points),
                    Err(_) => spread(samples, row * W, &mut points),
                }
            }
            let valid = aim(&points, case.light, options.from_light, &mut rays);
            if valid.0 == [0; K] {
                continue;
            }
            rays.far = [far; K];
            occluded(&mut query, &valid, &mut rays);
            let answers = answers(&valid, &rays);
            for row in 0..rows {
                let at = (y + row) * tile.width + x;
                tile.mask[at..at + columns].copy_from_slice(&answers[row * W..row * W + columns]);
            }
        }
    }
}

/// Puts neighbouring samples into the lanes from `first` on.
#[inline(always)]
fn spread<const K: usize>(samples: &[[f32; 3]], first: usize, points: &mut [[f32; K]; 3]) {
    for (lane, p) in (first..K).zip(samples) {
        for axis in 0..3 {
            points[axis][lane] = p[axis];
        }
    }
}

/// Rays between light and samples; which lanes have one.
#[inline(always)]
fn aim<const K: usize>(
    points: &[[f32; K]; 3],
    light: [f32; 3],
    from_light: bool,
    rays: &mut Rays<K>,
) -> Valid<K> {
    // NaN in any coordinate means that there is no sample.
    let valid = std::array::from_fn(|k| -i32::from(!(points[0][k] + points[1][k] + points[2][k]).is_nan()));
    for axis in 0..3 {
        for k in 0..K {
            let away = points[axis][k] - light[axis];
            // Embree looks at all lanes of a vector, so those without a ray hold a harmless one.
            let away = if away.is_nan() { 1.0 } else { away };
            rays.direction[axis][k] = if from_light { away } else { -away };
        }
    }
    if !from_light {
        rays.origin = *points;
    }
    Valid(valid)
}

#[inline(always)]
fn answers<const K: usize>(valid: &Valid<K>, rays: &Rays<K>) -> [u8; K] {
    std::array::from_fn(|k| {
        let hit = if rays.far[k] < 0.0 { SHADOWED } else { LIT };
        if valid.0[k] == 0 { NONE } else { hit }
    })
}
