//! The default method allocates nothing once it has seen a frame.
//!
//! A test binary of its own, with one test: the allocator counts for the whole process.

use std::alloc::System;

use antumbra::methods::{self, Method, Options, Samples};
use antumbra::samples::gbuffer::{self, GBufferOptions};
use antumbra::scene::{Triangle, procedural};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations of one more frame. With one thread: with more, chance says who takes what, and a worker that takes more than ever before makes room
/// for it. The thread must stay: one that ends allocates at a moment of its own.
fn more(
    pool: &rayon::ThreadPool,
    method: &mut dyn Method,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> usize {
    let mut mask = vec![0; samples.positions.len()];
    pool.install(|| {
        method.shadow(triangles, samples, light, &mut mask).unwrap();
        let region = Region::new(ALLOCATOR);
        method.shadow(triangles, samples, light, &mut mask).unwrap();
        let change = region.change();
        change.allocations + change.reallocations
    })
}

#[test]
fn a_second_frame_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for name in ["atrium?size=20000", "hairball?size=20000", "room", "layers", "fan"] {
        let scene = procedural::builtin(name, None).unwrap();
        let samples =
            gbuffer::render(&scene, &scene.cameras[0], 240, 160, &GBufferOptions::default()).samples;
        let light = scene.lights[0].position;
        let mut method = methods::create("light-tiles", &Options::default()).unwrap();
        let view = samples.view();
        assert_eq!(more(&pool, method.as_mut(), &scene.soup.positions, view, light), 0, "{name}");
        // Another shape of work, and back.
        let list = Samples::list(&view.positions[..9000]);
        assert_eq!(more(&pool, method.as_mut(), &scene.soup.positions, list, light), 0, "{name}, a list");
        // Clumps: samples in crowded cells, which get grids of their own.
        let clumps: Vec<[f32; 3]> = (0..40_000)
            .map(|i| {
                let at = view.positions.iter().filter(|p| !p[0].is_nan()).nth(i % 3).unwrap();
                [at[0] + (i % 200) as f32 * 1e-5, at[1], at[2] + (i / 200) as f32 * 1e-5]
            })
            .collect();
        assert_eq!(
            more(&pool, method.as_mut(), &scene.soup.positions, Samples::list(&clumps), light),
            0,
            "{name}, clumps"
        );
    }
}
