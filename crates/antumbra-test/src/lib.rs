//! The shared test runner: every method, thread count and instruction set against the oracle, to 0 mismatches.
//!
//! A [`Case`] is a scene with a camera, a light and a picture size; [`cases`] has one for every built-in failure mode and
//! small versions of the big scenes. [`check`] runs one method over one case and reports the first wrong samples with
//! their pixel, position and a blocking triangle.

use antumbra::mask::NONE;
use antumbra::methods::{self, Method, Options, Samples};
use antumbra::samples::{ViewSamples, gbuffer};
use antumbra::scene::{Camera, PointLight, Scene, Triangle, procedural};
use antumbra::{Isa, samples::gbuffer::GBufferOptions};

pub mod random;

/// What is asked: casters, samples, a light; and the oracle's answer.
#[derive(Clone, Debug)]
pub struct Case {
    /// For reports.
    pub name: String,
    /// The casters.
    pub triangles: Vec<Triangle>,
    /// The view samples.
    pub samples: ViewSamples,
    /// Where the light is.
    pub light: [f32; 3],
    /// The oracle's mask.
    pub expected: Vec<u8>,
}

impl Case {
    /// Renders the samples of a scene and asks the oracle.
    pub fn new(name: &str, scene: &Scene, camera: &Camera, light: [f32; 3], size: [usize; 2]) -> Case {
        let out = gbuffer::render(scene, camera, size[0], size[1], &GBufferOptions::default());
        Case::from_samples(name, scene.soup.positions.clone(), out.samples, light)
    }

    /// Asks the oracle about given samples.
    pub fn from_samples(name: &str, triangles: Vec<Triangle>, samples: ViewSamples, light: [f32; 3]) -> Case {
        let mut expected = vec![NONE; samples.positions.len()];
        let mut oracle = methods::Oracle;
        oracle
            .shadow(&triangles, samples.view(), light, &mut expected)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        Case { name: name.to_owned(), triangles, samples, light, expected }
    }

    /// A built-in scene seen by its own camera, lit by its own light.
    pub fn builtin(spec: &str, size: [usize; 2]) -> Case {
        let scene = procedural::builtin(spec, None).unwrap_or_else(|e| panic!("{spec}: {e}"));
        let camera = scene.cameras.first().unwrap_or_else(|| panic!("{spec} has no camera")).clone();
        let light = scene.lights.first().unwrap_or_else(|| panic!("{spec} has no light")).position;
        Case::new(spec, &scene, &camera, light, size)
    }

    /// The same case with another light.
    pub fn with_light(&self, light: [f32; 3]) -> Case {
        Case::from_samples(
            &format!("{} light {light:?}", self.name),
            self.triangles.clone(),
            self.samples.clone(),
            light,
        )
    }

    /// The same case with triangles in another order and corners rotated or mirrored: nothing may change.
    pub fn shuffled(&self, seed: u64) -> Case {
        let mut random = random::Random::new(seed);
        let mut triangles = self.triangles.clone();
        for i in (1..triangles.len()).rev() {
            triangles.swap(i, random.below(i as u64 + 1) as usize);
        }
        for t in &mut triangles {
            t.rotate_left(random.below(3) as usize);
            if random.below(2) == 1 {
                t.swap(0, 1);
            }
        }
        Case { name: format!("{} shuffled", self.name), triangles, ..self.clone() }
    }
}

/// A built-in scene of about `triangles` triangles, where its size can be chosen: the oracle is a plain loop.
pub fn sized(builtin: &procedural::BuiltinInfo, triangles: usize) -> String {
    let has_size = builtin.parameters.iter().find(|p| p.name == "size");
    match has_size {
        Some(p) if !builtin.failure_mode => {
            format!("{}?size={}", builtin.name, (triangles as u64).clamp(p.range[0], p.range[1]))
        }
        _ => builtin.name.to_owned(),
    }
}

/// Every built-in failure mode at picture size `size`, and small versions of the big scenes.
pub fn cases(size: [usize; 2]) -> Vec<Case> {
    procedural::BUILTINS.iter().map(|b| Case::builtin(&sized(b, 2000), size)).collect()
}

/// How a method is run.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Threads of the pool.
    pub threads: usize,
    /// Instruction set.
    pub isa: Isa,
}

