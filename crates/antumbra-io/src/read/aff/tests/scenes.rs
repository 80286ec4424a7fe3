//! The three scenes of BART.

use std::path::Path;

use antumbra::scene::Scene;

use super::{AffFile, open};

/// `None`, and a line that says so, if the scenes are not there.
#[expect(clippy::print_stderr, reason = "a test that did not run should say so")]
fn bart(scene: &str, main: &str) -> Option<AffFile> {
    let scenes = std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes"),
        std::path::PathBuf::from,
    );
    let folder = scenes.join(format!("bart_{scene}/aff"));
    if !folder.is_dir() {
        eprintln!("skipped: {scene}: {} not found", folder.display());
        return None;
    }
    let file = open(&folder.join(main)).unwrap();
    Some(file)
}

/// Valid, and of the right size, at every time asked for.
fn check(file: &AffFile, times: [f32; 3], triangles: usize, lights: usize) -> [Scene; 3] {
    times.map(|time| {
        let scene = file.at(Some(time)).unwrap();
        scene.validate().unwrap();
        assert_eq!(scene.soup.len(), triangles);
        assert_eq!(scene.lights.len(), lights);
        assert_eq!(scene.cameras.len(), 1);
        scene
    })
}

#[track_caller]
fn assert_bounds(scene: &Scene, lo: [f32; 3], hi: [f32; 3]) {
    let bounds = scene.soup.bounds().unwrap();
    for k in 0..3 {
        let near = (bounds.0[k] - lo[k]).abs() < 0.06 && (bounds.1[k] - hi[k]).abs() < 0.06;
        assert!(near, "{bounds:?} instead of {lo:?} {hi:?}");
    }
}

#[test]
fn robots() {
    let Some(file) = bart("robots", "Robot.aff") else { return };
    assert_eq!(file.time_span(), Some([0.0, 50.0]));
    let scenes = check(&file, [0.0, 20.0, 47.0], 71_708, 1);
    // The feet come a little below the street while they walk.
    for (scene, lowest) in scenes.iter().zip([-0.62, -0.14, -0.49]) {
        assert_bounds(scene, [-164.1, lowest, -435.4], [164.1, 535.4, 250.1]);
    }
    assert_eq!(scenes[0].name, "Robot");
    assert!(scenes[0].soup.positions != scenes[1].soup.positions);
    let heads = scenes[0].objects.iter().filter(|o| o.name.ends_with("/head")).count();
    assert_eq!(heads, 10);
}

#[test]
fn museum() {
    let Some(file) = bart("museum", "museum5.aff") else { return };
    assert_eq!(file.time_span(), Some([-1.0, 5.0]));
    let scenes = check(&file, [-1.0, 1.5, 5.0], 11_692, 2);
    for scene in &scenes {
        assert_bounds(scene, [-5.0, -1.1, -9.9], [5.0, 5.0, 5.0]);
        assert_eq!(scene.cameras[0].fov, 45.0);
    }
    assert_eq!(scenes[0].cameras[0].eye, [0.0, 1.8, -9.0]);
}

#[test]
fn kitchen() {
    let Some(file) = bart("kitchen", "kitchen.aff") else { return };
    assert_eq!(file.time_span(), Some([0.0, 20.0]));
    let scenes = check(&file, [0.0, 9.5, 20.0], 110_561, 6);
    for scene in &scenes {
        assert_bounds(scene, [-2.0, -1.1, -3.8], [6.0, 2.9, 4.3]);
    }
    let blend = |m: &&u32| scenes[0].materials[**m as usize].base_color[3] < 1.0;
    assert_eq!(scenes[0].soup.material.iter().filter(blend).count(), 19_128);
}
