//! The walk of all samples: tiles of 8 x 8 pixels become packets, packets are walked, leaves are tested.

use antumbra_predicates::{Coefficients, Resolver, SampleGroup, exact, resolve::Decided};
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

use super::debug::Record;
use crate::Isa;
use crate::bvh::packet::{Cone, Packet, Stack, VECTORS, Visitor, WalkCounts, part, walk};
use crate::bvh::{Bvh, Leaf, WIDTH};
use crate::mask::{LIT, NONE, SHADOWED};
use crate::methods::{Samples, StatsBuilder};
use crate::scene::Triangle;

/// Pixels of a tile's side.
const TILE: usize = 8;

/// Work of one call.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    walk: WalkCounts,
    packets: u64,
    setups: u64,
    refinements: u64,
    leaf_tests: u64,
    filter_f32_sure: u64,
    filter_f64: u64,
    filter_exact: u64,
}

impl Counts {
    fn add(mut self, other: Counts) -> Counts {
        self.walk.nodes += other.walk.nodes;
        self.walk.leaves += other.walk.leaves;
        self.packets += other.packets;
        self.setups += other.setups;
        self.refinements += other.refinements;
        self.leaf_tests += other.leaf_tests;
        self.filter_f32_sure += other.filter_f32_sure;
        self.filter_f64 += other.filter_f64;
        self.filter_exact += other.filter_exact;
        self
    }

    pub(super) fn report(&self, stats: &mut StatsBuilder) {
        stats.counter("packets", self.packets);
        stats.counter("node_visits", self.walk.nodes);
        stats.counter("leaf_visits", self.walk.leaves);
        stats.counter("triangle_setups", self.setups);
        stats.counter("refinements", self.refinements);
        stats.counter("leaf_tests", self.leaf_tests);
        stats.counter("filter_f32_sure", self.filter_f32_sure);
        stats.counter("filter_f64", self.filter_f64);
        stats.counter("filter_exact", self.filter_exact);
    }
}

/// Answers all samples.
pub(super) fn trace(
    isa: Isa,
    bvh: &Bvh,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
    mask: &mut [u8],
    record: Option<&Record>,
) -> Counts {
    let level = isa.level().unwrap_or_else(fearless_simd::Level::new);
    let width = samples.width.max(1);
    let is_list = width >= mask.len();
    // A list is walked in runs of 64, an image in rows of tiles.
    let band = if is_list { 64 * TILE } else { width * TILE };
    mask.par_chunks_mut(band)
        .zip(samples.positions.par_chunks(band))
        .enumerate()
        .map(|(i, (mask, positions))| {
            let record = record.map(|r| (r, i * band));
            dispatch!(level, s => trace_band(s, bvh, triangles, positions, if is_list { 0 } else { width }, light, mask, record))
        })
        .reduce(Counts::default, Counts::add)
}

/// Answers a row of tiles (`width` samples a row) or a run of a list (`width` 0). `record` comes with the number of the
/// first sample.
#[inline(always)]
fn trace_band<S: Simd>(
    s: S,
    bvh: &Bvh,
    triangles: &[Triangle],
    positions: &[[f32; 3]],
    width: usize,
    light: [f32; 3],
    mask: &mut [u8],
    record: Option<(&Record, usize)>,
) -> Counts {
    let mut counts = Counts::default();
    let mut stack = Stack::default();
    let mut packet = Packet::EMPTY;
    let tiles = if width == 0 { positions.len().div_ceil(TILE * TILE) } else { width.div_ceil(TILE) };
    for tile in 0..tiles {
        packet.count = 0;
        let mut take = |i: usize| {
            let p = positions[i];
            if p[0].is_nan() || p[1].is_nan() || p[2].is_nan() {
                mask[i] = NONE;
            } else {
                packet.push(p, i as u32);
            }
        };
        let rows = positions.len().checked_div(width);
        if let Some(rows) = rows {
            // Blocks of 4 x 2 pixels become vectors.
            for i in 0..TILE * TILE {
                let (block, within) = (i / 8, i % 8);
                let row = block / 2 * 2 + within / 4;
                let column = tile * TILE + block % 2 * 4 + within % 4;
                if row < rows && column < width {
                    take(row * width + column);
                }
            }
        } else {
            (tile * TILE * TILE..positions.len().min((tile + 1) * TILE * TILE)).for_each(&mut take);
        }
        part(&mut packet, light, &mut |packet, bounds| {
            let cone = Cone::new(light, bounds, &bvh.bounds);
            let set_up = counts.setups;
            let mut any_hit = AnyHit::new(packet, cone, light, triangles, &mut counts);
            let mut walked = WalkCounts::default();
            s.vectorize(
                #[inline(always)]
                || walk::<S, _, false>(s, bvh, &cone, &mut stack, &mut walked, &mut any_hit),
            );
            let blocked = any_hit.finish();
            counts.walk.nodes += walked.nodes;
            counts.walk.leaves += walked.leaves;
            counts.packets += 1;
            if let Some((record, first)) = record {
                let (visits, triangles) = (walked.nodes + walked.leaves, counts.setups - set_up);
                for id in &packet.id[..packet.count] {
                    record.note(first + *id as usize, visits, triangles, packet.count);
                }
            }
            for i in 0..packet.count {
                mask[packet.id[i] as usize] = if blocked >> i & 1 == 1 { SHADOWED } else { LIT };
            }
        });
    }
    counts
}

