//! Plain meshes, arrays and pictures: one small test a behaviour, each on files that it writes itself.

mod hostile;
mod npy;
mod obj;
mod ply;
mod real_scenes;
mod stl;
mod write;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use antumbra::scene::Scene;

/// A folder that lives as long as the test.
pub(crate) struct Folder(PathBuf);

impl Folder {
    /// A new, empty one.
    pub(crate) fn new() -> Folder {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let id = COUNT.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("antumbra-io-{}-{id}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Folder(folder)
    }

    /// A path in it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// A new file in it.
    pub(crate) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.path(name), content).unwrap();
        self.path(name)
    }

    /// The names of its files, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Reads and validates a scene.
pub(crate) fn scene(path: &Path) -> Scene {
    let scene = antumbra_io::open(path).unwrap_or_else(|e| panic!("{e}")).at(None).unwrap();
    scene.validate().unwrap();
    assert!(!scene.materials.is_empty());
    assert_eq!(Some(scene.name.as_str()), path.file_stem().and_then(|s| s.to_str()));
    scene
}

/// What is said of a file that cannot be read, without its path.
pub(crate) fn fault(path: &Path) -> String {
    let text = antumbra_io::open(path).expect_err("must not be readable").to_string();
    text.strip_prefix(&format!("{}: ", path.display())).expect("names the file").to_owned()
}

/// A scene or a fault from the bytes of a file.
pub(crate) fn scene_of(name: &str, content: impl AsRef<[u8]>) -> Scene {
    scene(&Folder::new().file(name, content))
}

/// What is said of these bytes.
pub(crate) fn fault_of(name: &str, content: impl AsRef<[u8]>) -> String {
    fault(&Folder::new().file(name, content))
}