/// One and two threads, each with every instruction set that this machine has.
pub fn runs() -> Vec<Run> {
    let levels = Isa::available();
    [1, 2].into_iter().flat_map(|threads| levels.iter().map(move |&isa| Run { threads, isa })).collect()
}

/// Runs `method` over `case`; `Err` is a report that names the first wrong samples.
pub fn check(method: &str, case: &Case, run: Run) -> Result<(), String> {
    let options = Options { isa: run.isa, ..Options::default() };
    let mut method = methods::create(method, &options).map_err(|e| e.to_string())?;
    check_made(method.as_mut(), case, run)
}

/// As [`check`], for a method made by the caller (with options of its own).
pub fn check_made(method: &mut dyn Method, case: &Case, run: Run) -> Result<(), String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(run.threads).build().map_err(|e| e.to_string())?;
    let mut mask = vec![77; case.expected.len()];
    pool.install(|| method.shadow(&case.triangles, case.samples.view(), case.light, &mut mask))
        .map_err(|e| format!("{}: {e}", case.name))?;
    report(method.name(), case, run, &mask)
}

/// As a bare list in a scattered order, which no method may rely on.
pub fn check_as_list(method: &mut dyn Method, case: &Case, run: Run) -> Result<(), String> {
    let n = case.expected.len();
    let mut order: Vec<usize> = (0..n).collect();
    let mut random = random::Random::new(n as u64);
    for i in (1..n).rev() {
        order.swap(i, random.below(i as u64 + 1) as usize);
    }
    let points: Vec<[f32; 3]> = order.iter().map(|&i| case.samples.positions[i]).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(run.threads).build().map_err(|e| e.to_string())?;
    let mut list_mask = vec![77; n];
    pool.install(|| method.shadow(&case.triangles, Samples::list(&points), case.light, &mut list_mask))
        .map_err(|e| format!("{}: {e}", case.name))?;
    let mut mask = vec![77; n];
    for (&i, m) in order.iter().zip(list_mask) {
        mask[i] = m;
    }
    report(&format!("{} (list)", method.name()), case, run, &mask)
}

fn report(method: &str, case: &Case, run: Run, mask: &[u8]) -> Result<(), String> {
    let wrong: Vec<usize> = (0..mask.len()).filter(|&i| mask[i] != case.expected[i]).collect();
    if wrong.is_empty() {
        return Ok(());
    }
    let mut text = format!(
        "{method} on {} ({} threads, {}): {} of {} samples differ from the oracle",
        case.name,
        run.threads,
        run.isa.name(),
        wrong.len(),
        mask.len()
    );
    for &i in wrong.iter().take(3) {
        let p = case.samples.positions[i];
        let width = case.samples.width.max(1);
        let blocker = case.triangles.iter().position(|t| blocks(t, case.light, p));
        text += &format!(
            "\n  sample {i} (pixel {}, {}) at {p:?} ({:08x?}): expected {}, got {}; blocking triangle: {:?}; light {:?}",
            i % width,
            i / width,
            p.map(f32::to_bits),
            case.expected[i],
            mask[i],
            blocker.map(|b| (b, case.triangles[b])),
            case.light
        );
    }
    Err(text)
}

fn blocks(t: &Triangle, light: [f32; 3], p: [f32; 3]) -> bool {
    !p[0].is_nan() && antumbra_predicates::exact::blocks(t, light, p)
}

/// The default light of a scene moved to places that hurt: inside geometry, on a diagonal of the view, far away.
pub fn nasty_lights(scene: &Scene) -> Vec<PointLight> {
    let Some((lo, hi)) = scene.soup.bounds() else { return Vec::new() };
    let size = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f32::max);
    let middle = [0, 1, 2].map(|k| lo[k] * 0.5 + hi[k] * 0.5);
    let corner = scene.soup.positions.first().map_or(middle, |t| t[0]);
    let at = |d: [f32; 3]| PointLight::at([0, 1, 2].map(|k| middle[k] + d[k] * size));
    vec![
        PointLight::at(middle),
        PointLight::at(corner),
        at([1.0, 1.0, 1.0]),
        at([1e4, 3e3, -2e3]),
        at([0.0, 1.0, 0.0]),
    ]
}
