//! The six faces of a cube around the light, each with a frame of its own: axes permuted, one perhaps negated.

use fearless_simd::{Simd, f32x8};

/// Faces of the cube.
pub(super) const FACES: usize = 6;

/// The frame of a face: world axes of u, v and w, and the sign that makes w point away from the light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Frame {
    pub(super) axis: [usize; 3],
    pub(super) sign: f32,
}

const AXES: [[usize; 3]; 3] = [[1, 2, 0], [0, 2, 1], [0, 1, 2]];

impl Frame {
    /// The frame of face `face`: +x, -x, +y, -y, +z, -z.
    #[inline(always)]
    pub(super) fn of(face: usize) -> Frame {
        Frame { axis: AXES[face / 2], sign: if face.is_multiple_of(2) { 1.0 } else { -1.0 } }
    }

    /// Vectors of points in the frame. Exact.
    #[inline(always)]
    pub(super) fn turn_all<S: Simd, const V: usize>(
        &self,
        [x, y, z]: [[f32x8<S>; V]; 3],
    ) -> [[f32x8<S>; V]; 3] {
        let (u, v, mut w) = match self.axis[2] {
            0 => (y, z, x),
            1 => (x, z, y),
            _ => (x, y, z),
        };
        for w in &mut w {
            *w *= self.sign;
        }
        [u, v, w]
    }

    /// A corner of each of eight triangles, or its vector from the light, in the frame. Exact.
    #[inline(always)]
    pub(super) fn turn_eight<S: Simd>(&self, p: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
        [p[self.axis[0]], p[self.axis[1]], p[self.axis[2]] * self.sign]
    }

    /// A point or vector in the frame. Exact.
    #[inline(always)]
    pub(super) fn turn(&self, p: [f32; 3]) -> [f32; 3] {
        [p[self.axis[0]], p[self.axis[1]], p[self.axis[2]] * self.sign]
    }
}

/// The face that a vector points through.
#[inline(always)]
pub(super) fn face_of(q: [f32; 3]) -> usize {
    let a = q.map(f32::abs);
    let axis = if a[0] >= a[1] && a[0] >= a[2] {
        0
    } else if a[1] >= a[2] {
        1
    } else {
        2
    };
    2 * axis + usize::from(q[axis] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn w_is_the_largest_coordinate_of_the_face() {
        for q in [
            [3.0, 1.0, -2.0],
            [-3.0, 1.0, 2.0],
            [1.0, 3.0, -2.0],
            [1.0, -3.0, 3.0],
            [0.0, 1.0, 2.0],
            [1.0, 1.0, -2.0],
        ] {
            let [u, v, w] = Frame::of(face_of(q)).turn(q);
            assert!(w > 0.0 && w >= u.abs() && w >= v.abs(), "{q:?}");
        }
    }
}
