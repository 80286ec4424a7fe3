//! All triangles through the tree: reject, accept or refine nodes, test samples at the leaves, share long walks.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

use super::boxes::{LANES, test_extra, test_main};
use super::frustum::Frustum;
use super::space::{Space, V3};
use super::tree::{MAX_LEVELS, Tree};
use super::tuning::{JOBS_PER_TASK, TRIANGLES_PER_TASK, Tuning};
use crate::Isa;
use crate::methods::StatsBuilder;
use crate::methods::leaf::{LeafCounts, LeafTest};
use crate::scene::Triangle;

/// Work of one call.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    setup_tris: u64,
    culled_tris: u64,
    /// Inner nodes whose children were tested.
    group_visits: u64,
    /// Children tested, and what came of it.
    node_visits: u64,
    node_reject: u64,
    extra_reject: u64,
    node_accept: u64,
    node_refine: u64,
    leaf_visits: u64,
    early_out_shadowed: u64,
    atomic_or: u64,
    queue_pushed: u64,
    queue_flushes: u64,
    pub(crate) queue_peak: u64,
    leaf: LeafCounts,
}

impl Counts {
    fn add(mut self, o: Counts) -> Counts {
        self.setup_tris += o.setup_tris;
        self.culled_tris += o.culled_tris;
        self.group_visits += o.group_visits;
        self.node_visits += o.node_visits;
        self.node_reject += o.node_reject;
        self.extra_reject += o.extra_reject;
        self.node_accept += o.node_accept;
        self.node_refine += o.node_refine;
        self.leaf_visits += o.leaf_visits;
        self.early_out_shadowed += o.early_out_shadowed;
        self.atomic_or += o.atomic_or;
        self.queue_pushed += o.queue_pushed;
        self.queue_flushes += o.queue_flushes;
        self.queue_peak = self.queue_peak.max(o.queue_peak);
        self.leaf.add(&o.leaf);
        self
    }

    pub(crate) fn report(&self, stats: &mut StatsBuilder) {
        stats.counter("setup_tris", self.setup_tris);
        stats.counter("culled_tris", self.culled_tris);
        stats.counter("group_visits", self.group_visits);
        stats.counter("node_visits", self.node_visits);
        stats.counter("node_reject", self.node_reject);
        stats.counter("extra_reject", self.extra_reject);
        stats.counter("node_accept", self.node_accept);
        stats.counter("node_refine", self.node_refine);
        stats.counter("leaf_visits", self.leaf_visits);
        stats.counter("early_out_shadowed", self.early_out_shadowed);
        stats.counter("atomic_or", self.atomic_or);
        stats.counter("queue_pushed", self.queue_pushed);
        stats.counter("queue_peak", self.queue_peak);
        stats.counter("queue_flushes", self.queue_flushes);
        self.leaf.report(stats);
    }
}

/// The rest of a walk: children of a group that are still to be looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job {
    triangle: u32,
    level: u32,
    group: u32,
    mask: u32,
}

/// How often nodes were visited, for pictures.
#[derive(Debug, Default)]
pub(crate) struct Visits {
    /// By level and group: tests of a child box.
    pub(crate) groups: Vec<Vec<AtomicU32>>,
    pub(crate) leaves: Vec<AtomicU32>,
}

impl Visits {
    pub(crate) fn new(tree: &Tree) -> Visits {
        let zeros = |n: usize| (0..n).map(|_| AtomicU32::new(0)).collect();
        let groups = tree.levels.iter().map(|l| zeros(l.groups.len())).collect();
        Visits { groups, leaves: zeros(tree.leaves.len()) }
    }
}

/// What all walks of a frame share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<'a> {
    pub(crate) tree: &'a Tree,
    pub(crate) triangles: &'a [Triangle],
    pub(crate) light: [f32; 3],
    pub(crate) space: &'a Space,
    pub(crate) residual: V3,
    pub(crate) wedges: bool,
    pub(crate) tuning: Tuning,
    pub(crate) visits: Option<&'a Visits>,
}

