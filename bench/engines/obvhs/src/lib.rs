//! obvhs: the fastest hierarchies that a Rust crate has. PLOC, then a compressed eight-wide tree, and one any-hit ray a sample.
//!
//! The crate's presets are options (`obvhs:fastest` to `obvhs:medium`). Its memory is kept from frame to frame where it lets it be;
//! the triangles are laid out in the order of the leaves, as its own example does for speed.

use std::sync::Arc;
use std::time::Instant;

use antumbra::mask::{LIT, SHADOWED};
use anyhow::{Context, Result, bail};
use bench_common::{Case, Engine, FrameTime, Tile, for_each_tile, ms_since};
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::ray::Ray;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use rayon::prelude::*;

/// What is left out at the sample's end (`Case::cut`), as with Embree.
const EPSILON: f32 = 1e-5;

/// Primitives that a leaf of the compressed tree can hold.
const MAX_LEAF: u32 = 3;

/// obvhs as an engine.
pub struct Obvhs {
    name: String,
    preset: &'static str,
    parameters: BvhBuildParams,
    /// With what is left out of each ray.
    case: Option<(Arc<Case>, f32)>,
    scratch: Scratch,
}

/// Memory that is kept.
#[derive(Default)]
struct Scratch {
    triangles: Vec<Triangle>,
    ploc: PlocBuilder,
    reinsertion: ReinsertionOptimizer,
    binary: Bvh2,
    leaves: Vec<RtTriangle>,
}

impl Obvhs {
    /// `preset` is one of the crate's, by the first words of its name; empty for the one that was fastest in total.
    ///
    /// # Errors
    /// An unknown preset.
    pub fn new(preset: &str) -> Result<Obvhs> {
        let (preset_name, parameters) = match preset {
            "fastest" => ("fastest_build", BvhBuildParams::fastest_build()),
            "" | "very-fast" => ("very_fast_build", BvhBuildParams::very_fast_build()),
            "fast" => ("fast_build", BvhBuildParams::fast_build()),
            "medium" => ("medium_build", BvhBuildParams::medium_build()),
            _ => bail!("obvhs:{preset}: unknown preset; known are fastest, very-fast, fast, medium"),
        };
        let name = if preset.is_empty() { "obvhs".to_owned() } else { format!("obvhs:{preset}") };
        Ok(Obvhs { name, preset: preset_name, parameters, case: None, scratch: Scratch::default() })
    }
}

impl Engine for Obvhs {
    fn name(&self) -> &str {
        &self.name
    }

    fn setup(&self) -> String {
        format!("obvhs 0.4.0, PLOC {} to CWBVH, rays from the light, epsilon {EPSILON:e}", self.preset)
    }

    fn prepare(&mut self, case: &Arc<Case>) -> Result<()> {
        self.case = Some((case.clone(), case.cut(EPSILON)));
        Ok(())
    }

    fn frame(&mut self, mask: &mut [u8]) -> Result<FrameTime> {
        let (case, cut) = self.case.as_ref().context("frame before prepare")?;
        let start = Instant::now();
        let tree = self.scratch.build(case, &self.parameters);
        let build_ms = ms_since(start);
        trace(case, &tree, &self.scratch.leaves, *cut, mask);
        let total_ms = ms_since(start);
        Ok(FrameTime { build_ms, trace_ms: total_ms - build_ms, total_ms })
    }
}

impl Scratch {
    /// All triangles may have moved: everything is made anew.
    fn build(&mut self, case: &Case, parameters: &BvhBuildParams) -> CwBvh {
        let triangles = case.triangles();
        let convert = |t: &[[f32; 3]; 3]| {
            let [v0, v1, v2] = t.map(Vec3A::from_array);
            Triangle { v0, v1, v2 }
        };
        triangles.par_iter().map(convert).collect_into_vec(&mut self.triangles);
        if triangles.is_empty() {
            self.leaves.clear();
            return CwBvh::default();
        }
        self.ploc.build_with_bvh(
            &mut self.binary,
            parameters.ploc_search_distance,
            &self.triangles,
            (0..triangles.len() as u32).collect(),
            parameters.sort_precision,
            parameters.search_depth_threshold,
        );
        self.reinsertion.run(&mut self.binary, parameters.reinsertion_batch_ratio, None);
        let tree = bvh2_to_cwbvh(&self.binary, parameters.max_prims_per_leaf.min(MAX_LEAF), true, false);
        let of = |&i: &u32| RtTriangle::from(&self.triangles[i as usize]);
        tree.primitive_indices.par_iter().map(of).collect_into_vec(&mut self.leaves);
        tree
    }
}

fn trace(case: &Case, tree: &CwBvh, leaves: &[RtTriangle], cut: f32, mask: &mut [u8]) {
    let light = Vec3A::from_array(case.light);
    for_each_tile(mask, case.width, |tile: &mut Tile<'_>| {
        for y in 0..tile.height {
            for x in 0..tile.width {
                let p = Vec3A::from_array(case.samples[tile.sample(x, y)]);
                if p.is_nan() {
                    continue;
                }
                let ray = Ray::new(light, p - light, 0.0, 1.0 - cut);
                let lit = leaves.is_empty() || tree.ray_traverse_miss(ray, |ray, i| leaves[i].intersect(ray));
                tile.mask[y * tile.width + x] = if lit { LIT } else { SHADOWED };
            }
        }
    });
}
