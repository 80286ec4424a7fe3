//! The deterministic parallel build: exactly the tree that inserting one triangle after the other would give.
//!
//! Triangles are inserted in a seeded pseudorandom order, `rank` 0 first. Sequentially, a triangle walks down from the
//! root until it finds an empty link and takes it. In parallel, all triangles go down together, one tree level a round: in
//! each round every pending triangle stands at a link, the smallest rank has won it (an atomic minimum of the round
//! before; nodes lie in the order of ranks, so the winner's rank *is* the link), and the others walk past the winner and
//! propose themselves to the next link. By induction over levels the triangles that reach a link are the same as in
//! sequential insertion, and all reach it in the same round; so the smallest of their ranks takes it in both. A minimum of
//! distances and a maximum of wedges do not depend on the order either.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::bounds::Directions;
use super::node::{CAP, NONE, Node, relative};
use super::order::Order;
use super::tuning::{BUILD_TASKS, MAX_DEPTH, SERIAL_ROUND};
use crate::scene::Triangle;

/// A triangle on its way down.
#[derive(Clone, Copy, Debug)]
struct Pending {
    rank: u32,
    /// The link it stands at: `8 node + plane` for outside, `+ 4` for crossing; `NONE` for the root.
    link: u32,
    /// Becomes [`Node::back`].
    back: u32,
    triangle: u32,
    nearest: u32,
}

/// What the build did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct BuildCounts {
    /// Degenerate or edge-on: never inserted.
    pub(super) culled: u64,
    /// Lie in the shadow of another triangle.
    pub(super) discarded: u64,
    /// Steps past a triangle, over all insertions.
    pub(super) steps: u64,
    /// Of those: into a crossing subtree.
    pub(super) crossings: u64,
    /// Triangles below one another.
    pub(super) depth: u64,
}

impl BuildCounts {
    fn add(mut self, other: BuildCounts) -> BuildCounts {
        self.culled += other.culled;
        self.discarded += other.discarded;
        self.steps += other.steps;
        self.crossings += other.crossings;
        self.depth = self.depth.max(other.depth);
        self
    }
}

/// The tree, and memory kept between builds.
#[derive(Debug, Default)]
pub(super) struct Tree {
    /// In the order of insertion.
    pub(super) nodes: Vec<Node>,
    root: AtomicU32,
    /// Triangles that lie too deep (see [`MAX_DEPTH`]) and are left to ray casting.
    pub(super) rest: Vec<u32>,
    pub(super) counts: BuildCounts,
    tasks: Vec<Task>,
}

#[derive(Debug, Default)]
struct Task {
    pending: Vec<Pending>,
    rest: Vec<u32>,
    counts: BuildCounts,
}

/// What walking past a triangle leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Outside(usize),
    Crossing(usize),
    /// Everything it could shadow is in shadow already.
    Discard,
}

/// Where does `triangle` go at `node`?
///
/// Section 5.2 asks that all corners lie strictly on one side. With exact signs that can be relaxed to "none lies on the
/// other side", which keeps neighbours with common corners out of the crossing subtrees: a triangle blocks a sample only
/// if the perturbed sample `P + (ε, ε², ε³)` lies in the *open* cone of the triangle, whose points are positive combinations
/// of its corners. So if the corners' signs at a shadow plane are `>= 0`, not all 0, the perturbed sample has the sign +1,
/// and the query, whose ties are broken by that very perturbation, walks the same way. (All 0 would be a triangle
/// seen edge-on: none of those are here.)
///
/// At the cap the triangle lies in the node's closed cone. If no corner is on the light's side, every sample that it blocks
/// lies strictly beyond the triangle, hence strictly beyond the cap (`P = t X` with `t > 1` and `N·X >= det > 0`), and so is
/// blocked by the node's triangle: discard, certain even for coplanar triangles and duplicates.
fn step(node: &Node, triangle: &Triangle, triangles: &[Triangle], light: [f32; 3]) -> Step {
    let q = triangle.map(|v| [v[0] - light[0], v[1] - light[1], v[2] - light[2]]);
    for k in 0..4 {
        let (mut inside, mut outside) = (false, false);
        for i in 0..3 {
            match node.sign(k, triangles, light, triangle[i], q[i]) {
                1 => inside = true,
                -1 => outside = true,
                _ => {}
            }
        }
        match (inside, outside) {
            (true, true) => return Step::Crossing(k),
            (false, true) => return Step::Outside(k),
            (true, false) => {}
            (false, false) if k == CAP => {}
            (false, false) => return Step::Crossing(k),
        }
    }
    Step::Discard
}

