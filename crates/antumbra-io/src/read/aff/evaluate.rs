//! The scene at a time: from keys to transforms to triangles.

use antumbra::scene::{Camera, PointLight, Scene, Soup, Triangle};

use super::affine::{Affine, Quaternion, dot, map_normal, subtract, unit};
use super::model::{Animation, Light, Model, Morph, MorphKey, Motion, Run, Source, View};
use super::tokens::Outcome;

/// An animation at a time. Made once each: a thousand transforms may share one with a million keys.
struct Pose {
    map: Affine,
    translation: Option<[f64; 3]>,
    rotation: Option<Quaternion>,
    visible: bool,
}

/// Everything at `time`.
pub(super) fn scene(model: &Model, time: f64) -> Outcome<Scene> {
    let poses: Vec<Pose> = model.animations.iter().map(|animation| pose(animation, time)).collect();
    let places = places(model, &poses);
    let mut soup = Soup::default();
    let shown = |run: &&Run| places[run.node as usize].1;
    let count = model.runs.iter().filter(shown).map(|run| run.count).sum();
    soup.positions.reserve_exact(count);
    soup.object.reserve_exact(count);
    soup.material.reserve_exact(count);
    soup.uvs.reserve_exact(count);
    soup.normals.reserve_exact(count);
    for run in model.runs.iter().filter(shown) {
        add_run(model, run, &places[run.node as usize].0, time, &mut soup);
    }
    check(model, &soup, time)?;
    // Arrays that say nothing are left out.
    if soup.uvs.as_flattened().as_flattened().iter().all(|&v| v == 0.0) {
        soup.uvs = Vec::new();
    }
    if soup.normals.as_flattened().as_flattened().iter().all(|&v| v == 0.0) {
        soup.normals = Vec::new();
    }
    let mut lights = Vec::with_capacity(model.lights.len());
    for light in &model.lights {
        // A light shines also out of a transform that cannot be seen.
        let (map, _) = &places[light.node as usize];
        let moved = light.animation.and_then(|index| poses[index as usize].translation);
        lights.push(point_light(light, map, moved, time)?);
    }
    let pose = model.camera_animation.map(|index| &poses[index as usize]);
    let cameras = model.view.iter().map(|view| camera(view, pose, time)).collect::<Outcome<_>>()?;
    Ok(Scene {
        name: model.name.clone(),
        soup,
        objects: model.objects.clone(),
        materials: model.materials.clone(),
        textures: model.textures.clone(),
        lights,
        cameras,
    })
}

fn pose(animation: &Animation, time: f64) -> Pose {
    let translation = animation.translation.as_ref().and_then(|t| t.at(time));
    let rotation = animation.rotation.as_ref().and_then(|r| r.at(time));
    let scale = animation.scale.as_ref().and_then(|s| s.at(time)).unwrap_or([1.0; 3]);
    let map =
        Affine::from_parts(translation.unwrap_or_default(), rotation.unwrap_or(Quaternion::IDENTITY), scale);
    Pose { map, translation, rotation, visible: animation.visible_at(time) }
}

/// Where each node is in the world, and if it can be seen.
fn places(model: &Model, poses: &[Pose]) -> Vec<(Affine, bool)> {
    let mut places: Vec<(Affine, bool)> = Vec::with_capacity(model.nodes.len());
    for node in &model.nodes {
        let (local, visible) = match &node.motion {
            Motion::Fixed(map) => (map, true),
            Motion::Animated(index) => {
                let pose = &poses[*index as usize];
                (&pose.map, pose.visible)
            }
        };
        // Only the world, the first, is its own parent.
        let (outer, shown) = places.get(node.parent as usize).unwrap_or(&(Affine::IDENTITY, true));
        places.push((outer.after(local), *shown && visible));
    }
    places
}

