//! Which points are asked.

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
}