impl Tree {
    /// Builds the tree anew. `max_depth`: [`MAX_DEPTH`], or less for tests.
    pub(super) fn build(&mut self, triangles: &[Triangle], light: [f32; 3], max_depth: usize) {
        let max_depth = max_depth.clamp(1, MAX_DEPTH);
        let order = Order::new(triangles.len() as u32);
        self.make_nodes(triangles, light, order);
        let count = self.enter(triangles.len(), order);
        let Tree { nodes, root, tasks, .. } = self;
        let (nodes, root) = (nodes.as_slice(), &*root);
        let mut pending = count;
        for depth in 1.. {
            if pending == 0 {
                break;
            }
            let round = |task: &mut Task| round(task, nodes, root, triangles, light, depth, max_depth);
            pending = if pending < SERIAL_ROUND {
                tasks.iter_mut().map(round).sum()
            } else {
                tasks.par_iter_mut().map(round).sum()
            };
        }
        self.rest.clear();
        for task in &mut self.tasks {
            self.rest.append(&mut task.rest);
            self.counts = self.counts.add(task.counts);
        }
    }

    /// Planes and distances of all triangles, in the order of insertion.
    fn make_nodes(&mut self, triangles: &[Triangle], light: [f32; 3], order: Order) {
        self.nodes.clear();
        let ranks = 0..triangles.len() as u32;
        self.nodes.par_extend(
            ranks.into_par_iter().with_min_len(256).map(|rank| Node::new(order.at(rank), triangles, light)),
        );
    }

    /// All triangles that can block anything stand at the root: in the order of the soup, in which neighbours are mostly
    /// close, so that they find each other's path in the cache. Returns how many.
    fn enter(&mut self, len: usize, order: Order) -> usize {
        let share = len.div_ceil(BUILD_TASKS).max(1);
        self.tasks.resize_with(len.div_ceil(share), Task::default);
        self.root = AtomicU32::new(NONE);
        let (nodes, root) = (&self.nodes, &self.root);
        self.counts = BuildCounts::default();
        self.tasks
            .par_iter_mut()
            .enumerate()
            .map(|(i, task)| {
                task.pending.clear();
                task.counts = BuildCounts::default();
                for index in i * share..len.min((i + 1) * share) {
                    let rank = order.rank(index as u32);
                    let node = &nodes[rank as usize];
                    if node.facing == 0 {
                        task.counts.culled += 1;
                        continue;
                    }
                    root.fetch_min(rank, Ordering::Relaxed);
                    let nearest = node.nearest.load(Ordering::Relaxed);
                    task.pending.push(Pending {
                        rank,
                        link: NONE,
                        back: NONE,
                        triangle: node.triangle,
                        nearest,
                    });
                }
                task.pending.len()
            })
            .sum()
    }

    /// The first triangle, `None` in an empty tree.
    pub(super) fn root(&self) -> Option<u32> {
        let root = self.root.load(Ordering::Relaxed);
        (root != NONE).then_some(root)
    }

    /// Bytes of nodes and of scratch memory.
    pub(super) fn bytes(&self) -> (usize, usize) {
        let pending: usize = self.tasks.iter().map(|t| t.pending.capacity()).sum();
        (self.nodes.len() * size_of::<Node>(), pending * size_of::<Pending>())
    }
}

