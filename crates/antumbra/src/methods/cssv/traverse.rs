//! Faces walk down the tree of samples: those crossed by no sample of a node are dropped, those crossed by all are added
//! to its counter, the rest goes on to its children and in the end to single samples.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;

use super::face::{Face, Faces, Verdict};
use super::leaf::{Leaf, Offsets};
use super::tiles::{Packet, Region, Tree};
use super::tuning::{CHILDREN, PACKET, TASK_LEVEL};
use crate::methods::StatsBuilder;

/// Work of one frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    node_visits: u64,
    node_reject: u64,
    node_accept: u64,
    node_refine: u64,
    /// Samples of the nodes that a face was accepted for, summed over all of them.
    pub(super) accepted_samples: u64,
    pub(super) leaf_tests: u64,
    pub(super) leaf_hits: u64,
    pub(super) filter_f64: u64,
    pub(super) filter_exact: u64,
    list_len_max: u64,
}

impl Counts {
    fn add(mut self, other: Counts) -> Counts {
        self.node_visits += other.node_visits;
        self.node_reject += other.node_reject;
        self.node_accept += other.node_accept;
        self.node_refine += other.node_refine;
        self.accepted_samples += other.accepted_samples;
        self.leaf_tests += other.leaf_tests;
        self.leaf_hits += other.leaf_hits;
        self.filter_f64 += other.filter_f64;
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
        stats.counter("additions", self.node_accept + self.leaf_hits);
        stats.counter("stencil_updates", self.accepted_samples + self.leaf_hits);
        stats.counter("filter_f32_sure", self.leaf_tests - self.filter_f64);
        stats.counter("filter_f64", self.filter_f64);
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

/// What came of making the faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Made {
    /// Faces that were made and tested against the root of the tree.
    pub(super) faces: u64,
    /// Of those: crossed by all samples.
    pub(super) accepted: u64,
    /// Volumes around the reference point.
    pub(super) eye_volumes: u64,
    /// Where counting starts: volumes around the reference point, and faces accepted.
    pub(super) start: i64,
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
    /// Counts for all samples. The faces have met the root already.
    pub(super) fn run(&self, made: &Made) -> Counts {
        let mut list = self.lists.take();
        list.extend(0..self.faces.len() as u32);
        let top = self.tree.top();
        let mut counts = self.visit(top, 0, &list, made.start);
        self.lists.give(list);
        if let Some(root) = self.tree.bounds(top, 0).region() {
            counts.node_visits += made.faces;
            counts.node_accept += made.accepted;
            counts.node_refine += self.faces.len() as u64;
            counts.node_reject += made.faces - made.accepted - self.faces.len() as u64;
            counts.accepted_samples += made.accepted * root.samples;
        }
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
        let first = node * CHILDREN;
        let there = self.tree.count(level - 1).min(first + CHILDREN) - first;
        let mut kept: [Vec<u32>; CHILDREN] = std::array::from_fn(|_| self.lists.take());
        let mut sums = [count; CHILDREN];
        let mut regions = [None; CHILDREN];
        for c in 0..there {
            let bounds = self.tree.bounds(level - 1, first + c);
            regions[c] = bounds.region();
            if regions[c].is_none() && !bounds.is_empty() {
                // Nothing is known of its samples: all faces stay.
                kept[c].extend_from_slice(list);
            }
        }
        dispatch!(self.level, s => self.filter(s, &regions, list, &mut kept, &mut sums, &mut counts));
        let child = |c: usize| self.visit(level - 1, first + c, &kept[c], sums[c]);
        counts = if level > TASK_LEVEL {
            counts.add((0..there).into_par_iter().map(child).reduce(Counts::default, Counts::add))
        } else {
            (0..there).map(child).fold(counts, Counts::add)
        };
        for list in kept {
            self.lists.give(list);
        }
        counts
    }

    /// Keeps, for each child, the faces of which its samples need to know more, and adds up those that all of them cross.
    /// All children at once: faces are scattered over more memory than caches hold, so each is fetched once.
    #[inline(always)]
    fn filter<S: Simd>(
        &self,
        s: S,
        regions: &[Option<Region>; CHILDREN],
        list: &[u32],
        kept: &mut [Vec<u32>; CHILDREN],
        sums: &mut [i64; CHILDREN],
        counts: &mut Counts,
    ) {
        let mut accepted = [0u64; CHILDREN];
        s.vectorize(
            #[inline(always)]
            || {
                for &i in list {
                    let face = &self.faces[i as usize];
                    for c in 0..CHILDREN {
                        let Some(region) = &regions[c] else { continue };
                        match face.against(s, self.decide.pass, region) {
                            Verdict::Reject => {}
                            Verdict::Refine => kept[c].push(i),
                            Verdict::Accept => {
                                sums[c] += i64::from(face.weight);
                                accepted[c] += 1;
                            }
                        }
                    }
                }
            },
        );
        for c in 0..CHILDREN {
            let Some(region) = &regions[c] else { continue };
            let (all, open) = (list.len() as u64, kept[c].len() as u64);
            counts.node_visits += all;
            counts.node_accept += accepted[c];
            counts.accepted_samples += accepted[c] * region.samples;
            counts.node_refine += open;
            counts.node_reject += all - open - accepted[c];
        }
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

    /// Face by face and sample by sample.
    #[inline(always)]
    fn packet<S: Simd>(&self, s: S, index: usize, list: &[u32], start: i64, counts: &mut Counts) {
        let mut packet = Packet::EMPTY;
        self.tree.load(self.positions, &self.decide.reference, index, &mut packet);
        let region = self.tree.bounds(0, index).region();
        let offsets = region.map(|region| (Offsets::new(&packet, &region), region));
        let mut leaf = Leaf {
            decide: &self.decide,
            positions: self.positions,
            packet: &packet,
            offsets: offsets.as_ref().map(|(offsets, region)| (offsets, region)),
            // At most five faces a triangle, 2^28 triangles: no sum leaves i32.
            count: [start as i32; PACKET],
        };
        s.vectorize(
            #[inline(always)]
            || {
                for &i in list {
                    leaf.add(s, &self.faces[i as usize], counts);
                }
            },
        );
        let count = leaf.count;
        let mut word = 0u64;
        for at in 0..packet.count {
            debug_assert!(count[at] >= 0, "{} volumes contain sample {}", count[at], packet.id[at]);
            word |= u64::from(count[at] != 0) << packet.slot[at];
            if let Some(trace) = self.trace {
                trace.volumes[index * PACKET + packet.slot[at] as usize].store(count[at] as u32, Relaxed);
            }
        }
        self.shadowed[index].store(word, Relaxed);
        if let Some(trace) = self.trace {
            trace.list_len[index].store(list.len() as u32, Relaxed);
        }
    }
}
