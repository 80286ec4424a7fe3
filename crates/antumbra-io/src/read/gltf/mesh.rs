//! Meshes as plain arrays in their own space, decoded once.

use std::collections::BTreeMap;
use std::sync::Arc;

use gltf::json::mesh::{Mode, Primitive as JsonPrimitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::same_length;
use super::materials::{Materials, UvSource};
use super::source::{Source, label};
use crate::Error;

/// Arrays of the file are shared by all primitives that use them.
type Shared<T> = Arc<Vec<T>>;

/// A mesh: only primitives with triangles are kept.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    /// `mesh 3 'wall'`, for messages.
    pub(super) label: String,
    pub(super) primitives: Vec<Primitive>,
    /// Weights of morph targets if the node has none.
    pub(super) weights: Vec<f32>,
}

/// Triangles of one material.
#[derive(Debug)]
pub(super) struct Primitive {
    /// Its index in the mesh.
    pub(super) index: usize,
    /// Index into the materials of the scene.
    pub(super) material: u32,
    /// Vertex of the file for each corner, three a triangle.
    pub(super) corners: Vec<u32>,
    /// True if the arrays have one entry a corner, false if they have one a vertex of the file. Many primitives may
    /// use a few vertices each of one large array: then the few are picked out.
    pub(super) gathered: bool,
    pub(super) positions: Shared<[f32; 3]>,
    pub(super) normals: Option<Shared<[f32; 3]>>,
    pub(super) uvs: Option<Shared<[f32; 2]>>,
    pub(super) colors: Option<Shared<[f32; 3]>>,
    /// Sets of four joints and their weights, a vertex each.
    pub(super) influences: Vec<(Shared<[u32; 4]>, Shared<[f32; 4]>)>,
    pub(super) targets: Vec<Target>,
}

/// A morph target: what is added.
#[derive(Debug)]
pub(super) struct Target {
    pub(super) positions: Option<Shared<[f32; 3]>>,
    pub(super) normals: Option<Shared<[f32; 3]>>,
}

impl Mesh {
    /// Number of triangles.
    pub(super) fn triangles(&self) -> u64 {
        self.primitives.iter().map(|p| p.corners.len() as u64 / 3).sum()
    }
}

impl Primitive {
    /// Where a corner's data stands in the arrays.
    pub(super) fn place(&self, corner: usize) -> usize {
        if self.gathered { corner } else { self.corners[corner] as usize }
    }
}

/// Decodes meshes; remembers what it decoded.
pub(super) struct Lowering<'s, 'a> {
    source: &'s Source<'a>,
    vec3: BTreeMap<usize, Shared<[f32; 3]>>,
    uvs: BTreeMap<(usize, usize), Shared<[f32; 2]>>,
    colors: BTreeMap<usize, Shared<[f32; 3]>>,
    joints: BTreeMap<usize, Shared<[u32; 4]>>,
    weights: BTreeMap<usize, Shared<[f32; 4]>>,
}

impl<'s, 'a> Lowering<'s, 'a> {
    pub(super) fn new(source: &'s Source<'a>) -> Self {
        Lowering {
            source,
            vec3: BTreeMap::new(),
            uvs: BTreeMap::new(),
            colors: BTreeMap::new(),
            joints: BTreeMap::new(),
            weights: BTreeMap::new(),
        }
    }

    /// Decodes mesh `index`.
    pub(super) fn mesh(&mut self, index: usize, materials: &mut Materials) -> Result<Mesh, Error> {
        let json = &self.source.root.meshes[index];
        let name = label("mesh", index, json.name.as_deref());
        let mut primitives = Vec::new();
        for (p, primitive) in json.primitives.iter().enumerate() {
            let user = format!("{name}, primitive {p}");
            primitives.extend(self.primitive(p, primitive, &user, materials)?);
        }
        Ok(Mesh { label: name, primitives, weights: json.weights.clone().unwrap_or_default() })
    }

    /// `None` if it has no triangles: points, lines, or no positions.
    fn primitive(
        &mut self,
        index: usize,
        json: &JsonPrimitive,
        user: &str,
        materials: &mut Materials,
    ) -> Result<Option<Primitive>, Error> {
        let source = self.source;
        let mode = source.known(&json.mode, "mode", user)?;
        let attribute = |s| json.attributes.get(&Checked::Valid(s)).map(|i| i.value());
        let triangles = matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan);
        let Some(positions) = attribute(Semantic::Positions).filter(|_| triangles) else { return Ok(None) };

        let positions = cached(&mut self.vec3, positions, || source.floats(positions, user))?;
        let vertices = positions.len();
        let corners = self.corners(json, mode, vertices, user)?;
        let gathered = vertices > corners.len();
        let mut fit = Fit { source, user, vertices, corners: gathered.then_some(&corners) };

