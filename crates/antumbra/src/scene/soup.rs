//! Triangles in world space, in any order, with no connectivity.

/// Three corners, world space. Both sides block light; the order of the corners does not matter to shadows.
pub type Triangle = [[f32; 3]; 3];

/// Something in the input that cannot be meant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InputError {
    /// A coordinate of a triangle is NaN or infinite.
    #[error("triangle {triangle}, vertex {vertex}: {value} is not a finite number")]
    Vertex {
        /// Index of the triangle.
        triangle: usize,
        /// 0, 1 or 2.
        vertex: usize,
        /// The offending value as text.
        value: String,
    },
    /// A number of something else is NaN or infinite.
    #[error("{what} {index}: not a finite number")]
    NotFinite {
        /// What it is, e.g. "light".
        what: &'static str,
        /// Its index.
        index: usize,
    },
    /// An index points past the end.
    #[error("{what} {index}: index {value} out of range (there are {len})")]
    Index {
        /// What holds the index.
        what: &'static str,
        /// Its own index.
        index: usize,
        /// The index that it holds.
        value: usize,
        /// How many there are.
        len: usize,
    },
    /// Two arrays that belong together differ in length.
    #[error("{what}: {got} entries where {expected} were expected")]
    Length {
        /// What array.
        what: &'static str,
        /// Its length.
        got: usize,
        /// The length that would be right.
        expected: usize,
    },
    /// More triangles or samples than a `u32` can count.
    #[error("{what}: {got} is more than the {limit} that are supported")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many came.
        got: usize,
        /// How many may come.
        limit: usize,
    },
}

/// A named group of triangles: a node of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Object {
    /// Name in the file, or a made-up one such as `mesh 3`.
    pub name: String,
}

/// Triangles and what hangs on them, in parallel arrays.
///
/// `positions`, `object` and `material` have one entry a triangle. `uvs`, `normals` and `colors` are either empty or
/// have one entry a triangle.
#[derive(Clone, Debug, Default)]
pub struct Soup {
    /// Corners in world space. The only part that shadows depend on.
    pub positions: Vec<Triangle>,
    /// Index into [`super::Scene::objects`].
    pub object: Vec<u32>,
    /// Index into [`super::Scene::materials`].
    pub material: Vec<u32>,
    /// Texture coordinates of the corners (v down, as in glTF), or empty.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// Shading normals of the corners (world space, about unit length; a zero vector means "use the geometric one"), or empty.
    pub normals: Vec<[[f32; 3]; 3]>,
    /// Linear colours of the corners, multiplied with the base colour, or empty.
    pub colors: Vec<[[f32; 3]; 3]>,
}

impl Soup {
    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// True if there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Smallest and largest coordinates; `None` if empty.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        let mut points = self.positions.iter().flatten();
        let first = *points.next()?;
        Some(points.fold((first, first), |(mut lo, mut hi), p| {
            for k in 0..3 {
                lo[k] = lo[k].min(p[k]);
                hi[k] = hi[k].max(p[k]);
            }
            (lo, hi)
        }))
    }

    /// Checks lengths, indices and that every coordinate is finite.
    ///
    /// # Errors
    /// [`InputError`] names the first offender.
    pub fn validate(&self, objects: usize, materials: usize) -> Result<(), InputError> {
        let n = self.len();
        let optional = |len: usize| if len == 0 { n } else { len };
        for (what, got) in [
            ("object ids", self.object.len()),
            ("material ids", self.material.len()),
            ("texture coordinates", optional(self.uvs.len())),
            ("normals", optional(self.normals.len())),
            ("colours", optional(self.colors.len())),
        ] {
            if got != n {
                return Err(InputError::Length { what, got, expected: n });
            }
        }
        check_triangles(&self.positions)?;
        for (what, ids, len) in [
            ("object of triangle", &self.object, objects),
            ("material of triangle", &self.material, materials),
        ] {
            if let Some(index) = ids.iter().position(|&id| id as usize >= len) {
                return Err(InputError::Index { what, index, value: ids[index] as usize, len });
            }
        }
        Ok(())
    }
}

/// Checks that every coordinate is finite and that `u32` can count the triangles.
///
/// # Errors
/// [`InputError`] names the first triangle and vertex.
pub fn check_triangles(triangles: &[Triangle]) -> Result<(), InputError> {
    let limit = u32::MAX as usize - 1;
    if triangles.len() > limit {
        return Err(InputError::TooMany { what: "triangles", got: triangles.len(), limit });
    }
    // A sum of absolute values is finite only if all are (or it overflows: then look closer).
    let bad = |t: &Triangle| !t.as_flattened().iter().all(|v| v.is_finite());
    if let Some(triangle) = triangles.iter().position(bad) {
        let t = triangles[triangle];
        let vertex = t.iter().position(|v| !v.iter().all(|x| x.is_finite())).unwrap_or(0);
        return Err(InputError::Vertex { triangle, vertex, value: format!("{:?}", t[vertex]) });
    }
    Ok(())
}
