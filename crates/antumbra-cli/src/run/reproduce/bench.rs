//! Where counts come from: scenes on stage, methods run on them, every mask held against `ray-cast`'s.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use antumbra::Isa;
use antumbra::methods::{Method, Options, Stats, create, info};
use antumbra::samples::ViewSamples;
use antumbra::samples::gbuffer::{self, GBufferOptions};
use antumbra::scene::{Camera, Scene, Triangle};
use anyhow::{Result, bail};

use crate::console::Progress;
use crate::files;
use crate::plan::{Input, Lights, Source, View};
use crate::stage::Stage;

/// What a run looks at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setting {
    /// What the page calls it.
    pub(super) name: &'static str,
    /// A file of the scenes' folder, or `builtin:NAME`.
    pub(super) scene: &'static str,
    /// What is taken where the file is not there: a built-in scene with a camera and a light of its own.
    pub(super) stand_in: Option<&'static str>,
    pub(super) time: Option<f32>,
    /// Eye and target; `None`: the file's, or the rule's.
    pub(super) view: Option<[[f32; 3]; 2]>,
    pub(super) light: Option<[f32; 3]>,
    pub(super) size: [usize; 2],
    /// How often every triangle of the object of this name is cut in four.
    pub(super) tessellate: Option<(&'static str, u32)>,
}

impl Setting {
    /// A scene with camera and light of its own.
    pub(super) const fn new(name: &'static str, scene: &'static str, size: [usize; 2]) -> Setting {
        Setting { name, scene, stand_in: None, time: None, view: None, light: None, size, tessellate: None }
    }

    /// The same with `size`.
    pub(super) const fn sized(self, size: [usize; 2]) -> Setting {
        Setting { size, ..self }
    }

    /// The same at a moment.
    pub(super) const fn at(self, time: f32) -> Setting {
        Setting { time: Some(time), ..self }
    }

    fn key(&self) -> String {
        format!("{} {:?} {:?} {:?}", self.scene, self.time, self.size, self.tessellate)
    }
}

/// A setting on stage.
struct Field {
    key: String,
    casters: Vec<Triangle>,
    samples: ViewSamples,
    light: [f32; 3],
    right: Vec<u8>,
}

/// What is known of a setting before any method of interest has run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) triangles: usize,
    pub(super) samples: usize,
}

/// Counts of runs, each made once.
pub(super) struct Bench<'a> {
    pub(super) folder: Option<PathBuf>,
    pub(super) isa: Isa,
    /// Width and height of all pictures are divided by this.
    pub(super) divide: usize,
    pub(super) progress: &'a Progress,
    /// What could not be had, and what was taken instead.
    pub(super) missing: Vec<String>,
    field: Option<Field>,
    places: HashMap<String, Place>,
    known: HashMap<(String, String), Stats>,
}

