//! What the readers of plain meshes share: the file in memory, a memory budget, text, polygons, colour.
//!
//! These formats are read by hand rather than with `tobj`, `ply-rs-bw`, `stl_io` and `npyz`: on hostile bytes those
//! panic (a material line `Kd 1`, an array shape whose product overflows), allocate by a declared size, or give
//! errors without line and index.

pub(in crate::read) mod polygon;
mod text;

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::LazyLock;

use antumbra::scene::{Material, Object, Scene, Soup, Triangle};

pub(in crate::read) use text::{Text, finite, number, quote};

use crate::Error;

/// What a reader may hold at once, in bytes. A growing list briefly holds its old copy too, which this does not count:
/// the rest up to 2 GiB is for that.
const LIMIT: u64 = 1408 << 20;

/// Bytes that a reader may still allocate. File sizes bound declared counts, but a byte of a file can stand for a whole
/// triangle, so the growth is bounded as well.
#[derive(Debug)]
pub(in crate::read) struct Budget {
    left: u64,
}

impl Budget {
    /// A fresh budget, for one file.
    pub(in crate::read) fn new() -> Budget {
        Budget { left: LIMIT }
    }

    /// Takes `count * size` bytes.
    pub(in crate::read) fn take(&mut self, count: usize, size: usize) -> Result<(), String> {
        let bytes = (count as u64).saturating_mul(size as u64);
        self.left = self.left.checked_sub(bytes).ok_or_else(too_big)?;
        Ok(())
    }

    /// Gives bytes back that were freed.
    pub(in crate::read) fn give(&mut self, bytes: usize) {
        self.left = (self.left + bytes as u64).min(LIMIT);
    }

    /// Appends to a list whose final length is not known.
    pub(in crate::read) fn push<T>(&mut self, list: &mut Vec<T>, item: T) -> Result<(), String> {
        if list.len() == list.capacity() {
            let more = list.capacity().max(64);
            self.take(more, size_of::<T>())?;
            list.reserve_exact(more);
        }
        list.push(item);
        Ok(())
    }
}

fn too_big() -> String {
    format!("reading it needs more than the {} MiB that are allowed; split it or thin it out", LIMIT >> 20)
}

/// The whole file, charged to the budget.
pub(in crate::read) fn load(path: &Path, budget: &mut Budget) -> Result<Vec<u8>, Error> {
    let io = |e| Error::io(path, e);
    let file = File::open(path).map_err(io)?;
    let size = file.metadata().map_err(io)?.len();
    budget.take(usize::try_from(size).unwrap_or(usize::MAX), 1).map_err(|e| Error::content(path, e))?;
    let mut bytes = Vec::with_capacity(size as usize);
    // A pipe has no size, and a file may grow while it is read.
    let most = size.max(LIMIT / 4);
    file.take(most + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > most {
        return Err(Error::content(path, too_big()));
    }
    let unexpected = bytes.len().saturating_sub(size as usize);
    budget.take(unexpected, 2).map_err(|e| Error::content(path, e))?;
    if bytes.is_empty() {
        return Err(Error::content(path, "the file is empty"));
    }
    Ok(bytes)
}

/// The file's name without its ending.
pub(in crate::read) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Numbers for names, in order of first use.
#[derive(Debug, Default)]
pub(in crate::read) struct Names {
    ids: HashMap<Vec<u8>, u32>,
    /// The names.
    pub(in crate::read) list: Vec<String>,
}

impl Names {
    /// The number of a name.
    pub(in crate::read) fn id(&mut self, name: &[u8], budget: &mut Budget) -> Result<u32, String> {
        if let Some(&id) = self.ids.get(name) {
            return Ok(id);
        }
        let id = self.list.len() as u32;
        // Two copies of the name (one may grow as it becomes UTF-8), and about this much for two entries.
        budget.take(1, 4 * name.len() + 128)?;
        self.ids.insert(name.to_vec(), id);
        self.list.push(String::from_utf8_lossy(name).into_owned());
        Ok(id)
    }

    /// The number of a name that is known.
    pub(in crate::read) fn get(&self, name: &[u8]) -> Option<u32> {
        self.ids.get(name).copied()
    }

    /// As objects; what has no name is called `unnamed`.
    pub(in crate::read) fn into_objects(self, unnamed: &str) -> Vec<Object> {
        let named = |name: String| Object { name: if name.is_empty() { unnamed.to_owned() } else { name } };
        self.list.into_iter().map(named).collect()
    }
}

/// A scene of one object and one grey material.
pub(in crate::read) fn plain_scene(path: &Path, positions: Vec<Triangle>) -> Scene {
    let n = positions.len();
    Scene {
        name: stem(path),
        soup: Soup { positions, object: vec![0; n], material: vec![0; n], ..Soup::default() },
        objects: vec![Object { name: stem(path) }],
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

/// The linear value of an 8-bit sRGB channel (IEC 61966-2-1).
pub(in crate::read) fn linear_of_byte(value: u8) -> f32 {
    static TABLE: LazyLock<[f32; 256]> =
        LazyLock::new(|| std::array::from_fn(|i| linear_of_srgb(i as f32 / 255.0)));
    TABLE[usize::from(value)]
}

/// The linear value of an sRGB channel in 0 to 1 (IEC 61966-2-1).
pub(in crate::read) fn linear_of_srgb(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
