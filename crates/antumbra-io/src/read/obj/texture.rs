//! Textures of MTL materials: `map_Kd` with `map_d` as its alpha.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use antumbra::scene::{Texture, Wrap};
use image::{ImageReader, Limits};

use super::super::mesh::{Budget, Text, number};

/// A texture statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    file: String,
    clamp: bool,
    /// `-s`: how often the image repeats.
    pub(super) scale: [f32; 2],
    /// `-o`.
    pub(super) offset: [f32; 2],
}

impl Map {
    /// Options, then a file name that may have blanks. `None` without a name.
    pub(super) fn parse(mut words: Text) -> Option<Map> {
        let mut map = Map { file: String::new(), clamp: false, scale: [1.0; 2], offset: [0.0; 2] };
        loop {
            let before = words.at;
            match words.word()? {
                b"-clamp" => map.clamp = words.word()? == b"on",
                b"-s" => numbers(&mut words, &mut map.scale),
                b"-o" => numbers(&mut words, &mut map.offset),
                b"-t" => numbers(&mut words, &mut [0.0; 2]),
                b"-mm" => {
                    words.word()?;
                    words.word()?;
                }
                b"-blendu" | b"-blendv" | b"-cc" | b"-bm" | b"-boost" | b"-texres" | b"-imfchan"
                | b"-type" => {
                    words.word()?;
                }
                _ => {
                    words.at = before;
                    break;
                }
            }
        }
        let name = String::from_utf8_lossy(words.rest_of_line()).into_owned();
        map.file = name.trim_matches('"').to_owned();
        (!map.file.is_empty()).then_some(map)
    }
}

/// One to three numbers, of which the first two count.
fn numbers(words: &mut Text, to: &mut [f32; 2]) {
    for k in 0..3 {
        let before = words.at;
        match words.word().map(number::<f32>) {
            Some(Ok(value)) if k < 2 && value.is_finite() => to[k] = value,
            Some(Ok(_)) => {}
            _ => {
                words.at = before;
                return;
            }
        }
    }
}

/// A file that a statement names: where it says, or next to the OBJ file, as many were moved since. Regular files only:
/// a hostile name could be that of a device.
pub(super) fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.replace('\\', "/");
    let is_file = |p: &PathBuf| p.metadata().is_ok_and(|m| m.is_file());
    let beside = name.rsplit('/').next().map(|last| folder.join(last));
    [Some(folder.join(&name)), beside].into_iter().flatten().find(is_file)
}

/// What came of a material's two maps.
#[derive(Clone, Debug, Default)]
pub(super) struct Loaded {
    pub(super) texture: Option<u32>,
    /// The colour comes from a file.
    pub(super) colored: bool,
    /// Some texel is not opaque, or there is a `map_d`.
    pub(super) alpha: bool,
    /// E.g. "missing texture wood.png".
    pub(super) faults: Vec<String>,
}

