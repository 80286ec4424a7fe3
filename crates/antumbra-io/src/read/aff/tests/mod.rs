//! One small file per behaviour; BART itself if it is there.

mod animation;
mod hostile;
mod scenes;
mod statements;

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use antumbra::scene::Scene;

use super::{AffFile, open};

/// A folder of its own that is gone in the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("antumbra-aff-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    /// A folder with `main.aff` and more files, by name and content.
    fn with(main: &str, others: &[(&str, &str)]) -> Folder {
        let folder = Folder::new();
        for (name, text) in others.iter().chain([&("main.aff", main)]) {
            folder.write(name, text.as_bytes());
        }
        folder
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }

    fn open(&self) -> Result<AffFile, crate::Error> {
        open(&self.0.join("main.aff"))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).ok();
    }
}

fn file(text: &str) -> AffFile {
    Folder::with(text, &[]).open().unwrap()
}

/// The scene at the start, which must be valid.
fn scene(text: &str) -> Scene {
    let scene = file(text).at(None).unwrap();
    scene.validate().unwrap();
    scene
}

/// The message about `text`, without the path.
fn error(text: &str) -> String {
    error_in(&Folder::with(text, &[]))
}

fn error_in(folder: &Folder) -> String {
    let text = folder.open().unwrap_err().to_string();
    assert!(text.lines().count() <= 2, "{text}");
    text.split_once("main.aff: ").unwrap().1.to_owned()
}

#[track_caller]
fn assert_near(got: [f32; 3], expected: [f32; 3]) {
    let near = got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4);
    assert!(near, "{got:?} instead of {expected:?}");
}

/// A triangle with a corner at the origin.
const TRIANGLE: &str = "p 3  0 0 0  1 0 0  0 1 0\n";
