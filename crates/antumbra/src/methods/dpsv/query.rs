//! The query of all samples: packets of 4 x 2 neighbours walk down together.
//!
//! At each triangle the packet's samples part into those inside and outside each plane; children wait on a stack with the
//! samples that want them. Each sample visits each triangle at most once. The small stack of the hybrid query, when full,
//! hands the subtree to the stackless query, sample by sample.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8};
use rayon::prelude::*;

use super::Query;
use super::build::Tree;
use super::node::{CAP, NONE, ROUNDING, Sample, TINY};
use super::stackless;
use super::tuning::{PACKET_HEIGHT, PACKET_WIDTH};
use crate::Isa;
use crate::mask::{self, LIT, SHADOWED};
use crate::methods::StatsBuilder;
use crate::scene::Triangle;

/// Work of one call.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Triangles visited, by packets or (stackless) by samples; returns of the stackless walk count again.
    pub(super) nodes: u64,
    /// Triangles visited, summed over samples.
    pub(super) sample_visits: u64,
    /// Samples (stackless) or packets that skipped a subtree by its distance.
    pub(super) depth_skips: u64,
    /// As before, crossing subtrees by their wedge.
    pub(super) wedge_skips: u64,
    /// Signs that f32 was sure of.
    pub(super) sure: u64,
    /// Signs taken to exact arithmetic.
    pub(super) exact: u64,
    hits: u64,
    queue_peak: u64,
    flushes: u64,
}

impl Counts {
    fn add(mut self, other: Counts) -> Counts {
        self.nodes += other.nodes;
        self.sample_visits += other.sample_visits;
        self.depth_skips += other.depth_skips;
        self.wedge_skips += other.wedge_skips;
        self.sure += other.sure;
        self.exact += other.exact;
        self.hits += other.hits;
        self.queue_peak = self.queue_peak.max(other.queue_peak);
        self.flushes += other.flushes;
        self
    }

    pub(super) fn report(&self, stats: &mut StatsBuilder) {
        stats.counter("node_visits", self.nodes);
        stats.counter("sample_visits", self.sample_visits);
        stats.counter("depth_skips", self.depth_skips);
        stats.counter("wedge_skips", self.wedge_skips);
        stats.counter("leaf_hits", self.hits);
        stats.counter("filter_f32_sure", self.sure);
        stats.counter("filter_exact", self.exact);
        stats.counter("queue_peak", self.queue_peak);
        stats.counter("queue_flushes", self.flushes);
    }
}

/// Answers all samples that are not background (their mask is [`mask::NONE`] already).
pub(super) fn query(
    isa: Isa,
    kind: Query,
    tree: &Tree,
    triangles: &[Triangle],
    positions: &[[f32; 3]],
    width: usize,
    light: [f32; 3],
    mask: &mut [u8],
) -> Counts {
    let level = isa.level().unwrap_or_else(fearless_simd::Level::new);
    // A list is cut into runs of eight; a picture into bands of two rows.
    let is_list = width < PACKET_WIDTH || width >= mask.len();
    let band = if is_list { 512 } else { width * PACKET_HEIGHT };
    let width = if is_list { 0 } else { width };
    mask.par_chunks_mut(band)
        .zip(positions.par_chunks(band))
        .map_init(Vec::new, |stack, (mask, positions)| {
            dispatch!(level, s => query_band(s, kind, tree, triangles, positions, width, light, mask, stack))
        })
        .reduce(Counts::default, Counts::add)
}

/// Answers a band of rows (`width` samples a row) or a run of a list (`width` 0).
#[inline(always)]
fn query_band<S: Simd>(
    s: S,
    kind: Query,
    tree: &Tree,
    triangles: &[Triangle],
    positions: &[[f32; 3]],
    width: usize,
    light: [f32; 3],
    mask: &mut [u8],
    stack: &mut Vec<(u32, u8)>,
) -> Counts {
    let mut counts = Counts::default();
    let Some(root) = tree.root() else {
        positions.iter().zip(mask).for_each(|(p, m)| *m = empty(p));
        return counts;
    };
    let size = PACKET_WIDTH * PACKET_HEIGHT;
    let packets = if width == 0 { positions.len().div_ceil(size) } else { width.div_ceil(PACKET_WIDTH) };
    for index in 0..packets {
        let mut packet = Packet::default();
        let mut take = |i: usize| {
            mask[i] = empty(&positions[i]);
            if mask[i] != mask::NONE {
                packet.push(Sample::new(positions[i], light), i);
            }
        };
        if let Some(rows) = positions.len().checked_div(width) {
            for row in 0..rows {
                (index * PACKET_WIDTH..width.min((index + 1) * PACKET_WIDTH))
                    .for_each(|column| take(row * width + column));
            }
        } else {
            (index * size..positions.len().min((index + 1) * size)).for_each(&mut take);
        }
        if packet.count == 0 {
            continue;
        }
        let shadowed = match kind {
            Query::Stackless => (0..packet.count).fold(0, |bits, i| {
                let hit = stackless::shadowed(tree, root, &packet.sample[i], triangles, light, &mut counts);
                bits | u8::from(hit) << i
            }),
            Query::Stack | Query::Hybrid { .. } => {
                let limit = if let Query::Hybrid { stack } = kind { stack } else { usize::MAX };
                let walk = Walk { tree, triangles, light, limit };
                s.vectorize(
                    #[inline(always)]
                    || walk.packet(s, root, &packet, stack, &mut counts),
                )
            }
        };
        counts.hits += u64::from(shadowed.count_ones());
        for i in 0..packet.count {
            if shadowed >> i & 1 == 1 {
                mask[packet.id[i]] = SHADOWED;
            }
        }
    }
    counts
}