/// The textures so far; each pair of files is read once.
#[derive(Debug)]
pub(super) struct Textures<'a> {
    folder: &'a Path,
    pub(super) list: Vec<Texture>,
    known: HashMap<(Option<String>, Option<String>, bool), Loaded>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(folder: &'a Path) -> Textures<'a> {
        Textures { folder, list: Vec::new(), known: HashMap::new() }
    }

    /// The texture of a material. Errors are for lack of memory only.
    pub(super) fn load(
        &mut self,
        color: Option<&Map>,
        alpha: Option<&Map>,
        budget: &mut Budget,
    ) -> Result<Loaded, String> {
        let file = |m: Option<&Map>| m.map(|m| m.file.clone());
        let Some(first) = color.or(alpha) else { return Ok(Loaded::default()) };
        let key = (file(color), file(alpha), first.clamp);
        if let Some(loaded) = self.known.get(&key) {
            return Ok(loaded.clone());
        }
        let mut loaded = Loaded::default();
        let mut open = |map: Option<&Map>| match map.map(|m| self.open(&m.file, budget)) {
            None => Ok(None),
            Some(Ok(image)) => Ok(Some(image)),
            Some(Err(Fault::Memory(e))) => Err(e),
            Some(Err(Fault::File(e))) => {
                loaded.faults.push(e);
                Ok(None)
            }
        };
        let (base, mask) = (open(color)?, open(alpha)?);
        loaded.colored = base.is_some();
        loaded.alpha = mask.is_some();
        let texture = match (base, mask) {
            (Some(base), None) => Some(base),
            (base, Some(mask)) => Some(merge(base, mask, budget)?),
            (None, None) => None,
        };
        if let Some(mut texture) = texture {
            if first.clamp {
                texture.wrap = [Wrap::Clamp; 2];
            }
            loaded.alpha |= texture.pixels.iter().any(|p| p[3] < 255);
            loaded.texture = Some(self.list.len() as u32);
            self.list.push(texture);
        }
        self.known.insert(key, loaded.clone());
        Ok(loaded)
    }

    fn open(&self, name: &str, budget: &mut Budget) -> Result<Texture, Fault> {
        let path = find(self.folder, name).ok_or_else(|| Fault::File(format!("missing texture {name}")))?;
        let unreadable = |_| Fault::File(format!("unreadable texture {name}"));
        let reader = || -> image::ImageResult<_> { Ok(ImageReader::open(&path)?.with_guessed_format()?) };
        let (width, height) = reader().and_then(ImageReader::into_dimensions).map_err(unreadable)?;
        let texels = width as usize * height as usize;
        // At most 16 bytes a texel as it is decoded (32-bit floats), and 4 that stay.
        budget.take(texels, 20).map_err(Fault::Memory)?;
        let mut limits = Limits::default();
        limits.max_alloc = Some(texels as u64 * 16 + (1 << 20));
        let mut reader = reader().map_err(unreadable)?;
        reader.limits(limits);
        let image = reader.decode().map_err(unreadable)?.into_rgba8();
        budget.give(texels * 16);
        let pixels = image.into_raw().as_chunks().0.to_vec();
        Ok(Texture { name: name.to_owned(), width, height, pixels, wrap: [Wrap::Repeat; 2] })
    }
}

enum Fault {
    Memory(String),
    File(String),
}

/// The base (white if there is none) with the mask's value as alpha, at the larger size of both.
fn merge(base: Option<Texture>, mask: Texture, budget: &mut Budget) -> Result<Texture, String> {
    // A mask is grey, or it is a copy of the colour with the mask in its alpha channel.
    let in_alpha = mask.pixels.iter().any(|p| p[3] < 255);
    let value = |p: [u8; 4]| if in_alpha { p[3] } else { luminance(p) };
    let name = base.as_ref().map_or_else(|| mask.name.clone(), |b| b.name.clone());
    let base = base.unwrap_or(Texture { width: 1, height: 1, pixels: vec![[255; 4]], ..Texture::default() });
    let (width, height) = (base.width.max(mask.width), base.height.max(mask.height));
    budget.take(width as usize * height as usize, 4)?;
    let nearest = |t: &Texture, x: u32, y: u32| {
        let scale = |v: u32, size: u32, to: u32| (u64::from(v) * u64::from(size) / u64::from(to)) as usize;
        t.pixels[scale(y, t.height, height) * t.width as usize + scale(x, t.width, width)]
    };
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        pixels.extend((0..width).map(|x| {
            let [r, g, b, _] = nearest(&base, x, y);
            [r, g, b, value(nearest(&mask, x, y))]
        }));
    }
    budget.give(4 * (base.pixels.len() + mask.pixels.len()));
    Ok(Texture { name, width, height, pixels, wrap: [Wrap::Repeat; 2] })
}

/// Rec. 709 weights in 256ths.
fn luminance([r, g, b, _]: [u8; 4]) -> u8 {
    ((54 * u32::from(r) + 183 * u32::from(g) + 19 * u32::from(b)) >> 8) as u8
}
