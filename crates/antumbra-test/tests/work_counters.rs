//! Work is counted, not timed: on a noisy machine it is what shows that a method does more than it did.
//!
//! Every counter must come out the same for every thread count and instruction set, and not larger than recorded.
//! `bench/counts.sh` holds instructions in the same way.

use antumbra::methods::{self, Options};
use antumbra::samples::gbuffer::{self, GBufferOptions};
use antumbra::scene::procedural;
use antumbra_test::{Run, runs};

/// Per cent that a counter may rise.
const TOLERANCE: f64 = 3.0;

/// What a method did for a frame, when it was last looked at.
struct Row {
    method: &'static str,
    scene: &'static str,
    counters: &'static [(&'static str, u64)],
}

/// After an improvement, write the new numbers here. Only counters that depend neither on threads nor on the instruction set.
const ROWS: &[Row] = &[
    Row {
        method: "ray-cast",
        scene: "atrium?size=20000",
        counters: &[
            ("packets", 430),
            ("node_visits", 13_992),
            ("leaf_visits", 18_404),
            ("triangle_setups", 88_179),
            ("refinements", 123_134),
            ("leaf_tests", 223_932),
        ],
    },
    Row {
        method: "ray-cast",
        scene: "room",
        counters: &[
            ("packets", 278),
            ("node_visits", 10_830),
            ("leaf_visits", 18_121),
            ("triangle_setups", 96_477),
            ("refinements", 117_575),
            ("leaf_tests", 232_337),
        ],
    },
];

const SIZE: [usize; 2] = [160, 90];

fn counters(row: &Row, run: Run) -> Vec<(&'static str, u64)> {
    let scene = procedural::builtin(row.scene, None).unwrap();
    let samples =
        gbuffer::render(&scene, &scene.cameras[0], SIZE[0], SIZE[1], &GBufferOptions::default()).samples;
    let mut method = methods::create(row.method, &Options { isa: run.isa, count: true }).unwrap();
    let mut mask = vec![0; SIZE[0] * SIZE[1]];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(run.threads).build().unwrap();
    let light = scene.lights[0].position;
    pool.install(|| method.shadow(&scene.soup.positions, samples.view(), light, &mut mask)).unwrap().counters
}

#[test]
fn no_method_does_more_than_it_did() {
    for row in ROWS {
        let (method, scene) = (row.method, row.scene);
        let all: Vec<_> = runs().into_iter().map(|run| (run, counters(row, run))).collect();
        for &(name, recorded) in row.counters {
            let value = |list: &[(&str, u64)]| list.iter().find(|(n, _)| *n == name).map(|(_, v)| *v);
            let now = value(&all[0].1).unwrap_or_else(|| panic!("{method} has no counter {name} any more"));
            assert!(
                now as f64 <= recorded as f64 * (1.0 + TOLERANCE / 100.0),
                "{method} on {scene}: {name} rose from {recorded} to {now}"
            );
            for (run, found) in &all {
                assert_eq!(value(found), Some(now), "{method} on {scene}: {name}, {run:?}");
            }
        }
    }
}