/// Walks all triangles. First all of them from the root, each within its budget; then, round by round, what is left of
/// those that had more to do (methods.md 3.6 (a) and 4.7).
pub(crate) fn walk_all(isa: Isa, frame: &Frame<'_>, jobs: &mut Vec<Job>) -> Counts {
    let level = isa.level().unwrap_or_else(fearless_simd::Level::new);
    if frame.tree.levels.is_empty() {
        return Counts::default();
    }
    jobs.clear();
    let queue = Mutex::new(std::mem::take(jobs));
    let mut counts = frame
        .triangles
        .par_chunks(TRIANGLES_PER_TASK)
        .enumerate()
        .map(|(task, chunk)| {
            let first = (task * TRIANGLES_PER_TASK) as u32;
            dispatch!(level, s => walk_triangles(s, frame, &queue, first, chunk.len() as u32))
        })
        .reduce(Counts::default, Counts::add);
    let mut round = Vec::new();
    loop {
        std::mem::swap(&mut round, &mut *lock(&queue));
        if round.is_empty() {
            break;
        }
        counts.queue_peak = counts.queue_peak.max(round.len() as u64);
        counts = round
            .par_chunks(JOBS_PER_TASK)
            .map(|jobs| dispatch!(level, s => walk_jobs(s, frame, &queue, jobs)))
            .reduce(Counts::default, Counts::add)
            .add(counts);
        round.clear();
    }
    *jobs = std::mem::take(&mut *lock(&queue));
    counts
}

/// A poisoned lock means that another thread has panicked already, which rayon passes on.
fn lock(queue: &Mutex<Vec<Job>>) -> std::sync::MutexGuard<'_, Vec<Job>> {
    queue.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

#[inline(always)]
fn walk_triangles<S: Simd>(
    s: S,
    frame: &Frame<'_>,
    queue: &Mutex<Vec<Job>>,
    first: u32,
    count: u32,
) -> Counts {
    let mut walk = Walk::new(frame, queue);
    let top = frame.tree.levels.len() - 1;
    for triangle in first..first + count {
        if walk.set_triangle(triangle) {
            walk.visit(s, top, 0);
            walk.run(s, top);
        }
    }
    walk.counts
}

#[inline(always)]
fn walk_jobs<S: Simd>(s: S, frame: &Frame<'_>, queue: &Mutex<Vec<Job>>, jobs: &[Job]) -> Counts {
    let mut walk = Walk::new(frame, queue);
    for job in jobs {
        if walk.set_triangle(job.triangle) {
            walk.stack[job.level as usize] = (job.group, job.mask);
            walk.run(s, job.level as usize);
        }
    }
    walk.counts
}

/// The triangle that is walked.
struct Caster<'a> {
    id: u32,
    triangle: &'a Triangle,
    frustum: Frustum,
    /// Made at the first leaf: most triangles of most scenes reach few.
    leaf: Option<LeafTest<'a>>,
}

struct Walk<'a> {
    frame: &'a Frame<'a>,
    queue: &'a Mutex<Vec<Job>>,
    caster: Option<Caster<'a>>,
    /// By level: a group, and its children that are still to be looked at.
    stack: [(u32, u32); MAX_LEVELS],
    counts: Counts,
}

impl<'a> Walk<'a> {
    fn new(frame: &'a Frame<'a>, queue: &'a Mutex<Vec<Job>>) -> Self {
        Walk { frame, queue, caster: None, stack: [(0, 0); MAX_LEVELS], counts: Counts::default() }
    }

    /// Prepares a triangle; `false` if it casts nothing.
    fn set_triangle(&mut self, id: u32) -> bool {
        let frame = self.frame;
        if self.caster.as_ref().is_some_and(|c| c.id == id) {
            return true;
        }
        let triangle = &frame.triangles[id as usize];
        self.counts.setup_tris += 1;
        let frustum = Frustum::new(triangle, frame.light, frame.space, frame.residual)
            .filter(|f| !(frame.tuning.cull_front_faces && f.facing < 0));
        self.counts.culled_tris += u64::from(frustum.is_none());
        self.caster = frustum.map(|frustum| Caster { id, triangle, frustum, leaf: None });
        self.caster.is_some()
    }

