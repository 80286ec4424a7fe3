//! Every engine on small pictures and lists, with ragged edges and gaps, against the definition itself.
//!
//! Embree is tried where its library is named (`ANTUMBRA_EMBREE_LIB`), and reported as skipped elsewhere.

use std::sync::Arc;

use antumbra::mask::{NONE, compare};
use antumbra::methods::{Method, Oracle};
use antumbra::samples::gbuffer::{self, GBufferOptions};
use antumbra::scene::procedural;
use antumbra_bench::engines::create;
use bench_common::{Case, Engine};

const ENGINES: &[&str] = &["antumbra:auto", "antumbra:ray-cast", "obvhs", "obvhs:fastest", "obvhs:medium"];
const EMBREE: &[&str] = &[
    "embree",
    "embree:16",
    "embree:sample",
    "embree:incoherent:robust",
    "embree:medium:join",
    "embree:eps=1e-4",
];

fn engines() -> Vec<Box<dyn Engine>> {
    let mut names = ENGINES.to_vec();
    match std::env::var_os(bench_embree::LIBRARY) {
        Some(_) => names.extend(EMBREE),
        None => println!("skipped: embree ({} is not set)", bench_embree::LIBRARY),
    }
    names.into_iter().map(|name| create(name, 2).unwrap()).collect()
}

/// A picture of a built-in scene with a piece cut out, or its samples as a list.
fn case(scene: &str, [width, height]: [usize; 2], is_list: bool) -> Arc<Case> {
    let scene = procedural::builtin(scene, None).unwrap();
    let mut seen =
        gbuffer::render(&scene, &scene.cameras[0], width, height, &GBufferOptions::default()).samples;
    seen.positions[width / 2..width].fill([f32::NAN; 3]);
    let (width, view) = if is_list { (width * height, None) } else { (width, seen.view) };
    Arc::new(Case::new(scene.soup.positions, seen.positions, width, scene.lights[0].position, view))
}

#[test]
fn engines_answer_right_and_again() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let mut engines = engines();
    for (scene, size, is_list) in [
        ("room", [101, 67], false),
        ("crowd?size=3000", [64, 33], true),
        ("forest?size=4000", [37, 9], false),
    ] {
        let case = case(scene, size, is_list);
        let mut expected = vec![NONE; case.samples.len()];
        Oracle.shadow(case.triangles(), case.asked(), case.light, &mut expected).unwrap();
        for engine in &mut engines {
            engine.prepare(&case).unwrap();
            let mut first = vec![77; case.samples.len()];
            let mut again = vec![78; case.samples.len()];
            for mask in [&mut first, &mut again] {
                let time = pool.install(|| engine.frame(mask)).unwrap();
                assert!(time.build_ms >= 0.0 && time.trace_ms > 0.0 && time.total_ms >= time.trace_ms);
            }
            let name = format!("{} on {scene}", engine.name());
            let found = compare(&expected, &first).unwrap();
            assert_eq!(first, again, "{name}: another frame, another answer");
            assert_eq!(found.stray, 0, "{name}: gaps, or bytes that are no answer");
            let allowed = if engine.exact() { 0 } else { found.samples / 50 };
            assert!(found.mismatches <= allowed, "{name}: {found:?}");
        }
    }
}

#[test]
fn no_triangles_no_shadow() {
    let case = Arc::new(Case::new(Vec::new(), vec![[1.0, 2.0, 3.0]; 70], 7, [0.0; 3], None));
    for mut engine in engines() {
        engine.prepare(&case).unwrap();
        let mut mask = vec![77; 70];
        engine.frame(&mut mask).unwrap();
        assert_eq!(mask, vec![0; 70], "{}", engine.name());
    }
}

#[test]
fn unknown_engines_are_told_what_there_is() {
    for name in ["optix", "antumbra:magic", "obvhs:slowest"] {
        let message = create(name, 1).err().unwrap().to_string();
        assert!(message.contains("known are"), "{name}: {message}");
    }
}
