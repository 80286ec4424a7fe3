//! Every exact method against the oracle: all failure modes, all threads, all instruction sets, lists, other lights.

use antumbra::Isa;
use antumbra::methods::{CATALOGUE, Options, create};
use antumbra::samples::{ViewSamples, points};
use antumbra::scene::procedural;
use antumbra_test::random::Random;
use antumbra_test::{Case, Run, cases, check, check_as_list, nasty_lights, runs, sized};

fn exact_methods() -> impl Iterator<Item = &'static str> {
    CATALOGUE.iter().filter(|m| m.exact && m.name != "oracle").map(|m| m.name)
}

const ONE: Run = Run { threads: 2, isa: Isa::Auto };

/// Collects reports, so that one failure does not hide the others.
fn all_pass(results: impl Iterator<Item = Result<(), String>>) {
    let failures: Vec<String> = results.filter_map(Result::err).collect();
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn every_scene_every_thread_count_every_instruction_set() {
    for case in cases([72, 48]) {
        all_pass(
            exact_methods()
                .flat_map(|m| runs().into_iter().map(|run| check(m, &case, run)).collect::<Vec<_>>()),
        );
    }
}

#[test]
fn order_of_triangles_and_corners_changes_nothing() {
    for case in cases([48, 32]) {
        let shuffled = case.shuffled(5);
        all_pass(exact_methods().map(|m| check(m, &shuffled, ONE)));
    }
}

#[test]
fn lists_in_any_order_get_the_same_answer() {
    for case in cases([48, 32]) {
        all_pass(exact_methods().map(|m| {
            let mut method = create(m, &Options::default()).map_err(|e| e.to_string())?;
            check_as_list(method.as_mut(), &case, ONE)
        }));
    }
}

#[test]
fn lights_in_nasty_places() {
    for builtin in procedural::BUILTINS {
        let spec = sized(builtin, 1000);
        let scene = procedural::builtin(&spec, None).unwrap_or_else(|e| panic!("{spec}: {e}"));
        let case = Case::builtin(&spec, [40, 24]);
        for light in nasty_lights(&scene) {
            let case = case.with_light(light.position);
            all_pass(exact_methods().map(|m| check(m, &case, ONE)));
        }
    }
}

#[test]
fn random_soup_on_a_lattice_is_full_of_ties() {
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let mut lattice = |n: u64| [0; 3].map(|_: i32| random.below(n) as f32 - (n / 2) as f32);
        let triangles: Vec<_> = (0..150).map(|_| [lattice(7), lattice(7), lattice(7)]).collect();
        let asked: Vec<_> = (0..700).map(|_| lattice(9)).collect();
        let light = lattice(5);
        let samples = points::from_points(&asked).expect("finite");
        let case = Case::from_samples(&format!("lattice seed {seed}"), triangles, samples, light);
        all_pass(exact_methods().map(|m| check(m, &case, ONE)));
    }
}

#[test]
fn huge_and_tiny_numbers() {
    for (name, scale) in [("1e38", 1e38f32), ("1e-38", 1e-38), ("1e-44", 1e-44), ("1e15", 1e15)] {
        let mut random = Random::new(3);
        let mut point = || [0; 3].map(|_: i32| random.range(-3.0, 3.0) * scale);
        let triangles: Vec<_> = (0..60).map(|_| [point(), point(), point()]).collect();
        let asked: Vec<_> = (0..400).map(|_| point()).collect();
        let samples = points::from_points(&asked).expect("finite");
        let case = Case::from_samples(name, triangles, samples, point());
        all_pass(exact_methods().map(|m| check(m, &case, ONE)));
    }
}

#[test]
fn mixed_magnitudes() {
    for seed in 0..8 {
        let mut random = Random::new(seed);
        let mut number = || {
            let v = f32::from_bits(random.bits() as u32);
            if v.is_finite() { v } else { 0.0 }
        };
        let mut point = || [number(), number(), number()];
        let triangles: Vec<_> = (0..80).map(|_| [point(), point(), point()]).collect();
        let asked: Vec<_> = (0..300).map(|_| point()).collect();
        let light = point();
        let samples = ViewSamples { width: 20, height: 15, positions: asked, ..ViewSamples::default() };
        let case = Case::from_samples(&format!("any bits, seed {seed}"), triangles, samples, light);
        all_pass(exact_methods().map(|m| check(m, &case, ONE)));
    }
}

#[test]
fn input_errors_name_the_thing() {
    let good = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0]];
    let positions = [[0.0, 0.0, 1.0], [f32::NAN; 3]];
    let samples = antumbra::methods::Samples::list(&positions);
    for info in CATALOGUE {
        let mut method = create(info.name, &Options::default()).expect("in the catalogue");
        let mut mask = [7; 2];
        let error = method.shadow(&[good, bad], samples, [0.0; 3], &mut mask).unwrap_err().to_string();
        assert!(error.contains("triangle 1, vertex 2"), "{}: {error}", info.name);
        let error =
            method.shadow(&[good], samples, [f32::INFINITY, 0.0, 0.0], &mut mask).unwrap_err().to_string();
        assert!(error.contains("light"), "{}: {error}", info.name);
        assert!(method.shadow(&[good], samples, [0.0; 3], &mut mask[..1]).is_err(), "{}", info.name);
        let infinite = [[0.0, f32::INFINITY, 1.0], [0.0; 3]];
        let infinite = antumbra::methods::Samples::list(&infinite);
        assert!(method.shadow(&[good], infinite, [0.0; 3], &mut mask).is_err(), "{}", info.name);
        assert!(method.shadow(&[], samples, [0.0; 3], &mut mask).is_ok(), "{}", info.name);
        assert_eq!(mask, [antumbra::mask::LIT, antumbra::mask::NONE], "{}", info.name);
    }
}
