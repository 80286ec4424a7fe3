//! Scenes that do not ship with the project; skipped by name where they are not there.

use std::path::PathBuf;
use std::time::Instant;

#[allow(clippy::print_stderr)]
fn count(name: &str, triangles: usize) {
    let folder = std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes")),
        PathBuf::from,
    );
    if !folder.is_dir() {
        eprintln!("skipped: {name}: {} not found", folder.display());
        return;
    }
    let start = Instant::now();
    let scene = crate::scene(&folder.join(name));
    eprintln!("{name}: {:?}", start.elapsed());
    assert_eq!(scene.soup.len(), triangles);
}

#[test]
fn conference() {
    count("conference/conference.ply", 331_179);
}

#[test]
fn dragon() {
    count("stanford_dragon/dragon_vrip.ply", 871_414);
    count("stanford_dragon/dragon_vrip_res3.ply", 47_794);
}

#[test]
fn neurons() {
    count("neurons/neuron_meshes.ply", 68_555);
}