impl<'a> Bench<'a> {
    pub(super) fn new(folder: Option<PathBuf>, isa: Isa, divide: usize, progress: &'a Progress) -> Bench<'a> {
        let (places, known) = (HashMap::new(), HashMap::new());
        Bench { folder, isa, divide, progress, missing: Vec::new(), field: None, places, known }
    }

    /// The setting as it can be had here: itself, its stand-in, or nothing. What is not there is noted.
    pub(super) fn resolve(&mut self, setting: &Setting) -> Option<Setting> {
        let setting = setting.sized(setting.size.map(|n| (n / self.divide).max(1)));
        if setting.scene.starts_with("builtin:") || self.path(&setting).is_some() {
            return Some(setting);
        }
        let told = match setting.stand_in {
            Some(scene) => format!("`{}` is not there; `{scene}` stands in", setting.scene),
            None => format!("`{}` is not there; left out", setting.scene),
        };
        if !self.missing.contains(&told) {
            self.progress.note(&format!("note: {}", told.replace('`', "")));
            self.missing.push(told);
        }
        let scene = setting.stand_in?;
        Some(Setting {
            name: scene,
            scene,
            stand_in: None,
            view: None,
            light: None,
            tessellate: None,
            ..setting
        })
    }

    fn path(&self, setting: &Setting) -> Option<PathBuf> {
        let path = self.folder.as_deref()?.join(setting.scene);
        path.is_file().then_some(path)
    }

    /// The counts of a method of the catalogue, by its name.
    pub(super) fn count(&mut self, setting: &Setting, method: &str) -> Result<Stats> {
        let options = Options { isa: self.isa, count: true };
        self.run(setting, method, info(method)?.exact, || Ok(create(method, &options)?))
    }

    /// The counts of a method that `make` makes; `label` tells it from others. `exact`: it must have `ray-cast`'s mask.
    pub(super) fn run(
        &mut self,
        setting: &Setting,
        label: &str,
        exact: bool,
        make: impl FnOnce() -> Result<Box<dyn Method>>,
    ) -> Result<Stats> {
        let key = (setting.key(), label.to_owned());
        if let Some(stats) = self.known.get(&key) {
            return Ok(stats.clone());
        }
        self.set(setting)?;
        self.progress.doing(format!("{}: {label}", setting.name));
        let Some(field) = &self.field else { bail!("{}: not on stage", setting.name) };
        let mut mask = vec![0; field.samples.positions.len()];
        let stats = make()?.shadow(&field.casters, field.samples.view(), field.light, &mut mask)?;
        if exact && mask != field.right {
            let found = antumbra::mask::compare(&field.right, &mask)?;
            bail!(
                "{}: {label} differs from ray-cast in {} samples: counts of a wrong mask mean nothing",
                setting.name,
                found.mismatches
            );
        }
        self.known.insert(key, stats.clone());
        Ok(stats)
    }

    /// Triangles and samples of a setting.
    pub(super) fn place(&mut self, setting: &Setting) -> Result<Place> {
        if let Some(place) = self.places.get(&setting.key()) {
            return Ok(*place);
        }
        self.set(setting)?;
        Ok(self.places[&setting.key()])
    }

    /// Puts a setting on stage, unless it is there.
    fn set(&mut self, setting: &Setting) -> Result<()> {
        let key = setting.key();
        if self.field.as_ref().is_some_and(|f| f.key == key) {
            return Ok(());
        }
        // The old one's memory first.
        self.field = None;
        self.progress.doing(format!("{}: setting the stage", setting.name));
        let source = match setting.scene.strip_prefix("builtin:") {
            Some(spec) => Source::Builtin(spec.to_owned()),
            None => Source::File(self.path(setting).unwrap_or_else(|| Path::new(setting.scene).to_owned())),
        };
        let mut scene = files::load(&Input { source, time: setting.time })?.scene;
        if let Some((object, times)) = setting.tessellate {
            tessellate(&mut scene, object, times);
        }
        let [eye, target] = setting.view.map_or([None; 2], |v| v.map(Some));
        let view = View { eye, target, up: None, fov: None, index: None, size: setting.size };
        let positions = setting.light.into_iter().collect();
        let lights =
            Lights { positions, indices: Vec::new(), all: false, skip_radius: 0.0, exclude: Vec::new() };
        let stage = Stage::set(&scene, &view, &lights)?;
        let camera: &Camera = &stage.camera.value;
        let [width, height] = setting.size;
        let gbuffer = gbuffer::render(&scene, camera, width, height, &GBufferOptions { isa: self.isa });
        let light = &stage.lights[0].value;
        let casters = scene.soup.casters(light).triangles.into_owned();
        let mut right = vec![0; width * height];
        let options = Options { isa: self.isa, count: true };
        let samples = gbuffer.samples;
        let stats =
            create("ray-cast", &options)?.shadow(&casters, samples.view(), light.position, &mut right)?;
        self.places.insert(key.clone(), Place { triangles: casters.len(), samples: stats.samples });
        self.known.insert((key.clone(), "ray-cast".to_owned()), stats);
        self.field = Some(Field { key, casters, samples, light: light.position, right });
        Ok(())
    }
}

/// Cuts every triangle of the objects of that name in four, `times` over. Corners only: nothing else is counted here.
fn tessellate(scene: &mut Scene, object: &str, times: u32) {
    let chosen: Vec<bool> = scene.objects.iter().map(|o| o.name == object).collect();
    let soup = &mut scene.soup;
    let middle = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| 0.5 * a[k] + 0.5 * b[k]);
    for _ in 0..times {
        let mut cut = Vec::new();
        for i in 0..soup.positions.len() {
            if !chosen[soup.object[i] as usize] {
                continue;
            }
            let [a, b, c] = soup.positions[i];
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            soup.positions[i] = [ab, bc, ca];
            cut.push((i, [[a, ab, ca], [ab, b, bc], [ca, bc, c]]));
        }
        for (of, parts) in cut {
            for part in parts {
                soup.positions.push(part);
                soup.object.push(soup.object[of]);
                repeat(&mut soup.material, of);
                repeat(&mut soup.uvs, of);
                repeat(&mut soup.normals, of);
                repeat(&mut soup.colors, of);
            }
        }
    }
}

/// Attributes are absent, or there for every triangle.
fn repeat<T: Copy>(list: &mut Vec<T>, of: usize) {
    if let Some(&value) = list.get(of) {
        list.push(value);
    }
}

/// A counter by name; 0 if the method has none of that name.
pub(super) fn counter(stats: &Stats, name: &str) -> u64 {
    stats.counters.iter().find(|(n, _)| *n == name).map_or(0, |(_, v)| *v)
}

/// Bytes of a buffer by name.
pub(super) fn bytes(stats: &Stats, name: &str) -> u64 {
    stats.bytes.iter().find(|(n, _)| *n == name).map_or(0, |(_, v)| *v)
}

#[cfg(test)]
mod tests {
    use antumbra::scene::{Object, Soup};

    use super::*;

    #[test]
    fn only_the_named_object_is_cut_and_keeps_its_area() {
        let t = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]];
        let mut scene = Scene {
            objects: vec![Object { name: "still".to_owned() }, Object { name: "moving".to_owned() }],
            soup: Soup { positions: vec![t, t], object: vec![0, 1], material: vec![0, 0], ..Soup::default() },
            ..Scene::default()
        };
        tessellate(&mut scene, "moving", 3);
        let soup = &scene.soup;
        assert_eq!((soup.len(), soup.object.len(), soup.material.len()), (65, 65, 65));
        assert_eq!(soup.object.iter().filter(|o| **o == 1).count(), 64);
        let area = |t: &Triangle| {
            let d = |i: usize, k: usize| t[i][k] - t[0][k];
            (d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0)).abs() / 2.0
        };
        assert!(soup.positions.iter().skip(2).all(|t| area(t) == 0.5));
    }
}
