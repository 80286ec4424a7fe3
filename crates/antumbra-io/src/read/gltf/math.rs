//! The little linear algebra that scenes need, in `f64`: positions are rounded once, at the end.

/// A vector.
pub(super) type Vec3 = [f64; 3];

/// An affine map: three rows of the matrix, the last column is the translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine(pub(super) [[f64; 4]; 3]);

/// Translation, rotation (a quaternion, `w` last) and scale, applied in the order scale, rotation, translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trs {
    pub(super) translation: Vec3,
    pub(super) rotation: [f64; 4],
    pub(super) scale: Vec3,
}

impl Affine {
    pub(super) const IDENTITY: Affine =
        Affine([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// From 16 numbers, column by column. The last row must be 0 0 0 1 in glTF and is not looked at.
    pub(super) fn from_columns(m: &[f32; 16]) -> Affine {
        Affine([0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| f64::from(m[column * 4 + row]))))
    }

    /// `self` after `inner`.
    pub(super) fn after(&self, inner: &Affine) -> Affine {
        let (a, b) = (&self.0, &inner.0);
        Affine([0, 1, 2].map(|r| {
            [0, 1, 2, 3].map(|c| {
                let shift = if c == 3 { a[r][3] } else { 0.0 };
                a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c] + shift
            })
        }))
    }

    /// The image of a point.
    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        self.0.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3])
    }

    /// The image of a direction.
    pub(super) fn direction(&self, d: Vec3) -> Vec3 {
        self.0.map(|r| r[0] * d[0] + r[1] * d[1] + r[2] * d[2])
    }

    /// Where the origin goes.
    pub(super) fn origin(&self) -> Vec3 {
        self.0.map(|r| r[3])
    }

    /// The linear map of normals: the inverse transpose, up to a positive factor. It is the matrix of cofactors times
    /// the sign of the determinant, so that nothing is divided and flat objects are no problem.
    pub(super) fn normals(&self) -> [Vec3; 3] {
        let m = self.0.map(|r| [r[0], r[1], r[2]]);
        let cofactors = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
        let sign = if dot(m[0], cofactors[0]) < 0.0 { -1.0 } else { 1.0 };
        cofactors.map(|row| row.map(|v| v * sign))
    }

    /// Adds `weight` times `other`.
    pub(super) fn accumulate(&mut self, other: &Affine, weight: f64) {
        for (row, more) in self.0.iter_mut().zip(&other.0) {
            for (a, b) in row.iter_mut().zip(more) {
                *a += weight * b;
            }
        }
    }
}

impl Trs {
    pub(super) const IDENTITY: Trs =
        Trs { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };

    /// As a matrix. The quaternion need not be of unit length.
    pub(super) fn affine(&self) -> Affine {
        let [x, y, z, w] = unit_quaternion(self.rotation);
        let [sx, sy, sz] = self.scale;
        let [tx, ty, tz] = self.translation;
        Affine([
            [(1.0 - 2.0 * (y * y + z * z)) * sx, 2.0 * (x * y - w * z) * sy, 2.0 * (x * z + w * y) * sz, tx],
            [2.0 * (x * y + w * z) * sx, (1.0 - 2.0 * (x * x + z * z)) * sy, 2.0 * (y * z - w * x) * sz, ty],
            [2.0 * (x * z - w * y) * sx, 2.0 * (y * z + w * x) * sy, (1.0 - 2.0 * (x * x + y * y)) * sz, tz],
        ])
    }
}

/// The unit quaternion of that direction; no rotation if it has none.
fn unit_quaternion(q: [f64; 4]) -> [f64; 4] {
    let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { q.map(|v| v / length) } else { Trs::IDENTITY.rotation }
}

/// From rotation `a` to rotation `b` at constant speed, the short way.
pub(super) fn slerp(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
    let (a, b) = (unit_quaternion(a), unit_quaternion(b));
    let cosine: f64 = a.iter().zip(&b).map(|(x, y)| x * y).sum();
    let (cosine, sign) = if cosine < 0.0 { (-cosine, -1.0) } else { (cosine, 1.0) };
    // Nearly equal rotations: the sines below would be 0 / 0; a straight line is as good to 1e-12.
    let (u, v) = if cosine > 1.0 - 1e-12 {
        (1.0 - t, t)
    } else {
        let angle = cosine.acos();
        (((1.0 - t) * angle).sin() / angle.sin(), (t * angle).sin() / angle.sin())
    };
    [0, 1, 2, 3].map(|k| a[k] * u + b[k] * v * sign)
}

/// Applies a linear map.
pub(super) fn apply(m: &[Vec3; 3], v: Vec3) -> Vec3 {
    m.map(|row| dot(row, v))
}

/// The unit vector of that direction in `f32`; zero if it has none.
pub(super) fn unit(v: Vec3) -> [f32; 3] {
    // Scaled first: squares of tiny or huge components would leave the range of f64.
    let largest = v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let v = v.map(|x| x / largest);
    let length = dot(v, v).sqrt();
    if length.is_finite() && length > 0.0 { v.map(|x| (x / length) as f32) } else { [0.0; 3] }
}

pub(super) fn widen(v: [f32; 3]) -> Vec3 {
    v.map(f64::from)
}

pub(super) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let trs = Trs { rotation: [0.0, 0.0, half, half], scale: [2.0; 3], translation: [1.0, 0.0, 0.0] };
        let p = trs.affine().point([1.0, 0.0, 0.0]);
        assert!((p[0] - 1.0).abs() < 1e-12 && (p[1] - 2.0).abs() < 1e-12 && p[2] == 0.0, "{p:?}");
        assert_eq!(Trs::IDENTITY.affine(), Affine::IDENTITY);
    }

    #[test]
    fn normals_stay_perpendicular_under_shear_and_mirroring() {
        let shear = Affine([[-1.0, 2.0, 0.0, 5.0], [0.0, 3.0, 1.0, 0.0], [0.0, 0.0, 0.5, 0.0]]);
        // The plane x = y holds (1, 1, 0) and (0, 0, 1).
        let n = apply(&shear.normals(), [1.0, -1.0, 0.0]);
        assert!(dot(n, shear.direction([1.0, 1.0, 0.0])).abs() < 1e-12);
        assert!(dot(n, shear.direction([0.0, 0.0, 1.0])).abs() < 1e-12);
        // A side stays the same side.
        assert!(dot(n, shear.direction([1.0, -1.0, 0.0])) > 0.0);
    }

    #[test]
    fn slerp_goes_the_short_way_at_constant_speed() {
        let about_z = |angle: f64| [0.0, 0.0, (angle / 2.0).sin(), (angle / 2.0).cos()];
        let q = slerp(about_z(0.0), about_z(1.0).map(|v| -v), 0.25);
        let expected = about_z(0.25);
        assert!((0..4).all(|k| (q[k] - expected[k]).abs() < 1e-12), "{q:?}");
    }
}
