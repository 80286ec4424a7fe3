//! Streaming triangles through the tree: hybrid breadth-first and depth-first, in queues of fixed size (section 4.2 of the
//! paper).
//!
//! A task takes a block of triangles and tests all of them against the top level; pairs (triangle, node) that may meet
//! go into the queue of that level. A queue is worked off in order, each pair putting its children into the queue below.
//! When that one has no room for four more, it is drained first, all the way down; then the work goes on above.
//! Breadth-first as long as there is room, and never more memory than the queues have, for any scene.
//!
//! Without early accept each pair (triangle, ray) is seen exactly once, so the same walk can count or multiply blockers.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

use super::build::Hierarchy;
use super::debug::Record;
use super::leaf_tests::{Leaf, Mistakes};
use super::node_test::{precise, sphere};
use super::options::{ConeTest, RayHierarchyOptions};
use super::triangle::Caster;
use super::tuning;
use crate::methods::StatsBuilder;
use crate::methods::leaf::LeafCounts;
use crate::scene::Triangle;

/// Levels that a tree over `u32` leaves can have, rays and root included.
const LEVELS: usize = 17;

/// Names of the counters of visits by level.
const VISITS: [&str; LEVELS] = [
    "node_visits[0]",
    "node_visits[1]",
    "node_visits[2]",
    "node_visits[3]",
    "node_visits[4]",
    "node_visits[5]",
    "node_visits[6]",
    "node_visits[7]",
    "node_visits[8]",
    "node_visits[9]",
    "node_visits[10]",
    "node_visits[11]",
    "node_visits[12]",
    "node_visits[13]",
    "node_visits[14]",
    "node_visits[15]",
    "node_visits[16]",
];

/// A triangle of the block, and the group of siblings that it has yet to be tested against: the children of a node that it
/// may meet.
#[derive(Clone, Copy, Debug)]
struct Pair {
    slot: u32,
    group: u32,
}

/// Memory of one thread, kept between frames.
#[derive(Debug, Default)]
pub(super) struct Queues {
    levels: Vec<Vec<Pair>>,
}

impl Queues {
    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().map(|q| q.capacity() * size_of::<Pair>()).sum()
    }
}

/// Work of one traversal.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    setup_tris: u64,
    culled_tris: u64,
    visits: [u64; LEVELS],
    reject: u64,
    accept: u64,
    refine: u64,
    dead: u64,
    shadowed: u64,
    queue_peak: u64,
    queue_flushes: u64,
    leaf: LeafCounts,
    mistakes: Mistakes,
}

impl Counts {
    pub(super) fn add(mut self, other: Counts) -> Counts {
        self.setup_tris += other.setup_tris;
        self.culled_tris += other.culled_tris;
        for k in 0..LEVELS {
            self.visits[k] += other.visits[k];
        }
        self.reject += other.reject;
        self.accept += other.accept;
        self.refine += other.refine;
        self.dead += other.dead;
        self.shadowed += other.shadowed;
        self.queue_peak = self.queue_peak.max(other.queue_peak);
        self.queue_flushes += other.queue_flushes;
        self.leaf.add(&other.leaf);
        self.mistakes.false_hits += other.mistakes.false_hits;
        self.mistakes.false_misses += other.mistakes.false_misses;
        self
    }

    pub(super) fn report(&self, options: &RayHierarchyOptions, top: usize, stats: &mut StatsBuilder) {
        stats.counter("setup_tris", self.setup_tris);
        stats.counter("culled_tris", self.culled_tris);
        stats.counter("node_visits", self.visits.iter().sum());
        if options.count {
            for k in 1..=top {
                stats.counter(VISITS[k], self.visits[k]);
            }
        }
        stats.counter("node_reject", self.reject);
        stats.counter("node_accept", self.accept);
        stats.counter("node_refine", self.refine);
        stats.counter("dead_terminations", self.dead);
        self.leaf.report(stats);
        stats.counter("early_out_shadowed", self.shadowed);
        stats.counter("queue_peak", self.queue_peak);
        stats.counter("queue_flushes", self.queue_flushes);
        if options.compares_leaves() {
            stats.counter("leaf_false_hits", self.mistakes.false_hits);
            stats.counter("leaf_false_misses", self.mistakes.false_misses);
        }
    }
}

