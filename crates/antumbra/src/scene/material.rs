//! How surfaces look. Nothing here changes a shadow, except that the eye looks through holes of alpha masks.

/// How alpha is meant, as in glTF.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// There or not there: a surface point exists where alpha >= `cutoff`.
    Mask {
        /// Smallest alpha that is there.
        cutoff: f32,
    },
    /// Partly covering.
    Blend,
}

/// A surface's look.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file, or empty.
    pub name: String,
    /// Linear colour and alpha, multiplied with the texture.
    pub base_color: [f32; 4],
    /// Index into [`super::Scene::textures`].
    pub base_color_texture: Option<u32>,
    /// What alpha means.
    pub alpha_mode: AlphaMode,
    /// Linear light that the surface adds.
    pub emissive: [f32; 3],
    /// Shown in its base colour, without shading (sky domes).
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Material {
            name: String::new(),
            base_color: [0.8, 0.8, 0.8, 1.0],
            base_color_texture: None,
            alpha_mode: AlphaMode::Opaque,
            emissive: [0.0; 3],
            unlit: false,
        }
    }
}

/// What lies beyond the border of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image again, every other one mirrored.
    Mirror,
    /// The border pixel.
    Clamp,
}

/// An image: sRGB colour and linear alpha, 8 bits each, top row first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Texture {
    /// Name in the file, or empty.
    pub name: String,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<[u8; 4]>,
    /// Horizontal and vertical wrapping.
    pub wrap: [Wrap; 2],
}