    /// Tests the children of a group; those to refine go onto the stack.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, s: S, height: usize, group: usize) {
        let Some(caster) = &mut self.caster else { return };
        let frame = self.frame;
        let level = &frame.tree.levels[height];
        let node = &level.groups[group];
        let asked = !level.words[group].load(Relaxed);
        self.stack[height] = (group as u32, 0);
        self.counts.early_out_shadowed += u64::from(node.count - asked.count_ones());
        if asked == 0 {
            return;
        }
        self.counts.group_visits += 1;
        self.counts.node_visits += u64::from(asked.count_ones());
        if let Some(visits) = frame.visits {
            visits.groups[height][group].fetch_add(1, Relaxed);
        }
        let boxes = level.boxes(node);
        let (reject, accept) = test_main(s, boxes, &caster.frustum.main, node.reach, asked);
        let mut refine = asked & !reject & !accept;
        if refine != 0 {
            let extra = caster.frustum.extra(frame.space, frame.residual, frame.wedges);
            let more = test_extra(s, boxes, extra, node.reach, refine);
            self.counts.extra_reject += u64::from(more.count_ones());
            refine &= !more;
        }
        self.counts.node_reject += u64::from(reject.count_ones());
        self.counts.node_accept += u64::from(accept.count_ones());
        self.counts.node_refine += u64::from(refine.count_ones());
        if accept != 0 {
            self.counts.atomic_or += frame.tree.cover(height, group, accept);
        }
        self.stack[height].1 = refine;
    }

    /// Empties the stack from its lowest level up to `top`.
    #[inline(always)]
    fn run<S: Simd>(&mut self, s: S, top: usize) {
        let tree = self.frame.tree;
        let mut left = self.frame.tuning.budget;
        let mut height = top;
        loop {
            let (group, mask) = self.stack[height];
            let level = &tree.levels[height];
            // Others may have covered a child since it was tested.
            let open = mask & !level.words[group as usize].load(Relaxed);
            self.counts.early_out_shadowed += u64::from((mask & !open).count_ones());
            if open == 0 {
                if height == top {
                    return;
                }
                height += 1;
                continue;
            }
            if left == 0 {
                self.stack[height].1 = open;
                if self.hand_over(height, top) {
                    return;
                }
                left = self.frame.tuning.budget;
            }
            left = left.saturating_sub(1);
            self.stack[height].1 = open & (open - 1);
            let child = (level.groups[group as usize].first_child + open.trailing_zeros()) as usize;
            if height == 0 {
                self.leaf(s, child);
            } else {
                height -= 1;
                self.visit(s, height, child);
            }
        }
    }

    /// Queues what is on the stack. `false` if the queue is full.
    #[cold]
    fn hand_over(&mut self, low: usize, top: usize) -> bool {
        let Some(caster) = &self.caster else { return true };
        let mut queue = lock(self.queue);
        let jobs = self.stack[low..=top].iter().filter(|(_, mask)| *mask != 0).count();
        if queue.len() + jobs > self.frame.tuning.queue {
            self.counts.queue_flushes += 1;
            return false;
        }
        for level in low..=top {
            let (group, mask) = self.stack[level];
            if mask != 0 {
                queue.push(Job { triangle: caster.id, level: level as u32, group, mask });
            }
        }
        self.counts.queue_pushed += jobs as u64;
        true
    }

    /// Tests the samples of a tile that are not shadowed yet.
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, s: S, leaf: usize) {
        let Some(caster) = &mut self.caster else { return };
        let frame = self.frame;
        if caster.leaf.is_none() {
            caster.leaf = LeafTest::new(caster.triangle, frame.light);
        }
        let Some(test) = &mut caster.leaf else { return };
        self.counts.leaf_visits += 1;
        if let Some(visits) = frame.visits {
            visits.leaves[leaf].fetch_add(1, Relaxed);
        }
        let open = !frame.tree.leaf_words[leaf].load(Relaxed);
        let first = frame.tree.leaves[leaf].first_block as usize;
        let mut hits = 0u64;
        let mut block = 0;
        while open >> (LANES * block) != 0 {
            let asked = (open >> (LANES * block)) as u8;
            if asked != 0 {
                let at = &frame.tree.blocks[first + block].at;
                let found = test.eight(s, &at[0], &at[1], &at[2], asked, &mut self.counts.leaf);
                hits |= u64::from(found) << (LANES * block);
            }
            block += 1;
            if block == 8 {
                break;
            }
        }
        if hits != 0 {
            self.counts.atomic_or += frame.tree.cover_samples(leaf, hits);
        }
    }
}
