//! The frame that is counted.

use std::sync::OnceLock;

use antumbra::Isa;
use antumbra::methods::{self, Method, Options, Samples, Stats, info};
use antumbra::samples::gbuffer::{self, GBufferOptions};
use antumbra::scene::{InputError, Triangle, procedural};
use anyhow::{Context, Result};

use crate::record::Case;

/// Why a case cannot be run here, if it cannot.
pub(crate) fn possible(case: &Case) -> Result<(), String> {
    if info(&case.method).is_err() {
        return Err(format!("there is no method {} in this build", case.method));
    }
    match Isa::parse(&case.isa) {
        Ok(_) => Ok(()),
        Err(e) => Err(e.to_string()),
    }
}

/// Makes the arrays, runs a frame for memory to be there, and the frame that counts; both on one thread.
pub(crate) fn run(method: &str, scene: &str, size: &str, isa: &str) -> Result<Stats> {
    let [width, height] = parse_size(size)?;
    let isa = Isa::parse(isa)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let scene = procedural::builtin(scene, None)?;
        let camera = scene.cameras.first().context("the scene has no camera")?;
        let light = scene.lights.first().context("the scene has no light")?.position;
        // The eye's part is not what is counted, and the same samples are to be asked whatever the instruction set.
        let seen = gbuffer::render(&scene, camera, width, height, &GBufferOptions::default()).samples;
        let mut method = methods::create(method, &Options { isa, count: true })?;
        let mut mask = vec![0; width * height];
        let triangles = &scene.soup.positions;
        method.shadow(triangles, seen.view(), light, &mut mask)?;
        Ok(counted_frame(method.as_mut(), triangles, seen.view(), light, &mut mask)?)
    })
}

/// Callgrind counts what happens in here. The name is in the command that starts it: not mangled away, not inlined.
#[inline(never)]
pub(crate) fn counted_frame(
    method: &mut dyn Method,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
    mask: &mut [u8],
) -> Result<Stats, InputError> {
    // Keeps the compiler from merging this function with the call in it.
    static ENTERED: OnceLock<()> = OnceLock::new();
    let _ = ENTERED.set(());
    method.shadow(triangles, samples, light, mask)
}

fn parse_size(text: &str) -> Result<[usize; 2]> {
    let (width, height) = text.split_once('x').with_context(|| format!("'{text}' is not a size WxH"))?;
    Ok([width.parse()?, height.parse()?])
}