/// The answer where nothing blocks.
fn empty(p: &[f32; 3]) -> u8 {
    if p.iter().any(|v| v.is_nan()) { mask::NONE } else { LIT }
}

/// Up to eight samples, one lane each.
struct Packet {
    sample: [Sample; 8],
    id: [usize; 8],
    count: usize,
}

impl Default for Packet {
    fn default() -> Packet {
        Packet { sample: [Sample::new([0.0; 3], [0.0; 3]); 8], id: [0; 8], count: 0 }
    }
}

impl Packet {
    #[inline(always)]
    fn push(&mut self, sample: Sample, id: usize) {
        self.sample[self.count] = sample;
        self.id[self.count] = id;
        self.count += 1;
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, s: S, get: impl Fn(&Sample) -> f32) -> f32x8<S> {
        let mut lanes = [0.0; 8];
        for i in 0..8 {
            lanes[i] = get(&self.sample[i]);
        }
        f32x8::load_array(s, lanes)
    }
}

/// The walk of packets.
struct Walk<'a> {
    tree: &'a Tree,
    triangles: &'a [Triangle],
    light: [f32; 3],
    /// Entries of the stack.
    limit: usize,
}

impl Walk<'_> {
    /// One bit a sample: blocked. The same arithmetic as [`stackless::shadowed`], lane by lane (fused or not: the
    /// bounds cover both).
    #[inline(always)]
    fn packet<S: Simd>(
        &self,
        s: S,
        root: u32,
        packet: &Packet,
        stack: &mut Vec<(u32, u8)>,
        counts: &mut Counts,
    ) -> u8 {
        let q = [0, 1, 2].map(|k| packet.lanes(s, |sample| sample.q[k]));
        let sum = packet.lanes(s, |sample| sample.sum);
        let length = packet.lanes(s, |sample| sample.length);
        let slack = sum * ROUNDING + TINY;
        let all = (0xffu32 >> (8 - packet.count)) as u8;
        let mut alive = all;
        stack.clear();
        stack.push((root, all));
        while let Some((at, lanes)) = stack.pop() {
            let mut here = lanes & alive;
            if here == 0 {
                continue;
            }
            let node = &self.tree.nodes[at as usize];
            counts.nodes += 1;
            counts.sample_visits += u64::from(here.count_ones());
            here &= !(length.simd_lt(node.nearest()).to_bitmask() as u8);
            if here == 0 {
                counts.depth_skips += 1;
                continue;
            }
            for k in 0..4 {
                let m = node.normal(k);
                let offset = f32x8::splat(s, node.offset(k));
                let value = q[2].mul_add(m[2], q[1].mul_add(m[1], q[0].mul_add(m[0], offset)));
                let (relative, absolute) = node.error(k);
                let error = sum.mul_add(relative, f32x8::splat(s, absolute));
                let mut inside = value.simd_gt(error).to_bitmask() as u8 & here;
                let outside = value.simd_lt(-error).to_bitmask() as u8;
                let mut open = here & !(inside | outside);
                counts.sure += u64::from((here & !open).count_ones());
                counts.exact += u64::from(open.count_ones());
                while open != 0 {
                    let lane = open.trailing_zeros() as usize;
                    open &= open - 1;
                    let p = packet.sample[lane].p;
                    inside |= u8::from(node.exactly_inside(k, self.triangles, self.light, p)) << lane;
                }
                if k == CAP {
                    alive &= !inside;
                    here &= !inside;
                    if alive == 0 {
                        return all;
                    }
                }
                let crossing = node.crossing(k);
                if crossing != NONE && here != 0 {
                    let may = if k == CAP {
                        here
                    } else {
                        let reach = length.mul_add(node.wedge(k), slack);
                        here & !(value.abs().simd_gt(reach).to_bitmask() as u8)
                    };
                    if may != 0 {
                        self.push(stack, crossing, may, packet, &mut alive, counts);
                    } else {
                        counts.wedge_skips += 1;
                    }
                }
                let out = here & !inside;
                let child = node.outside(k);
                if out != 0 && child != NONE {
                    self.push(stack, child, out, packet, &mut alive, counts);
                }
                here &= inside;
                if here == 0 {
                    break;
                }
            }
            counts.queue_peak = counts.queue_peak.max(stack.len() as u64);
        }
        all & !alive
    }

    /// Puts a subtree on the stack, or walks it without one if the stack is full.
    #[inline(always)]
    fn push(
        &self,
        stack: &mut Vec<(u32, u8)>,
        node: u32,
        lanes: u8,
        packet: &Packet,
        alive: &mut u8,
        counts: &mut Counts,
    ) {
        if stack.len() < self.limit {
            stack.push((node, lanes));
        } else {
            self.flush(node, lanes & *alive, packet, alive, counts);
        }
    }

    #[inline(never)]
    fn flush(&self, node: u32, mut lanes: u8, packet: &Packet, alive: &mut u8, counts: &mut Counts) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            counts.flushes += 1;
            let sample = &packet.sample[lane];
            if stackless::shadowed(self.tree, node, sample, self.triangles, self.light, counts) {
                *alive &= !(1 << lane);
            }
        }
    }
}
