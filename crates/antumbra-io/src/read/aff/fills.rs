//! Fills, and the materials they become together with a texture.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use antumbra::scene::{AlphaMode, Material, Texture};

use super::files::Files;
use super::model::{MAX_PIXELS, Model};
use super::parse::{Parser, limit};
use super::tokens::{Outcome, Tokens};

/// The fill that counts now.
#[derive(Clone, Debug)]
struct Fill {
    /// File and place of its statement: tells fills apart.
    place: (usize, usize),
    name: String,
    color: [f32; 3],
    transmittance: f32,
}

/// Fills and materials so far.
pub(super) struct Fills {
    current: Fill,
    /// By place of the fill and name of the texture (in the folder of a file).
    material_by_use: BTreeMap<((usize, usize), Option<(usize, String)>), u32>,
    texture_by_path: BTreeMap<PathBuf, Result<u32, &'static str>>,
    pixels: usize,
}

impl Default for Fills {
    fn default() -> Self {
        let Material { base_color: [r, g, b, _], .. } = Material::default();
        let current =
            Fill { place: (usize::MAX, 0), name: "default".to_owned(), color: [r, g, b], transmittance: 0.0 };
        Fills { current, material_by_use: BTreeMap::new(), texture_by_path: BTreeMap::new(), pixels: 0 }
    }
}

impl Fills {
    /// `f red green blue Kd Ks shine T index`.
    pub(super) fn plain(&mut self, tokens: &mut Tokens<'_>, file: usize, files: &Files) -> Outcome<()> {
        let color = tokens.floats::<3>("colour")?;
        let [diffuse, _specular, _shine, transmittance, _index] = tokens.floats("Kd Ks shine T index")?;
        self.set(tokens, file, files, color.map(|c| c * diffuse), transmittance);
        Ok(())
    }

    /// `fm` with ambient, diffuse and specular colour, then `shine T index`.
    pub(super) fn extended(&mut self, tokens: &mut Tokens<'_>, file: usize, files: &Files) -> Outcome<()> {
        let _ambient = tokens.floats::<3>("ambient colour")?;
        let diffuse = tokens.floats("diffuse colour")?;
        let _specular = tokens.floats::<3>("specular colour")?;
        let [_shine, transmittance, _index] = tokens.floats("shine T index")?;
        self.set(tokens, file, files, diffuse, transmittance);
        Ok(())
    }

    fn set(&mut self, tokens: &Tokens<'_>, file: usize, files: &Files, color: [f32; 3], transmittance: f32) {
        self.current = Fill {
            place: (file, tokens.offset()),
            name: format!("{} line {}", files.get(file).stem(), tokens.line),
            color: color.map(|c| c.clamp(0.0, 1.0)),
            transmittance: transmittance.clamp(0.0, 1.0),
        };
    }
}

impl Parser {
    /// The material of the fill that counts now, with a texture if one is named.
    pub(super) fn material(&mut self, tokens: &Tokens<'_>, texture: Option<&str>) -> Outcome<u32> {
        let key = (self.fills.current.place, texture.map(|name| (self.file, name.to_owned())));
        if let Some(&index) = self.fills.material_by_use.get(&key) {
            return Ok(index);
        }
        limit(tokens, "materials", self.model.materials.len())?;
        let Fill { mut name, color: [r, g, b], transmittance, .. } = self.fills.current.clone();
        let mut base_color = [r, g, b, 1.0 - transmittance];
        let mut base_color_texture = None;
        if let Some(texture) = texture {
            let folder = self.files.get(self.file).folder;
            match self.texture(&folder, texture) {
                Ok(index) => {
                    base_color_texture = Some(index);
                    base_color[..3].fill(1.0);
                    name = format!("{name} ({texture})");
                }
                Err(why) => name = format!("{name} ({why} texture {texture})"),
            }
        }
        let alpha_mode = if transmittance > 0.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
        let index = self.model.materials.len() as u32;
        self.model.materials.push(Material {
            name,
            base_color,
            base_color_texture,
            alpha_mode,
            ..Material::default()
        });
        self.fills.material_by_use.insert(key, index);
        Ok(index)
    }

    /// Index of a texture, or an adjective that says why there is none. Shadows do not depend on it: no error.
    fn texture(&mut self, folder: &Path, name: &str) -> Result<u32, &'static str> {
        let path = self.files.find(folder, name).map_err(|_| "missing")?;
        if let Some(known) = self.fills.texture_by_path.get(&path) {
            return *known;
        }
        let result = load(&path, name, MAX_PIXELS.saturating_sub(self.fills.pixels)).map(|texture| {
            self.fills.pixels += texture.pixels.len();
            add(&mut self.model, texture)
        });
        self.fills.texture_by_path.insert(path, result);
        result
    }
}

fn add(model: &mut Model, texture: Texture) -> u32 {
    model.textures.push(texture);
    (model.textures.len() - 1) as u32
}

/// Reads an image of at most `pixels_left` pixels.
fn load(path: &Path, name: &str, pixels_left: usize) -> Result<Texture, &'static str> {
    const UNREADABLE: &str = "unreadable";
    let open = || {
        let file = BufReader::new(File::open(path)?);
        image::ImageReader::new(file).with_guessed_format()
    };
    // Once for the size, so that nothing too large is ever decoded.
    let (width, height) = open().ok().and_then(|r| r.into_dimensions().ok()).ok_or(UNREADABLE)?;
    if u64::from(width) * u64::from(height) > pixels_left as u64 {
        return Err("too large");
    }
    let mut reader = open().map_err(|_| UNREADABLE)?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(1 << 28);
    reader.limits(limits);
    let image = reader.decode().map_err(|_| UNREADABLE)?.into_rgba8();
    let pixels = image.pixels().map(|pixel| pixel.0).collect();
    Ok(Texture { name: name.to_owned(), width, height, pixels, ..Texture::default() })
}