fn link<'a>(nodes: &'a [Node], root: &'a AtomicU32, link: u32) -> &'a AtomicU32 {
    if link == NONE {
        return root;
    }
    let (node, k) = (&nodes[(link >> 3) as usize], (link & 3) as usize);
    if link & 4 == 0 { &node.outside[k] } else { &node.crossing[k] }
}

/// One round of one task: settles who won, moves the others on. Returns how many are still pending.
fn round(
    task: &mut Task,
    nodes: &[Node],
    root: &AtomicU32,
    triangles: &[Triangle],
    light: [f32; 3],
    depth: usize,
    max_depth: usize,
) -> usize {
    let Task { pending, rest, counts } = task;
    pending.retain_mut(|p| {
        let winner = link(nodes, root, p.link).load(Ordering::Relaxed);
        if winner == p.rank {
            nodes[p.rank as usize].back.store(p.back, Ordering::Relaxed);
            counts.depth = counts.depth.max(depth as u64);
            return false;
        }
        if depth == max_depth {
            rest.push(p.triangle);
            return false;
        }
        counts.steps += 1;
        let node = &nodes[winner as usize];
        if p.nearest < node.nearest.load(Ordering::Relaxed) {
            node.nearest.fetch_min(p.nearest, Ordering::Relaxed);
        }
        let triangle = &triangles[p.triangle as usize];
        match step(node, triangle, triangles, light) {
            Step::Discard => {
                counts.discarded += 1;
                return false;
            }
            Step::Outside(k) => p.link = winner * 8 + k as u32,
            Step::Crossing(k) => {
                counts.crossings += 1;
                if k != CAP {
                    raise_wedge(node, k, triangle, light);
                }
                p.link = winner * 8 + 4 + k as u32;
                p.back = winner * 4 + k as u32;
            }
        }
        propose(link(nodes, root, p.link), p.rank);
        true
    });
    pending.len()
}

/// `link = min(link, rank)`, reading first: most proposals lose.
fn propose(link: &AtomicU32, rank: u32) {
    if link.load(Ordering::Relaxed) > rank {
        link.fetch_min(rank, Ordering::Relaxed);
    }
}

fn raise_wedge(node: &Node, k: usize, triangle: &Triangle, light: [f32; 3]) {
    let wedge = Directions::new(&relative(triangle, light)).wedge(node.normal(k)).to_bits();
    if node.wedge[k].load(Ordering::Relaxed) < wedge {
        node.wedge[k].fetch_max(wedge, Ordering::Relaxed);
    }
}

/// Inserts one triangle after the other: what [`Tree::build`] must equal.
#[cfg(test)]
pub(super) fn build_sequentially(triangles: &[Triangle], light: [f32; 3]) -> Tree {
    let order = Order::new(triangles.len() as u32);
    let mut tree = Tree::default();
    tree.make_nodes(triangles, light, order);
    tree.root = AtomicU32::new(NONE);
    for rank in 0..triangles.len() as u32 {
        let node = &tree.nodes[rank as usize];
        if node.facing == 0 {
            continue;
        }
        let triangle = &triangles[node.triangle as usize];
        let nearest = node.nearest.load(Ordering::Relaxed);
        let (mut at, mut back) = (&tree.root, NONE);
        loop {
            let here = at.load(Ordering::Relaxed);
            if here == NONE {
                at.store(rank, Ordering::Relaxed);
                node.back.store(back, Ordering::Relaxed);
                break;
            }
            let passed = &tree.nodes[here as usize];
            passed.nearest.fetch_min(nearest, Ordering::Relaxed);
            match step(passed, triangle, triangles, light) {
                Step::Discard => break,
                Step::Outside(k) => at = &passed.outside[k],
                Step::Crossing(k) => {
                    if k != CAP {
                        raise_wedge(passed, k, triangle, light);
                    }
                    back = here * 4 + k as u32;
                    at = &passed.crossing[k];
                }
            }
        }
    }
    tree
}
