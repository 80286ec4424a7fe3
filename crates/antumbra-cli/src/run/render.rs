//! `render`: a scene to a picture, its masks, and what the shadow test saw.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use antumbra::methods::{Stats, create};
use antumbra::samples::gbuffer::{self, GBuffer, GBufferOptions};
use antumbra::scene::PointLight;
use antumbra::scene::defaults::Choice;
use antumbra::shade;
use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;

use crate::console::{Progress, print_json};
use crate::files;
use crate::plan::Render;
use crate::report::{CameraReport, StageReport, StatsReport};
use crate::run::debug::{DebugReport, Numbers};
use crate::stage::Stage;

/// `--stats` of a picture: all its lights summed up, then each.
#[derive(Serialize)]
struct RenderReport {
    #[serde(flatten)]
    total: StatsReport,
    scene: String,
    /// Width and height.
    size: [usize; 2],
    camera: CameraReport,
    lights: Vec<LightReport>,
    /// The run around the shadows, from the start of the program.
    program_stages: Vec<StageReport>,
    program_ms: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    debug: Option<DebugReport>,
}

#[derive(Serialize)]
struct LightReport {
    name: String,
    position: [f32; 3],
    rule: &'static str,
    skip_radius: f32,
    triangles: usize,
    shadowed: usize,
    stages: Vec<StageReport>,
    total_ms: f64,
}

pub(crate) fn run(plan: &Render) -> Result<ExitCode> {
    let mut progress = Progress::new(plan.talk.quiet);
    progress.doing("reading the scene");
    let files::Loaded { scene, span } = files::load(&plan.input)?;
    note_time(&progress, plan.input.time, span);
    progress.stage("read");

    progress.doing("placing camera and lights");
    let stage = Stage::set(&scene, &plan.view, &plan.lights)?;
    note_choices(&progress, &stage);
    progress.stage("place");

    progress.doing("finding what the eye sees");
    let [width, height] = plan.view.size;
    let camera = &stage.camera.value;
    let options = GBufferOptions { isa: plan.method.options.isa };
    let gbuffer = gbuffer::render(&scene, camera, width, height, &options);
    progress.stage("gbuffer");

    let mut method = create(plan.method.info.name, &plan.method.options)?;
    let (mut masks, mut stats): (Vec<Vec<u8>>, Vec<Stats>) = (Vec::new(), Vec::new());
    for (k, light) in stage.lights.iter().enumerate() {
        progress.doing(format!("shadows: {}, light {}/{}", method.name(), k + 1, stage.lights.len()));
        let mut mask = vec![0; width * height];
        let casters = scene.soup.casters(&light.value);
        stats.push(method.shadow(
            &casters.triangles,
            gbuffer.samples.view(),
            light.value.position,
            &mut mask,
        )?);
        masks.push(mask);
    }
    progress.stage("shadow");
    let mut numbers = Vec::new();
    if let Some(view) = &plan.debug {
        for light in &stage.lights {
            progress.doing(format!("debug view {} of {}", view.name, method.name()));
            let casters = scene.soup.casters(&light.value);
            let asked = gbuffer.samples.view();
            let seen = method.debug_view(view.name, &casters.triangles, asked, light.value.position)?;
            let seen = Numbers::new(view, plan.debug_max, seen.context("the view is not there any more")?);
            seen.note(view, plan.debug_max, &progress);
            numbers.push(seen);
        }
        progress.stage("debug");
    }
    // Its memory is not needed any more, and the picture's is to come.
    drop(method);

    progress.doing("shading");
    let outputs =
        Outputs { plan, scene: &scene, stage: &stage, gbuffer: &gbuffer, masks: &masks, numbers: &numbers };
    let picture = outputs.shade()?;
    progress.stage("shade");
    progress.doing("writing");
    let written = outputs.write(&picture)?;
    progress.stage("write");

    let (program_stages, program_ms) = progress.finish();
    let total = StatsReport::of_lights(&stats).context("no light")?;
    progress.note(&format!(
        "{}: {} triangles, {width}x{height}; {}: {} of {} samples shadowed in {:.1} ms; {:.2} s in all",
        scene.name,
        scene.soup.len(),
        total.method,
        total.shadowed,
        total.samples,
        total.total_ms,
        program_ms / 1e3,
    ));
    if total.samples > 0 && total.shadowed as f64 >= 0.999 * total.samples as f64 {
        progress.note(
            "note: nearly everything is in shadow: the light may sit inside something, such as lamp glass; --skip-radius R \
             leaves out casters nearer than R to it, --light-index N takes another light of the file",
        );
    }
    if !written.is_empty() {
        let names: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
        progress.note(&format!("wrote {}", names.join(", ")));
    }
    let report = RenderReport {
        total,
        scene: scene.name.clone(),
        size: plan.view.size,
        camera: CameraReport::new(camera, Some(stage.camera.rule)),
        lights: stage
            .lights
            .iter()
            .zip(&stats)
            .map(|(light, stats)| LightReport::new(light, stats))
            .collect(),
        program_stages,
        program_ms,
        debug: plan.debug.as_ref().map(|view| DebugReport::new(view, plan.debug_max, &numbers)),
    };
    if let Some(path) = &plan.stats {
        files::write_json(path, &report)?;
    }
    if plan.talk.json {
        print_json(&report)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Says what `--time` did if that may surprise.
pub(crate) fn note_time(progress: &Progress, time: Option<f32>, span: Option<[f32; 2]>) {
    match (time, span) {
        (Some(time), None) => {
            progress.note(&format!("note: nothing moves in this scene: --time {time} changes nothing"));
        }
        (Some(time), Some([first, last])) if time < first || time > last => {
            progress.note(&format!(
                "note: --time {time} is outside the animation, {first} to {last}: the nearer end is taken"
            ));
        }
        _ => {}
    }
}

/// Says which camera and light were chosen where nobody told.
pub(crate) fn note_choices(progress: &Progress, stage: &Stage) {
    let [x, y, z] = stage.camera.value.eye;
    let [tx, ty, tz] = stage.camera.value.target;
    if stage.camera.rule != "as told" {
        progress.note(&format!("camera: {}: --eye {x},{y},{z} --target {tx},{ty},{tz}", stage.camera.rule));
    }
    for light in stage.lights.iter().filter(|l| l.rule != "as told" && l.rule != "of the file") {
        let [x, y, z] = light.value.position;
        progress.note(&format!("light: {}: --light {x},{y},{z}", light.rule));
    }
}

impl LightReport {
    fn new(light: &Choice<PointLight>, stats: &Stats) -> LightReport {
        LightReport {
            name: light.value.name.clone(),
            position: light.value.position,
            rule: light.rule,
            skip_radius: light.value.skip_radius,
            triangles: stats.triangles,
            shadowed: stats.shadowed,
            stages: stats.stages.iter().map(StageReport::from).collect(),
            total_ms: stats.total_ms,
        }
    }
}

/// Everything that files are made of.
struct Outputs<'a> {
    plan: &'a Render,
    scene: &'a antumbra::scene::Scene,
    stage: &'a Stage,
    gbuffer: &'a GBuffer,
    masks: &'a [Vec<u8>],
    /// Of the debug view, if there is one: by light.
    numbers: &'a [Numbers],
}

/// A file, and what makes it.
type Job<'a> = (PathBuf, Box<dyn Fn(&Path) -> Result<()> + Send + Sync + 'a>);

