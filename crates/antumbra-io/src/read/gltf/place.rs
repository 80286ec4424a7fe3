//! Puts one primitive into the world: morphed, skinned or moved as a whole.

use antumbra::scene::Soup;

use super::math::{Affine, Vec3, apply, unit, widen};
use super::mesh::Primitive;

/// What carries the vertices into the world.
pub(super) enum Carrier<'a> {
    /// One matrix for all, with its linear map of normals.
    Rigid(Affine, [Vec3; 3]),
    /// Matrices of joints, and of the node itself for vertices that no joint carries.
    Skin(&'a [Affine], Affine),
}

impl Carrier<'_> {
    pub(super) fn rigid(matrix: Affine) -> Self {
        Carrier::Rigid(matrix, matrix.normals())
    }
}

/// Which optional arrays the scene has.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extra {
    pub(super) uvs: bool,
    pub(super) normals: bool,
    pub(super) colors: bool,
}

/// Vertices of one primitive in world space; kept between primitives for its memory.
#[derive(Default)]
pub(super) struct Placed {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Placed {
    /// Computes all vertices of `primitive`. An error fits behind its name and a comma.
    pub(super) fn compute(
        &mut self,
        primitive: &Primitive,
        carrier: &Carrier<'_>,
        weights: &[f32],
        with_normals: bool,
    ) -> Result<(), String> {
        self.positions.clear();
        self.normals.clear();
        let targets = primitive.targets.iter().zip(weights).filter(|(_, w)| **w != 0.0);
        let targets: Vec<_> = targets.map(|(t, &w)| (t, f64::from(w))).collect();
        let normals = primitive.normals.as_deref().filter(|_| with_normals);
        let mut finite = true;
        for (v, &position) in primitive.positions.iter().enumerate() {
            let (mut p, mut n) = (widen(position), normals.map_or([0.0; 3], |list| widen(list[v])));
            for (target, weight) in &targets {
                let add = |sum: &mut Vec3, list: &[[f32; 3]]| {
                    (0..3).for_each(|k| sum[k] += weight * f64::from(list[v][k]));
                };
                target.positions.iter().for_each(|list| add(&mut p, list));
                target.normals.iter().for_each(|list| add(&mut n, list));
            }
            let (p, n) = match carrier {
                Carrier::Rigid(matrix, of_normals) => (matrix.point(p), apply(of_normals, n)),
                Carrier::Skin(joints, own) => {
                    let matrix = blend(primitive, v, joints, own)?;
                    (matrix.point(p), if normals.is_some() { apply(&matrix.normals(), n) } else { n })
                }
            };
            let p = p.map(|x| x as f32);
            finite &= p.iter().all(|x| x.is_finite());
            self.positions.push(p);
            if normals.is_some() {
                self.normals.push(unit(n));
            }
        }
        if finite { Ok(()) } else { self.check(primitive) }
    }

    /// Names the first vertex of a triangle that is nowhere. Vertices of no triangle may be.
    fn check(&self, primitive: &Primitive) -> Result<(), String> {
        for (corner, vertex) in primitive.corners.iter().enumerate() {
            let p = self.positions[primitive.place(corner)];
            if !p.iter().all(|x| x.is_finite()) {
                return Err(format!("vertex {vertex}: its position {p:?} is not finite"));
            }
        }
        Ok(())
    }

    /// Adds the triangles to the soup.
    pub(super) fn emit(&self, primitive: &Primitive, object: u32, extra: Extra, soup: &mut Soup) {
        let count = primitive.corners.len() / 3;
        soup.positions.extend((0..count).map(|t| triangle(primitive, t, &self.positions)));
        soup.object.resize(soup.positions.len(), object);
        soup.material.resize(soup.positions.len(), primitive.material);
        if extra.normals {
            match primitive.normals {
                Some(_) => soup.normals.extend((0..count).map(|t| triangle(primitive, t, &self.normals))),
                None => soup.normals.resize(soup.positions.len(), [[0.0; 3]; 3]),
            }
        }
        if extra.uvs {
            match &primitive.uvs {
                Some(uvs) => soup.uvs.extend((0..count).map(|t| triangle(primitive, t, uvs))),
                None => soup.uvs.resize(soup.positions.len(), [[0.0; 2]; 3]),
            }
        }
        if extra.colors {
            match &primitive.colors {
                Some(colors) => soup.colors.extend((0..count).map(|t| triangle(primitive, t, colors))),
                None => soup.colors.resize(soup.positions.len(), [[1.0; 3]; 3]),
            }
        }
    }
}

fn triangle<T: Copy>(primitive: &Primitive, t: usize, list: &[T]) -> [T; 3] {
    [0, 1, 2].map(|k| list[primitive.place(t * 3 + k)])
}

/// The weighted mean of the matrices that carry a vertex. Weights are divided by their sum: stored as small integers,
/// they often miss 1 by a little.
fn blend(primitive: &Primitive, vertex: usize, joints: &[Affine], own: &Affine) -> Result<Affine, String> {
    let mut sum = 0.0;
    let mut matrix = Affine([[0.0; 4]; 3]);
    for (ids, weights) in &primitive.influences {
        for (&joint, &weight) in ids[vertex].iter().zip(&weights[vertex]) {
            // Unused slots may name any joint.
            if weight != 0.0 {
                let carried_by = joints.get(joint as usize).ok_or_else(|| {
                    let vertex = if primitive.gathered { primitive.corners[vertex] } else { vertex as u32 };
                    format!("vertex {vertex}: joint {joint} out of range (there are {})", joints.len())
                })?;
                matrix.accumulate(carried_by, f64::from(weight));
                sum += f64::from(weight);
            }
        }
    }
    if sum == 0.0 {
        return Ok(*own);
    }
    Ok(Affine(matrix.0.map(|row| row.map(|v| v / sum))))
}
