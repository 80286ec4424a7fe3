//! The camera of a picture, as axes and as a projection.

use crate::scene::Camera;

/// The axes of a camera, scaled so that `forward + x right + y up` with `x, y` in [-1, 1] spans the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The pinhole.
    pub eye: [f64; 3],
    /// Unit.
    pub forward: [f64; 3],
    /// Half the picture's width at distance 1.
    pub right: [f64; 3],
    /// Half the picture's height at distance 1.
    pub up: [f64; 3],
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn normalize(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length > 0.0 && length.is_finite()).then(|| a.map(|v| v / length))
}

impl View {
    /// The axes of `camera` for a picture of the given size. A camera that looks along its own up vector, or at
    /// its own eye, gets the next best axis.
    pub fn new(camera: &Camera, width: usize, height: usize) -> View {
        let eye = camera.eye.map(f64::from);
        let toward = [0, 1, 2].map(|k| f64::from(camera.target[k]) - eye[k]);
        let forward = normalize(toward).unwrap_or([0.0, 0.0, -1.0]);
        let right = [camera.up.map(f64::from), [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .into_iter()
            .find_map(|up| {
                let r = cross(forward, normalize(up)?);
                if dot(r, r) > 1e-12 { normalize(r) } else { None }
            })
            .unwrap_or([1.0, 0.0, 0.0]);
        let up = cross(right, forward);
        let half = (f64::from(camera.fov).to_radians() * 0.5).tan();
        let aspect = width as f64 / height as f64;
        View { eye, forward, right: right.map(|v| v * half * aspect), up: up.map(|v| v * half) }
    }

    /// The direction through the middle of a pixel (not unit; one along the viewing axis).
    pub fn direction(&self, x: usize, y: usize, width: usize, height: usize) -> [f64; 3] {
        let u = (2 * x + 1) as f64 / width as f64 - 1.0;
        let v = 1.0 - (2 * y + 1) as f64 / height as f64;
        [0, 1, 2].map(|k| self.forward[k] + u * self.right[k] + v * self.up[k])
    }

    /// Clip space from world space, row-major, for column vectors: reversed depth with an infinite far plane. After
    /// the division x and y lie in [-1, 1] over the picture (y up) and z is 1 at distance 1 along the viewing axis, 0 at infinity;
    /// w is the distance along the viewing axis.
    pub fn clip_from_world(&self) -> [[f64; 4]; 4] {
        let row = |axis: [f64; 3], scale: f64| {
            let a = axis.map(|v| v * scale);
            [a[0], a[1], a[2], -dot(a, self.eye)]
        };
        let inverse_square = |a: [f64; 3]| 1.0 / dot(a, a);
        [
            row(self.right, inverse_square(self.right)),
            row(self.up, inverse_square(self.up)),
            [0.0, 0.0, 0.0, 1.0],
            row(self.forward, 1.0),
        ]
    }
}
