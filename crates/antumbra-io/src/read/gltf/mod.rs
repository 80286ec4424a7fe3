//! glTF 2.0, `.gltf` and `.glb`.
//!
//! [`open`] reads everything once: [`container`] splits the file and parses the JSON, [`source`] loads buffers and
//! keeps account of the memory, [`accessor`] reads typed arrays out of them, and [`nodes`], [`mesh`], [`skin`],
//! [`materials`], [`images`], [`view`] and [`animation`] turn what the file says into checked, plain data. Then
//! [`GltfFile::at`] takes the pose of a time, walks the nodes and puts the primitives into the world ([`place`]).
//!
//! Files are untrusted. Of the `gltf` crate only the types of the JSON are used: its iterators over accessors trust
//! offsets and counts. All indices are checked here, when they are followed for the first time.
//!
//! Left out: colours' alpha, emissive and all other textures beside base colour, directional lights, spot cones,
//! orthographic cameras, `KHR_animation_pointer`, compressed meshes.

mod accessor;
mod animation;
mod container;
mod images;
mod materials;
mod math;
mod mesh;
mod nodes;
mod place;
mod skin;
mod source;
mod uri;
mod view;

use std::path::{Path, PathBuf};

use antumbra::scene::{Material, Object, Scene, Soup, Texture};

use self::animation::{Animation, Pose};
use self::container::Container;
use self::materials::Materials;
use self::math::Affine;
use self::mesh::{Lowering, Mesh};
use self::nodes::{Node, Tree};
use self::place::{Carrier, Extra, Placed};
use self::skin::Skin;
use self::source::{MEMORY_LIMIT, Source};
use self::view::{Lamp, Lens};
use crate::Error;

/// Most triangles of a scene.
const MAX_TRIANGLES: u64 = 1 << 28;

/// Most steps (vertices times what is added up for each) that placing a scene may take: some ten seconds.
const MAX_WORK: u64 = 1 << 32;

/// A glTF file, decoded; [`GltfFile::at`] poses it.
#[derive(Debug)]
pub(super) struct GltfFile {
    path: PathBuf,
    tree: Tree,
    /// Empty ones where no shown node needs them.
    meshes: Vec<Mesh>,
    skins: Vec<Skin>,
    animation: Animation,
    lamps: Vec<Option<Lamp>>,
    lenses: Vec<Option<Lens>>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    /// Bytes held by all this.
    held: u64,
}

/// Reads and decodes a file.
pub(super) fn open(path: &Path) -> Result<GltfFile, Error> {
    let container = Container::read(path)?;
    let source = Source::load(path, &container)?;
    let tree = Tree::read(&source)?;
    let mut materials = Materials::read(&source)?;
    let mut lowering = Lowering::new(&source);
    let mut needed = vec![false; source.root.meshes.len()];
    tree.shown().filter_map(|(_, n)| n.mesh).for_each(|m| needed[m] = true);
    let mut meshes = Vec::new();
    for (index, needed) in needed.into_iter().enumerate() {
        meshes.push(if needed { lowering.mesh(index, &mut materials)? } else { Mesh::default() });
    }
    drop(lowering);
    let skins = (0..source.root.skins.len()).map(|i| Skin::read(&source, &tree, i));
    let skins = skins.collect::<Result<_, _>>()?;
    let targets = |mesh: usize| meshes[mesh].primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0);
    let animation = Animation::read(&source, &tree, targets)?;
    let textures = images::decode(&source, &materials.images)?;
    Ok(GltfFile {
        path: path.to_owned(),
        lamps: view::read_lamps(&source)?,
        lenses: view::read_lenses(&source)?,
        held: source.kept(&container),
        materials: materials.list,
        tree,
        meshes,
        skins,
        animation,
        textures,
    })
}

impl GltfFile {
    /// First and last key of all channels that are played.
    pub(super) fn time_span(&self) -> Option<[f32; 2]> {
        self.animation.time_span()
    }

    /// The scene at `time`, or in its rest pose: one object for each node with a mesh, in the order of the file.
    pub(super) fn at(&self, time: Option<f32>) -> Result<Scene, Error> {
        if time.is_some_and(f32::is_nan) {
            return Err(self.error("the time is not a number"));
        }
        let pose = self.animation.pose(&self.tree, time);
        let world = self.tree.world(&pose.locals);
        let mut scene = Scene {
            name: self.path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
            materials: self.materials.clone(),
            ..Scene::default()
        };
        self.place_meshes(&mut scene, &pose, &world)?;
        for (index, node) in self.tree.shown() {
            let (world, name, label) = (&world[index], &node.name, &node.label);
            if let Some(lamp) = node.light.and_then(|i| self.lamps[i].as_ref()) {
                scene.lights.push(lamp.at(world, name, label).map_err(|e| self.error(&e))?);
            }
            if let Some(lens) = node.camera.and_then(|i| self.lenses[i].as_ref()) {
                scene.cameras.push(lens.at(world, name, label).map_err(|e| self.error(&e))?);
            }
        }
        scene.textures = self.textures.clone();
        Ok(scene)
    }

