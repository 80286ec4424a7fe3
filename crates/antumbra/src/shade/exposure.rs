//! How bright: measured on a coarse grid of the picture's own pixels, so that files in candela, in arbitrary units or
//! without any give a picture alike.

use rayon::prelude::*;

use super::surface::{Materials, Surface};
use super::{Lamp, Options, irradiance};
use crate::mask::LIT;
use crate::vec3::{dot, sub};

/// About how many pixels are looked at.
const PROBES: usize = 40_000;

/// What arrives at the median lit surface of middling colour (linear, white is 1).
const LIT_LEVEL: f32 = 0.72;

/// The colour for which [`LIT_LEVEL`] is meant. Darker scenes are exposed longer, but only by the square root: coal
/// should not look like chalk.
const MIDDLE_ALBEDO: f32 = 0.5;

/// Below this share of a light's median distance it grows no brighter (so 1 / 0.4² ≈ 6 times the median at most).
const SOFT_SHARE: f32 = 0.4;

/// Factors for the two kinds of light.
pub(crate) struct Exposure {
    pub(crate) lights: f32,
    pub(crate) ambient: f32,
}

impl Exposure {
    /// Sets each lamp's soft distance, then the factors: the median irradiance of all pixels that any light reaches
    /// lands at [`LIT_LEVEL`], corrected by the median albedo.
    pub(crate) fn measure(materials: &Materials<'_>, lamps: &mut [Lamp<'_>], options: &Options) -> Exposure {
        let (width, height) = (materials.gbuffer.samples.width, materials.gbuffer.samples.height);
        let step = ((width * height) as f64 / PROBES as f64).sqrt().ceil().max(1.0) as usize;
        let pixels: Vec<usize> = (step / 2..height)
            .step_by(step)
            .flat_map(|y| (step / 2..width).step_by(step).map(move |x| y * width + x))
            .collect();
        materials.prepare(&pixels);
        let probes: Vec<(usize, Surface)> = pixels
            .into_par_iter()
            .with_min_len(1024)
            .filter_map(|i| Some((i, materials.surface(i).filter(|s| !s.unlit)?)))
            .collect();

        for lamp in lamps.iter_mut() {
            let distances = |lit: bool| -> Vec<f32> {
                let reached = probes.iter().filter(|(i, _)| !lit || lamp.mask[*i] == LIT);
                reached.map(|(_, s)| sub(lamp.position, s.position)).map(|d| dot(d, d).sqrt()).collect()
            };
            let median = median(distances(true)).or_else(|| median(distances(false))).unwrap_or(1.0);
            lamp.soft2 = (SOFT_SHARE * median).powi(2).max(f32::MIN_POSITIVE);
        }

        let arriving = probes
            .par_iter()
            .with_min_len(1024)
            .map(|(i, s)| luminance(irradiance(s, *i, lamps, options.soften_terminator)));
        let lit = median(arriving.filter(|v| *v > 0.0).collect());
        let albedo =
            median(probes.iter().map(|(_, s)| luminance(s.albedo)).collect()).unwrap_or(MIDDLE_ALBEDO);
        let adaptation = (MIDDLE_ALBEDO / albedo.max(1e-3)).sqrt().clamp(0.75, 3.0);
        let lights = lit.map_or(0.0, |lit| LIT_LEVEL * adaptation * options.exposure / lit);
        Exposure { lights: if lights.is_finite() { lights } else { 0.0 }, ambient: adaptation }
    }
}

/// Rec. 709 weights.
fn luminance(c: [f32; 3]) -> f32 {
    dot(c, [0.2126, 0.7152, 0.0722])
}

/// The middle value of the finite ones.
fn median(mut values: Vec<f32>) -> Option<f32> {
    values.retain(|v| v.is_finite());
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}
