//! MTL: what the used materials look like.

use std::path::{Path, PathBuf};

use antumbra::scene::{AlphaMode, Material, Texture};

use super::super::mesh::{Budget, Names, Text, load, number, quote};
use super::texture::{Map, Textures};
use crate::Error;

/// Materials, in the order of `Names`, with how their texture coordinates are moved.
#[derive(Debug, Default)]
pub(super) struct Look {
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    /// Scale and offset of the texture coordinates, for each material; empty if all leave them alone.
    pub(super) moved: Vec<([f32; 2], [f32; 2])>,
}

/// What an MTL file says of one material.
#[derive(Clone, Debug, Default)]
struct Definition {
    diffuse: Option<[f32; 3]>,
    emissive: [f32; 3],
    /// `d`, which wins over `Tr`.
    dissolve: Option<f32>,
    transparency: Option<f32>,
    map_color: Option<Map>,
    map_alpha: Option<Map>,
}

/// Finds the materials that the faces use. Files that are not there are named in the materials' names.
pub(super) fn look_up(
    path: &Path,
    used: &Names,
    libraries: &[Vec<u8>],
    budget: &mut Budget,
) -> Result<Look, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut found: Vec<Option<Definition>> = vec![None; used.list.len()];
    let mut missing = None;
    for library in libraries {
        for file in files(folder, library) {
            match file {
                Ok(file) => {
                    let bytes = load(&file, budget)?;
                    read(&bytes, used, &mut found).map_err(|e| Error::content(&file, e))?;
                }
                Err(name) => missing = missing.or(Some(name)),
            }
        }
    }
    let mut textures = Textures::new(folder);
    let mut look = Look::default();
    for (name, definition) in used.list.iter().zip(found) {
        let (material, moved) = match definition {
            Some(definition) => {
                definition.finish(name, &mut textures, budget).map_err(|e| Error::content(path, e))?
            }
            None => (unknown(name, missing.as_deref()), STILL),
        };
        look.materials.push(material);
        look.moved.push(moved);
    }
    if look.moved.iter().all(|m| *m == STILL) {
        look.moved.clear();
    }
    look.textures = textures.list;
    Ok(look)
}

const STILL: ([f32; 2], [f32; 2]) = ([1.0; 2], [0.0; 2]);

/// A grey material that says why it is grey. Faces before any `usemtl` have no name and lack nothing.
fn unknown(name: &str, missing: Option<&str>) -> Material {
    let name = match missing {
        _ if name.is_empty() => String::new(),
        Some(file) => format!("{name} (missing file {file})"),
        None => format!("{name} (missing material)"),
    };
    Material { name, ..Material::default() }
}

/// The files of a `mtllib` statement: one whose name may have blanks, or several; those not there by name.
fn files(folder: &Path, library: &[u8]) -> Vec<Result<PathBuf, String>> {
    let find = |name: &[u8]| {
        let name = String::from_utf8_lossy(name).into_owned();
        super::texture::find(folder, &name).ok_or(name)
    };
    match find(library) {
        Ok(file) => vec![Ok(file)],
        Err(name) => {
            let mut words = Text { bytes: library, at: 0 };
            let parts: Vec<_> = std::iter::from_fn(|| words.word()).take(100).map(find).collect();
            if parts.iter().any(Result::is_ok) { parts } else { vec![Err(name)] }
        }
    }
}

fn read(bytes: &[u8], used: &Names, found: &mut [Option<Definition>]) -> Result<(), String> {
    // The first file that defines a material wins; its own last word on a property does, too.
    let taken: Vec<bool> = found.iter().map(Option::is_some).collect();
    let mut current = None;
    for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let mut words = Text { bytes: line, at: 0 };
        let Some(key) = words.word() else { continue };
        if key == b"newmtl" {
            current = used.get(words.rest_of_line()).map(|id| id as usize).filter(|&id| !taken[id]);
            if let Some(id) = current {
                found[id] = Some(Definition::default());
            }
        } else if let Some(Some(definition)) = current.map(|id| &mut found[id]) {
            definition.property(key, words).map_err(|e| format!("line {}: {e}", number + 1))?;
        }
    }
    Ok(())
}

impl Definition {
    fn property(&mut self, key: &[u8], words: Text) -> Result<(), String> {
        match key {
            b"Kd" => self.diffuse = color(words)?.or(self.diffuse),
            b"Ke" => self.emissive = color(words)?.unwrap_or(self.emissive),
            b"d" => self.dissolve = Some(single(words)?),
            b"Tr" => self.transparency = Some(single(words)?),
            b"map_Kd" => self.map_color = Map::parse(words),
            b"map_d" => self.map_alpha = Map::parse(words),
            _ => {}
        }
        Ok(())
    }

    fn finish(
        self,
        name: &str,
        textures: &mut Textures,
        budget: &mut Budget,
    ) -> Result<(Material, ([f32; 2], [f32; 2])), String> {
        let loaded = textures.load(self.map_color.as_ref(), self.map_alpha.as_ref(), budget)?;
        let mut base = self.diffuse.unwrap_or([0.8; 3]);
        // With a texture, no Kd means "as the texture is", and so does black: programs write it, and nobody means it.
        if loaded.colored && (self.diffuse.is_none() || base == [0.0; 3]) {
            base = [1.0; 3];
        }
        let alpha = self.dissolve.or(self.transparency.map(|t| 1.0 - t)).unwrap_or(1.0).clamp(0.0, 1.0);
        let alpha_mode = if alpha < 1.0 {
            AlphaMode::Blend
        } else if loaded.alpha {
            AlphaMode::Mask { cutoff: 0.5 }
        } else {
            AlphaMode::Opaque
        };
        let mut name = name.to_owned();
        if !loaded.faults.is_empty() {
            name = format!("{name} ({})", loaded.faults.join(", "));
        }
        let map = self.map_color.or(self.map_alpha);
        let material = Material {
            name,
            base_color: [base[0], base[1], base[2], alpha],
            base_color_texture: loaded.texture,
            alpha_mode,
            emissive: self.emissive,
            unlit: false,
        };
        Ok((material, map.map_or(STILL, |m| (m.scale, m.offset))))
    }
}

/// One number for grey or three; `None` for spectra, which few programs know.
fn color(mut words: Text) -> Result<Option<[f32; 3]>, String> {
    let mut color = [0.0; 3];
    let mut count = 0;
    while count < 3
        && let Some(word) = words.word().filter(|w| w[0] != b'#')
    {
        if matches!(word, b"spectral" | b"xyz") {
            return Ok(None);
        }
        color[count] = bounded(word)?;
        count += 1;
    }
    match count {
        1 => Ok(Some([color[0]; 3])),
        3 => Ok(Some(color)),
        _ => Err(format!("a colour of {count} numbers instead of three")),
    }
}

fn single(mut words: Text) -> Result<f32, String> {
    let mut word = words.word();
    if word == Some(b"-halo") {
        word = words.word();
    }
    bounded(word.ok_or("a number is missing")?)
}

/// Finite, not below 0.
fn bounded(word: &[u8]) -> Result<f32, String> {
    let value: f32 = number(word)?;
    if value.is_finite() { Ok(value.max(0.0)) } else { Err(format!("{} is not finite", quote(word))) }
}
