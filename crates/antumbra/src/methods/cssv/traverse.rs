//! Faces walk down the tree of samples: those crossed by no sample of a node are dropped, those crossed by all are added
//! to its counter, the rest goes on to its children and in the end to single samples.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use fearless_simd::{Level, Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f64x4};
use rayon::prelude::*;

use super::face::{Face, Faces, MARGIN, Verdict};
use super::tiles::{Packet, Region, Tree};
use super::tuning::{CHILDREN, PACKET, TASK_LEVEL};
use crate::methods::StatsBuilder;

/// Lanes of a vector of samples.
const LANES: usize = 4;

/// Work of one frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    node_visits: u64,
    node_reject: u64,
    node_accept: u64,
    node_refine: u64,
    leaf_tests: u64,
    leaf_hits: u64,
    filter_exact: u64,
    list_len_max: u64,
}

impl Counts {
    fn add(mut self, other: Counts) -> Counts {
        self.node_visits += other.node_visits;
        self.node_reject += other.node_reject;
        self.node_accept += other.node_accept;
        self.node_refine += other.node_refine;
        self.leaf_tests += other.leaf_tests;
        self.leaf_hits += other.leaf_hits;
        self.filter_exact += other.filter_exact;
        self.list_len_max = self.list_len_max.max(other.list_len_max);
        self
    }

    pub(super) fn report(&self, stats: &mut StatsBuilder) {
        stats.counter("node_visits", self.node_visits);
        stats.counter("node_reject", self.node_reject);
        stats.counter("node_accept", self.node_accept);
        stats.counter("node_refine", self.node_refine);
        stats.counter("leaf_tests", self.leaf_tests);
        stats.counter("leaf_hits", self.leaf_hits);
        stats.counter("stencil_updates", self.node_accept + self.leaf_hits);
        stats.counter("filter_f64", self.leaf_tests);
        stats.counter("filter_exact", self.filter_exact);
        stats.counter("list_len_max", self.list_len_max);
    }
}

/// Lists of faces that are not in use: kept, so that a frame allocates nothing once it has seen a like one.
#[derive(Debug, Default)]
pub(super) struct Lists(Mutex<Vec<Vec<u32>>>);

impl Lists {
    fn take(&self) -> Vec<u32> {
        self.0.lock().map_or_else(|_| Vec::new(), |mut lists| lists.pop().unwrap_or_default())
    }

    fn give(&self, mut list: Vec<u32>) {
        list.clear();
        if let Ok(mut lists) = self.0.lock() {
            lists.push(list);
        }
    }

    /// Bytes of all lists; none may be in use.
    pub(super) fn bytes(&self) -> usize {
        self.0.lock().map_or(0, |lists| lists.iter().map(|l| l.capacity() * 4).sum())
    }
}

/// What a walk is about.
pub(super) struct Walk<'a> {
    pub(super) level: Level,
    pub(super) tree: &'a Tree,
    pub(super) positions: &'a [[f32; 3]],
    pub(super) faces: &'a [Face],
    pub(super) decide: Faces<'a>,
    pub(super) lists: &'a Lists,
    /// One word a packet: shadowed.
    pub(super) shadowed: &'a [AtomicU64],
    /// Filled where a picture of the work is wanted.
    pub(super) trace: Option<&'a Trace>,
}

/// What debug views are made of.
#[derive(Debug, Default)]
pub(super) struct Trace {
    /// By packet: faces that had to be tested sample by sample.
    pub(super) list_len: Vec<AtomicU32>,
    /// By packet and slot: volumes that contain the sample.
    pub(super) volumes: Vec<AtomicU32>,
}

impl Trace {
    pub(super) fn new(packets: usize) -> Trace {
        let zeros = |n: usize| std::iter::repeat_with(AtomicU32::default).take(n).collect();
        Trace { list_len: zeros(packets), volumes: zeros(packets * PACKET) }
    }
}