/// Adds the triangles of a run.
fn add_run(model: &Model, run: &Run, map: &Affine, time: f64, soup: &mut Soup) {
    let normal_map = map.normal_map();
    let range = run.first..run.first + run.count;
    soup.object.resize(soup.object.len() + run.count, run.object);
    let corners = |positions: &Triangle| positions.map(|p| map.point(p));
    let directions = |normals: &[[f32; 3]; 3]| normals.map(|n| map_normal(&normal_map, n));
    match run.source {
        Source::Faces => {
            let faces = &model.faces;
            soup.positions.extend(faces.positions[range.clone()].iter().map(corners));
            soup.normals.extend(faces.normals[range.clone()].iter().map(directions));
            soup.uvs.extend_from_slice(&faces.uvs[range.clone()]);
            soup.material.extend_from_slice(&faces.material[range]);
        }
        Source::Morphs => {
            for morph in &model.morphs[range] {
                let (positions, normals) = shape(model, morph, time);
                soup.positions.push(corners(&positions));
                soup.normals.push(directions(&normals));
                soup.uvs.push([[0.0; 2]; 3]);
                soup.material.push(morph.material);
            }
        }
    }
}

/// An animated triangle: straight lines between its keys, still before the first and after the last.
fn shape(model: &Model, morph: &Morph, time: f64) -> (Triangle, [[f32; 3]; 3]) {
    let keys = &model.morph_keys[morph.first..morph.first + morph.count];
    let (first, last) = (&keys[0], &keys[keys.len() - 1]);
    let time_of = |key: &MorphKey| f64::from(key.time);
    let between = keys.array_windows().find(|[a, b]| time_of(a) <= time && time < time_of(b));
    match between {
        _ if time <= time_of(first) => (first.positions, first.normals),
        Some([a, b]) => {
            let u = (time - time_of(a)) / (time_of(b) - time_of(a));
            let mix = |a: f32, b: f32| (f64::from(a) + u * (f64::from(b) - f64::from(a))) as f32;
            let mix = |a: &[[f32; 3]; 3], b: &[[f32; 3]; 3]| {
                [0, 1, 2].map(|i| [0, 1, 2].map(|k| mix(a[i][k], b[i][k])))
            };
            (mix(&a.positions, &b.positions), mix(&a.normals, &b.normals))
        }
        None => (last.positions, last.normals),
    }
}

/// Nested scales can leave the range of `f32`.
fn check(model: &Model, soup: &Soup, time: f64) -> Outcome<()> {
    let finite = |t: &Triangle| t.as_flattened().iter().all(|v| v.is_finite());
    match soup.positions.iter().position(|t| !finite(t)) {
        None => Ok(()),
        Some(i) => {
            let name = &model.objects[soup.object[i] as usize].name;
            Err(format!(
                "object '{name}', triangle {i} of the scene: a coordinate is too large at time {time}"
            ))
        }
    }
}

fn point_light(light: &Light, map: &Affine, moved: Option<[f64; 3]>, time: f64) -> Outcome<PointLight> {
    let position = map.point(moved.map_or(light.position, |p| p.map(|v| v as f32)));
    if !position.iter().all(|v| v.is_finite()) {
        return Err(format!("light '{}': a coordinate is too large at time {time}", light.name));
    }
    Ok(PointLight { name: light.name.clone(), color: light.color, ..PointLight::at(position) })
}

/// The viewpoint, moved and turned by the animation `camera` if there is one.
fn camera(view: &View, pose: Option<&Pose>, time: f64) -> Outcome<Camera> {
    let eye = pose.and_then(|p| p.translation).unwrap_or(view.from);
    let (mut target, mut up) = (view.at, view.up);
    if let Some(rotation) = pose.and_then(|p| p.rotation) {
        let matrix = rotation.matrix();
        let gaze = subtract(view.at, view.from);
        // How far the target is makes no difference to the picture.
        let distance = unit(gaze).map_or(1.0, |_| dot(gaze, gaze).sqrt());
        target = [0, 1, 2].map(|k| eye[k] - matrix[k][2] * distance);
        up = matrix.map(|row| row[1]);
    }
    let camera = Camera {
        name: if pose.is_some() { "camera".to_owned() } else { String::new() },
        eye: eye.map(|v| v as f32),
        target: target.map(|v| v as f32),
        up: up.map(|v| v as f32),
        fov: view.angle,
    };
    if ![camera.eye, camera.target, camera.up].as_flattened().iter().all(|v| v.is_finite()) {
        return Err(format!("camera: a coordinate is too large at time {time}"));
    }
    Ok(camera)
}
