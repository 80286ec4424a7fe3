//! Everything that touches a file: scenes and arrays in, pictures, masks and arrays out.

use std::path::{Path, PathBuf};

use antumbra::scene::procedural::{self, BUILTINS};
use antumbra::scene::{Scene, Triangle};
use antumbra_io::{read, write};
use anyhow::{Context, Result, bail};

use crate::false_color::Painting;
use crate::plan::{Input, Source, ending};

/// A scene, and the seconds that its animation spans.
pub(crate) struct Loaded {
    pub(crate) scene: Scene,
    pub(crate) span: Option<[f32; 2]>,
}

/// Reads or makes a scene, at its moment, and checks it.
pub(crate) fn load(input: &Input) -> Result<Loaded> {
    let (mut scene, span, name) = match &input.source {
        Source::Builtin(spec) => {
            (procedural::builtin(spec, input.time)?, procedural::time_span(spec), format!("builtin:{spec}"))
        }
        Source::File(path) => {
            hint_at_builtin(path)?;
            let file = antumbra_io::open(path)?;
            (file.at(input.time)?, file.time_span(), path.display().to_string())
        }
    };
    scene.validate().with_context(|| name.clone())?;
    // A built-in scene may be empty on purpose.
    if scene.soup.is_empty() && matches!(input.source, Source::File(_)) {
        bail!("{name}: the scene has no triangles: there is nothing to draw or to cast a shadow");
    }
    if scene.name.is_empty() {
        scene.name = name;
    }
    Ok(Loaded { scene, span })
}

/// `room` where `builtin:room` was meant.
fn hint_at_builtin(path: &Path) -> Result<()> {
    let text = path.to_string_lossy();
    let name = text.split('?').next().unwrap_or_default();
    if !path.exists() && BUILTINS.iter().any(|b| b.name == name) {
        bail!("{text}: no such file; the built-in scene of that name is builtin:{text}");
    }
    Ok(())
}

/// `[T,3,3]`.
pub(crate) fn read_triangles(path: &Path) -> Result<Vec<Triangle>> {
    Ok(read::npy::read_triangles(path)?)
}

/// Positions, and the shape without its last 3.
pub(crate) fn read_samples(path: &Path) -> Result<(Vec<[f32; 3]>, Vec<usize>)> {
    Ok(read::npy::read_samples(path)?)
}

/// A mask as `.npy` or, of a picture, as `.png`.
pub(crate) fn write_mask(path: &Path, mask: &[u8], shape: &[usize]) -> Result<()> {
    match (ending(path).as_str(), shape) {
        ("png", &[height, width]) => write::png::mask(path, width, height, mask)?,
        ("png", _) => bail!("{}: a list of samples is not a picture; write an .npy file", path.display()),
        _ => write::npy::mask(path, mask, shape)?,
    }
    Ok(())
}

/// A picture of linear light as `.exr`, or encoded for screens as `.png`.
pub(crate) fn write_picture(path: &Path, [width, height]: [usize; 2], linear: &[[f32; 3]]) -> Result<()> {
    match ending(path).as_str() {
        "exr" => write::exr::color(path, width, height, linear, &[])?,
        _ => write_pixels(path, [width, height], &antumbra::shade::encode::picture(linear))?,
    }
    Ok(())
}

/// One number a pixel as `.exr`.
pub(crate) fn write_numbers(path: &Path, [width, height]: [usize; 2], numbers: &[f32]) -> Result<()> {
    Ok(write::exr::numbers(path, width, height, numbers)?)
}

/// A picture with a palette as `.png`.
pub(crate) fn write_painting(path: &Path, [width, height]: [usize; 2], painting: &Painting) -> Result<()> {
    Ok(write::png::indexed(path, width, height, &painting.palette, &painting.pixels)?)
}

/// sRGB pixels as `.png`.
pub(crate) fn write_pixels(path: &Path, [width, height]: [usize; 2], pixels: &[[u8; 3]]) -> Result<()> {
    Ok(write::png::color(path, width, height, pixels)?)
}

/// `[H,W,3]`.
pub(crate) fn write_samples(path: &Path, positions: &[[f32; 3]], [width, height]: [usize; 2]) -> Result<()> {
    Ok(write::npy::samples(path, positions, &[height, width])?)
}

/// `[T,3,3]`.
pub(crate) fn write_triangles(path: &Path, triangles: &[Triangle]) -> Result<()> {
    Ok(write::npy::triangles(path, triangles)?)
}

/// Indented JSON.
pub(crate) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)? + "\n";
    Ok(write::bytes(path, text.as_bytes())?)
}

/// `m.npy` of light 2 of several is `m.2.npy`.
pub(crate) fn numbered(path: &Path, index: usize, of: usize) -> PathBuf {
    if of <= 1 {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}.{index}.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_of_several_lights_are_numbered() {
        assert_eq!(numbered(Path::new("a/m.npy"), 0, 1), Path::new("a/m.npy"));
        assert_eq!(numbered(Path::new("a/m.x.npy"), 2, 3), Path::new("a/m.x.2.npy"));
    }
}
