//! AFF, the format of BART (museum, robots, kitchen), with its animation.
//!
//! Supported: all of the published format. Viewpoint `v`, lights `l` and `la`, fills `f` and `fm`, polygons `p` and
//! `pp`, textured triangles `tt` and `ttp`, animated triangles `tpa`, meshes `m`, spheres `s`, cones and cylinders `c`,
//! includes `i` with detail level `d`, transforms `xs` and `x`, key frames `k` (of translation, rotation, scale and
//! visibility), animation times `a`. The background `b` and the ambient light `am` are read, but a [`Scene`] has no
//! place for them.
//!
//! How it is meant here:
//! - A file that is included counts as if its text stood there, so a fill lasts beyond the end of the file or brace
//!   it stands in; only braces must match within a file.
//! - Between keys, translations and scales run on Kochanek-Bartels splines, rotations on the quaternion splines of
//!   BART's animation code. First and last key only shape the curve; before the second and after the last but one
//!   nothing moves. An `x` whose name has no keys stays put.
//! - The translation of the animation `camera` replaces the eye point, its rotation turns a camera that looks along
//!   -z with +y up. The translation of a light's animation replaces the light's position.
//! - Curved surfaces become triangles: cones 24-gons without end caps, spheres 24 by 12. Polygons are fans from their
//!   first corner; those with a dent are cut by ears.
//! - Every fill is a material. A transmittance above 0 makes it partly covering, alpha `1 - T`. The diffuse colour is
//!   the base colour; if a texture is found it is white, as in BART, and the texture is all. BART's images come apart
//!   from its scenes: a missing one is told in the material's name. Texture coordinates are as written, v down: the
//!   pictures of the museum and the garden behind the kitchen stand upright so. (BART is not of one mind: the car's
//!   number plate and the robots count v upwards.)
//! - An object is an include or a named transform with triangles directly in it, named by the way to it:
//!   `Robot1/robot_transl1/head_rot1/head`.
//!
//! Sources: J. Lext, U. Assarsson, T. Möller, "BART: A Benchmark for Animated Ray Tracing", Technical Report 00-14,
//! Chalmers, 2000, and IEEE Computer Graphics and Applications 21(2), 2001; "AFF - Animated File Format", drafts of
//! 15 May and 26 June 2000; E. Haines, "Neutral File Format" 3.9, Standard Procedural Databases. Splines: `spline.rs`.

mod affine;
mod evaluate;
mod files;
mod fills;
mod keyframes;
mod model;
mod parse;
mod shapes;
mod spline;
mod tessellate;
mod tokens;

#[cfg(test)]
mod tests;

use std::path::Path;

use antumbra::scene::Scene;

use crate::Error;

use self::model::Model;

/// An AFF file, parsed with all that it includes.
#[derive(Debug)]
pub(super) struct AffFile {
    model: Model,
}

/// Reads `path` and what it includes.
pub(super) fn open(path: &Path) -> Result<AffFile, Error> {
    let model = parse::read(path)?;
    Ok(AffFile { model })
}

impl AffFile {
    /// The scene at `time` seconds of the file's own clock, clamped to [`AffFile::time_span`]; `None` is the start.
    pub(super) fn at(&self, time: Option<f32>) -> Result<Scene, Error> {
        let [start, end] = self.model.clock();
        // A time that is not a number falls through to the start.
        let time = time.map_or(start, |t| f64::from(t).max(start).min(end));
        evaluate::scene(&self.model, time).map_err(|what| Error::content(&self.model.path, what))
    }

    /// Start and end as the file's `a` says, or else as its keys do; `None` if nothing moves.
    pub(super) fn time_span(&self) -> Option<[f32; 2]> {
        self.model.moves().then(|| self.model.clock().map(|t| t as f32))
    }
}
