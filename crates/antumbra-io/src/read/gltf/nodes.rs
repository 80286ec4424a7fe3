//! The tree of nodes: checked once, then walked without recursion.

use gltf::json::Value;
use gltf::json::scene::Node as JsonNode;

use super::math::{Affine, Trs, widen};
use super::source::{Source, label};
use crate::Error;

/// How a node stands to its parent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Local {
    Matrix(Affine),
    Trs(Trs),
}

/// A node. Indices are checked.
#[derive(Debug)]
pub(super) struct Node {
    /// The name of the file, maybe empty.
    pub(super) name: String,
    /// `node 3 'lamp'`, for messages.
    pub(super) label: String,
    parent: Option<usize>,
    pub(super) local: Local,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) camera: Option<usize>,
    pub(super) light: Option<usize>,
    pub(super) weights: Option<Vec<f32>>,
    /// Copies of the mesh, relative to the node (`EXT_mesh_gpu_instancing`).
    pub(super) instances: Option<Vec<Affine>>,
    /// Part of the scene that is shown.
    pub(super) shown: bool,
}

/// All nodes of a file.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    /// All nodes, parents before children.
    order: Vec<usize>,
}

impl Tree {
    /// Checks that the nodes form trees, and marks those of the default scene, else of the first one, else all.
    pub(super) fn read(source: &Source<'_>) -> Result<Tree, Error> {
        let json = &source.root.nodes;
        let nodes = json.iter().enumerate().map(|(i, n)| read_node(source, i, n));
        let mut nodes = nodes.collect::<Result<Vec<_>, _>>()?;
        for (index, node) in json.iter().enumerate() {
            for child in children(node) {
                source.item(json, child, "child", &nodes[index].label)?;
                if let Some(other) = nodes[child].parent.replace(index) {
                    let (child, a, b) = (&nodes[child].label, &nodes[other].label, &nodes[index].label);
                    return Err(
                        source.error(format!("{child} is a child of {a} and of {b}: one parent is allowed"))
                    );
                }
            }
        }
        let mut order: Vec<usize> = (0..nodes.len()).filter(|&i| nodes[i].parent.is_none()).collect();
        let mut next = 0;
        while let Some(&index) = order.get(next) {
            order.extend(children(&json[index]));
            next += 1;
        }
        if order.len() < nodes.len() {
            // Every node has at most one parent, so that what no root reaches is in or below a cycle.
            let mut reached = vec![false; nodes.len()];
            order.iter().for_each(|&i| reached[i] = true);
            let lost = reached.iter().position(|&r| !r).unwrap_or(0);
            return Err(
                source.error(format!("{} is below itself: the nodes form a cycle", nodes[lost].label))
            );
        }
        let roots = match (source.root.scene, source.root.scenes.first()) {
            (Some(scene), _) => {
                Some(source.item(&source.root.scenes, scene.value(), "scene", "default scene")?)
            }
            (None, first) => first,
        };
        match roots {
            None => nodes.iter_mut().for_each(|n| n.shown = true),
            Some(scene) => {
                for root in &scene.nodes {
                    source.item(json, root.value(), "node", "scene")?;
                    nodes[root.value()].shown = true;
                }
                for &index in &order {
                    if let Some(parent) = nodes[index].parent {
                        nodes[index].shown |= nodes[parent].shown;
                    }
                }
            }
        }
        Ok(Tree { nodes, order })
    }

    /// World matrices of all nodes, given how each stands to its parent.
    pub(super) fn world(&self, locals: &[Local]) -> Vec<Affine> {
        let mut world = vec![Affine::IDENTITY; self.nodes.len()];
        for &index in &self.order {
            let local = match &locals[index] {
                Local::Matrix(matrix) => *matrix,
                Local::Trs(trs) => trs.affine(),
            };
            world[index] = match self.nodes[index].parent {
                Some(parent) => world[parent].after(&local),
                None => local,
            };
        }
        world
    }

