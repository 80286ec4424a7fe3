//! From a definition to arrays: the scene is read, seen by its camera, and put under stress.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::samples::gbuffer::{self, GBufferOptions};
use antumbra::scene::defaults::Defaults;
use antumbra::scene::{Camera, PointLight, Scene, procedural};
use anyhow::{Context, Result, bail};
use bench_common::Case;

use crate::definition::Definition;
use crate::stress::Arrays;

/// The environment variable that says where scene files are.
pub const SCENES: &str = "ANTUMBRA_SCENES";

/// Where they are looked for otherwise.
const SCENES_DEFAULT: &str = "../shared/scenes";

/// The file of a definition; `None` for a built-in scene.
pub fn file(definition: &Definition) -> Option<PathBuf> {
    let scene = definition.scene.as_deref()?;
    if scene.starts_with("builtin:") {
        return None;
    }
    let folder = std::env::var_os(SCENES).map_or_else(|| PathBuf::from(SCENES_DEFAULT), PathBuf::from);
    Some(folder.join(scene))
}

/// Makes the arrays of a definition at a size.
///
/// # Errors
/// A scene that cannot be read, a camera or light that is not there.
pub fn case(definition: &Definition, [width, height]: [usize; 2]) -> Result<Arc<Case>> {
    let scene = match file(definition) {
        Some(path) => read(&path, definition.time)?,
        None => {
            let spec = definition.scene.as_deref().and_then(|s| s.strip_prefix("builtin:"));
            procedural::builtin(spec.context("no scene")?, definition.time)?
        }
    };
    scene.validate()?;
    let defaults = Defaults::new(&scene, [0.0, 1.0, 0.0]);
    let camera = camera(definition, &scene, &defaults, width as f32 / height as f32)?;
    let light = light(definition, &scene, &defaults, &camera)?;
    let seen = gbuffer::render(&scene, &camera, width, height, &GBufferOptions::default()).samples;
    let mut arrays = Arrays {
        triangles: scene.soup.casters(&light).triangles.into_owned(),
        samples: seen.positions,
        light: light.position,
    };
    // Clumps of samples are no longer what a camera saw.
    let mut view = seen.view;
    if let Some(stress) = &definition.stress {
        stress.apply(&mut arrays);
        view = view.filter(|_| stress.clumps.is_none());
    }
    let Arrays { triangles, samples, light } = arrays;
    Ok(Arc::new(Case::new(triangles, samples, width, light, view)))
}

fn read(path: &Path, time: Option<f32>) -> Result<Scene> {
    Ok(antumbra_io::open(path)?.at(time)?)
}

fn camera(d: &Definition, scene: &Scene, defaults: &Defaults<'_>, aspect: f32) -> Result<Camera> {
    Ok(match (d.camera_index, d.eye, d.target) {
        (Some(index), ..) => match scene.cameras.get(index) {
            Some(camera) => camera.clone(),
            None => bail!("camera_index = {index}: the scene has {} cameras", scene.cameras.len()),
        },
        (None, Some(eye), Some(target)) => {
            Camera { name: String::new(), eye, target, up: [0.0, 1.0, 0.0], fov: 45.0 }
        }
        _ => defaults.camera(aspect).value,
    })
}

fn light(d: &Definition, scene: &Scene, defaults: &Defaults<'_>, camera: &Camera) -> Result<PointLight> {
    let mut light = match (d.light_index, d.light) {
        (Some(index), _) => match scene.lights.get(index) {
            Some(light) => light.clone(),
            None => bail!("light_index = {index}: the scene has {} lights", scene.lights.len()),
        },
        (None, Some(position)) => PointLight::at(position),
        (None, None) => defaults.light(camera).value,
    };
    light.skip_radius = light.skip_radius.max(d.skip_radius.unwrap_or(0.0));
    Ok(light)
}
