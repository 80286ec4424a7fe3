//! `info`: what a scene holds.

use std::process::ExitCode;

use antumbra::scene::defaults::{core_bounds, framed_bounds};
use anyhow::Result;
use serde::Serialize;

use crate::console::{print, print_json};
use crate::files::{self, Loaded};
use crate::plan::Input;
use crate::report::{CameraReport, SCHEMA_VERSION};

#[derive(Serialize)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

#[derive(Serialize)]
struct LightInfo {
    name: String,
    position: [f32; 3],
    color: [f32; 3],
    intensity: f32,
}

#[derive(Serialize)]
struct TextureInfo {
    name: String,
    width: u32,
    height: u32,
}

#[derive(Serialize)]
struct InfoReport {
    schema_version: u32,
    scene: String,
    triangles: usize,
    /// Without area; they cast nothing.
    degenerate: usize,
    /// With the corners of an earlier one.
    duplicate: usize,
    bounds: Option<Bounds>,
    /// From the 5th to the 95th percentile of the vertices.
    core_bounds: Option<Bounds>,
    /// The one of the two that default cameras frame.
    framed_bounds: Option<Bounds>,
    /// First and last second, if anything moves.
    animation: Option<[f32; 2]>,
    has_normals: bool,
    has_uvs: bool,
    has_colors: bool,
    objects: Vec<String>,
    materials: Vec<String>,
    textures: Vec<TextureInfo>,
    lights: Vec<LightInfo>,
    cameras: Vec<CameraReport>,
}

pub(crate) fn run(input: &Input, first: usize, json: bool) -> Result<ExitCode> {
    let report = InfoReport::new(files::load(input)?);
    if json {
        print_json(&report)?;
    } else {
        print(&report.text(first))?;
    }
    Ok(ExitCode::SUCCESS)
}

impl InfoReport {
    fn new(Loaded { scene, span }: Loaded) -> InfoReport {
        let bounds = |b: Option<([f32; 3], [f32; 3])>| b.map(|(min, max)| Bounds { min, max });
        let census = scene.soup.census();
        InfoReport {
            schema_version: SCHEMA_VERSION,
            triangles: scene.soup.len(),
            degenerate: census.degenerate,
            duplicate: census.duplicate,
            bounds: bounds(scene.soup.bounds()),
            core_bounds: bounds(core_bounds(&scene)),
            framed_bounds: bounds(framed_bounds(&scene)),
            animation: span,
            has_normals: !scene.soup.normals.is_empty(),
            has_uvs: !scene.soup.uvs.is_empty(),
            has_colors: !scene.soup.colors.is_empty(),
            objects: scene.objects.into_iter().map(|o| o.name).collect(),
            materials: scene.materials.into_iter().map(|m| m.name).collect(),
            textures: scene
                .textures
                .into_iter()
                .map(|t| TextureInfo { name: t.name, width: t.width, height: t.height })
                .collect(),
            lights: scene
                .lights
                .into_iter()
                .map(|l| LightInfo {
                    name: l.name,
                    position: l.position,
                    color: l.color,
                    intensity: l.intensity,
                })
                .collect(),
            cameras: scene.cameras.iter().map(|c| CameraReport::new(c, None)).collect(),
            scene: scene.name,
        }
    }

    fn text(&self, first: usize) -> String {
        let mut text = format!(
            "{}\ntriangles   {} ({} degenerate, {} duplicate)\n",
            self.scene, self.triangles, self.degenerate, self.duplicate
        );
        for (name, bounds) in
            [("bounds", &self.bounds), ("5 to 95 %", &self.core_bounds), ("framed", &self.framed_bounds)]
        {
            if let Some(Bounds { min, max }) = bounds {
                text += &format!("{name:<10}  {} .. {}\n", point(*min), point(*max));
            }
        }
        text += &match self.animation {
            Some([from, to]) => format!("animation   {from} s to {to} s\n"),
            None => "animation   none\n".to_owned(),
        };
        let has: Vec<&str> =
            [("normals", self.has_normals), ("uvs", self.has_uvs), ("vertex colours", self.has_colors)]
                .into_iter()
                .filter_map(|(name, has)| has.then_some(name))
                .collect();
        text += &format!(
            "corners     {}\n",
            if has.is_empty() { "positions only".to_owned() } else { has.join(", ") }
        );

        let named = |names: &[String]| names.iter().map(|n| or_unnamed(n)).collect::<Vec<_>>();
        let textures = self
            .textures
            .iter()
            .map(|t| format!("{} {}x{}", or_unnamed(&t.name), t.width, t.height))
            .collect();
        let lights = self.lights.iter().map(|l| {
            format!(
                "{} at {}, {} cd, colour {}",
                or_unnamed(&l.name),
                point(l.position),
                l.intensity,
                point(l.color)
            )
        });
        let cameras = self.cameras.iter().map(|c| {
            format!("{} at {} to {}, {}°", or_unnamed(&c.name), point(c.eye), point(c.target), c.fov)
        });
        for (kind, entries) in [
            ("objects", named(&self.objects)),
            ("materials", named(&self.materials)),
            ("textures", textures),
            ("lights", lights.collect()),
            ("cameras", cameras.collect()),
        ] {
            text += &format!("{kind:<10}  {}\n", entries.len());
            for (i, entry) in entries.iter().take(first).enumerate() {
                text += &format!("  {i:>8}  {entry}\n");
            }
            if entries.len() > first && first > 0 {
                text += &format!("         …  {} more (--first N, or --json)\n", entries.len() - first);
            }
        }
        text
    }
}

fn point([x, y, z]: [f32; 3]) -> String {
    format!("{x},{y},{z}")
}

fn or_unnamed(name: &str) -> String {
    if name.is_empty() { "(no name)".to_owned() } else { name.to_owned() }
}