/// Pairs that f32 left open: a triangle and eight lanes of the packet.
#[derive(Clone, Copy, Debug)]
struct Open {
    triangle: u32,
    vector: u8,
    lanes: u8,
}

/// Open pairs that wait until the end of the walk, when most of their samples are blocked anyway.
const OPEN: usize = 256;

/// Finds for each point of a packet whether any triangle blocks it.
struct AnyHit<'a> {
    packet: &'a Packet,
    cone: Cone,
    light: [f32; 3],
    triangles: &'a [Triangle],
    counts: &'a mut Counts,
    coefficients: Coefficients,
    /// Points that are not blocked yet.
    alive: u64,
    /// The boxes of the packet's vectors.
    parts: [SampleGroup; VECTORS],
    open: [Open; OPEN],
    open_count: usize,
}

impl<'a> AnyHit<'a> {
    #[inline(always)]
    fn new(
        packet: &'a Packet,
        cone: Cone,
        light: [f32; 3],
        triangles: &'a [Triangle],
        counts: &'a mut Counts,
    ) -> Self {
        let open = [Open { triangle: 0, vector: 0, lanes: 0 }; OPEN];
        let mut parts = [cone.group; VECTORS];
        for (vector, part) in parts.iter_mut().enumerate().take(packet.vectors()) {
            *part = packet.vector_group(vector);
        }
        AnyHit {
            parts,
            packet,
            cone,
            light,
            triangles,
            counts,
            coefficients: Coefficients::ZERO,
            alive: packet.all(),
            open,
            open_count: 0,
        }
    }

    /// Settles the open pairs in f64 and exact arithmetic.
    fn resolve(&mut self) {
        let mut i = 0;
        while i < self.open_count {
            let triangle = self.open[i].triangle;
            let resolver = Resolver::new(&self.triangles[triangle as usize], self.light);
            while i < self.open_count && self.open[i].triangle == triangle {
                let Open { vector, lanes, .. } = self.open[i];
                i += 1;
                let Some(resolver) = &resolver else { continue };
                let base = vector as usize * WIDTH;
                let mut left = lanes & (self.alive >> base) as u8;
                while left != 0 {
                    let lane = base + left.trailing_zeros() as usize;
                    left &= left - 1;
                    let (blocks, decided) = resolver.blocks(self.packet.point(lane));
                    self.counts.filter_f64 += 1;
                    self.counts.filter_exact += u64::from(decided == Decided::Exact);
                    if blocks {
                        self.alive &= !(1 << lane);
                    }
                }
            }
        }
        self.open_count = 0;
    }

    /// One bit a point: blocked.
    fn finish(mut self) -> u64 {
        self.resolve();
        self.packet.all() & !self.alive
    }
}

impl Visitor for AnyHit<'_> {
    #[inline(always)]
    fn limit(&self) -> f32 {
        1.0
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, s: S, leaf: &Leaf) -> bool {
        let live = leaf.live();
        let verdict = leaf.block.against(s, live, self.light, &self.cone.group, &mut self.coefficients);
        self.counts.setups += u64::from(live.count_ones());
        if verdict.covers != 0 {
            self.alive = 0;
            return true;
        }
        let mut maybe = verdict.maybe;
        let mut edge_on = verdict.edge_on;
        while edge_on != 0 {
            let lane = edge_on.trailing_zeros() as usize;
            edge_on &= edge_on - 1;
            match exact::facing(&self.triangles[leaf.id[lane] as usize], self.light) {
                0 => maybe &= !(1 << lane),
                1 => {}
                _ => self.coefficients.flip(lane),
            }
        }
        if maybe == 0 {
            return false;
        }
        for vector in 0..self.packet.vectors().min(VECTORS) {
            let base = vector * WIDTH;
            let mut alive = (self.alive >> base) as u8;
            if alive == 0 {
                continue;
            }
            let (near, covers) = self.coefficients.refine(s, &self.parts[vector]);
            self.counts.refinements += 1;
            let mut left = near & maybe;
            if covers & left != 0 {
                self.alive &= !(0xff << base);
                continue;
            }
            if left == 0 {
                continue;
            }
            let points = self.packet.load(s, vector);
            while left != 0 && alive != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let lanes = self.coefficients.test(s, lane, points);
                self.counts.leaf_tests += 1;
                let unsure = lanes.unsure & alive;
                self.counts.filter_f32_sure += u64::from((alive & !unsure).count_ones());
                alive &= !lanes.blocked;
                if unsure != 0 {
                    if self.open_count == OPEN {
                        self.resolve();
                    }
                    self.open[self.open_count] =
                        Open { triangle: leaf.id[lane], vector: vector as u8, lanes: unsure };
                    self.open_count += 1;
                }
            }
            self.alive &= !(0xff << base) | u64::from(alive) << base;
        }
        self.alive == 0
    }
}
