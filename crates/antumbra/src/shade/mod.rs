//! From samples and masks to a picture.
//!
//! [`shade`] gives linear light with the exposure already set; [`encode::picture`] makes screen pixels of it.
//!
//! The look has no knob that a scene needs: surfaces are Lambertian, each light adds
//! `color * intensity * cos / (d² + r²)` where its mask says lit, a soft sky-and-ground term keeps shadows readable,
//! and the exposure follows from the picture itself (`exposure.rs`). Nothing here can change a mask.

pub mod encode;
mod exposure;
mod surface;
mod texture;

use rayon::prelude::*;

use crate::mask::LIT;
use crate::samples::GBuffer;
use crate::samples::View;
use crate::scene::{Camera, InputError, PointLight, Scene};
use crate::vec3::{V3, add, dot, mix, mul, scale, sub, unit};
use exposure::Exposure;
use surface::{Materials, Surface};

/// How a picture looks. The defaults are meant for every scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Factor on the automatic exposure of the lights.
    pub exposure: f32,
    /// Factor on the light that comes from everywhere; 0 makes shadows black.
    pub ambient: f32,
    /// Dim what a smooth normal lights although the flat triangle is at grazing incidence: hides the saw-tooth edge
    /// that exact shadows draw on coarse round meshes (Chiang, Li and Burley, "Taming the Shadow Terminator",
    /// SIGGRAPH Talks 2019). A choice of shading: the mask stays as it is.
    pub soften_terminator: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options { exposure: 1.0, ambient: 1.0, soften_terminator: true }
    }
}

/// Light from above and from below where nothing else lights: cool and warm, so that shape shows in shadow.
const SKY: V3 = [0.125, 0.140, 0.165];
const GROUND: V3 = [0.075, 0.066, 0.058];

/// The backdrop: straight up, at the horizon, straight down. Dark slate: lit and shadowed surfaces both stand out.
const BACKDROP: [V3; 3] = [[0.035, 0.052, 0.080], [0.150, 0.170, 0.195], [0.050, 0.048, 0.047]];

/// A light made ready for many pixels.
pub(crate) struct Lamp<'a> {
    position: V3,
    power: V3,
    /// The square of the distance below which a light grows no brighter: no blown-out spot on the wall beside it.
    soft2: f32,
    mask: &'a [u8],
}

/// Shades every pixel of what `camera` sees with the lights that reach it. Linear, exposed, not yet bent by the shoulder
/// of [`encode::picture`]; values over 1 are kept. Rows run in parallel.
///
/// # Errors
/// [`InputError::Length`] if the G-buffer's arrays and the masks are not of one length.
pub fn shade(
    scene: &Scene,
    camera: &Camera,
    gbuffer: &GBuffer,
    lights: &[(PointLight, &[u8])],
    options: &Options,
) -> Result<Vec<V3>, InputError> {
    let samples = &gbuffer.samples;
    let pixels = samples.width * samples.height;
    let lengths = [
        ("positions", samples.positions.len()),
        ("triangles of samples", samples.triangle.len()),
        ("barycentric weights", gbuffer.bary.len()),
    ];
    let masks = lights.iter().map(|(_, mask)| ("mask", mask.len()));
    if let Some((what, got)) = lengths.into_iter().chain(masks).find(|&(_, got)| got != pixels) {
        return Err(InputError::Length { what, got, expected: pixels });
    }

    let mut lamps: Vec<Lamp<'_>> = lights
        .iter()
        .map(|(light, mask)| Lamp {
            position: light.position,
            power: scale(light.color, light.intensity.max(0.0)),
            soft2: 0.0,
            mask,
        })
        .collect();
    let materials = Materials::new(scene, camera, gbuffer);
    let exposure = Exposure::measure(&materials, &mut lamps, options);
    let backdrop = Backdrop::new(camera, samples.width, samples.height);

    let mut picture = vec![[0.0; 3]; pixels];
    picture.par_chunks_mut(samples.width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let i = y * samples.width + x;
            *pixel = match materials.surface(i) {
                Some(surface) => look(&surface, i, &lamps, &exposure, options, backdrop.up),
                None => backdrop.color(x, y),
            };
        }
    });
    Ok(picture)
}

/// The light that a surface sends to the eye.
fn look(s: &Surface, i: usize, lamps: &[Lamp<'_>], exposure: &Exposure, options: &Options, up: V3) -> V3 {
    if s.unlit {
        return add(s.albedo, s.emissive);
    }
    let direct = scale(irradiance(s, i, lamps, options.soften_terminator), exposure.lights);
    // Sky over ground, a little darker where the surface turns away from the eye.
    let towards_eye = 0.75 + 0.25 * dot(s.normal, s.to_eye).max(0.0);
    let around = mix(GROUND, SKY, 0.5 + 0.5 * dot(s.normal, up));
    let ambient = scale(around, towards_eye * exposure.ambient * options.ambient);
    add(mul(s.albedo, add(direct, ambient)), s.emissive)
}

/// What arrives at the surface of pixel `i` from all lights whose mask says lit.
pub(crate) fn irradiance(s: &Surface, i: usize, lamps: &[Lamp<'_>], soften: bool) -> V3 {
    let mut sum = [0.0; 3];
    for lamp in lamps.iter().filter(|lamp| lamp.mask[i] == LIT) {
        let to_light = sub(lamp.position, s.position);
        let Some(direction) = unit(to_light) else { continue };
        let cos = dot(s.normal, direction);
        if cos <= 0.0 {
            continue;
        }
        let mut share = cos / (dot(to_light, to_light) + lamp.soft2);
        if soften {
            let flat = dot(s.flat_normal, direction).max(0.0);
            let g = (flat / (cos * dot(s.flat_normal, s.normal)).max(1e-6)).min(1.0);
            share *= g * (1.0 + g * (1.0 - g));
        }
        sum = add(sum, scale(lamp.power, share));
    }
    sum
}

/// The colour where there is nothing: a gradient along the camera's vertical.
struct Backdrop {
    frame: View,
    width: usize,
    height: usize,
    up: V3,
}

impl Backdrop {
    fn new(camera: &Camera, width: usize, height: usize) -> Backdrop {
        let frame = View::new(camera, width, height);
        let up = unit(camera.up).unwrap_or([0.0, 1.0, 0.0]);
        Backdrop { frame, width, height, up }
    }

    fn color(&self, x: usize, y: usize) -> V3 {
        let ray = self.frame.direction(x, y, self.width, self.height).map(|v| v as f32);
        let height = dot(unit(ray).unwrap_or(self.up), self.up);
        let [zenith, horizon, nadir] = BACKDROP;
        // The square root makes the horizon a soft band instead of a broad one.
        mix(horizon, if height > 0.0 { zenith } else { nadir }, height.abs().sqrt())
    }
}

#[cfg(test)]
mod tests;
