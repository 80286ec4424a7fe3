//! A pinhole camera.

/// A perspective camera, world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the file, or empty.
    pub name: String,
    /// Position of the pinhole.
    pub eye: [f32; 3],
    /// A point in the middle of the picture.
    pub target: [f32; 3],
    /// Roughly upwards.
    pub up: [f32; 3],
    /// Vertical field of view in degrees, over 0 and under 180.
    pub fov: f32,
}
