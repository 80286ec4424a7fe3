//! Real scenes. They are not part of the project: `ANTUMBRA_SCENES` names their folder.
#![allow(clippy::print_stderr, reason = "a skipped test says so")]

use std::path::{Path, PathBuf};
use std::time::Instant;

use antumbra::scene::{AlphaMode, Scene};
use antumbra_io::SceneFile;

fn folder() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes");
    std::env::var_os("ANTUMBRA_SCENES").map_or_else(beside, PathBuf::from)
}

/// What is known about a scene.
struct Known {
    file: &'static str,
    triangles: usize,
    lights: usize,
    cameras: usize,
    /// Smallest and largest coordinates in the rest pose.
    bounds: [[f32; 3]; 2],
    /// How far they may be off: the digits given, or what the pose changes.
    tolerance: f32,
}

/// Opens a scene, poses it, and checks what is known. `None` if the scenes are not there.
fn check(known: &Known) -> Option<(SceneFile, Scene)> {
    let folder = folder();
    if !folder.is_dir() {
        eprintln!("skipped: {}: {} not found", known.file, folder.display());
        return None;
    }
    let start = Instant::now();
    let file = antumbra_io::open(&folder.join(known.file)).unwrap_or_else(|e| panic!("{e}"));
    let opened = start.elapsed();
    let scene = file.at(None).unwrap_or_else(|e| panic!("{e}"));
    eprintln!("{}: open {opened:?}, at {:?}", known.file, start.elapsed() - opened);
    valid(&scene, known);
    let (lo, hi) = scene.soup.bounds().unwrap_or_default();
    for (got, expected) in lo.iter().chain(&hi).zip(known.bounds.as_flattened()) {
        assert!((got - expected).abs() <= known.tolerance, "{}: {lo:?} .. {hi:?}", known.file);
    }
    Some((file, scene))
}

fn valid(scene: &Scene, known: &Known) {
    scene.validate().unwrap_or_else(|e| panic!("{}: {e}", known.file));
    let counts = (scene.soup.len(), scene.lights.len(), scene.cameras.len());
    assert_eq!(counts, (known.triangles, known.lights, known.cameras), "{}", known.file);
}

/// [`check`], then three times within the animation, at which something must have moved.
fn check_moving(known: &Known, span: [f32; 2]) {
    let Some((file, rest)) = check(known) else { return };
    let got = file.time_span().unwrap_or_else(|| panic!("{} does not move", known.file));
    assert!((0..2).all(|k| (got[k] - span[k]).abs() < 0.05), "{}: {got:?}", known.file);
    let mut before = rest.soup.positions;
    for part in [0.23, 0.52, 0.81] {
        let scene = file.at(Some(got[0] + part * (got[1] - got[0]))).unwrap_or_else(|e| panic!("{e}"));
        valid(&scene, known);
        let moved = scene.soup.positions != before;
        assert!(moved, "{} stands still at {part} of its time", known.file);
        before = scene.soup.positions;
    }
}

fn share(scene: &Scene, mode: impl Fn(AlphaMode) -> bool) -> usize {
    scene.soup.material.iter().filter(|&&m| mode(scene.materials[m as usize].alpha_mode)).count()
}

fn masked(mode: AlphaMode) -> bool {
    matches!(mode, AlphaMode::Mask { .. })
}

#[test]
fn sponza() {
    let bounds = [[-1920.9, -126.4, -1105.4], [1799.9, 1429.4, 1182.8]];
    let known = Known {
        file: "crytek_sponza/sponza.glb",
        triangles: 279_163,
        lights: 0,
        cameras: 0,
        bounds,
        tolerance: 0.06,
    };
    if let Some((_, scene)) = check(&known) {
        assert_eq!((share(&scene, masked), scene.objects.len()), (31_468, 382));
        assert!(!scene.textures.is_empty());
    }
}

#[test]
fn robots() {
    let bounds = [[-164.1, -0.6, -435.4], [164.1, 535.4, 250.1]];
    let known = Known {
        file: "bart_robots/bart_robots.glb",
        triangles: 71_708,
        lights: 1,
        cameras: 1,
        bounds,
        tolerance: 0.06,
    };
    check_moving(&known, [0.0, 50.0]);
}

