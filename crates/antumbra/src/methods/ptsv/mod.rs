//! `ptsv`: per-triangle shadow volumes, rasterised as a whole into a pyramid over the view samples.
//!
//! Source: Sintorn, Olsson, Assarsson 2011, "An Efficient Alias-free Shadow Algorithm for Opaque and Transparent Objects
//! using per-triangle Shadow Volumes" (ACM TOG 30(6)): section 3.1 (pyramid with 32 children a node, tile test in clip space,
//! trivial accept), section 3.5 (planes through eye, light and silhouette corners).
//!
//! Each triangle's shadow is four planes. It is walked down the pyramid: a tile whose box lies outside one plane is rejected,
//! one inside all four is shadowed as a whole by one bit, others are refined down to samples. In the end bits are
//! carried down.
//!
//! What we changed, and why:
//! - Boxes bound the *samples* in clip space in x, y and depth, instead of depth only over a fixed pixel grid: 24 bytes a node
//!   instead of 8, but samples need not lie where the camera says, and without any camera the same tree works on boxes
//!   in the world.
//! - Planes come with proven margins; reject and accept happen outside them only, samples are decided by the shared exact leaf test. So there is no bias.
//! - Empty tiles are not stored, children are numbered without gaps.
//! - Nodes that become complete by several triangles set their parent's bit, so that later triangles stop there.
//! - A walk that exceeds its budget becomes jobs of a bounded queue: one huge triangle is shared by all threads.
//!
//! Cost: tree O(N) and a sort of N / 32 keys, frusta O(T), walks O(T log N + length of shadow outlines in tiles). 24 bytes
//! and 1 bit a node, 12 bytes and 1 bit a sample.

pub(crate) mod boxes;
pub(crate) mod engine;
pub(crate) mod frustum;
pub(crate) mod space;
#[cfg(test)]
mod tests;
pub(crate) mod tiles;
pub(crate) mod tree;
mod tuning;
pub(crate) mod views;
pub(crate) mod walk;

pub use tuning::Tuning;

use super::{DebugView, Method, Options, Samples, Stats, StatsBuilder, check_input};
use crate::Isa;
use crate::scene::{InputError, Triangle};
use engine::{Engine, Shape};

/// Pixels of the lowest tile; 8 x 4 makes one word of 32 samples.
const TILE: [usize; 2] = [8, 4];

/// Per-triangle shadow volumes.
#[derive(Debug)]
pub struct Ptsv {
    engine: Engine,
}

impl Default for Ptsv {
    fn default() -> Self {
        Ptsv::new(&Options::default())
    }
}

impl Ptsv {
    /// With the default [`Tuning`].
    pub fn new(options: &Options) -> Ptsv {
        Ptsv::with_tuning(options.isa, Tuning::default())
    }

    /// With other trade-offs.
    pub fn with_tuning(isa: Isa, tuning: Tuning) -> Ptsv {
        Ptsv { engine: Engine::new(Shape { tile: TILE, clusters: false }, isa, tuning) }
    }
}

impl Method for Ptsv {
    fn name(&self) -> &'static str {
        "ptsv"
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let mut stats = StatsBuilder::start("ptsv", self.engine.isa.resolved().name());
        check_input(triangles, samples, light, mask)?;
        check_count(triangles)?;
        stats.stage("check_input");
        self.engine.run(triangles, samples, light, mask, &mut stats);
        Ok(stats.finish(triangles.len(), mask))
    }

    fn debug_views(&self) -> &'static [DebugView] {
        views::PTSV
    }

    fn debug_view(
        &mut self,
        view: &str,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
    ) -> Result<Option<Vec<f32>>, InputError> {
        views::draw(&mut self.engine, views::PTSV, view, triangles, samples, light)
    }
}

/// Triangles are numbered in 32 bits.
pub(crate) fn check_count(triangles: &[Triangle]) -> Result<(), InputError> {
    let limit = u32::MAX as usize - 1;
    if triangles.len() > limit {
        return Err(InputError::TooMany { what: "triangles", got: triangles.len(), limit });
    }
    Ok(())
}
