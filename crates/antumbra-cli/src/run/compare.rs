//! `compare`: every method against a reference, sample by sample.

use std::path::Path;
use std::process::ExitCode;

use antumbra::mask::{self, Comparison};
use antumbra::methods::{CATALOGUE, MethodInfo, create};
use antumbra::samples::gbuffer::{self, GBuffer, GBufferOptions};
use antumbra::scene::{PointLight, Scene};
use anyhow::{Context, Result, bail};
use serde::Serialize;

use super::render::{note_choices, note_time};
use crate::console::{Progress, print, print_json, table};
use crate::files;
use crate::plan::Compare;
use crate::report::{CameraReport, SCHEMA_VERSION, StatsReport};
use crate::stage::Stage;

/// Pairs of triangle and sample up to which the oracle is the default reference: some seconds of one core.
const ORACLE_PAIRS: u128 = 1_000_000_000;

/// Exit code when a method that claims to be exact is not.
const DIFFERS: u8 = 1;

#[derive(Serialize)]
struct CompareReport {
    schema_version: u32,
    scene: String,
    size: [usize; 2],
    samples: usize,
    triangles: usize,
    camera: CameraReport,
    reference: &'static str,
    /// Why that one.
    reference_rule: String,
    lights: Vec<LightRows>,
    /// No exact method has a mismatch.
    agree: bool,
}

#[derive(Serialize)]
struct LightRows {
    position: [f32; 3],
    /// After `--skip-radius` and `--exclude-object`.
    triangles: usize,
    shadowed: usize,
    methods: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    method: &'static str,
    exact: bool,
    is_reference: bool,
    mismatches: usize,
    leaks: usize,
    acne: usize,
    stray: usize,
    /// Column and row of the first sample that differs.
    #[serde(skip_serializing_if = "Option::is_none")]
    first: Option<[usize; 2]>,
    ms: f64,
    stats: StatsReport,
}

/// What is compared with what.
struct Field {
    reference: &'static MethodInfo,
    rule: String,
    /// With the reference first.
    methods: Vec<&'static MethodInfo>,
}

pub(crate) fn run(plan: &Compare) -> Result<ExitCode> {
    let mut progress = Progress::new(plan.talk.quiet);
    progress.doing("reading the scene");
    let files::Loaded { scene, span } = files::load(&plan.input)?;
    note_time(&progress, plan.input.time, span);
    progress.doing("placing camera and lights");
    let stage = Stage::set(&scene, &plan.view, &plan.lights)?;
    note_choices(&progress, &stage);
    progress.doing("finding what the eye sees");
    let [width, height] = plan.view.size;
    let options = GBufferOptions { isa: plan.options.isa };
    let gbuffer = gbuffer::render(&scene, &stage.camera.value, width, height, &options);
    let samples = gbuffer.samples.positions.iter().filter(|p| !p[0].is_nan()).count();

    let field = Field::new(plan, scene.soup.len(), samples, &progress)?;
    if let Some(dir) = &plan.diff_dir {
        std::fs::create_dir_all(dir).with_context(|| format!("--diff-dir {}", dir.display()))?;
    }
    let mut lights = Vec::new();
    for (k, light) in stage.lights.iter().enumerate() {
        let of = stage.lights.len();
        let pictures = plan.diff_dir.as_deref().map(|dir| (dir, k, of));
        lights.push(field.compare(plan, &scene, &gbuffer, &light.value, pictures, &progress)?);
    }
    progress.finish();

    let agree = lights.iter().flat_map(|l| &l.methods).all(|row| !row.exact || row.mismatches == 0);
    let report = CompareReport {
        schema_version: SCHEMA_VERSION,
        scene: scene.name.clone(),
        size: plan.view.size,
        samples,
        triangles: scene.soup.len(),
        camera: CameraReport::new(&stage.camera.value, Some(stage.camera.rule)),
        reference: field.reference.name,
        reference_rule: field.rule,
        lights,
        agree,
    };
    if plan.talk.json {
        print_json(&report)?;
    } else {
        print(&report.text())?;
    }
    Ok(if agree { ExitCode::SUCCESS } else { ExitCode::from(DIFFERS) })
}

