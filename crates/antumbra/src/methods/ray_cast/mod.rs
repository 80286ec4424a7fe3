//! `ray-cast`: any-hit rays from the light through a bounding volume hierarchy that is built anew every frame.
//!
//! Source: the baseline of Kobrtek, Milet, Tóth, Herout 2021 ("Comparison of Modern Omnidirectional Precise Shadowing
//! Techniques Versus Ray Tracing", section 2.6), here on the CPU. Packet walk after Boulos, Wald, Shirley 2006 ("Geometric
//! and Arithmetic Culling Methods for Entire Ray Packets").
//!
//! What we changed: all rays of a frame share one end, the light, so a packet of up to 64 samples is one cone: a node is
//! tested once a packet by interval arithmetic, a triangle once a packet before it is tested sample by sample. Packets
//! over depth edges are parted. Leaves use the shared exact test, so there is no bias and no leak.
//!
//! Cost: build O(T) after a radix sort; trace O(N log T) expected.

mod debug;
mod trace;

use rayon::prelude::*;

use super::debug::{check_view, complete};
use super::{DebugView, Method, Options, Samples, Stats, StatsBuilder, check_input};
use crate::Isa;
use crate::bvh::Bvh;
use crate::bvh::build::morton;
use crate::bvh::{Bounds, build};
use crate::mask::NONE;
use crate::scene::{InputError, Triangle};

/// Any-hit ray casting with a hierarchy built every frame, or kept.
#[derive(Debug, Default)]
pub struct RayCast {
    isa: Isa,
    bvh: Bvh,
    triangles: Vec<Triangle>,
    kept: bool,
    order: Vec<u64>,
    sorted: Vec<[f32; 3]>,
    sorted_mask: Vec<u8>,
}

impl RayCast {
    /// A method that builds its hierarchy in every call.
    pub fn new(options: &Options) -> RayCast {
        RayCast { isa: options.isa, ..RayCast::default() }
    }

    /// Builds the hierarchy of a static scene once; [`Method::shadow`] then keeps it as long as it is given as many
    /// triangles (they must be the same ones: that is the caller's promise), for any light and any samples.
    ///
    /// # Errors
    /// [`InputError`] names a coordinate that is not finite.
    pub fn keep(&mut self, triangles: &[Triangle]) -> Result<(), InputError> {
        crate::scene::check_triangles(triangles)?;
        check_count(triangles)?;
        self.bvh.build(triangles);
        self.triangles = triangles.to_vec();
        self.kept = true;
        Ok(())
    }

    /// Forgets the kept hierarchy.
    pub fn release(&mut self) {
        self.kept = false;
        self.triangles = Vec::new();
    }
}

fn check_count(triangles: &[Triangle]) -> Result<(), InputError> {
    let limit = build::MAX_TRIANGLES;
    if triangles.len() > limit {
        return Err(InputError::TooMany { what: "triangles", got: triangles.len(), limit });
    }
    Ok(())
}

impl Method for RayCast {
    fn name(&self) -> &'static str {
        "ray-cast"
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let isa = self.isa.resolved();
        let mut stats = StatsBuilder::start("ray-cast", isa.name());
        check_input(triangles, samples, light, mask)?;
        check_count(triangles)?;
        stats.stage("check_input");
        let counts = self.run(triangles, samples, light, mask, &mut stats, None);
        stats.stage("trace");
        let (nodes, leaves) = self.bvh.bytes();
        stats.bytes("nodes", nodes);
        stats.bytes("leaves", leaves);
        stats.bytes("build_keys", self.bvh.scratch_bytes());
        stats.bytes(
            "sorted_list",
            self.order.len() * 8 + size_of_val(&self.sorted[..]) + self.sorted_mask.len(),
        );
        counts.report(&mut stats);
        Ok(stats.finish(triangles.len(), mask))
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
        if !check_view(debug::VIEWS, view, triangles, samples, light)? {
            return Ok(None);
        }
        check_count(triangles)?;
        let n = samples.positions.len();
        let mut record = debug::Record::new(n);
        let mut stats = StatsBuilder::start("ray-cast", self.isa.resolved().name());
        self.run(triangles, samples, light, &mut vec![NONE; n], &mut stats, Some(&mut record));
        Ok(Some(complete(record.numbers(view), samples.positions)))
    }
}

impl RayCast {
    /// Builds and traces. `record` is filled if it is there.
    fn run(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
        stats: &mut StatsBuilder,
        record: Option<&mut debug::Record>,
    ) -> trace::Counts {
        let isa = self.isa.resolved();
        if !self.kept {
            self.bvh.build(triangles);
        }
        stats.stage("build_hierarchy");
        let is_list = samples.width >= samples.positions.len();
        if !is_list || samples.positions.len() <= crate::bvh::packet::PACKET {
            return trace::trace(isa, &self.bvh, triangles, samples, light, mask, record.as_deref());
        }
        self.sort_list(samples.positions);
        stats.stage("sort_samples");
        self.sorted_mask.resize(self.sorted.len(), NONE);
        let sorted = Samples::list(&self.sorted);
        let mask_of_sorted = &mut self.sorted_mask;
        let counts =
            trace::trace(isa, &self.bvh, triangles, sorted, light, mask_of_sorted, record.as_deref());
        let place = |key: &u64| (key & 0xffff_ffff) as usize;
        mask.fill(NONE);
        for (key, m) in self.order.iter().zip(&self.sorted_mask) {
            mask[place(key)] = *m;
        }
        if let Some(record) = record {
            record.unsort(self.order.iter().map(place));
        }
        counts
    }

    /// Puts the samples of a bare list into Morton order, background left out, so that neighbours are close.
    fn sort_list(&mut self, positions: &[[f32; 3]]) {
        let valid = |p: &[f32; 3]| !p.iter().any(|v| v.is_nan());
        let bounds = positions
            .par_iter()
            .filter(|p| valid(p))
            .fold(
                || Bounds::EMPTY,
                |mut b, p| {
                    b.add(*p);
                    b
                },
            )
            .reduce(|| Bounds::EMPTY, Bounds::union);
        let scale = [0, 1, 2].map(|k| {
            let s = 1024.0 / (bounds.hi[k] - bounds.lo[k]);
            if s.is_finite() { s } else { 0.0 }
        });
        let key = |(i, p): (usize, &[f32; 3])| {
            let code = morton([0, 1, 2].map(|k| (p[k] - bounds.lo[k]) * scale[k]));
            u64::from(code) << 32 | i as u64
        };
        self.order.clear();
        self.order.par_extend(positions.par_iter().enumerate().filter(|(_, p)| valid(p)).map(key));
        self.order.par_sort_unstable();
        self.sorted.clear();
        self.sorted.par_extend(self.order.par_iter().map(|key| positions[(key & 0xffff_ffff) as usize]));
    }
}
