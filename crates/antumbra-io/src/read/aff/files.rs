//! Finds and reads what a file includes, never outside the main file's folder.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use super::model::MAX_TEXT;

/// Most different names looked up, and most entries of a folder looked at: bounds for the disk's sake.
const MAX_NAMES: usize = 1 << 16;

/// A file that has been read.
#[derive(Clone)]
pub(super) struct SourceFile {
    /// As it is called in messages: the path below the main file's folder.
    pub(super) name: Rc<str>,
    pub(super) folder: PathBuf,
    pub(super) text: Rc<[u8]>,
}

impl SourceFile {
    /// The name without folder and ending.
    pub(super) fn stem(&self) -> String {
        Path::new(&*self.name).file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
    }
}

/// The main file's folder and all files read so far.
pub(super) struct Files {
    root: PathBuf,
    read: Vec<SourceFile>,
    index_by_path: BTreeMap<PathBuf, usize>,
    found: BTreeMap<(PathBuf, String), Result<PathBuf, Missing>>,
    /// Per folder: the true names by lower-case name.
    listings: BTreeMap<PathBuf, BTreeMap<String, String>>,
}

/// Why a name gives no file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Missing {
    NotFound,
    /// It lies outside the main file's folder, where nobody may be sent by a file.
    Outside,
    TooManyNames,
}

impl std::fmt::Display for Missing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Missing::NotFound => "there is no such file",
            Missing::Outside => "it lies outside the main file's folder",
            Missing::TooManyNames => "too many file names before it",
        })
    }
}

impl Files {
    /// Opens the main file, which gets index 0.
    pub(super) fn new(main: &Path) -> std::io::Result<Files> {
        let folder = match main.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let root = fs::canonicalize(folder)?;
        let mut files = Files {
            root: root.clone(),
            read: Vec::new(),
            index_by_path: BTreeMap::new(),
            found: BTreeMap::new(),
            listings: BTreeMap::new(),
        };
        let text = read_bounded(main)?;
        let name = main.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        files.read.push(SourceFile { name: name.into(), folder: root, text });
        files.index_by_path.insert(fs::canonicalize(main)?, 0);
        Ok(files)
    }

    pub(super) fn get(&self, index: usize) -> SourceFile {
        self.read[index].clone()
    }

    /// Index of the file called `name` in file `from`; reads it if that was not done yet.
    pub(super) fn include(&mut self, from: usize, name: &str) -> Result<usize, String> {
        let folder = self.read[from].folder.clone();
        let path = self.find(&folder, name).map_err(|missing| missing.to_string())?;
        if let Some(&index) = self.index_by_path.get(&path) {
            return Ok(index);
        }
        let text = read_bounded(&path).map_err(|error| error.to_string())?;
        let below = path.strip_prefix(&self.root).unwrap_or(&path);
        let index = self.read.len();
        self.read.push(SourceFile {
            name: below.to_string_lossy().into(),
            folder: path.parent().unwrap_or(&self.root).to_owned(),
            text,
        });
        self.index_by_path.insert(path, index);
        Ok(index)
    }

    /// The regular file that `name` means: from `folder` on, else from the main file's folder on; as written, else
    /// with any case of letters (BART was written on systems that did not tell them apart).
    pub(super) fn find(&mut self, folder: &Path, name: &str) -> Result<PathBuf, Missing> {
        let key = (folder.to_owned(), name.to_owned());
        if let Some(known) = self.found.get(&key) {
            return known.clone();
        }
        if self.found.len() >= MAX_NAMES {
            return Err(Missing::TooManyNames);
        }
        let result = self.search(folder, name);
        self.found.insert(key, result.clone());
        result
    }

    fn search(&mut self, folder: &Path, name: &str) -> Result<PathBuf, Missing> {
        let relative = PathBuf::from(name.replace('\\', "/"));
        let stays =
            |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir | Component::ParentDir);
        if !relative.components().all(stays) {
            return Err(Missing::Outside);
        }
        let root = self.root.clone();
        for base in [folder, &root] {
            if let Ok(path) = fs::canonicalize(base.join(&relative)) {
                return self.inside(path);
            }
            if let Some(path) = self.any_case(base, &relative) {
                return self.inside(path);
            }
        }
        Err(Missing::NotFound)
    }

    /// `path`, which has no links and dots left, if it is a regular file below the root.
    fn inside(&self, path: PathBuf) -> Result<PathBuf, Missing> {
        if !path.starts_with(&self.root) {
            return Err(Missing::Outside);
        }
        // A pipe or a device could be read for ever.
        if path.is_file() { Ok(path) } else { Err(Missing::NotFound) }
    }

    fn any_case(&mut self, base: &Path, relative: &Path) -> Option<PathBuf> {
        let mut path = base.to_owned();
        for component in relative.components() {
            match component {
                Component::Normal(part) => {
                    let wanted = part.to_str()?.to_lowercase();
                    let listing = self.listings.entry(path.clone()).or_insert_with(|| list(&path));
                    path.push(listing.get(&wanted)?);
                }
                Component::ParentDir => {
                    path.pop();
                }
                _ => {}
            }
            if !path.starts_with(&self.root) {
                return None;
            }
        }
        fs::canonicalize(path).ok()
    }
}

/// Of names that differ by case only, the first in the order of bytes.
fn list(folder: &Path) -> BTreeMap<String, String> {
    let Ok(entries) = fs::read_dir(folder) else { return BTreeMap::new() };
    let mut names: Vec<String> =
        entries.take(MAX_NAMES).filter_map(|e| e.ok()?.file_name().into_string().ok()).collect();
    names.sort_unstable_by(|a, b| b.cmp(a));
    names.into_iter().map(|name| (name.to_lowercase(), name)).collect()
}

fn read_bounded(path: &Path) -> std::io::Result<Rc<[u8]>> {
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(MAX_TEXT as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes.into())
}
