//! What every built-in scene promises.

use std::collections::HashMap;

use super::*;

fn make(spec: &str) -> Scene {
    builtin(spec, None).unwrap()
}

fn bits(scene: &Scene) -> Vec<u32> {
    scene.soup.positions.as_flattened().as_flattened().iter().map(|v| v.to_bits()).collect()
}

#[test]
fn every_scene_is_valid_and_about_as_big_as_it_says() {
    for info in BUILTINS {
        let scales = info.parameters.iter().any(|p| p.name == "size");
        let size = if scales { 40_000 } else { info.default_triangles };
        let scene = if scales { make(&format!("{}?size={size}", info.name)) } else { make(info.name) };
        scene.validate().unwrap();
        assert_eq!(scene.name, info.name);
        assert!(!scene.lights.is_empty() && !scene.cameras.is_empty(), "{}", info.name);
        let error = (scene.soup.len() as f64 - size as f64).abs();
        assert!(error <= 0.15 * size as f64, "{}: {} triangles for {size}", info.name, scene.soup.len());
        assert!(!info.failure_mode || scene.soup.len() <= 20_000, "{}", info.name);
        let used = |k: u32| scene.soup.object.contains(&k);
        assert!((0..scene.objects.len() as u32).all(used), "{}: an object is empty", info.name);
        assert!(scene.objects.iter().all(|o| !o.name.is_empty()));
    }
}

#[test]
fn names_are_unique() {
    for (k, info) in BUILTINS.iter().enumerate() {
        assert!(BUILTINS[..k].iter().all(|other| other.name != info.name), "{}", info.name);
    }
}

/// Triangles of one object by name.
fn object(scene: &Scene, name: &str) -> Vec<[[u32; 3]; 3]> {
    let id = scene.objects.iter().position(|o| o.name == name).unwrap() as u32;
    let soup = &scene.soup;
    let of = (0..soup.len()).filter(|&k| soup.object[k] == id);
    of.map(|k| soup.positions[k].map(|p| p.map(f32::to_bits))).collect()
}

#[track_caller]
fn assert_closed(scene: &Scene, name: &str) {
    let mut edges = HashMap::new();
    for t in object(scene, name) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *edges.entry((a, b)).or_insert(0) += 1;
            *edges.entry((b, a)).or_insert(0) -= 1;
        }
    }
    assert!(!edges.is_empty());
    let open = edges.values().filter(|&&count| count != 0).count();
    assert_eq!(open, 0, "{} / {name}", scene.name);
}

#[test]
fn meshes_that_look_closed_are_closed() {
    for (spec, names) in [
        ("room", &["table", "lantern", "ball", "globe", "chair 1", "shelves", "stairs", "railing"][..]),
        ("fan", &["sphere"]),
        ("fan-rotated", &["sphere"]),
        ("lattice", &["cubes"]),
        ("seams", &["room", "cubes"]),
        ("layers", &["plates"]),
        ("tiny", &["pebble"]),
        ("offset", &["ball"]),
        ("light-inside", &["ball"]),
        ("hairball?size=20000", &["hair"]),
        ("statue?size=20000", &["statue", "plinth"]),
        ("crowd?size=20000", &["person 1", "person 9", "lamp post"]),
        ("forest?size=20000", &["stones"]),
        ("atrium?size=40000", &["balustrade 0.1", "balustrade 1.1"]),
    ] {
        let scene = make(spec);
        names.iter().for_each(|name| assert_closed(&scene, name));
    }
}

#[test]
fn the_seed_decides() {
    for spec in [
        "room",
        "degenerate",
        "slivers",
        "interpenetrating",
        "hairball?size=20000",
        "city?size=40000",
        "atrium?size=40000",
        "statue?size=20000",
        "forest?size=20000",
        "crowd?size=20000",
    ] {
        let with = |seed: u32| {
            bits(&make(&format!("{spec}{}seed={seed}", if spec.contains('?') { '&' } else { '?' })))
        };
        assert_eq!(with(1), bits(&make(spec)), "{spec}");
        assert_eq!(with(7), with(7), "{spec}");
        assert_ne!(with(7), with(8), "{spec}");
    }
}

#[test]
fn errors_say_what_is_right() {
    let message = |spec: &str| builtin(spec, None).unwrap_err().to_string();
    assert!(message("rooom").contains("`rooom`") && message("rooom").contains("room, "));
    let other = message("room?colour=3");
    assert!(other.contains("`colour`") && other.contains("`seed` (another"), "{other}");
    let value = message("room?seed=many");
    assert!(value.contains("seed=many") && value.contains("whole number from 0 to"), "{value}");
    assert_eq!(message("room?seed"), message("room?seed="));
    assert_eq!(time_span("rooom"), None);
}

#[test]
fn the_crowd_walks_and_the_rest_stands() {
    let at = |spec: &str, time: f32| builtin(spec, Some(time)).unwrap();
    let crowd = "crowd?size=20000";
    let [start, later] = [0.0, 0.5].map(|t| at(crowd, t));
    assert_eq!(start.soup.len(), later.soup.len());
    assert_eq!(start.soup.object, later.soup.object);
    assert_ne!(bits(&start), bits(&later));
    assert_eq!(bits(&start), bits(&builtin(crowd, None).unwrap()));
    assert_eq!(time_span(crowd), Some([0.0, 10.0]));
    // Time stays within the span.
    assert_eq!(bits(&at(crowd, 10.0)), bits(&at(crowd, 1e9)));
    assert_eq!(bits(&start), bits(&at(crowd, f32::NAN)));
    assert_eq!(bits(&at("fan", 0.0)), bits(&at("fan", 5.0)));
    for info in BUILTINS {
        assert_eq!(time_span(info.name).is_some(), info.animated, "{}", info.name);
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for spec in ["hairball?size=50000", "statue?size=150000"] {
        assert_eq!(one.install(|| bits(&make(spec))), bits(&make(spec)), "{spec}");
    }
}
