//! `cube-map` and `dual-paraboloid`: shadow maps, the baselines that alias.
//!
//! Sources: Williams 1978 ("Casting Curved Shadows on Curved Surfaces"); Gerasimov 2004 ("Omnidirectional Shadow Mapping",
//! GPU Gems, chapter 12) for the cube; Brabec, Annen, Seidel 2002 ("Shadow Mapping for Hemispherical and Omnidirectional
//! Light Sources") for the paraboloids; Reeves, Salesin, Cook 1987 ("Rendering Antialiased Shadows with Depth Maps") for
//! percentage-closer filtering. The parameters and their defaults are those of the comparison framework of Kobrtek et al. 2021.
//!
//! They are here to be measured: one depth a texel cannot know where an edge runs inside of it, so they leak and have acne; how
//! many samples are wrong is what `compare` prints. Rasterisation is by texel centres in f64 with a maximum (or minimum)
//! a texel, so a picture does not depend on the number of threads or on the order of triangles.
//!
//! What we changed: the cube needs no near and far plane (the map holds 1 / distance, for which infinity is 0), casters are never
//! clipped, and filtering looks across faces; the paraboloids' casters are subdivided until their arcs are arcs.
//!
//! Cost: O(T + texels) to draw, O(N) to look up. 24 MiB (cube) or 8 MiB (paraboloids) at 1024² texels.

mod cube;
mod debug;
mod paraboloid;
#[cfg(test)]
mod tests;

use std::sync::atomic::AtomicU32;

use rayon::prelude::*;

use super::{DebugView, Method, Options, Samples, Stats, StatsBuilder, check_input};
use crate::mask::{LIT, NONE, SHADOWED};
use crate::scene::{InputError, Triangle};

/// How a shadow map is drawn and read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowMapOptions {
    /// Texels a side of each face or hemisphere, 1 to 16384.
    pub resolution: u32,
    /// Nearer casters are not drawn, nearer samples are lit. `None`: no such plane.
    pub near: Option<f32>,
    /// Farther casters are not drawn, farther samples are lit. `None`: no such plane.
    pub far: Option<f32>,
    /// Bias for each unit of depth by which the caster changes over one texel.
    pub slope_bias: f32,
    /// Bias everywhere. Cube: units in the last place of the caster's depth. Paraboloids: parts of the depth range.
    pub constant_bias: f32,
    /// Percentage-closer filtering over `pcf` x `pcf` texels; 1: none. A sample is shadowed where less than half of them are
    /// lit (the mask has no greys).
    pub pcf: u32,
    /// Paraboloids: casters are subdivided until no edge is further from its arc than so many texels. `None`: straight
    /// edges between projected corners, as on a GPU without tessellation.
    pub arc_error: Option<f32>,
}

impl ShadowMapOptions {
    /// Polygon offset (2.5, 10), as the framework has for its cube map.
    pub const CUBE: ShadowMapOptions = ShadowMapOptions {
        resolution: 1024,
        near: None,
        far: None,
        slope_bias: 2.5,
        constant_bias: 10.0,
        pcf: 1,
        arc_error: None,
    };

    /// A bias of 0.0005 of the depth range, as the framework has for its dual paraboloids, and the slope's share that it has
    /// for its cube map only: without that, most samples on slopes have acne.
    pub const PARABOLOID: ShadowMapOptions =
        ShadowMapOptions { constant_bias: 5e-4, arc_error: Some(0.5), ..ShadowMapOptions::CUBE };

    fn within(&self, depth: f64) -> bool {
        self.near.is_none_or(|n| depth >= f64::from(n)) && self.far.is_none_or(|f| depth <= f64::from(f))
    }

    /// Sizes in range, so that nothing later has to ask.
    fn checked(mut self) -> ShadowMapOptions {
        self.resolution = self.resolution.clamp(1, 16384);
        self.pcf = self.pcf.clamp(1, 64);
        self
    }

    /// Where filtering looks, in texels from the sample's own.
    fn taps(&self) -> impl Iterator<Item = [f64; 2]> {
        let (k, middle) = (self.pcf, 0.5 * (f64::from(self.pcf) - 1.0));
        (0..k * k).map(move |i| [f64::from(i % k) - middle, f64::from(i / k) - middle])
    }
}

/// What the two kinds of map have of their own.
trait DepthMap: Send + Sync {
    const NAME: &'static str;
    /// Maps side by side.
    const LAYERS: usize;
    /// What an empty texel holds.
    const EMPTY: f32;
    /// The deepest sample, where the range of depths depends on it.
    fn range(options: &ShadowMapOptions, positions: &[[f32; 3]], light: [f32; 3]) -> f64;
    /// Draws one triangle (relative to the light) into all layers.
    fn draw(options: &ShadowMapOptions, range: f64, triangle: &[[f64; 3]; 3], texels: &[AtomicU32]);
    /// Which share of the filter's texels lets the light through to a sample (relative to the light, not at it).
    fn lit(options: &ShadowMapOptions, range: f64, p: [f64; 3], texels: &[AtomicU32]) -> f32;
    /// The texel that a sample (relative to the light, not at it) falls into, unfiltered.
    fn texel(resolution: u32, p: [f64; 3]) -> usize;
}

