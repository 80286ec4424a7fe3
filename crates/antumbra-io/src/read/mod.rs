//! Readers, one a format.

pub mod npy;

mod aff;
mod gltf;
mod mesh;
mod obj;
mod ply;
mod stl;

use std::path::Path;

use antumbra::scene::Scene;

use crate::Error;

const KNOWN: &str = ".glb .gltf .obj .ply .stl .aff .npy";

/// A scene file, parsed once; [`SceneFile::at`] evaluates its animation.
#[derive(Debug)]
pub struct SceneFile(Kind);

#[derive(Debug)]
enum Kind {
    Static(Box<Scene>),
    Gltf(Box<gltf::GltfFile>),
    Aff(Box<aff::AffFile>),
}

/// Reads a scene file by its ending: `.glb .gltf .obj .ply .stl .aff`, or `.npy` with triangles.
///
/// # Errors
/// [`Error`] names the file and what in it cannot be meant.
pub fn open(path: &Path) -> Result<SceneFile, Error> {
    std::fs::metadata(path).map_err(|e| Error::io(path, e))?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let kind = match extension.as_str() {
        "glb" | "gltf" => Kind::Gltf(Box::new(gltf::open(path)?)),
        "aff" => Kind::Aff(Box::new(aff::open(path)?)),
        "obj" => Kind::Static(Box::new(obj::open(path)?)),
        "ply" => Kind::Static(Box::new(ply::open(path)?)),
        "stl" => Kind::Static(Box::new(stl::open(path)?)),
        "npy" => Kind::Static(Box::new(npy::open_scene(path)?)),
        _ => return Err(Error::Type { path: path.to_owned(), extension, known: KNOWN }),
    };
    Ok(SceneFile(kind))
}

impl SceneFile {
    /// The scene at `time` seconds (of the file's first animation; clamped to its span). `None` is the rest pose, or
    /// the start of the animation where the format has no rest pose.
    ///
    /// # Errors
    /// [`Error`] if something cannot be meant, e.g. an index out of range.
    pub fn at(&self, time: Option<f32>) -> Result<Scene, Error> {
        match &self.0 {
            Kind::Static(scene) => Ok((**scene).clone()),
            Kind::Gltf(file) => file.at(time),
            Kind::Aff(file) => file.at(time),
        }
    }

    /// Start and end of the animation in seconds, `None` if nothing moves.
    pub fn time_span(&self) -> Option<[f32; 2]> {
        match &self.0 {
            Kind::Static(_) => None,
            Kind::Gltf(file) => file.time_span(),
            Kind::Aff(file) => file.time_span(),
        }
    }
}