    /// Nodes with a mesh.
    fn carriers(&self) -> impl Iterator<Item = (usize, &Node, &Mesh)> {
        self.tree.shown().filter_map(|(i, node)| Some((i, node, &self.meshes[node.mesh?])))
    }

    fn place_meshes(&self, scene: &mut Scene, pose: &Pose, world: &[Affine]) -> Result<(), Error> {
        let (triangles, extra) = self.check_size()?;
        let soup = &mut scene.soup;
        reserve(soup, triangles as usize, extra);
        let skins: Vec<Vec<Affine>> = self.skins.iter().map(|s| s.matrices(world)).collect();
        let mut placed = Placed::default();
        for (index, node, mesh) in self.carriers() {
            let object = scene.objects.len() as u32;
            let name = if node.name.is_empty() { format!("node {index}") } else { node.name.clone() };
            scene.objects.push(Object { name });
            let weights = pose.weights.get(&index).or(node.weights.as_ref()).unwrap_or(&mesh.weights);
            let mut place = |carrier: Carrier<'_>| {
                for primitive in &mesh.primitives {
                    placed.compute(primitive, &carrier, weights, extra.normals).map_err(|e| {
                        let (node, mesh, primitive) = (&node.label, &mesh.label, primitive.index);
                        self.error(&format!("{node}, {mesh}, primitive {primitive}, {e}"))
                    })?;
                    placed.emit(primitive, object, extra, soup);
                }
                Ok::<_, Error>(())
            };
            let own = world[index];
            match (node.skin, &node.instances) {
                (Some(skin), _) => place(Carrier::Skin(&skins[skin], own))?,
                (None, Some(instances)) => {
                    instances.iter().try_for_each(|i| place(Carrier::rigid(own.after(i))))?;
                }
                (None, None) => place(Carrier::rigid(own))?,
            }
        }
        Ok(())
    }

    /// Number of triangles and the arrays that they have. A few bytes can ask for any number of copies, so that
    /// memory and work are estimated before anything is allocated.
    fn check_size(&self) -> Result<(u64, Extra), Error> {
        let mut extra = Extra::default();
        let (mut triangles, mut work) = (0u64, 0u64);
        for (_, node, mesh) in self.carriers() {
            let copies = match (&node.skin, &node.instances) {
                (None, Some(instances)) => instances.len() as u64,
                _ => 1,
            };
            triangles = triangles.saturating_add(mesh.triangles().saturating_mul(copies));
            for p in &mesh.primitives {
                let steps =
                    1 + p.targets.len() + if node.skin.is_some() { 4 * p.influences.len() } else { 0 };
                let steps = p.positions.len().max(p.corners.len()) as u64 * steps as u64;
                work = work.saturating_add((steps + 1).saturating_mul(copies));
                extra.uvs |= p.uvs.is_some();
                extra.normals |= p.normals.is_some();
                extra.colors |= p.colors.is_some();
            }
        }
        let bytes = 36
            + 8
            + if extra.uvs { 24 } else { 0 }
            + if extra.normals { 36 } else { 0 }
            + if extra.colors { 36 } else { 0 };
        let textures: u64 = self.textures.iter().map(|t| t.pixels.len() as u64 * 4).sum();
        let memory = self.held.saturating_add(textures).saturating_add(triangles.saturating_mul(bytes));
        if triangles > MAX_TRIANGLES || memory > MEMORY_LIMIT {
            return Err(self.error(&format!(
                "{triangles} triangles (all copies counted) and {} textures need {} MiB; the limit is {} MiB and {MAX_TRIANGLES} triangles",
                self.textures.len(),
                memory >> 20,
                MEMORY_LIMIT >> 20
            )));
        }
        if work > MAX_WORK {
            return Err(self
                .error(&format!("the morph targets and skins of {triangles} triangles are too much work")));
        }
        Ok((triangles, extra))
    }

    fn error(&self, what: &str) -> Error {
        Error::content(&self.path, what)
    }
}

fn reserve(soup: &mut Soup, triangles: usize, extra: Extra) {
    soup.positions.reserve_exact(triangles);
    soup.object.reserve_exact(triangles);
    soup.material.reserve_exact(triangles);
    soup.uvs.reserve_exact(if extra.uvs { triangles } else { 0 });
    soup.normals.reserve_exact(if extra.normals { triangles } else { 0 });
    soup.colors.reserve_exact(if extra.colors { triangles } else { 0 });
}
