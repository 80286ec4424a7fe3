//! What lies under a pixel: colour, normal and light of its own.

use rayon::prelude::*;

use super::encode::decode_table;
use super::texture::Pyramid;
use crate::samples::GBuffer;
use crate::scene::{AlphaMode, Camera, Scene};
use crate::vec3::{V3, add, cross, dot, mul, scale, sub, unit};

/// A surface as shading sees it.
pub(crate) struct Surface {
    pub(crate) position: V3,
    /// Base colour × vertex colour × texture, linear.
    pub(crate) albedo: V3,
    pub(crate) emissive: V3,
    /// Interpolated normal, on the eye's side of the triangle.
    pub(crate) normal: V3,
    /// The triangle's own normal, towards the eye.
    pub(crate) flat_normal: V3,
    pub(crate) to_eye: V3,
    /// Shown as it is, without light.
    pub(crate) unlit: bool,
}

/// Everything that is needed to know a pixel's surface.
pub(crate) struct Materials<'a> {
    scene: &'a Scene,
    eye: V3,
    pub(crate) gbuffer: &'a GBuffer,
    textures: Vec<Pyramid<'a>>,
    decode: [f32; 256],
    /// Angle that a pixel spans, as a length at distance 1.
    pixel: f32,
}

impl<'a> Materials<'a> {
    pub(crate) fn new(scene: &'a Scene, camera: &Camera, gbuffer: &'a GBuffer) -> Materials<'a> {
        let cutout = |texture: usize| {
            scene
                .materials
                .iter()
                .any(|m| m.alpha_mode != AlphaMode::Opaque && m.base_color_texture == Some(texture as u32))
        };
        Materials {
            scene,
            eye: camera.eye,
            gbuffer,
            textures: scene.textures.iter().enumerate().map(|(i, t)| Pyramid::new(t, cutout(i))).collect(),
            decode: decode_table(),
            pixel: 2.0 * (camera.fov.to_radians() * 0.5).tan() / gbuffer.samples.height.max(1) as f32,
        }
    }

    /// Makes the reduced images of the textures that these pixels show, side by side: later they are found ready.
    pub(crate) fn prepare(&self, pixels: &[usize]) {
        let soup = &self.scene.soup;
        let mut shown = vec![false; self.textures.len()];
        for &i in pixels {
            let material = soup.material.get(self.gbuffer.samples.triangle[i] as usize);
            let material = material.and_then(|m| self.scene.materials.get(*m as usize));
            if let Some(texture) = material.and_then(|m| m.base_color_texture)
                && let Some(shown) = shown.get_mut(texture as usize)
            {
                *shown = true;
            }
        }
        self.textures.par_iter().zip(shown).with_max_len(1).for_each(|(texture, shown)| {
            if shown {
                texture.prepare(&self.decode);
            }
        });
    }

    /// The surface of pixel `i`, `None` for background.
    pub(crate) fn surface(&self, i: usize) -> Option<Surface> {
        let (samples, soup) = (&self.gbuffer.samples, &self.scene.soup);
        let t = samples.triangle[i] as usize;
        let position = samples.positions[i];
        let corners = soup.positions.get(t)?;
        if position[0].is_nan() {
            return None;
        }
        let [u, v] = self.gbuffer.bary[i];
        let weights = [1.0 - u - v, u, v];

        let eye = sub(self.eye, position);
        let to_eye = unit(eye).unwrap_or([0.0, 1.0, 0.0]);
        let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
        let flat = samples.normals.get(i).copied().or_else(|| unit(normal)).unwrap_or(to_eye);
        let flat_normal = if dot(flat, to_eye) < 0.0 { scale(flat, -1.0) } else { flat };
        let normal_at = |n: &[V3; 3]| unit(blend(n, weights));
        let smooth = soup.normals.get(t).and_then(normal_at).unwrap_or(flat_normal);
        // Seen from its back, a surface is lit as if it were turned around: both sides are real.
        let smooth_normal = if dot(smooth, flat_normal) < 0.0 { scale(smooth, -1.0) } else { smooth };

        let material = self.scene.materials.get(*soup.material.get(t)? as usize)?;
        let mut albedo = [material.base_color[0], material.base_color[1], material.base_color[2]];
        if let Some(colors) = soup.colors.get(t) {
            albedo = mul(albedo, blend(colors, weights));
        }
        let texture = material.base_color_texture.and_then(|index| self.textures.get(index as usize));
        if let (Some(texture), Some(uv)) = (texture, soup.uvs.get(t)) {
            let at = |k: usize| uv[0][k] * weights[0] + uv[1][k] * weights[1] + uv[2][k] * weights[2];
            let level = self.level(uv, normal, texture.area(), eye, dot(flat_normal, to_eye));
            albedo = mul(albedo, texture.color(&self.decode, [at(0), at(1)], level));
        }
        let emissive = material.emissive;
        Some(Surface {
            position,
            albedo,
            emissive,
            normal: smooth_normal,
            flat_normal,
            to_eye,
            unlit: material.unlit,
        })
    }

    /// The base-2 logarithm of how many texels lie side by side under a pixel: the texels that its footprint covers,
    /// as an area, so that a grazing view is neither as sharp as it could be across nor as smooth as it should be along.
    fn level(&self, uv: &[[f32; 2]; 3], normal: V3, texels: f32, eye: V3, facing: f32) -> f32 {
        let (du, dv) =
            ([uv[1][0] - uv[0][0], uv[2][0] - uv[0][0]], [uv[1][1] - uv[0][1], uv[2][1] - uv[0][1]]);
        let uv_area = (du[0] * dv[1] - du[1] * dv[0]).abs() * texels;
        let side = self.pixel * self.pixel * dot(eye, eye);
        0.5 * (uv_area * side / (dot(normal, normal).sqrt() * facing.max(0.05))).log2()
    }
}

fn blend(corners: &[V3; 3], weights: [f32; 3]) -> V3 {
    add(add(scale(corners[0], weights[0]), scale(corners[1], weights[1])), scale(corners[2], weights[2]))
}