        let (material, uv_source) = materials.of_primitive(json.material.map(|m| m.value()), source, user)?;
        let normals = match attribute(Semantic::Normals) {
            Some(a) => Some(fit.fit("NORMAL", cached(&mut self.vec3, a, || source.floats(a, user))?)?),
            None => None,
        };
        let uvs = match attribute(Semantic::TexCoords(uv_source.set)) {
            Some(a) => {
                let key = (a, uv_source.transform.map_or(usize::MAX, |_| material as usize));
                let read = || read_uvs(source, a, &uv_source, user);
                Some(fit.fit("TEXCOORD", cached(&mut self.uvs, key, read)?)?)
            }
            None => None,
        };
        let colors = match attribute(Semantic::Colors(0)) {
            Some(a) => {
                Some(fit.fit("COLOR_0", cached(&mut self.colors, a, || read_colors(source, a, user))?)?)
            }
            None => None,
        };
        let mut influences = Vec::new();
        for set in 0.. {
            let pair = attribute(Semantic::Joints(set)).zip(attribute(Semantic::Weights(set)));
            let Some((joints, weights)) = pair else { break };
            let joints = cached(&mut self.joints, joints, || source.integers(joints, user))?;
            let weights = cached(&mut self.weights, weights, || source.floats(weights, user))?;
            influences.push((fit.fit("JOINTS", joints)?, fit.fit("WEIGHTS", weights)?));
        }
        let mut targets = Vec::new();
        for (t, target) in json.targets.iter().flatten().enumerate() {
            let user = format!("{user}, morph target {t}");
            let mut fit = Fit { user: &user, ..fit };
            let mut read = |index: Option<usize>, what| {
                let Some(index) = index else { return Ok(None) };
                let values = cached(&mut self.vec3, index, || source.floats(index, &user))?;
                fit.fit(what, values).map(Some)
            };
            targets.push(Target {
                positions: read(target.positions.map(|i| i.value()), "POSITION")?,
                normals: read(target.normals.map(|i| i.value()), "NORMAL")?,
            });
        }
        let positions = fit.fit("POSITION", positions)?;
        Ok(Some(Primitive {
            index,
            material,
            gathered,
            positions,
            normals,
            uvs,
            colors,
            influences,
            targets,
            corners,
        }))
    }

    /// The vertices of all triangles. An incomplete triangle at the end of a list is left out, as every renderer does.
    fn corners(
        &self,
        json: &JsonPrimitive,
        mode: Mode,
        vertices: usize,
        user: &str,
    ) -> Result<Vec<u32>, Error> {
        let source = self.source;
        let indices = match json.indices {
            Some(accessor) => {
                let indices: Vec<[u32; 1]> = source.integers(accessor.value(), user)?;
                if let Some(bad) = indices.iter().find(|i| i[0] as usize >= vertices) {
                    let what =
                        format!("{user}: index {} out of range (there are {vertices} vertices)", bad[0]);
                    return Err(source.error(what));
                }
                Some(indices)
            }
            None => None,
        };
        let n = indices.as_ref().map_or(vertices, Vec::len);
        let count = match mode {
            Mode::Triangles => n / 3,
            _ => n.saturating_sub(2),
        };
        source.charge(count as u64 * 3, 4, user)?;
        // Vertices without indices are counted by `u32` too: they were booked, and 2^32 of them do not fit the limit.
        let vertex = |i: usize| indices.as_ref().map_or(i as u32, |list| list[i][0]);
        let mut corners = Vec::with_capacity(count * 3);
        for t in 0..count {
            corners.extend(match mode {
                Mode::TriangleFan => [0, t + 1, t + 2].map(vertex),
                // Every other triangle of a strip is turned over, so that all face the same way.
                Mode::TriangleStrip => [t, t + 1 + t % 2, t + 2 - t % 2].map(vertex),
                _ => [t * 3, t * 3 + 1, t * 3 + 2].map(vertex),
            });
        }
        source.release(indices.map_or(0, |list| list.len() as u64 * 4));
        Ok(corners)
    }
}

/// Checks the length of an array, and picks the corners out of it where only a few are used.
#[derive(Clone, Copy)]
struct Fit<'f, 'a> {
    source: &'f Source<'a>,
    user: &'f str,
    vertices: usize,
    corners: Option<&'f [u32]>,
}

impl Fit<'_, '_> {
    fn fit<T: Copy>(&mut self, what: &str, all: Shared<T>) -> Result<Shared<T>, Error> {
        same_length(self.source, self.user, what, all.len(), self.vertices)?;
        let Some(corners) = self.corners else { return Ok(all) };
        self.source.charge(corners.len() as u64, size_of::<T>(), self.user)?;
        Ok(Arc::new(corners.iter().map(|&i| all[i as usize]).collect()))
    }
}

fn cached<K: Ord, T>(
    cache: &mut BTreeMap<K, Shared<T>>,
    key: K,
    read: impl FnOnce() -> Result<Vec<T>, Error>,
) -> Result<Shared<T>, Error> {
    if let Some(found) = cache.get(&key) {
        return Ok(found.clone());
    }
    let values = Arc::new(read()?);
    cache.insert(key, values.clone());
    Ok(values)
}

/// Texture coordinates with `KHR_texture_transform` applied. What is not finite becomes 0: it shows, but harms nothing.
fn read_uvs(
    source: &Source<'_>,
    accessor: usize,
    from: &UvSource,
    user: &str,
) -> Result<Vec<[f32; 2]>, Error> {
    let mut uvs = source.floats::<2>(accessor, user)?;
    for uv in &mut uvs {
        if let Some(rows) = &from.transform {
            let [u, v] = uv.map(f64::from);
            *uv = rows.map(|r| (r[0] * u + r[1] * v + r[2]) as f32);
        }
        *uv = uv.map(|x| if x.is_finite() { x } else { 0.0 });
    }
    Ok(uvs)
}

/// Colours without their alpha, which our triangles do not have.
fn read_colors(source: &Source<'_>, accessor: usize, user: &str) -> Result<Vec<[f32; 3]>, Error> {
    let flat = source.scalars(accessor, &[3, 4], user)?;
    let colors = flat.values.chunks_exact(flat.width);
    source.charge(colors.len() as u64, 12, user)?;
    let finite = |x: f32| if x.is_finite() { x } else { 1.0 };
    Ok(colors.map(|c| [c[0], c[1], c[2]].map(finite)).collect())
}
