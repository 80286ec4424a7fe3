//! Samples from given points.

use super::ViewSamples;
use crate::scene::InputError;

/// View samples from points that are taken as they are (no offset): a bare list, in any order. NaN = no sample.
///
/// # Errors
/// [`InputError::NotFinite`] names the first point with an infinite coordinate.
pub fn from_points(points: &[[f32; 3]]) -> Result<ViewSamples, InputError> {
    if let Some(index) = points.iter().position(|p| p.iter().any(|v| v.is_infinite())) {
        return Err(InputError::NotFinite { what: "sample", index });
    }
    Ok(ViewSamples { width: points.len(), height: 1, positions: points.to_vec(), ..ViewSamples::default() })
}
