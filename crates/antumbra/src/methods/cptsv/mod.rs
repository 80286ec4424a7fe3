//! `cptsv`: per-triangle shadow volumes over clusters of view samples.
//!
//! Source: Sintorn, Kämpe, Olsson, Assarsson 2014, "Per-Triangle Shadow Volumes Using a View-Sample Cluster Hierarchy"
//! (I3D 2014), as Kobrtek, Milet, Tóth, Herout 2021 describe it (section 2.2).
//!
//! As [`super::Ptsv`], whose walk and boxes it shares, over another tree: tiles of 8 x 8 pixels are cut into depth slices, so that
//! a tile over a depth edge becomes several tight boxes; the tree is ordered by picture and depth at once. Nodes are cut
//! away by three more planes a triangle, through its corners' light rays.
//!
//! What we changed, and why:
//! - The tree is sparse: it has the nodes that hold samples. The dense arrays of the comparison framework take gigabytes from
//!   2160 lines on ([`DenseLayout`] says how many); ours take some ten bytes a sample.
//! - Slice numbers are as wide as the scene needs. A fixed ten bits put all far samples of a large picture into one slice.
//! - The wedge planes are projected along the light ray *before* they are bisected: bisected first, they cut into the
//!   frusta of slanted triangles.
//! - Walks share long work through a bounded queue, planes carry proven margins, samples are decided by the exact leaf test,
//!   a leaf tests the samples of its own cluster only.
//! - Without a camera, clusters are runs of 64 samples in the Morton order of their quantised positions.
//!
//! Cost: tree O(N) and a sort of C cluster keys, walks O(T log C + outlines in clusters). C is about N / 50.

mod dense;

pub use dense::DenseLayout;

use super::ptsv::engine::{Engine, Shape};
use super::ptsv::tiles::Tiling;
use super::ptsv::{Tuning, check_count, views};
use super::{DebugView, Method, Options, Samples, Stats, StatsBuilder, check_input};
use crate::Isa;
use crate::scene::{InputError, Triangle};

/// Pixels of a tile: one word of 64 samples.
const TILE: [usize; 2] = [8, 8];

/// Per-triangle shadow volumes over clusters of view samples.
#[derive(Debug)]
pub struct Cptsv {
    engine: Engine,
}

impl Default for Cptsv {
    fn default() -> Self {
        Cptsv::new(&Options::default())
    }
}

impl Cptsv {
    /// With the default [`Tuning`].
    pub fn new(options: &Options) -> Cptsv {
        Cptsv::with_tuning(options.isa, Tuning::default())
    }

    /// With other trade-offs.
    pub fn with_tuning(isa: Isa, tuning: Tuning) -> Cptsv {
        Cptsv { engine: Engine::new(Shape { tile: TILE, clusters: true }, isa, tuning) }
    }

    /// Counters of the clusters, and what the dense layout would have taken for this picture.
    fn report(&self, stats: &mut StatsBuilder) {
        let per_tile = self.engine.bands.iter().flat_map(|b| {
            let starts = std::iter::once(0).chain(b.ends.iter().copied());
            b.ends.iter().zip(starts).map(|(end, start)| end - start)
        });
        stats.counter("clusters_per_tile_max", u64::from(per_tile.max().unwrap_or(0)));
        if let Tiling::Picture { .. } = self.engine.tiling {
            let tiles = self.engine.bands.iter().map(|b| b.ends.len() as u64).sum();
            let dense = DenseLayout::new(self.engine.key_bits, tiles);
            stats.counter("slice_bits", u64::from(self.engine.key_bits[2]));
            stats.counter("dense_bytes", dense.bytes());
            stats.counter("dense_reduced_bytes", dense.reduced_bytes());
        }
    }
}

impl Method for Cptsv {
    fn name(&self) -> &'static str {
        "cptsv"
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let mut stats = StatsBuilder::start("cptsv", self.engine.isa.resolved().name());
        check_input(triangles, samples, light, mask)?;
        check_count(triangles)?;
        stats.stage("check_input");
        self.engine.run(triangles, samples, light, mask, &mut stats);
        self.report(&mut stats);
        Ok(stats.finish(triangles.len(), mask))
    }

    fn debug_views(&self) -> &'static [DebugView] {
        views::CPTSV
    }

    fn debug_view(
        &mut self,
        view: &str,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
    ) -> Result<Option<Vec<f32>>, InputError> {
        views::draw(&mut self.engine, views::CPTSV, view, triangles, samples, light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::Oracle;
    use crate::samples::View;
    use crate::scene::Camera;

    /// Two depths a tile, 1e-1 to 1e5 from the eye, through the smallest queue, in clip space and in the world.
    #[test]
    fn depth_edges_become_clusters_and_nothing_else_changes() {
        let camera = Camera {
            name: String::new(),
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov: 90.0,
        };
        let (width, height) = (61, 43);
        let view = View::new(&camera, width, height);
        let depth =
            |x: usize, y: usize| if (x + y).is_multiple_of(2) { 0.1 * 1.5f64.powi(y as i32) } else { 1e5 };
        let positions: Vec<[f32; 3]> = (0..width * height)
            .map(|i| {
                let d = view.direction(i % width, i / width, width, height);
                d.map(|v| (v * depth(i % width, i / width)) as f32)
            })
            .collect();
        let triangles: Vec<Triangle> = (0..60)
            .map(|i| {
                let at = |k: usize| {
                    let a = (i * 7 + k * 5) as f32;
                    let r = 0.2 * 1.2f32.powi(i as i32);
                    [r * a.sin(), r * (a * 1.3).cos(), -r * (1.0 + (a * 0.7).sin())]
                };
                [at(0), at(1), at(2)]
            })
            .collect();
        let light = [0.03, 0.3, 0.05];
        let samples = Samples { positions: &positions, width, view: Some(&view) };
        let mut expected = vec![9; positions.len()];
        Oracle.shadow(&triangles, samples, light, &mut expected).expect("finite");
        assert!(expected.contains(&0) && expected.contains(&1));
        for tuning in [Tuning::default(), Tuning { budget: 1, queue: 2, ..Tuning::default() }] {
            let mut method = Cptsv::with_tuning(Isa::Auto, tuning);
            for view in [samples.view, None] {
                let mut mask = vec![9; positions.len()];
                let stats =
                    method.shadow(&triangles, Samples { view, ..samples }, light, &mut mask).expect("finite");
                assert_eq!(mask, expected);
                let counter = |name| stats.counters.iter().find(|c| c.0 == name).map_or(0, |c| c.1);
                assert_eq!(counter("queue_flushes") > 0, tuning.budget == 1);
                // Half a tile is far away, the rest of it in at least one slice.
                assert!((2..=64).contains(&counter("clusters_per_tile_max")) == view.is_some());
            }
            let level =
                method.debug_view("level", &triangles, samples, light).expect("finite").expect("known");
            assert!(level.iter().zip(&expected).all(|(v, m)| (*v > 0.0) == (*m == 1)));
        }
    }
}