/// What all tasks share.
pub(super) struct Frame<'a> {
    pub(super) options: &'a RayHierarchyOptions,
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) triangles: &'a [Triangle],
    pub(super) light: [f32; 3],
    /// For debug views.
    pub(super) record: Option<&'a Record>,
}

/// Streams triangles (all, or those of `list`) through the tree, and leaves the answer in the tree's bits.
pub(super) fn traverse(frame: &Frame<'_>, list: Option<&[u32]>, queues: &mut Vec<Queues>) -> Counts {
    let level = frame.options.isa.level().unwrap_or_else(fearless_simd::Level::new);
    queues.resize_with(rayon::current_num_threads(), Queues::default);
    let next = AtomicUsize::new(0);
    queues
        .par_iter_mut()
        .with_max_len(1)
        .map(|queues| dispatch!(level, s => work(s, frame, list, &next, queues)))
        .reduce(Counts::default, Counts::add)
}

/// Takes blocks until there are none left.
#[inline(always)]
fn work<S: Simd>(
    s: S,
    frame: &Frame<'_>,
    list: Option<&[u32]>,
    next: &AtomicUsize,
    queues: &mut Queues,
) -> Counts {
    let count = list.map_or(frame.triangles.len(), <[u32]>::len);
    let block = (count / tuning::MIN_TASKS).clamp(1, frame.options.block.max(1));
    let capacity = frame.options.queue_capacity.max(tuning::MIN_QUEUE);
    let top = frame.hierarchy.top();
    // Levels 2 to `top`, and the root, whose queue holds the block.
    queues.levels.resize_with(top + 2, Vec::new);
    for (level, queue) in queues.levels.iter_mut().enumerate().skip(2) {
        queue.clear();
        queue.reserve_exact(if level > top { block } else { capacity });
    }
    let mut walk = Walk {
        frame,
        early: frame.options.accepts(),
        spheres: frame.options.cone_test == ConeTest::Sphere,
        compare: frame.options.compares_leaves(),
        capacity,
        top,
        queues: &mut queues.levels,
        casters: Vec::with_capacity(block),
        counts: Counts::default(),
    };
    loop {
        let first = next.fetch_add(1, Relaxed) * block;
        if first >= count {
            return walk.counts;
        }
        walk.casters.clear();
        for i in first..count.min(first + block) {
            walk.set_up(list.map_or(i, |l| l[i] as usize));
        }
        s.vectorize(
            #[inline(always)]
            || walk.block(s),
        );
    }
}

/// One block of triangles on its way through the tree.
struct Walk<'a, 'q> {
    frame: &'a Frame<'a>,
    early: bool,
    spheres: bool,
    compare: bool,
    capacity: usize,
    top: usize,
    /// By the level of the node that was met: pairs that wait to be tested against its children.
    queues: &'q mut [Vec<Pair>],
    casters: Vec<(Caster, Leaf<'a>)>,
    counts: Counts,
}

impl Walk<'_, '_> {
    /// Prepares a triangle, unless it blocks nothing.
    fn set_up(&mut self, triangle: usize) {
        let frame = self.frame;
        let t = &frame.triangles[triangle];
        let made = Caster::new(t, frame.light, self.spheres)
            .filter(|c| !frame.options.front_face_culling || c.facing > 0)
            .and_then(|c| Some((c, Leaf::new(t, frame.light, frame.options.leaf)?)));
        match made {
            Some(made) => {
                self.counts.setup_tris += 1;
                self.casters.push(made);
            }
            None => self.counts.culled_tris += 1,
        }
    }

    /// Streams the prepared triangles. The root's children are tested at once.
    #[inline(always)]
    fn block<S: Simd>(&mut self, s: S) {
        let root = &mut self.queues[self.top + 1];
        root.clear();
        root.extend((0..self.casters.len() as u32).map(|slot| Pair { slot, group: 0 }));
        self.drain(s);
    }

    /// No room for the output of one more pair.
    #[inline(always)]
    fn is_full(&self, level: usize) -> bool {
        self.queues[level].len() + 4 > self.capacity
    }