#[test]
fn museum() {
    let bounds = [[-5.0, -1.1, -9.9], [5.0, 5.0, 5.0]];
    let known = Known {
        file: "bart_museum/bart_museum.glb",
        triangles: 11_692,
        lights: 2,
        cameras: 1,
        bounds,
        tolerance: 0.06,
    };
    check_moving(&known, [0.0, 6.0]);
}

#[test]
fn kitchen() {
    let bounds = [[-2.0, -1.1, -3.8], [6.0, 2.9, 4.3]];
    let known = Known {
        file: "bart_kitchen/bart_kitchen.glb",
        triangles: 110_561,
        lights: 6,
        cameras: 1,
        bounds,
        tolerance: 0.06,
    };
    check_moving(&known, [0.0, 20.0]);
}

#[test]
fn black_forest() {
    let bounds = [[-2177.9, -482.7, -2543.7], [1971.7, 556.9, 1817.5]];
    let file = "stk_black_forest/black_forest.glb";
    let known = Known { file, triangles: 594_662, lights: 204, cameras: 0, bounds, tolerance: 0.06 };
    check_moving(&known, [0.0, 18.0]);
    if let Some((_, scene)) = check(&known) {
        assert_eq!((share(&scene, masked), share(&scene, |m| m == AlphaMode::Blend)), (115_550, 3_218));
    }
}

#[test]
fn candela_city() {
    let bounds = [[-2132.2, -695.2, -1523.8], [1723.6, 419.6, 1362.8]];
    let file = "stk_candela_city/candela_city.glb";
    let known = Known { file, triangles: 407_352, lights: 94, cameras: 0, bounds, tolerance: 0.06 };
    check_moving(&known, [0.0, 37.4]);
}

#[test]
fn bathroom() {
    let bounds = [[-2.7, 0.0, -2.5], [2.5, 2.8, -0.05]];
    let known = Known {
        file: "bathroom/bathroom.glb",
        triangles: 380_280,
        lights: 0,
        cameras: 0,
        bounds,
        tolerance: 0.06,
    };
    if let Some((_, scene)) = check(&known) {
        assert_eq!((share(&scene, |m| m == AlphaMode::Blend), scene.objects.len()), (12_800, 851));
    }
}

#[test]
fn ingolstadt() {
    let bounds = [[-13.8, -7.1, -366.4], [176.7, 16.9, 124.2]];
    let file = "ingolstadt_lod3/ingolstadt_lod3.glb";
    check(&Known { file, triangles: 147_845, lights: 0, cameras: 0, bounds, tolerance: 0.06 });
}

#[test]
fn schependomlaan() {
    let bounds = [[-1.0, -0.6, -24.4], [22.9, 13.1, 0.0]];
    let file = "schependomlaan_bim/schependomlaan_bim.glb";
    check(&Known { file, triangles: 60_204, lights: 0, cameras: 0, bounds, tolerance: 0.06 });
}

#[test]
fn neurons() {
    let bounds = [[1.7, 9.3, 8.2], [17.7, 30.0, 23.0]];
    let file = "neurons/neuron_tubes.glb";
    check(&Known { file, triangles: 232_150, lights: 0, cameras: 0, bounds, tolerance: 0.06 });
}

#[test]
fn pine() {
    let bounds = [[-29.2, 0.0, -29.1], [29.1, 75.0, 28.2]];
    let known = Known {
        file: "pine_tree/pine_tree.glb",
        triangles: 1_650,
        lights: 0,
        cameras: 0,
        bounds,
        tolerance: 0.06,
    };
    if let Some((_, scene)) = check(&known) {
        assert_eq!(share(&scene, masked), 1_442);
    }
}

#[test]
fn fox() {
    let bounds = [[-12.6, -0.1, -88.1], [12.6, 78.9, 66.6]];
    // The bounds are those of the mesh before its skin; the rest pose of the joints is nearly the same.
    let known = Known { file: "fox/Fox.glb", triangles: 576, lights: 0, cameras: 0, bounds, tolerance: 0.06 };
    check_moving(&known, [0.0, 3.42]);
}
