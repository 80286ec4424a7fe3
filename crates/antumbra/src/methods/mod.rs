//! Who finds the blocking triangle. All methods have one shape, [`Method::shadow`], and one answer.

mod catalogue;
mod cptsv;
mod cssv;
pub(crate) mod debug;
mod dpsv;
pub(crate) mod leaf;
mod light_tiles;
mod ofts;
mod oracle;
pub(crate) mod ptsv;
mod ray_cast;
mod ray_hierarchy;
mod shadow_map;
mod stats;

pub use catalogue::{CATALOGUE, MethodInfo, Options, UnknownMethod, create, info};
pub use cptsv::{Cptsv, DenseLayout};
pub use cssv::Cssv;
pub use debug::{DebugView, Scale};
pub use dpsv::{Dpsv, Query as DpsvQuery};
pub use light_tiles::LightTiles;
pub use ofts::Ofts;
pub use oracle::Oracle;
pub use ptsv::{Ptsv, Tuning as PtsvTuning};
pub use ray_cast::RayCast;
pub use ray_hierarchy::{ConeTest, LeafKind, RayHierarchy, RayHierarchyOptions};
pub use shadow_map::{CubeMap, DualParaboloid, ShadowMapOptions};
pub use stats::{Stage, Stats, StatsBuilder};

use crate::samples::View;
use crate::scene::{InputError, Triangle};

/// The points that are asked: rows of positions, NaN = no sample here.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// World space, row by row.
    pub positions: &'a [[f32; 3]],
    /// Samples a row. Neighbours in the picture are neighbours in space: methods may use it, never rely on it.
    /// For a bare list: its length.
    pub width: usize,
    /// The camera that saw the samples, where known: methods that work in its clip space (PTSV, CPTSV) or that count
    /// from the eye (stencil volumes) use it, and make one up otherwise. It never changes the answer.
    pub view: Option<&'a View>,
}

impl<'a> Samples<'a> {
    /// Points in no particular order.
    pub fn list(positions: &'a [[f32; 3]]) -> Samples<'a> {
        Samples { positions, width: positions.len(), view: None }
    }

    /// The pixels of a picture, `width` a row, of which no camera is known.
    pub fn image(positions: &'a [[f32; 3]], width: usize) -> Samples<'a> {
        Samples { positions, width, view: None }
    }
}

/// A shadow method. Scratch memory is kept between calls, results are not: every call answers anew.
pub trait Method: Send {
    /// The name in [`CATALOGUE`].
    fn name(&self) -> &'static str;

    /// Writes [`crate::mask::LIT`], [`crate::mask::SHADOWED`] or [`crate::mask::NONE`] for every sample, using the
    /// threads of the current rayon pool.
    ///
    /// # Errors
    /// [`InputError`] names a coordinate that is not finite (samples: infinite; NaN means "no sample"), or a mask of
    /// the wrong length.
    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError>;

    /// The pictures that [`Method::debug_view`] can make.
    fn debug_views(&self) -> &'static [DebugView] {
        &[]
    }

    /// Answers once more, and returns for every sample one number that shows what was done: NaN where there is no sample,
    /// and nowhere else. `None` if there is no view of that name.
    ///
    /// # Errors
    /// As [`Method::shadow`].
    fn debug_view(
        &mut self,
        view: &str,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
    ) -> Result<Option<Vec<f32>>, InputError> {
        let _ = (view, triangles, samples, light);
        Ok(None)
    }
}

/// The checks at the border, the same for every method.
pub(crate) fn check_input(
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
    mask: &[u8],
) -> Result<(), InputError> {
    check_asked(triangles, samples, light)?;
    if mask.len() != samples.positions.len() {
        return Err(InputError::Length { what: "mask", got: mask.len(), expected: samples.positions.len() });
    }
    Ok(())
}

/// The checks of everything but the mask.
fn check_asked(triangles: &[Triangle], samples: Samples<'_>, light: [f32; 3]) -> Result<(), InputError> {
    crate::scene::check_triangles(triangles)?;
    if !light.iter().all(|v| v.is_finite()) {
        return Err(InputError::NotFinite { what: "light", index: 0 });
    }
    let limit = u32::MAX as usize - 1;
    if samples.positions.len() > limit {
        return Err(InputError::TooMany { what: "samples", got: samples.positions.len(), limit });
    }
    if let Some(index) = samples.positions.iter().position(|p| p.iter().any(|v| v.is_infinite())) {
        return Err(InputError::NotFinite { what: "sample", index });
    }
    Ok(())
}

/// The level to dispatch a kernel on.
pub(crate) fn simd_level(isa: crate::Isa) -> fearless_simd::Level {
    isa.level().unwrap_or_else(fearless_simd::Level::new)
}