/// The texel at a place of a layer; (u, v) in [-1, 1], what is outside goes to the border.
fn texel_at(resolution: u32, layer: usize, uv: [f64; 2]) -> usize {
    let side = resolution as usize;
    let index = |x: f64| (((x + 1.0) * 0.5 * f64::from(resolution)) as usize).min(side - 1);
    (layer * side + index(uv[1])) * side + index(uv[0])
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn relative(p: [f32; 3], light: [f32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(light[k]))
}

/// Memory of a map, kept between frames, and how it is made.
#[derive(Debug)]
struct Map {
    options: ShadowMapOptions,
    texels: Vec<AtomicU32>,
}

impl Map {
    fn new(options: ShadowMapOptions) -> Map {
        Map { options: options.checked(), texels: Vec::new() }
    }

    /// Draws the map and returns the range of depths.
    fn draw<M: DepthMap>(&mut self, triangles: &[Triangle], positions: &[[f32; 3]], light: [f32; 3]) -> f64 {
        let r = self.options.resolution as usize;
        self.texels.resize_with(M::LAYERS * r * r, AtomicU32::default);
        self.texels.par_iter_mut().for_each(|t| *t.get_mut() = M::EMPTY.to_bits());
        let range = M::range(&self.options, positions, light);
        let (options, texels) = (&self.options, &self.texels);
        triangles.par_iter().with_min_len(64).for_each(|t| {
            M::draw(options, range, &t.map(|c| relative(c, light)), texels);
        });
        range
    }

    /// The share of light at a sample: NaN where there is none, 1 at the light itself.
    fn lit<M: DepthMap>(&self, range: f64, p: [f32; 3], light: [f32; 3]) -> f32 {
        let p = relative(p, light);
        match p.iter().any(|v| v.is_nan()) {
            true => f32::NAN,
            false if p == [0.0; 3] => 1.0,
            false => M::lit(&self.options, range, p, &self.texels),
        }
    }

    fn shadow<M: DepthMap>(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let mut stats = StatsBuilder::start(M::NAME, "scalar");
        check_input(triangles, samples, light, mask)?;
        stats.stage("check_input");
        let range = self.draw::<M>(triangles, samples.positions, light);
        stats.stage("draw_depth");
        mask.par_iter_mut().zip(samples.positions).with_min_len(1024).for_each(|(m, p)| {
            let lit = self.lit::<M>(range, *p, light);
            *m = match lit.is_nan() {
                true => NONE,
                false if lit < 0.5 => SHADOWED,
                false => LIT,
            };
        });
        stats.stage("look_up");
        stats.bytes("depth_map", 4 * self.texels.capacity());
        Ok(stats.finish(triangles.len(), mask))
    }
}

macro_rules! shadow_map {
    ($(#[$doc:meta])* $name:ident, $kind:ty, $defaults:expr) => {
        $(#[$doc])*
        #[derive(Debug)]
        pub struct $name(Map);

        impl $name {
            /// A map with the framework's parameters.
            pub fn new(_: &Options) -> $name {
                $name::with($defaults)
            }

            /// A map with parameters of the caller's.
            pub fn with(options: ShadowMapOptions) -> $name {
                $name(Map::new(options))
            }
        }

        impl Method for $name {
            fn name(&self) -> &'static str {
                <$kind as DepthMap>::NAME
            }

            fn shadow(
                &mut self,
                triangles: &[Triangle],
                samples: Samples<'_>,
                light: [f32; 3],
                mask: &mut [u8],
            ) -> Result<Stats, InputError> {
                self.0.shadow::<$kind>(triangles, samples, light, mask)
            }

            fn debug_views(&self) -> &'static [DebugView] {
                debug::VIEWS
            }

            fn debug_view(
                &mut self,
                view: &str,
                triangles: &[Triangle],
                samples: Samples<'_>,
                light: [f32; 3],
            ) -> Result<Option<Vec<f32>>, InputError> {
                debug::draw::<$kind>(&mut self.0, view, triangles, samples, light)
            }
        }
    };
}

shadow_map! {
    /// Six perspective shadow maps around the light. Not exact.
    CubeMap, cube::Cube, ShadowMapOptions::CUBE
}
shadow_map! {
    /// Two parabolic shadow maps, one for each side of the light along z. Not exact.
    DualParaboloid, paraboloid::Paraboloid, ShadowMapOptions::PARABOLOID
}
