//! A file as parsed: what [`super::evaluate`] needs to make the scene at any time.

use std::path::PathBuf;

use antumbra::scene::{Material, Object, Texture, Triangle};

use super::affine::Affine;
use super::spline::{PointTrack, RotationTrack};

/// Most triangles, after including: 4 million take some 0.45 GB here and the same in the scene. The largest scene of
/// BART has 110,561.
pub(super) const MAX_TRIANGLES: usize = 1 << 22;
/// Most bytes of text parsed, files included twice counted twice: bounds the time and, at two bytes of text a number,
/// the memory to about double that.
pub(super) const MAX_TEXT: usize = 1 << 28;
/// Most includes in all; some 800 are in a scene of BART.
pub(super) const MAX_INCLUDES: usize = 100_000;
/// Deepest nesting of files.
pub(super) const MAX_INCLUDE_DEPTH: usize = 32;
/// Deepest nesting of braces.
pub(super) const MAX_BRACES: usize = 1024;
/// Most transforms, objects, lights, materials, animations: of each. A quarter of a million take below 0.1 GB.
pub(super) const MAX_PIECES: usize = 1 << 18;
/// Most key frames in all; the robots have some 10,000. A million take 0.15 GB.
pub(super) const MAX_KEYS: usize = 1 << 20;
/// Most pixels of all textures together: 0.13 GB here and the same in the scene.
pub(super) const MAX_PIXELS: usize = 1 << 25;

/// Everything, with times in seconds of the file's own clock.
#[derive(Debug, Default)]
pub(super) struct Model {
    pub(super) path: PathBuf,
    pub(super) name: String,
    /// Parents stand before their children; the first is the world.
    pub(super) nodes: Vec<Node>,
    pub(super) animations: Vec<Animation>,
    pub(super) runs: Vec<Run>,
    pub(super) faces: Faces,
    pub(super) morphs: Vec<Morph>,
    pub(super) morph_keys: Vec<MorphKey>,
    pub(super) objects: Vec<Object>,
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    pub(super) lights: Vec<Light>,
    pub(super) view: Option<View>,
    /// Index of the animation named `camera`.
    pub(super) camera_animation: Option<u32>,
    /// Start and end as `a` says.
    pub(super) span: Option<[f64; 2]>,
}

impl Model {
    /// Start and end of the animation: by `a`, else of all keys, else 0.
    pub(super) fn clock(&self) -> [f64; 2] {
        if let Some(span) = self.span {
            return span;
        }
        let animations = self.animations.iter().flat_map(Animation::times);
        let times = animations.chain(self.morph_keys.iter().map(|k| f64::from(k.time)));
        times
            .fold(None, |span: Option<[f64; 2]>, t| {
                Some(span.map_or([t, t], |[lo, hi]| [lo.min(t), hi.max(t)]))
            })
            .unwrap_or([0.0, 0.0])
    }

    /// True if two times may give two scenes.
    pub(super) fn moves(&self) -> bool {
        let used =
            |index: Option<u32>| index.is_some_and(|i| self.animations[i as usize].times().next().is_some());
        self.nodes.iter().any(|node| matches!(node.motion, Motion::Animated(i) if used(Some(i))))
            || self.lights.iter().any(|light| used(light.animation))
            || (self.view.is_some() && used(self.camera_animation))
            || self.morphs.iter().any(|morph| morph.count > 1)
    }
}

/// A transform: all in it is in its own coordinates.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) parent: u32,
    pub(super) motion: Motion,
}

#[derive(Debug)]
pub(super) enum Motion {
    Fixed(Affine),
    /// Index into [`Model::animations`].
    Animated(u32),
}

/// The key frames of one name; all empty if the file has none.
#[derive(Debug, Default)]
pub(super) struct Animation {
    pub(super) translation: Option<PointTrack>,
    pub(super) rotation: Option<RotationTrack>,
    pub(super) scale: Option<PointTrack>,
    /// From each time on: to be seen or not. Before the first: to be seen.
    pub(super) visibility: Vec<(f64, bool)>,
}

impl Animation {
    /// Times between which something may move.
    fn times(&self) -> impl Iterator<Item = f64> {
        let points = [&self.translation, &self.scale].into_iter().flatten().filter_map(PointTrack::span);
        let rotation = self.rotation.as_ref().and_then(RotationTrack::span);
        points.chain(rotation).flatten().chain(self.visibility.iter().map(|&(time, _)| time))
    }

    pub(super) fn visible_at(&self, time: f64) -> bool {
        self.visibility.iter().rev().find(|&&(from, _)| from <= time).is_none_or(|&(_, visible)| visible)
    }
}

/// Triangles that follow each other in one transform and one object.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) node: u32,
    pub(super) object: u32,
    pub(super) source: Source,
    pub(super) first: usize,
    pub(super) count: usize,
}

/// Where a [`Run`] has its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// [`Model::faces`].
    Faces,
    /// [`Model::morphs`].
    Morphs,
}

/// Triangles in parallel arrays, in the coordinates of their transform.
#[derive(Debug, Default)]
pub(super) struct Faces {
    pub(super) positions: Vec<Triangle>,
    pub(super) normals: Vec<[[f32; 3]; 3]>,
    pub(super) uvs: Vec<[[f32; 2]; 3]>,
    pub(super) material: Vec<u32>,
}

impl Faces {
    pub(super) fn push(&mut self, corners: [Corner; 3], material: u32) {
        self.positions.push(corners.map(|c| c.position));
        self.normals.push(corners.map(|c| c.normal));
        self.uvs.push(corners.map(|c| c.uv));
        self.material.push(material);
    }
}

/// A corner of a triangle; a zero normal means "use the geometric one".
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) uv: [f32; 2],
}

/// A triangle whose corners move: `count` keys from `first` on, in [`Model::morph_keys`].
#[derive(Debug)]
pub(super) struct Morph {
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) material: u32,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct MorphKey {
    pub(super) time: f32,
    pub(super) positions: Triangle,
    pub(super) normals: [[f32; 3]; 3],
}

#[derive(Debug)]
pub(super) struct Light {
    pub(super) name: String,
    pub(super) position: [f32; 3],
    pub(super) color: [f32; 3],
    pub(super) node: u32,
    /// Index into [`Model::animations`]: its translation replaces `position`.
    pub(super) animation: Option<u32>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) from: [f64; 3],
    pub(super) at: [f64; 3],
    pub(super) up: [f64; 3],
    /// Vertical, degrees.
    pub(super) angle: f32,
}
