//! Work is counted, not timed: on a noisy machine it is what shows that a method does more than it did.
//!
//! Most counters must come out the same for every thread count and instruction set, and not larger than recorded. Those that depend on
//! the order in which threads take work, or on the last bit of a bound, must not be larger than recorded with one thread.
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
    /// Depend neither on threads nor on the instruction set.
    counters: &'static [(&'static str, u64)],
    /// Of one thread.
    alone: &'static [(&'static str, u64)],
}

/// After an improvement, write the new numbers here.
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
        alone: &[],
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
        alone: &[],
    },
    Row {
        method: "light-tiles",
        scene: "atrium?size=20000",
        counters: &[("tiles", 69), ("block_leaves", 1_586), ("loose_samples", 1_030), ("setup_tris", 43_863)],
        alone: &[
            ("descents", 10_106),
            ("node_visits", 10_327),
            ("list_entries", 12_846),
            ("prepared", 30_915),
            ("leaf_box_tests", 33_060),
            ("pairs", 59_996),
            ("leaf_tests", 56_842),
        ],
    },
    Row {
        method: "light-tiles",
        scene: "room",
        counters: &[("tiles", 69), ("block_leaves", 1_388), ("loose_samples", 1_029), ("setup_tris", 22_370)],
        alone: &[
            ("descents", 6_926),
            ("node_visits", 7_119),
            ("list_entries", 10_430),
            ("prepared", 28_541),
            ("leaf_box_tests", 30_070),
            ("pairs", 59_927),
            ("leaf_tests", 55_961),
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
    let stats =
        pool.install(|| method.shadow(&scene.soup.positions, samples.view(), light, &mut mask)).unwrap();
    stats.counters.to_vec()
}

#[test]
fn no_method_does_more_than_it_did() {
    for row in ROWS {
        let (method, scene) = (row.method, row.scene);
        let all: Vec<_> = runs().into_iter().map(|run| (run, counters(row, run))).collect();
        let value = |list: &[(&str, u64)], name: &str| {
            let found = list.iter().find(|(n, _)| *n == name).map(|(_, v)| *v);
            found.unwrap_or_else(|| panic!("{method} has no counter {name} any more"))
        };
        let check = |name: &str, recorded: u64, now: u64, run: &Run| {
            assert!(
                now as f64 <= recorded as f64 * (1.0 + TOLERANCE / 100.0),
                "{method} on {scene}: {name} rose from {recorded} to {now}, {run:?}"
            );
        };
        for &(name, recorded) in row.counters {
            let now = value(&all[0].1, name);
            check(name, recorded, now, &all[0].0);
            for (run, found) in &all {
                assert_eq!(value(found, name), now, "{method} on {scene}: {name}, {run:?}");
            }
        }
        for &(name, recorded) in row.alone {
            for (run, found) in all.iter().filter(|(run, _)| run.threads == 1) {
                check(name, recorded, value(found, name), run);
            }
        }
    }
}
