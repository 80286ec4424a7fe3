//! How surfaces look. Nothing here changes a shadow, except that the eye looks through holes of alpha masks.

use super::Scene;

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

impl Texture {
    /// The pixel at integer coordinates, after wrapping.
    #[inline]
    pub fn pixel(&self, x: i64, y: i64) -> [u8; 4] {
        let wrap = |v: i64, n: u32, mode: Wrap| -> usize {
            let n = i64::from(n);
            (match mode {
                Wrap::Repeat => v.rem_euclid(n),
                Wrap::Clamp => v.clamp(0, n - 1),
                Wrap::Mirror => {
                    let m = v.rem_euclid(2 * n);
                    if m < n { m } else { 2 * n - 1 - m }
                }
            }) as usize
        };
        self.pixels
            [wrap(y, self.height, self.wrap[1]) * self.width as usize + wrap(x, self.width, self.wrap[0])]
    }

    /// Alpha in [0, 1] at texture coordinates, bilinear.
    pub fn alpha(&self, uv: [f64; 2]) -> f64 {
        if self.pixels.is_empty() || !uv.iter().all(|v| v.is_finite()) {
            return 1.0;
        }
        let (x, y) = (uv[0] * f64::from(self.width) - 0.5, uv[1] * f64::from(self.height) - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let at = |dx: i64, dy: i64| {
            f64::from(self.pixel((x0 as i64).saturating_add(dx), (y0 as i64).saturating_add(dy))[3])
        };
        let top = at(0, 0) * (1.0 - fx) + at(1, 0) * fx;
        let bottom = at(0, 1) * (1.0 - fx) + at(1, 1) * fx;
        (top * (1.0 - fy) + bottom * fy) / 255.0
    }
}

impl Scene {
    /// Alpha of a triangle at the weights of its second and third corner, before the material's mode is applied.
    pub fn alpha(&self, triangle: u32, bary: [f64; 2]) -> f64 {
        let triangle = triangle as usize;
        let material = &self.materials[self.soup.material[triangle] as usize];
        let factor = f64::from(material.base_color[3]);
        let Some(texture) = material.base_color_texture else { return factor };
        let Some(uv) = self.soup.uvs.get(triangle) else { return factor };
        let weights = [1.0 - bary[0] - bary[1], bary[0], bary[1]];
        let at = |k: usize| (0..3).map(|i| weights[i] * f64::from(uv[i][k])).sum();
        factor * self.textures[texture as usize].alpha([at(0), at(1)])
    }

    /// Does the eye see the triangle there? Alpha masks have holes where alpha is under the cutoff; blended surfaces are
    /// looked through where they are less than half opaque.
    pub fn is_there(&self, triangle: u32, bary: [f64; 2]) -> bool {
        let material = &self.materials[self.soup.material[triangle as usize] as usize];
        match material.alpha_mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask { cutoff } => self.alpha(triangle, bary) >= f64::from(cutoff),
            AlphaMode::Blend => self.alpha(triangle, bary) >= 0.5,
        }
    }
}