impl Outputs<'_> {
    /// Writes all files at once, the picture (which takes longest) first. The names, in order.
    fn write(&self, picture: &[[f32; 3]]) -> Result<Vec<PathBuf>> {
        let plan = self.plan;
        let size = plan.view.size;
        let mut jobs: Vec<Job<'_>> = Vec::new();
        for (k, numbers) in self.numbers.iter().enumerate() {
            if let Some(path) = &plan.picture {
                let path = files::numbered(path, k, self.numbers.len());
                jobs.push((path, Box::new(move |path| numbers.write(path, size, picture))));
            }
        }
        if let Some(path) = plan.picture.as_ref().filter(|_| plan.debug.is_none()) {
            jobs.push((path.clone(), Box::new(move |path| files::write_picture(path, size, picture))));
        }
        if let Some(path) = &plan.mask {
            for (k, mask) in self.masks.iter().enumerate() {
                let path = files::numbered(path, k, self.masks.len());
                jobs.push((path, Box::new(move |path| files::write_mask(path, mask, &[size[1], size[0]]))));
            }
        }
        if let Some(path) = &plan.samples {
            let positions = &self.gbuffer.samples.positions;
            jobs.push((path.clone(), Box::new(move |path| files::write_samples(path, positions, size))));
        }
        if let Some(path) = &plan.triangles {
            let lights = &self.stage.lights;
            let first = &lights[0].value;
            let shared = lights.iter().all(|l| {
                l.value.skip_radius <= 0.0 && first.skip_radius <= 0.0 && l.value.excluded == first.excluded
            });
            let files = if shared { 1 } else { lights.len() };
            for (k, light) in lights.iter().take(files).enumerate() {
                let write = move |path: &Path| {
                    files::write_triangles(path, &self.scene.soup.casters(&light.value).triangles)
                };
                jobs.push((files::numbered(path, k, files), Box::new(write)));
            }
        }
        jobs.par_iter().with_max_len(1).try_for_each(|(path, job)| job(path))?;
        Ok(jobs.into_iter().map(|(path, _)| path).collect())
    }

    /// The picture, empty if none is asked for.
    fn shade(&self) -> Result<Vec<[f32; 3]>> {
        if self.plan.picture.is_none() {
            return Ok(Vec::new());
        }
        let masks = self.masks.iter().map(Vec::as_slice);
        let lights: Vec<(PointLight, &[u8])> =
            self.stage.lights.iter().map(|l| l.value.clone()).zip(masks).collect();
        let camera = &self.stage.camera.value;
        Ok(shade::shade(self.scene, camera, self.gbuffer, &lights, &shade::Options::default())?)
    }
}