    /// Nodes of the shown scene, in the order of the file.
    pub(super) fn shown(&self) -> impl Iterator<Item = (usize, &Node)> {
        self.nodes.iter().enumerate().filter(|(_, n)| n.shown)
    }
}

fn children(node: &JsonNode) -> impl Iterator<Item = usize> {
    node.children.iter().flatten().map(gltf::json::Index::value)
}

fn read_node(source: &Source<'_>, index: usize, json: &JsonNode) -> Result<Node, Error> {
    let root = source.root;
    let name = label("node", index, json.name.as_deref());
    let mesh = json.mesh.map(|i| i.value());
    let skin = json.skin.map(|i| i.value());
    let camera = json.camera.map(|i| i.value());
    let extensions = json.extensions.as_ref();
    let light = extensions.and_then(|e| e.khr_lights_punctual.as_ref()).map(|l| l.light.value());
    if let Some(mesh) = mesh {
        source.item(&root.meshes, mesh, "mesh", &name)?;
    }
    if let Some(skin) = skin {
        source.item(&root.skins, skin, "skin", &name)?;
    }
    if let Some(camera) = camera {
        source.item(&root.cameras, camera, "camera", &name)?;
    }
    if let Some(light) = light {
        let lights = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        source.item(lights.map_or(&[], |l| l.lights.as_slice()), light, "light", &name)?;
    }
    let instancing = extensions.and_then(|e| e.others.get("EXT_mesh_gpu_instancing"));
    let instances = match (instancing, mesh) {
        (Some(value), Some(_)) => Some(read_instances(source, &name, value)?),
        _ => None,
    };
    let local = match &json.matrix {
        Some(matrix) => Local::Matrix(Affine::from_columns(matrix)),
        None => Local::Trs(Trs {
            translation: json.translation.map_or(Trs::IDENTITY.translation, widen),
            rotation: json.rotation.map_or(Trs::IDENTITY.rotation, |q| q.0.map(f64::from)),
            scale: json.scale.map_or(Trs::IDENTITY.scale, widen),
        }),
    };
    Ok(Node {
        name: json.name.clone().unwrap_or_default(),
        label: name,
        parent: None,
        local,
        mesh,
        skin,
        camera,
        light,
        weights: json.weights.clone(),
        instances,
        shown: false,
    })
}

/// `EXT_mesh_gpu_instancing`: accessors of translations, rotations and scales, each of which may be missing.
fn read_instances(source: &Source<'_>, node: &str, value: &Value) -> Result<Vec<Affine>, Error> {
    let user = format!("{node}, EXT_mesh_gpu_instancing");
    let attribute = |name: &str| {
        let value = value.get("attributes")?.get(name)?;
        // What is no index is out of range.
        Some(value.as_u64().and_then(|i| usize::try_from(i).ok()).unwrap_or(usize::MAX))
    };
    let translations = attribute("TRANSLATION").map(|a| source.floats::<3>(a, &user)).transpose()?;
    let rotations = attribute("ROTATION").map(|a| source.floats::<4>(a, &user)).transpose()?;
    let scales = attribute("SCALE").map(|a| source.floats::<3>(a, &user)).transpose()?;
    let counts = [
        translations.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
    ];
    let mut given = counts.iter().flatten();
    let Some(&count) = given.next() else { return Ok(vec![Affine::IDENTITY]) };
    if let Some(&other) = given.find(|&&n| n != count) {
        return Err(source.error(format!("{user}: attributes have {count} and {other} entries")));
    }
    source.charge(count as u64, size_of::<Affine>(), &user)?;
    let instance = |i: usize| {
        let trs = Trs {
            translation: translations.as_ref().map_or(Trs::IDENTITY.translation, |v| widen(v[i])),
            rotation: rotations.as_ref().map_or(Trs::IDENTITY.rotation, |v| v[i].map(f64::from)),
            scale: scales.as_ref().map_or(Trs::IDENTITY.scale, |v| widen(v[i])),
        };
        trs.affine()
    };
    Ok((0..count).map(instance).collect())
}
