//! Scenes as data: `bench/definitions/*.toml`. What each field means is said here and in `bench/README.md`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::stress::Stress;

/// One case of the suite.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// In tables and records.
    pub name: String,
    /// The name of another definition that says what this one does not.
    pub base: Option<String>,
    /// A file below the folder of scenes, or `builtin:NAME`.
    pub scene: Option<String>,
    /// Seconds, for scenes that move.
    pub time: Option<f32>,
    /// The camera; without one, and without an index, that which `antumbra render` chooses.
    pub eye: Option<[f32; 3]>,
    /// Where it looks.
    pub target: Option<[f32; 3]>,
    /// A camera of the file.
    pub camera_index: Option<usize>,
    /// The light; without one, and without an index, that which `antumbra render` chooses.
    pub light: Option<[f32; 3]>,
    /// A light of the file.
    pub light_index: Option<usize>,
    /// Casters nearer than this to the light are left out.
    pub skip_radius: Option<f32>,
    /// What is done to the arrays to make it hard.
    pub stress: Option<Stress>,
    /// The size that this case needs; otherwise that of the suite.
    pub size: Option<String>,
    /// Triangles that there must be.
    pub triangles: Option<usize>,
    /// The right answer by size (`"1920x1080" = 1900878`): samples in shadow.
    #[serde(default)]
    pub shadowed: BTreeMap<String, usize>,
    /// Where it was read from.
    #[serde(skip)]
    pub path: PathBuf,
}

impl Definition {
    /// Reads all definitions below a folder, in the order of their paths, with their bases filled in.
    ///
    /// # Errors
    /// Names the file that cannot be read or says what cannot be meant.
    pub fn read_all(folder: &Path) -> Result<Vec<Definition>> {
        let mut paths = Vec::new();
        find(folder, &mut paths)?;
        paths.sort();
        let read = |path: &PathBuf| {
            let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
            let definition: Definition =
                toml_edit::de::from_str(&text).with_context(|| path.display().to_string())?;
            Ok(Definition { path: path.clone(), ..definition })
        };
        let all: Vec<Definition> = paths.iter().map(read).collect::<Result<_>>()?;
        all.iter().map(|d| d.filled(&all)).collect()
    }

    /// With what the base says where this one does not. Answers are not inherited: they are another's.
    fn filled(&self, all: &[Definition]) -> Result<Definition> {
        let shown = self.path.display();
        let mut filled = self.clone();
        if let Some(name) = &self.base {
            let Some(base) = all.iter().find(|d| &d.name == name) else {
                bail!("{shown}: base = \"{name}\": there is no such definition");
            };
            if base.base.is_some() {
                bail!("{shown}: base = \"{name}\" has a base itself: name that one");
            }
            filled.scene = self.scene.clone().or_else(|| base.scene.clone());
            filled.time = self.time.or(base.time);
            if self.eye.is_none() && self.camera_index.is_none() {
                (filled.eye, filled.target, filled.camera_index) = (base.eye, base.target, base.camera_index);
            }
            if self.light.is_none() && self.light_index.is_none() {
                (filled.light, filled.light_index) = (base.light, base.light_index);
            }
            filled.skip_radius = self.skip_radius.or(base.skip_radius);
        }
        if filled.scene.is_none() {
            bail!("{shown}: no scene");
        }
        if filled.eye.is_some() != filled.target.is_some() {
            bail!("{shown}: eye and target go together");
        }
        Ok(filled)
    }

    /// Writes what was found as what there must be, and leaves the rest of the file as it is.
    ///
    /// # Errors
    /// Names the file.
    pub fn record(&self, size: &str, triangles: usize, shadowed: usize) -> Result<()> {
        let shown = || self.path.display().to_string();
        let text = std::fs::read_to_string(&self.path).with_context(shown)?;
        let mut document: toml_edit::DocumentMut = text.parse().with_context(shown)?;
        document["triangles"] = toml_edit::value(triangles as i64);
        if document.get("shadowed").is_none() {
            document["shadowed"] = toml_edit::table();
        }
        document["shadowed"][size] = toml_edit::value(shadowed as i64);
        std::fs::write(&self.path, document.to_string()).with_context(shown)
    }
}

fn find(folder: &Path, paths: &mut Vec<PathBuf>) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            find(&path, paths)?;
        } else if path.extension().is_some_and(|e| e == "toml") {
            paths.push(path);
        }
    }
    Ok(())
}

/// `WxH`.
///
/// # Errors
/// Says what is wrong with the text.
pub fn size(text: &str) -> Result<[usize; 2], String> {
    let parts = text.split_once('x').map(|(w, h)| (w.parse::<usize>(), h.parse::<usize>()));
    match parts {
        Some((Ok(w), Ok(h))) if (1..=16384).contains(&w) && (1..=16384).contains(&h) => Ok([w, h]),
        _ => Err(format!("'{text}' is not a size WxH")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definitions_of_the_suite_can_be_read() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("definitions");
        let all = Definition::read_all(&folder).unwrap();
        assert!(all.len() > 20);
        for (i, d) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| other.name != d.name), "{} twice", d.name);
            assert!(!d.shadowed.is_empty(), "{} has no answer", d.name);
        }
    }

    #[test]
    fn sizes() {
        assert_eq!(size("64x48"), Ok([64, 48]));
        assert!(size("64").is_err() && size("0x4").is_err() && size("axb").is_err());
    }
}