impl Walk<'_> {
    /// Counts for all samples, from `start`.
    pub(super) fn run(&self, start: i64) -> Counts {
        let mut list = self.lists.take();
        list.extend(0..self.faces.len() as u32);
        let counts = self.visit(self.tree.top(), 0, &list, start);
        self.lists.give(list);
        counts
    }

    fn visit(&self, level: usize, node: usize, list: &[u32], count: i64) -> Counts {
        let mut counts = Counts::default();
        if self.tree.bounds(level, node).is_empty() {
            return counts;
        }
        if list.is_empty() {
            self.settle(level, node, count);
            return counts;
        }
        if level == 0 {
            counts.list_len_max = list.len() as u64;
            dispatch!(self.level, s => self.packet(s, node, list, count, &mut counts));
            return counts;
        }
        let children = node * CHILDREN..self.tree.count(level - 1).min((node + 1) * CHILDREN);
        let child = |child: usize, mut kept: Vec<u32>| {
            kept.clear();
            let mut counts = Counts::default();
            let mut count = count;
            match self.tree.bounds(level - 1, child).region() {
                Some(region) => {
                    let level = self.level;
                    count += dispatch!(level, s => self.filter(s, &region, list, &mut kept, &mut counts));
                }
                None if self.tree.bounds(level - 1, child).is_empty() => {}
                None => kept.extend_from_slice(list),
            }
            let counts = counts.add(self.visit(level - 1, child, &kept, count));
            (counts, kept)
        };
        if level > TASK_LEVEL {
            let work = |c| {
                let (counts, kept) = child(c, self.lists.take());
                self.lists.give(kept);
                counts
            };
            return children.into_par_iter().map(work).reduce(Counts::default, Counts::add);
        }
        let mut kept = self.lists.take();
        for c in children {
            let done;
            (done, kept) = child(c, kept);
            counts = counts.add(done);
        }
        self.lists.give(kept);
        counts
    }

    /// Keeps the faces of which a region's samples need to know more, and adds up those that all of them cross.
    #[inline(always)]
    fn filter<S: Simd>(
        &self,
        s: S,
        region: &Region,
        list: &[u32],
        kept: &mut Vec<u32>,
        counts: &mut Counts,
    ) -> i64 {
        s.vectorize(
            #[inline(always)]
            || {
                let mut sum = 0i64;
                let mut accepted = 0;
                for &i in list {
                    let face = &self.faces[i as usize];
                    match face.against(s, self.decide.pass, region) {
                        Verdict::Reject => {}
                        Verdict::Refine => kept.push(i),
                        Verdict::Accept => {
                            sum += i64::from(face.weight);
                            accepted += 1;
                        }
                    }
                }
                counts.node_visits += list.len() as u64;
                counts.node_accept += accepted;
                counts.node_refine += kept.len() as u64;
                counts.node_reject += (list.len() - kept.len()) as u64 - accepted;
                sum
            },
        )
    }

    /// All samples of the node have the same count.
    fn settle(&self, level: usize, node: usize, count: i64) {
        debug_assert!(count >= 0, "{count} volumes contain a sample");
        let per_node = CHILDREN.pow(level as u32);
        let packets = node * per_node..self.tree.packets().min((node + 1) * per_node);
        let word = if count != 0 { u64::MAX } else { 0 };
        for packet in packets {
            self.shadowed[packet].store(word, Relaxed);
            if let Some(trace) = self.trace {
                for slot in 0..PACKET {
                    trace.volumes[packet * PACKET + slot].store(count as u32, Relaxed);
                }
            }
        }
    }

    /// Face by face and sample by sample. Counts are sums of whole numbers below 2^53, so f64 lanes hold them exactly.
    #[inline(always)]
    fn packet<S: Simd>(&self, s: S, index: usize, list: &[u32], start: i64, counts: &mut Counts) {
        let mut packet = Packet::EMPTY;
        self.tree.load(self.positions, &self.decide.reference, index, &mut packet);
        let mut count = [start as f64; PACKET];
        s.vectorize(
            #[inline(always)]
            || {
                for &i in list {
                    self.face(s, &self.faces[i as usize], &packet, &mut count, counts);
                }
            },
        );
        let mut word = 0u64;
        for at in 0..packet.count {
            debug_assert!(count[at] >= 0.0, "{} volumes contain sample {}", count[at], packet.id[at]);
            word |= u64::from(count[at] != 0.0) << packet.slot[at];
            if let Some(trace) = self.trace {
                trace.volumes[index * PACKET + packet.slot[at] as usize].store(count[at] as u32, Relaxed);
            }
        }
        self.shadowed[index].store(word, Relaxed);
        if let Some(trace) = self.trace {
            trace.list_len[index].store(list.len() as u32, Relaxed);
        }
    }

    #[inline(always)]
    fn face<S: Simd>(
        &self,
        s: S,
        face: &Face,
        packet: &Packet,
        count: &mut [f64; PACKET],
        counts: &mut Counts,
    ) {
        let bound = f64x4::splat(s, MARGIN * (face.mag * packet.scale + face.k_mag));
        let k = f64x4::splat(s, face.k);
        let zero = f64x4::splat(s, 0.0);
        let weight = f64x4::splat(s, f64::from(face.weight));
        for base in (0..packet.count).step_by(LANES) {
            let x = f64x4::from_slice(s, &packet.x[base..base + LANES]);
            let y = f64x4::from_slice(s, &packet.y[base..base + LANES]);
            let w = f64x4::from_slice(s, &packet.w[base..base + LANES]);
            let at = |f: usize| w.mul_add(face.n[2][f], y.mul_add(face.n[1][f], x * face.n[0][f]));
            let place = at(3) - k;
            let low =
                at(0).min(at(1)).min(at(2)).min(if self.decide.pass { place } else { at(3).min(-place) });
            let used = ((1u32 << (packet.count - base).min(LANES)) - 1) as u64;
            let crossed = low.simd_gt(bound);
            let at = &mut count[base..base + LANES];
            let sum = f64x4::from_slice(s, at) + crossed.select(weight, zero);
            sum.store_slice(at);
            let crossed = crossed.to_bitmask();
            let mut open = !(crossed | low.simd_lt(-bound).to_bitmask()) & used;
            counts.leaf_tests += u64::from(used.count_ones());
            counts.leaf_hits += u64::from((crossed & used).count_ones());
            while open != 0 {
                let lane = base + open.trailing_zeros() as usize;
                open &= open - 1;
                counts.filter_exact += 1;
                if self.decide.decide(face.source, self.positions[packet.id[lane] as usize]) {
                    counts.leaf_hits += 1;
                    count[lane] += f64::from(face.weight);
                }
            }
        }
    }
}
