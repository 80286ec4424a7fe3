//! Looks of surfaces, and which images they need.

use std::collections::BTreeMap;

use antumbra::scene::{AlphaMode, Material, Wrap};
use gltf::json::material::AlphaMode as JsonAlpha;
use gltf::json::texture::{Info, WrappingMode};

use super::source::{Source, label};
use crate::Error;

/// Which texture coordinates a material wants.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UvSource {
    /// `TEXCOORD_n`.
    pub(super) set: u32,
    /// Two rows: u' and v' from (u, v, 1).
    pub(super) transform: Option<[[f64; 3]; 2]>,
}

/// An image as it is looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageUse {
    pub(super) image: usize,
    pub(super) wrap: [Wrap; 2],
}

/// All materials of a file, and the images that their base colours need.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub(super) list: Vec<Material>,
    uvs: Vec<UvSource>,
    /// One a texture of the scene.
    pub(super) images: Vec<ImageUse>,
    /// Where in `images` an image with this wrapping stands.
    known: BTreeMap<(usize, [u8; 2]), u32>,
    /// Where the material of primitives without one stands in `list`, once there is such a primitive.
    fallback: Option<u32>,
}

impl Materials {
    pub(super) fn read(source: &Source<'_>) -> Result<Materials, Error> {
        let mut materials = Materials::default();
        for (index, json) in source.root.materials.iter().enumerate() {
            let name = label("material", index, json.name.as_deref());
            let extensions = json.extensions.as_ref();
            let (factor, texture) = match extensions.and_then(|e| e.pbr_specular_glossiness.as_ref()) {
                Some(old) => (old.diffuse_factor.0, old.diffuse_texture.as_ref()),
                None => {
                    let pbr = &json.pbr_metallic_roughness;
                    (pbr.base_color_factor.0, pbr.base_color_texture.as_ref())
                }
            };
            let mut material = Material {
                name: json.name.clone().unwrap_or_default(),
                base_color: factor,
                base_color_texture: None,
                alpha_mode: match source.known(&json.alpha_mode, "alphaMode", &name)? {
                    JsonAlpha::Opaque => AlphaMode::Opaque,
                    JsonAlpha::Mask => AlphaMode::Mask { cutoff: json.alpha_cutoff.map_or(0.5, |c| c.0) },
                    JsonAlpha::Blend => AlphaMode::Blend,
                },
                emissive: emissive(json),
                unlit: extensions.is_some_and(|e| e.unlit.is_some()),
            };
            let mut uv = UvSource::default();
            if let Some(info) = texture {
                material.base_color_texture = materials.texture(source, info, &name)?;
                uv = uv_source(info);
            }
            materials.list.push(material);
            materials.uvs.push(uv);
        }
        Ok(materials)
    }

    /// The scene's material of a primitive, and its texture coordinates.
    pub(super) fn of_primitive(
        &mut self,
        material: Option<usize>,
        source: &Source<'_>,
        user: &str,
    ) -> Result<(u32, UvSource), Error> {
        if let Some(index) = material {
            source.item(&source.root.materials, index, "material", user)?;
            return Ok((index as u32, self.uvs[index]));
        }
        let next = self.list.len() as u32;
        let index = *self.fallback.get_or_insert_with(|| {
            self.list.push(Material::default());
            next
        });
        Ok((index, UvSource::default()))
    }

    /// Index of the scene's texture for a texture of the file; the same image and wrapping are one texture.
    fn texture(&mut self, source: &Source<'_>, info: &Info, user: &str) -> Result<Option<u32>, Error> {
        let root = source.root;
        let index = info.index.value();
        let texture = source.item(&root.textures, index, "texture", user)?;
        let name = label("texture", index, texture.name.as_deref());
        // Without a plain source the picture is in a format of an extension: only then are those looked at.
        let plain = root.images.get(texture.source.value()).map(|_| texture.source.value());
        let others = texture.extensions.as_ref().map(|e| &e.others);
        let Some(image) = plain else {
            if let Some(extension) = others.and_then(|o| o.keys().next()) {
                return Err(source.error(format!(
                    "{name} needs {extension:.60}, which cannot be read: export the file with PNG or JPEG images"
                )));
            }
            if texture.source.value() == u32::MAX as usize {
                return Ok(None);
            }
            source.item(&root.images, texture.source.value(), "image", &name)?;
            return Ok(None);
        };
        let wrap = match texture.sampler {
            None => [Wrap::Repeat; 2],
            Some(sampler) => {
                let sampler = source.item(&root.samplers, sampler.value(), "sampler", &name)?;
                let wrap = |mode| match mode {
                    WrappingMode::Repeat => Wrap::Repeat,
                    WrappingMode::MirroredRepeat => Wrap::Mirror,
                    WrappingMode::ClampToEdge => Wrap::Clamp,
                };
                [
                    wrap(source.known(&sampler.wrap_s, "wrapS", &name)?),
                    wrap(source.known(&sampler.wrap_t, "wrapT", &name)?),
                ]
            }
        };
        let next = self.images.len() as u32;
        let at = *self.known.entry((image, wrap.map(|w| w as u8))).or_insert(next);
        if at == next {
            self.images.push(ImageUse { image, wrap });
        }
        Ok(Some(at))
    }
}

/// Emitted light. Emissive textures are not read: a factor that waits for one would make the whole surface glow,
/// so such surfaces emit nothing.
fn emissive(json: &gltf::json::Material) -> [f32; 3] {
    if json.emissive_texture.is_some() {
        return [0.0; 3];
    }
    let strength = json.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
    json.emissive_factor.0.map(|v| v * strength.map_or(1.0, |s| s.emissive_strength.0))
}

/// `KHR_texture_transform`: scale, then a turn, then a shift. A positive angle is counter-clockwise as one sees the
/// image, with v down; this is what the example of the extension's text and its sample viewer do, not its GLSL.
fn uv_source(info: &Info) -> UvSource {
    let Some(transform) = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref()) else {
        return UvSource { set: info.tex_coord, transform: None };
    };
    let (sin, cos) = f64::from(transform.rotation.0).sin_cos();
    let [su, sv] = transform.scale.0.map(f64::from);
    let [du, dv] = transform.offset.0.map(f64::from);
    UvSource {
        set: transform.tex_coord.unwrap_or(info.tex_coord),
        transform: Some([[cos * su, sin * sv, du], [-sin * su, cos * sv, dv]]),
    }
}
