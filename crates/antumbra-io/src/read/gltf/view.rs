//! Lights and cameras: what is seen by, and from where.

use antumbra::scene::{Camera, PointLight};
use gltf::json::extensions::scene::khr_lights_punctual::Type;

use super::math::{Affine, unit};
use super::source::{Source, label};
use crate::Error;

/// A point light of the file, without its place.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    label: String,
    name: String,
    color: [f32; 3],
    intensity: f32,
}

/// A perspective camera of the file, without its place.
#[derive(Clone, Debug)]
pub(super) struct Lens {
    label: String,
    name: String,
    /// Degrees.
    fov: f32,
}

/// The lights of `KHR_lights_punctual`, in the order of the file. Spot lights are taken as point lights;
/// directional lights have no place and are `None`.
pub(super) fn read_lamps(source: &Source<'_>) -> Result<Vec<Option<Lamp>>, Error> {
    let extension = source.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let lights = extension.map_or(&[][..], |e| &e.lights);
    let read = |(index, light): (usize, &gltf::json::extensions::scene::khr_lights_punctual::Light)| {
        let label = label("light", index, light.name.as_deref());
        let kind = source.known(&light.type_, "type", &label)?;
        if !light.intensity.is_finite() || !light.color.iter().all(|c| c.is_finite()) {
            return Err(source.error(format!("{label}: its colour or intensity is not finite")));
        }
        let name = light.name.clone().unwrap_or_default();
        let lamp = Lamp { label, name, color: light.color, intensity: light.intensity };
        Ok((kind != Type::Directional).then_some(lamp))
    };
    lights.iter().enumerate().map(read).collect()
}

/// The cameras of the file, in its order; orthographic ones are `None`.
pub(super) fn read_lenses(source: &Source<'_>) -> Result<Vec<Option<Lens>>, Error> {
    let read = |(index, camera): (usize, &gltf::json::Camera)| {
        let label = label("camera", index, camera.name.as_deref());
        let Some(perspective) = &camera.perspective else { return Ok(None) };
        let fov = f64::from(perspective.yfov).to_degrees() as f32;
        if !(fov > 0.0 && fov < 180.0) {
            return Err(
                source.error(format!("{label}: its field of view of {fov} degrees is not within 0 and 180"))
            );
        }
        Ok(Some(Lens { label, name: camera.name.clone().unwrap_or_default(), fov }))
    };
    source.root.cameras.iter().enumerate().map(read).collect()
}

impl Lamp {
    /// The light at a node, named after the node if that has a name. An error is one line.
    pub(super) fn at(&self, world: &Affine, node: &str, node_label: &str) -> Result<PointLight, String> {
        let position = round(world.origin(), node_label, &self.label)?;
        let name = if node.is_empty() { self.name.clone() } else { node.into() };
        Ok(PointLight { name, color: self.color, intensity: self.intensity, ..PointLight::at(position) })
    }
}

impl Lens {
    /// The camera at a node, named after the node if that has a name. An error is one line.
    pub(super) fn at(&self, world: &Affine, node: &str, node_label: &str) -> Result<Camera, String> {
        let eye = round(world.origin(), node_label, &self.label)?;
        // glTF cameras look along -z, with y up.
        let [ahead, up] = [unit(world.direction([0.0, 0.0, -1.0])), unit(world.direction([0.0, 1.0, 0.0]))];
        if ahead == [0.0; 3] || up == [0.0; 3] {
            return Err(format!("{node_label}, {}: it looks nowhere, its matrix is flat", self.label));
        }
        // As far off as the origin, at least: next to large coordinates of the eye a near target would be rounded.
        let distance = eye.iter().fold(1.0f64, |d, x| d.max(f64::from(x.abs())));
        let origin = world.origin();
        let target = [0, 1, 2].map(|k| origin[k] + distance * f64::from(ahead[k]));
        let target = round(target, node_label, &self.label)?;
        let name = if node.is_empty() { self.name.clone() } else { node.into() };
        Ok(Camera { name, eye, target, up, fov: self.fov })
    }
}

fn round(p: [f64; 3], node: &str, what: &str) -> Result<[f32; 3], String> {
    let rounded = p.map(|x| x as f32);
    if rounded.iter().all(|x| x.is_finite()) {
        Ok(rounded)
    } else {
        Err(format!("{node}, {what}: its position {rounded:?} is not finite"))
    }
}