    /// Works off all queues from the root down. On entry only the root's queue holds pairs; on return none does.
    #[inline(always)]
    fn drain<S: Simd>(&mut self, s: S) {
        // Pairs before the cursor are done. All queues below `level` are empty, but for the one that it writes to.
        let mut cursor = [0; LEVELS + 1];
        let mut level = self.top + 1;
        loop {
            if cursor[level] == self.queues[level].len() {
                if level <= self.top {
                    self.counts.queue_peak = self.counts.queue_peak.max(cursor[level] as u64);
                }
                self.queues[level].clear();
                cursor[level] = 0;
                if level > 2 && !self.queues[level - 1].is_empty() {
                    level -= 1;
                } else if level > self.top {
                    return;
                } else {
                    level += 1;
                }
            } else if level > 2 && self.is_full(level - 1) {
                self.counts.queue_flushes += 1;
                level -= 1;
            } else {
                let pair = self.queues[level][cursor[level]];
                cursor[level] += 1;
                self.expand(s, level - 1, pair);
            }
        }
    }

    /// Tests a triangle against four siblings of `level`; queues those that it may meet, or asks their rays.
    #[inline(always)]
    fn expand<S: Simd>(&mut self, s: S, level: usize, pair: Pair) {
        let hierarchy = self.frame.hierarchy;
        let index = pair.group as usize;
        let there = (1u8 << (hierarchy.nodes(level) - 4 * index).min(4)) - 1;
        let dead = if self.early { hierarchy.done.dead(level, index) } else { 0 };
        let alive = there & !dead;
        self.counts.dead += u64::from((there & dead).count_ones());
        if alive == 0 {
            return;
        }
        let group = &hierarchy.level(level)[index];
        let caster = &self.casters[pair.slot as usize].0;
        let verdict =
            if self.spheres { sphere(s, group, caster) } else { precise(s, group, caster, self.early) };
        let (open, covered) = (verdict.open & alive, verdict.covered & alive);
        self.counts.visits[level] += u64::from(alive.count_ones());
        self.counts.refine += u64::from(open.count_ones());
        self.counts.accept += u64::from(covered.count_ones());
        self.counts.reject += u64::from((alive & !open & !covered).count_ones());
        if let Some(record) = self.frame.record {
            record.visit(level, index, alive);
            record.accept(level, index, covered);
        }
        let mut left = covered;
        while left != 0 {
            hierarchy.done.kill(level, 4 * index + left.trailing_zeros() as usize);
            left &= left - 1;
        }
        if level == 1 {
            self.ask_rays(s, pair.slot, index, open);
            return;
        }
        let mut left = open;
        while left != 0 {
            let child = 4 * index + left.trailing_zeros() as usize;
            self.queues[level].push(Pair { slot: pair.slot, group: child as u32 });
            left &= left - 1;
        }
    }

    /// Tests the rays of the open nodes of a group of level 1: 16 rays, two vectors.
    #[inline(always)]
    fn ask_rays<S: Simd>(&mut self, s: S, slot: u32, group: usize, open: u8) {
        let hierarchy = self.frame.hierarchy;
        for half in 0..2 {
            let asked = [0, 0x0f, 0xf0, 0xff][(open >> (2 * half) & 3) as usize];
            if asked == 0 {
                continue;
            }
            let block = 2 * group + half;
            let (word, shift) = (block / 8, block % 8 * 8);
            let Some(valid) = hierarchy.valid.get(word) else { continue };
            let mut asked = asked & (valid >> shift) as u8;
            if self.early {
                let done = asked & (hierarchy.done.rays(word) >> shift) as u8;
                self.counts.shadowed += u64::from(done.count_ones());
                asked &= !done;
            }
            if asked == 0 {
                continue;
            }
            let mistakes = self.compare.then_some(&mut self.counts.mistakes);
            let leaf = &mut self.casters[slot as usize].1;
            let hits = leaf.eight(s, &hierarchy.rays[block], asked, &mut self.counts.leaf, mistakes);
            if hits != 0 {
                hierarchy.done.set(0, word, u64::from(hits) << shift);
            }
        }
    }
}
