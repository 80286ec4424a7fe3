//! The space that tiles are boxes in: clip space of the camera, or the world where no usable camera is known.
//!
//! A plane `m · (p - base) = 0` becomes four coefficients over the box coordinates `(x, y, z, 1)`, for which
//!
//! ```text
//! clip   z m·(p - base) = x m·right + y m·up + z m·(eye - base) + m·forward       z = 1 / w > 0
//! world    m·(p - base) = x m.x     + y m.y  + z m.z            + m·(origin - base)
//! ```
//!
//! holds up to `m · r`, with `r` the *residual* of the sample: what is missing when the sample is put together again
//! from its rounded coordinates. It is measured, sample by sample, so nothing is assumed about the camera: axes that are
//! not perpendicular, or samples that another camera saw, give larger boxes and the same mask.

use crate::samples::View;

pub(crate) type V3 = [f64; 3];

/// Unit roundoff of f64.
pub(crate) const U64: f64 = 0.5 * f64::EPSILON;

#[inline(always)]
pub(crate) fn wide(p: [f32; 3]) -> V3 {
    [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])]
}

#[inline(always)]
pub(crate) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(crate) fn abs(a: V3) -> V3 {
    [a[0].abs(), a[1].abs(), a[2].abs()]
}

/// Residuals over this make boxes too loose to be worth a camera: a ten-thousandth of a pixel of a large picture.
const RESIDUAL_LIMIT: f64 = 1.0 / (1u64 << 26) as f64;

/// Box coordinates of one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinates {
    pub(crate) at: V3,
    /// Bounds the residual, axis by axis of the world.
    pub(crate) residual: V3,
    /// False if the sample has no place in this space (behind the camera, or too far out): then the rest means nothing.
    pub(crate) good: bool,
}

/// Where boxes live.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Space {
    /// After the division of [`View::clip_from_world`]: x and y over the picture, z = 1 / w.
    Clip {
        view: View,
        /// Rows that give w x, w y and w.
        dual: [V3; 3],
    },
    /// Differences from a point in the middle of the samples.
    World { origin: V3 },
}

impl Default for Space {
    fn default() -> Self {
        Space::World { origin: [0.0; 3] }
    }
}

impl Space {
    /// Clip space of a camera; its axes need not be perpendicular.
    pub(crate) fn clip(view: &View) -> Space {
        let volume = dot(view.forward, cross(view.right, view.up));
        let row = |a: V3, b: V3| cross(a, b).map(|v| v / volume);
        let dual = [row(view.up, view.forward), row(view.forward, view.right), row(view.right, view.up)];
        Space::Clip { view: *view, dual }
    }

    /// The camera's eye, where there is one.
    pub(crate) fn eye(&self) -> Option<V3> {
        match self {
            Space::Clip { view, .. } => Some(view.eye),
            Space::World { .. } => None,
        }
    }

    /// Box coordinates of a sample. Without branches, so that a loop over samples becomes vector code.
    #[inline(always)]
    pub(crate) fn coordinates(&self, p: [f32; 3]) -> Coordinates {
        match self {
            Space::Clip { view, dual } => {
                let q = sub(wide(p), view.eye);
                let z = 1.0 / dot(dual[2], q);
                let (x, y) = (z * dot(dual[0], q), z * dot(dual[1], q));
                let mut residual = [0.0; 3];
                for k in 0..3 {
                    let (zq, xr, yu) = (z * q[k], x * view.right[k], y * view.up[k]);
                    let r = zq - view.forward[k] - xr - yu;
                    // q carries one rounding, the products one each, the sum three: under 6 u of the absolute terms.
                    let sum = zq.abs() + view.forward[k].abs() + xr.abs() + yu.abs();
                    residual[k] = r.abs() + 8.0 * U64 * sum;
                }
                // Written so that NaN fails.
                let small = |k: usize| residual[k] <= RESIDUAL_LIMIT;
                let good = (z > 0.0) & (z < f64::INFINITY) & small(0) & small(1) & small(2);
                Coordinates { at: [x, y, z], residual, good }
            }
            Space::World { origin } => {
                let at = sub(wide(p), *origin);
                // The difference carries one rounding; twice that bounds it in terms of the rounded difference.
                Coordinates { at, residual: at.map(|v| 2.0 * U64 * v.abs()), good: true }
            }
        }
    }

    /// Coefficients of the plane through `base` with normal `m`, and how far each may be from those of the real plane if
    /// `m` is within `error` of the real normal and residuals are within `residual`.
    ///
    /// `base` is exact, so its difference from eye or origin carries one rounding u; a dot product three more of each term.
    #[inline(always)]
    pub(crate) fn plane(&self, m: V3, error: V3, base: V3, residual: V3) -> ([f64; 4], [f64; 4]) {
        let along = |axis: V3| {
            let size = abs(axis);
            (dot(m, axis), dot(error, size) * (1.0 + 8.0 * U64) + 8.0 * U64 * dot(abs(m), size))
        };
        let missed = dot([0, 1, 2].map(|k| m[k].abs() + error[k]), residual);
        match self {
            Space::Clip { view, .. } => {
                let (x, ex) = along(view.right);
                let (y, ey) = along(view.up);
                let (z, ez) = along(sub(view.eye, base));
                let (w, ew) = along(view.forward);
                ([x, y, z, w], [ex, ey, ez, ew + missed])
            }
            Space::World { origin } => {
                let (w, ew) = along(sub(*origin, base));
                ([m[0], m[1], m[2], w], [error[0], error[1], error[2], ew + missed])
            }
        }
    }
}
