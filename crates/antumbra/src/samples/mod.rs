//! Which points are asked: one a pixel of a picture, or any others.

pub mod depth_buffer;
pub mod gbuffer;
pub mod offset;
pub mod points;
mod view;

pub use gbuffer::GBuffer;
pub use view::View;

use crate::methods::Samples;

/// One point a pixel (or any list of points), with what is known about the surface that it lies on.
///
/// All arrays have `width * height` entries, row by row, top row first; `normals`, `triangle` and `depth` may be empty
/// where they are not known. A sample whose position is NaN is "no sample here" (background).
#[derive(Clone, Debug, Default)]
pub struct ViewSamples {
    /// Samples a row; for a bare list its length.
    pub width: usize,
    /// Rows; 1 for a bare list.
    pub height: usize,
    /// World space; NaN = no sample.
    pub positions: Vec<[f32; 3]>,
    /// Geometric unit normals, towards the eye.
    pub normals: Vec<[f32; 3]>,
    /// The triangle of the soup that the sample lies on, `u32::MAX` = none.
    pub triangle: Vec<u32>,
    /// Distance from the eye along the viewing axis.
    pub depth: Vec<f32>,
    /// The camera that saw the samples, where known.
    pub view: Option<View>,
}

impl ViewSamples {
    /// What a method takes.
    pub fn view(&self) -> Samples<'_> {
        Samples { positions: &self.positions, width: self.width, view: self.view.as_ref() }
    }
}

/// A sample that is not there.
pub(crate) const NO_SAMPLE: [f32; 3] = [f32::NAN; 3];
