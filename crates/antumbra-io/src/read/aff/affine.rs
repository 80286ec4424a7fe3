//! Affine maps and the quaternions that turn them, in double precision: products of a dozen nested transforms should
//! not cost a bit of the `f32` that comes out.

/// `x ↦ A x + b`: three rows `[a0 a1 a2 b]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine(pub(super) [[f64; 4]; 3]);

impl Affine {
    pub(super) const IDENTITY: Affine =
        Affine([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// Scales first, then turns, then moves: the order `T * R * S` of the format.
    pub(super) fn from_parts(translation: [f64; 3], rotation: Quaternion, scale: [f64; 3]) -> Affine {
        let turn = rotation.matrix();
        Affine([0, 1, 2].map(|row| {
            let [a, b, c] = turn[row];
            [a * scale[0], b * scale[1], c * scale[2], translation[row]]
        }))
    }

    /// `inner` first, then `self`.
    pub(super) fn after(&self, inner: &Affine) -> Affine {
        Affine(self.0.map(|[a, b, c, d]| {
            let column = |k: usize| a * inner.0[0][k] + b * inner.0[1][k] + c * inner.0[2][k];
            [column(0), column(1), column(2), column(3) + d]
        }))
    }

    pub(super) fn point(&self, p: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = p.map(f64::from);
        self.0.map(|[a, b, c, d]| (a * x + b * y + c * z + d) as f32)
    }

    /// The map for normals, up to a positive factor: the inverse transpose times the absolute determinant. It needs no
    /// division, so a flat scale (determinant 0) still gives the normal of the plane all lies in.
    pub(super) fn normal_map(&self) -> [[f64; 3]; 3] {
        let row = |i: usize| [self.0[i][0], self.0[i][1], self.0[i][2]];
        let (a, b, c) = (row(0), row(1), row(2));
        let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
        let sign = if dot(a, cofactors[0]) < 0.0 { -1.0 } else { 1.0 };
        cofactors.map(|r| r.map(|v| v * sign))
    }
}

/// Maps a normal and makes it unit length. Zero ("use the geometric one") stays zero, as does what has no direction.
pub(super) fn map_normal(map: &[[f64; 3]; 3], n: [f32; 3]) -> [f32; 3] {
    if n == [0.0; 3] {
        return n;
    }
    let n = n.map(f64::from);
    unit(map.map(|row| dot(row, n))).map_or([0.0; 3], |v| v.map(|x| x as f32))
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The direction of `v`; `None` if it has none.
pub(super) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    let inverse = length.recip();
    // Also none if it is so short or long that its inverse is no number.
    (length > 0.0 && inverse > 0.0 && inverse.is_finite()).then(|| v.map(|x| x * inverse))
}

/// `[w, x, y, z]`, of about unit length where it stands for a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quaternion(pub(super) [f64; 4]);

impl Quaternion {
    pub(super) const IDENTITY: Quaternion = Quaternion([1.0, 0.0, 0.0, 0.0]);

    /// A turn about `axis`, whose length does not matter; an axis of no length turns nothing.
    pub(super) fn about(axis: [f64; 3], degrees: f64) -> Quaternion {
        let Some(axis) = unit(axis) else { return Quaternion::IDENTITY };
        let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
        Quaternion([cos, sin * axis[0], sin * axis[1], sin * axis[2]])
    }

    pub(super) fn dot(self, other: Quaternion) -> f64 {
        self.0.iter().zip(other.0).map(|(a, b)| a * b).sum()
    }

    pub(super) fn negated(self) -> Quaternion {
        Quaternion(self.0.map(|v| -v))
    }

    /// The inverse of a unit quaternion.
    pub(super) fn conjugate(self) -> Quaternion {
        let [w, x, y, z] = self.0;
        Quaternion([w, -x, -y, -z])
    }

    pub(super) fn times(self, other: Quaternion) -> Quaternion {
        let ([a, b, c, d], [w, x, y, z]) = (self.0, other.0);
        Quaternion([
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y + c * w + d * x - b * z,
            a * z + d * w + b * y - c * x,
        ])
    }

    /// A length of 1 again; nonsense becomes the identity.
    fn normalized(self) -> Quaternion {
        let length = self.dot(self).sqrt();
        if length > 0.0 && length.is_finite() {
            Quaternion(self.0.map(|v| v / length))
        } else {
            Quaternion::IDENTITY
        }
    }

    pub(super) fn matrix(self) -> [[f64; 3]; 3] {
        let [w, x, y, z] = self.normalized().0;
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}
