//! Samples from the depth buffer of another renderer.
//!
//! Such samples know no triangle, so they cannot be moved off their own surface exactly. Instead they are moved towards
//! the eye by an amount that the precision of the depth buffer dictates: one step of its depth values.

use rayon::prelude::*;

use super::{NO_SAMPLE, ViewSamples};
use crate::scene::InputError;

/// A depth buffer and the camera that made it.
#[derive(Clone, Copy, Debug)]
pub struct DepthBuffer<'a> {
    /// Depth values as the renderer stored them, row by row, top row first.
    pub depth: &'a [f32],
    /// Pixels a row.
    pub width: usize,
    /// The inverse of projection times view, row-major, acting on column vectors: takes clip space with `x` to the right,
    /// `y` up, both in [-1, 1], and `z` as stored, to world space.
    pub world_from_clip: [[f64; 4]; 4],
    /// The value of pixels that show no surface (1 for a usual buffer, 0 for reversed depth).
    pub background: f32,
    /// The distance between neighbouring depth values: 2^-24 for 24-bit buffers; 0 for 32-bit float buffers, where it is
    /// the spacing of floats at each value.
    pub step: f32,
    /// How many steps samples are moved towards the eye; 2 suits a buffer that is rounded to nearest.
    pub offset_steps: f32,
}

/// One sample a pixel: the world position of its depth value, moved by `offset_steps` towards the eye.
///
/// # Errors
/// [`InputError`] if the size does not fit or the matrix has a number that is not finite.
pub fn from_depth_buffer(buffer: &DepthBuffer<'_>) -> Result<ViewSamples, InputError> {
    let DepthBuffer { depth, width, world_from_clip: m, .. } = *buffer;
    if width == 0 || !depth.len().is_multiple_of(width) {
        return Err(InputError::Length {
            what: "depth buffer",
            got: depth.len(),
            expected: depth.len().next_multiple_of(width.max(1)),
        });
    }
    if !m.iter().flatten().all(|v| v.is_finite()) {
        return Err(InputError::NotFinite { what: "camera matrix", index: 0 });
    }
    let height = depth.len() / width;
    // The depth of the eye's side: larger values are farther in a usual buffer, nearer in a reversed one.
    let nearer = if buffer.background > 0.5 { -1.0 } else { 1.0 };
    let unproject = |x: f64, y: f64, z: f64| {
        let h = [0, 1, 2, 3].map(|r| m[r][0] * x + m[r][1] * y + m[r][2] * z + m[r][3]);
        [h[0] / h[3], h[1] / h[3], h[2] / h[3]]
    };
    let positions = depth
        .par_iter()
        .enumerate()
        .map(|(i, &d)| {
            if d == buffer.background || !d.is_finite() {
                return NO_SAMPLE;
            }
            let x = (2 * (i % width) + 1) as f64 / width as f64 - 1.0;
            let y = 1.0 - (2 * (i / width) + 1) as f64 / height as f64;
            let step = if buffer.step > 0.0 {
                f64::from(buffer.step)
            } else {
                f64::from(d.abs().next_up() - d.abs())
            };
            let p = unproject(x, y, f64::from(d) + nearer * step * f64::from(buffer.offset_steps))
                .map(|v| v as f32);
            if p.iter().all(|v| v.is_finite()) { p } else { NO_SAMPLE }
        })
        .collect();
    Ok(ViewSamples { width, height, positions, depth: depth.to_vec(), ..ViewSamples::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reversed infinite projection with near plane 0.5 and 90 degrees, camera at the origin looking along -z.
    fn inverse_reversed_infinite(near: f64) -> [[f64; 4]; 4] {
        // clip = (x, y, near, -z); so x = clip.x, y = clip.y, z = -clip.w, w = clip.z / near.
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 1.0 / near, 0.0]]
    }

    #[test]
    fn positions_come_back_and_lie_on_the_eye_side() {
        let near = 0.5;
        let depth = [0.0, 0.25, 0.05, 0.5];
        let buffer = DepthBuffer {
            depth: &depth,
            width: 2,
            world_from_clip: inverse_reversed_infinite(near),
            background: 0.0,
            step: 0.0,
            offset_steps: 2.0,
        };
        let samples = from_depth_buffer(&buffer).expect("valid");
        assert!(samples.positions[0][0].is_nan());
        for i in 1..4 {
            let distance = -f64::from(samples.positions[i][2]);
            let expected = near / f64::from(depth[i]);
            assert!(distance < expected && distance > expected * 0.999_999, "{distance} {expected}");
        }
        // Pixel 1 is the upper right one.
        assert!(samples.positions[1][0] > 0.0 && samples.positions[1][1] > 0.0);
    }

    #[test]
    fn a_size_that_does_not_fit_is_an_error() {
        let buffer = DepthBuffer {
            depth: &[0.5; 3],
            width: 2,
            world_from_clip: [[0.0; 4]; 4],
            background: 0.0,
            step: 0.0,
            offset_steps: 0.0,
        };
        assert!(matches!(from_depth_buffer(&buffer), Err(InputError::Length { .. })));
    }
}
