//! Pictures of the map and of its mistakes.

use rayon::prelude::*;

use super::{DepthMap, Map, relative};
use crate::mask::{NONE, SHADOWED};
use crate::methods::debug::{check_view, complete, group};
use crate::methods::{DebugView, Method, Options, RayCast, Samples};
use crate::scene::{InputError, Triangle};

pub(super) const VIEWS: &[DebugView] = &[
    DebugView::amount("light", "share of the filter's texels that let the light through"),
    DebugView::label("texel", "the texel that the sample falls into; numbers only tell neighbours apart"),
    DebugView::label(
        "errors",
        "against exact shadows: 0 right, 1 a leak (lit here, shadowed in truth), 2 acne (shadowed here, lit in truth)",
    ),
];

pub(super) fn draw<M: DepthMap>(
    map: &mut Map,
    view: &str,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> Result<Option<Vec<f32>>, InputError> {
    if !check_view(VIEWS, view, triangles, samples, light)? {
        return Ok(None);
    }
    let positions = samples.positions;
    let numbers = match view {
        "light" => {
            let range = map.draw::<M>(triangles, positions, light);
            positions.par_iter().map(|p| map.lit::<M>(range, *p, light)).collect()
        }
        "texel" => {
            let texel = |p: &[f32; 3]| match relative(*p, light) {
                // It needs no map to be lit.
                [0.0, 0.0, 0.0] => 0.0,
                p => group(M::texel(map.options.resolution, p)),
            };
            positions.par_iter().map(texel).collect()
        }
        _ => errors::<M>(map, triangles, samples, light)?,
    };
    Ok(Some(complete(numbers, positions)))
}

fn errors<M: DepthMap>(
    map: &mut Map,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> Result<Vec<f32>, InputError> {
    let mut mask = vec![NONE; samples.positions.len()];
    let mut truth = mask.clone();
    map.shadow::<M>(triangles, samples, light, &mut mask)?;
    RayCast::new(&Options::default()).shadow(triangles, samples, light, &mut truth)?;
    let class = |(m, t): (&u8, &u8)| match m == t {
        true => 0.0,
        false if *t == SHADOWED => 1.0,
        false => 2.0,
    };
    Ok(mask.iter().zip(&truth).map(class).collect())
}