impl Field {
    fn new(plan: &Compare, triangles: usize, samples: usize, progress: &Progress) -> Result<Field> {
        let pairs = triangles as u128 * samples as u128;
        let known = |name: &str| CATALOGUE.iter().find(|m| m.name == name);
        let (reference, rule) = match plan.reference {
            Some(info) => (Some(info), "as told".to_owned()),
            None if plan.methods.as_ref().is_some_and(|named| named.iter().any(|m| m.name == "oracle")) => {
                (known("oracle"), "named in --methods".to_owned())
            }
            None if pairs <= ORACLE_PAIRS => {
                (known("oracle"), format!("exact arithmetic on all {triangles} x {samples} pairs"))
            }
            None => (
                known("ray-cast").or(known("oracle")),
                format!(
                    "{triangles} x {samples} pairs are too many for the oracle; --reference oracle takes it all the same"
                ),
            ),
        };
        let Some(reference) = reference else {
            bail!("no reference method is built in; give --reference NAME")
        };
        let mut methods = vec![reference];
        match &plan.methods {
            Some(named) => methods.extend(named.iter().filter(|m| m.name != reference.name)),
            None => {
                for info in CATALOGUE.iter().filter(|m| m.name != reference.name) {
                    if info.name == "oracle" && pairs > ORACLE_PAIRS {
                        progress.note(
                            "note: oracle left out, it would take long; name it in --methods to run it",
                        );
                    } else {
                        methods.push(info);
                    }
                }
            }
        }
        Ok(Field { reference, rule, methods })
    }

    fn compare(
        &self,
        plan: &Compare,
        scene: &Scene,
        gbuffer: &GBuffer,
        light: &PointLight,
        pictures: Option<(&Path, usize, usize)>,
        progress: &Progress,
    ) -> Result<LightRows> {
        let casters = scene.soup.casters(light);
        let mut right: Vec<u8> = Vec::new();
        let mut rows: Vec<Row> = Vec::new();
        for info in &self.methods {
            progress.doing(format!("shadows: {}", info.name));
            let mut mask = vec![0; gbuffer.samples.positions.len()];
            let mut method = create(info.name, &plan.options)?;
            let stats =
                method.shadow(&casters.triangles, gbuffer.samples.view(), light.position, &mut mask)?;
            let is_reference = rows.is_empty();
            if is_reference {
                right.clone_from(&mask);
            }
            let found = mask::compare(&right, &mask)?;
            if let Some((dir, k, of)) = pictures {
                let path = files::numbered(&dir.join(format!("{}.png", info.name)), k, of);
                files::write_pixels(&path, plan.view.size, &mask::difference_picture(&right, &mask)?)?;
            }
            rows.push(Row::new(info, is_reference, &found, gbuffer.samples.width, StatsReport::new(&stats)));
        }
        let shadowed = right.iter().filter(|&&m| m == mask::SHADOWED).count();
        Ok(LightRows {
            position: light.position,
            triangles: casters.triangles.len(),
            shadowed,
            methods: rows,
        })
    }
}

impl Row {
    fn new(
        info: &MethodInfo,
        is_reference: bool,
        found: &Comparison,
        width: usize,
        stats: StatsReport,
    ) -> Row {
        Row {
            method: info.name,
            exact: info.exact,
            is_reference,
            mismatches: found.mismatches,
            leaks: found.leaks,
            acne: found.acne,
            stray: found.stray,
            first: found.first.map(|i| [i % width.max(1), i / width.max(1)]),
            ms: stats.total_ms,
            stats,
        }
    }
}

impl CompareReport {
    fn text(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!(
            "{}: {} triangles, {width}x{height}, {} samples\nreference: {} ({})\n",
            self.scene, self.triangles, self.samples, self.reference, self.reference_rule
        );
        for light in &self.lights {
            let [x, y, z] = light.position;
            text += &format!(
                "\nlight {x},{y},{z}: {} casters, {} samples shadowed\n",
                light.triangles, light.shadowed
            );
            let head = ["method", "exact", "mismatches", "leaks", "acne", "ms", "first at"];
            let mut rows = vec![head.map(str::to_owned).to_vec()];
            for row in &light.methods {
                rows.push(vec![
                    row.method.to_owned(),
                    if row.exact { "yes" } else { "no" }.to_owned(),
                    row.mismatches.to_string(),
                    row.leaks.to_string(),
                    row.acne.to_string(),
                    format!("{:.1}", row.ms),
                    match (row.is_reference, row.first) {
                        (true, _) => "(reference)".to_owned(),
                        (_, Some([x, y])) => format!("{x},{y}"),
                        _ => String::new(),
                    },
                ]);
            }
            text += &table(&rows, &[0, 1, 6]);
        }
        text += if self.agree { "\nall exact methods agree\n" } else { "\nAN EXACT METHOD DIFFERS\n" };
        text
    }
}
