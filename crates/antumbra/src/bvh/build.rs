//! Builds the hierarchy in parallel: Morton codes, radix sort, splits at the highest differing bit, eight ways at once.

use rayon::prelude::*;
use rdst::{RadixKey, RadixSort};

use super::{Arena, Bounds, Bvh, HALF, HalfLeaf, Leaf, Node, Ref, WIDTH};
use crate::scene::Triangle;
use antumbra_predicates::TriangleBlock;

/// Triangles that one task builds, about. Smaller: more parallel slack and more arenas. Larger: less of both. 2048 to
/// 16384 measured the same.
const ARENA_TRIANGLES: usize = 4096;

/// Triangles at most: what 31 bits of reference can point at when every leaf holds one triangle.
pub(crate) const MAX_TRIANGLES: usize = 1 << 27;

/// A triangle on its way into the tree.
#[derive(Clone, Copy, Debug, Default)]
struct Item {
    code: u32,
    triangle: u32,
}

impl RadixKey for Item {
    const LEVELS: usize = 4;

    #[inline]
    fn get_level(&self, level: usize) -> u8 {
        (self.code >> (8 * level)) as u8
    }
}

/// Memory that is kept between builds.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    items: Vec<Item>,
    ranges: Vec<Range>,
    top: Vec<TopNode>,
}

impl Scratch {
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.items[..]) + size_of_val(&self.ranges[..]) + size_of_val(&self.top[..])
    }
}

/// Items `start..end`, and where the subtree over them ended up.
#[derive(Clone, Copy, Debug)]
struct Range {
    start: usize,
    end: usize,
    built: Ref,
    bounds: Bounds,
}

/// A child of a node of the top of the tree.
#[derive(Clone, Copy, Debug)]
enum TopChild {
    Range(usize),
    Node(usize),
}

#[derive(Clone, Copy, Debug)]
struct TopNode {
    child: [TopChild; WIDTH],
    count: usize,
}

/// Triangles with two equal corners are degenerate from everywhere and never enter the tree.
#[inline(always)]
fn is_visible(t: &Triangle) -> bool {
    t[0] != t[1] && t[1] != t[2] && t[2] != t[0]
}

#[inline(always)]
fn bounds_of(t: &Triangle) -> Bounds {
    let mut b = Bounds { lo: t[0], hi: t[0] };
    b.add(t[1]);
    b.add(t[2]);
    b
}

/// Spreads the low ten bits to every third place.
#[inline(always)]
fn spread(v: u32) -> u32 {
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

/// 30-bit Morton code of a point in `[0, 1024)³`; anything else is clamped (casts saturate, NaN becomes 0).
#[inline(always)]
pub(crate) fn morton(p: [f32; 3]) -> u32 {
    let q = p.map(|v| (v as u32).min(1023));
    spread(q[0]) | spread(q[1]) << 1 | spread(q[2]) << 2
}

impl Bvh {
    /// Builds the hierarchy over `triangles` anew.
    pub(crate) fn build(&mut self, triangles: &[Triangle]) {
        let mut scratch = std::mem::take(&mut self.scratch);
        sort_by_code(triangles, &mut scratch.items);
        self.build_sorted(triangles, &mut scratch);
        self.scratch = scratch;
    }

    fn build_sorted(&mut self, triangles: &[Triangle], scratch: &mut Scratch) {
        let Scratch { items, ranges, top } = scratch;
        (self.root, self.used, self.bounds) = (None, 0, Bounds::EMPTY);
        ranges.clear();
        top.clear();
        if items.is_empty() {
            return;
        }
        let root = plan_top(items, 0, items.len(), ranges, top);
        // Twice the target, as ranges are put together until the target is passed.
        let arena_triangles = ARENA_TRIANGLES.max(items.len() >> 14);
        self.local_bits =
            (4 * arena_triangles).next_power_of_two().max(2 * top.len()).next_power_of_two().trailing_zeros();

        // Consecutive ranges share an arena.
        let mut jobs: Vec<(usize, usize)> = Vec::new();
        let mut first = 0;
        while first < ranges.len() {
            let (mut last, mut size) = (first, 0);
            while last < ranges.len()
                && (size == 0 || size + (ranges[last].end - ranges[last].start) <= arena_triangles)
            {
                size += ranges[last].end - ranges[last].start;
                last += 1;
            }
            jobs.push((first, last));
            first = last;
        }
        self.used = jobs.len() + 1;
        if self.arenas.len() < self.used {
            self.arenas.resize_with(self.used, Arena::default);
        }
        let (head, tail) = self.arenas.split_at_mut(1);
        let local_bits = self.local_bits;
        let mut rest = ranges.as_mut_slice();
        let mut slices = Vec::with_capacity(jobs.len());
        for &(a, b) in &jobs {
            let (now, later) = rest.split_at_mut(b - a);
            slices.push(now);
            rest = later;
        }
        let items = items.as_slice();
        tail.par_iter_mut().zip(slices).enumerate().for_each(|(index, (arena, ranges))| {
            arena.nodes.clear();
            arena.leaves.clear();
            arena.halves.clear();
            let mut builder = Builder { triangles, items, base: (index as u32 + 1) << local_bits, arena };
            for range in ranges {
                (range.built, range.bounds) = builder.subtree(range.start, range.end);
            }
        });

        let arena = &mut head[0];
        arena.leaves.clear();
        arena.halves.clear();
        arena.nodes.clear();
        arena.nodes.resize(top.len(), Node::EMPTY);
        // Children come after their parents: backwards, every child is ready before its parent.
        for (index, plan) in top.iter().enumerate().rev() {
            let mut node = Node::EMPTY;
            for &child in &plan.child[..plan.count] {
                match child {
                    TopChild::Range(r) => node.push(ranges[r].built, ranges[r].bounds),
                    TopChild::Node(n) => node.push(Ref(n as u32), arena.nodes[n].bounds()),
                }
            }
            node.fill_unused();
            arena.nodes[index] = node;
        }
        let (root, bounds) = match root {
            TopChild::Range(r) => (ranges[r].built, ranges[r].bounds),
            TopChild::Node(n) => (Ref(n as u32), arena.nodes[n].bounds()),
        };
        (self.root, self.bounds) = (Some(root), bounds);
    }
}

/// Fills `items` with the visible triangles in Morton order of their boxes' centres.
fn sort_by_code(triangles: &[Triangle], items: &mut Vec<Item>) {
    let bounds = triangles
        .par_chunks(4096)
        .map(|chunk| {
            let mut b = Bounds::EMPTY;
            for t in chunk {
                let own = bounds_of(t);
                b.add([0, 1, 2].map(|k| own.lo[k] * 0.5 + own.hi[k] * 0.5));
            }
            b
        })
        .reduce(|| Bounds::EMPTY, Bounds::union);
    let scale = [0, 1, 2].map(|k| {
        let s = 1024.0 / (bounds.hi[k] - bounds.lo[k]);
        if s.is_finite() { s } else { 0.0 }
    });
    let code = |t: &Triangle| {
        let own = bounds_of(t);
        morton([0, 1, 2].map(|k| (own.lo[k] * 0.5 + own.hi[k] * 0.5 - bounds.lo[k]) * scale[k]))
    };
    // Invisible triangles get a code that sorts last, and are cut off.
    items.resize(triangles.len(), Item::default());
    items.par_chunks_mut(4096).zip(triangles.par_chunks(4096)).enumerate().for_each(
        |(chunk, (items, triangles))| {
            for (i, (item, t)) in items.iter_mut().zip(triangles).enumerate() {
                let code = if is_visible(t) { code(t) } else { u32::MAX };
                *item = Item { code, triangle: (chunk * 4096 + i) as u32 };
            }
        },
    );
    items.radix_sort_unstable();
    let visible = items.partition_point(|item| item.code != u32::MAX);
    items.truncate(visible);
}

/// Where to cut `start..end` (at least two items): at the highest bit that differs, else in the middle.
#[inline(always)]
fn cut(items: &[Item], start: usize, end: usize) -> usize {
    let (first, last) = (items[start].code, items[end - 1].code);
    let differing = first ^ last;
    if differing == 0 {
        return start.midpoint(end);
    }
    let bit = 1 << (31 - differing.leading_zeros());
    start + items[start..end].partition_point(|item| item.code & bit == 0)
}

/// Cuts `start..end` into up to eight parts, always the largest first. Returns how many.
#[inline(always)]
fn cut_eight(
    items: &[Item],
    start: usize,
    end: usize,
    leaf: usize,
    parts: &mut [(usize, usize); WIDTH],
) -> usize {
    parts[0] = (start, end);
    let mut count = 1;
    while count < WIDTH {
        let (mut largest, mut size) = (0, 0);
        for (i, &(s, e)) in parts[..count].iter().enumerate() {
            if e - s > size {
                (largest, size) = (i, e - s);
            }
        }
        if size <= leaf {
            break;
        }
        let (s, e) = parts[largest];
        let middle = cut(items, s, e);
        parts[largest] = (s, middle);
        parts[count] = (middle, e);
        count += 1;
    }
    count
}

/// Plans the nodes above the ranges that tasks build.
fn plan_top(
    items: &[Item],
    start: usize,
    end: usize,
    ranges: &mut Vec<Range>,
    top: &mut Vec<TopNode>,
) -> TopChild {
    if end - start <= ARENA_TRIANGLES.max(items.len() >> 14) {
        ranges.push(Range { start, end, built: Ref::default(), bounds: Bounds::EMPTY });
        return TopChild::Range(ranges.len() - 1);
    }
    let mut parts = [(0, 0); WIDTH];
    let count = cut_eight(items, start, end, WIDTH, &mut parts);
    let index = top.len();
    top.push(TopNode { child: [TopChild::Range(0); WIDTH], count });
    for (i, &(s, e)) in parts[..count].iter().enumerate() {
        let child = plan_top(items, s, e, ranges, top);
        top[index].child[i] = child;
    }
    TopChild::Node(index)
}

/// Builds subtrees into one arena.
struct Builder<'a> {
    triangles: &'a [Triangle],
    items: &'a [Item],
    /// The arena's bits of a reference.
    base: u32,
    arena: &'a mut Arena,
}

impl Builder<'_> {
    fn subtree(&mut self, start: usize, end: usize) -> (Ref, Bounds) {
        if end - start <= WIDTH {
            return self.leaf(start, end);
        }
        let mut parts = [(0, 0); WIDTH];
        let count = cut_eight(self.items, start, end, WIDTH, &mut parts);
        let index = self.arena.nodes.len();
        self.arena.nodes.push(Node::EMPTY);
        let (mut node, mut all) = (Node::EMPTY, Bounds::EMPTY);
        for &(s, e) in &parts[..count] {
            let (child, bounds) = self.subtree(s, e);
            node.push(child, bounds);
            all = all.union(bounds);
        }
        node.fill_unused();
        self.arena.nodes[index] = node;
        (Ref(self.base | index as u32), all)
    }

    fn leaf(&mut self, start: usize, end: usize) -> (Ref, Bounds) {
        let Arena { leaves, halves, .. } = &mut *self.arena;
        let (local, bounds) = if end - start <= HALF {
            let (corner, id, bounds) = lanes(self.triangles, &self.items[start..end]);
            halves.push(HalfLeaf { corner, id });
            (Ref::half(halves.len() - 1), bounds)
        } else {
            let (corner, id, bounds) = lanes(self.triangles, &self.items[start..end]);
            leaves.push(Leaf { block: TriangleBlock { corner }, id });
            (Ref::whole(leaves.len() - 1), bounds)
        };
        (Ref(Ref::LEAF | self.base | local), bounds)
    }
}

/// Corners, numbers and bounds of up to `N` triangles. Unused lanes repeat the last, but for the number.
#[inline(always)]
fn lanes<const N: usize>(triangles: &[Triangle], items: &[Item]) -> ([[[f32; N]; 3]; 3], [u32; N], Bounds) {
    let mut corners = [[[0.0; N]; 3]; 3];
    let mut id = [Leaf::NONE; N];
    let mut bounds = Bounds::EMPTY;
    for lane in 0..N {
        let item = items[lane.min(items.len() - 1)];
        let t = &triangles[item.triangle as usize];
        if lane < items.len() {
            id[lane] = item.triangle;
        }
        for corner in 0..3 {
            bounds.add(t[corner]);
            for axis in 0..3 {
                corners[corner][axis][lane] = t[corner][axis];
            }
        }
    }
    (corners, id, bounds)
}

impl Node {
    const EMPTY: Node = Node { lo: [[0.0; WIDTH]; 3], hi: [[0.0; WIDTH]; 3], child: [Ref::NONE; WIDTH] };

    fn push(&mut self, child: Ref, bounds: Bounds) {
        let lane = self.live().count_ones() as usize;
        for k in 0..3 {
            self.lo[k][lane] = bounds.lo[k];
            self.hi[k][lane] = bounds.hi[k];
        }
        self.child[lane] = child;
    }

    fn fill_unused(&mut self) {
        for lane in self.live().count_ones() as usize..WIDTH {
            for k in 0..3 {
                self.lo[k][lane] = self.lo[k][0];
                self.hi[k][lane] = self.hi[k][0];
            }
        }
    }

    fn bounds(&self) -> Bounds {
        let fold = |v: &[f32; WIDTH], f: fn(f32, f32) -> f32| v.iter().copied().reduce(f).unwrap_or(0.0);
        Bounds {
            lo: [0, 1, 2].map(|k| fold(&self.lo[k], f32::min)),
            hi: [0, 1, 2].map(|k| fold(&self.hi[k], f32::max)),
        }
    }
}
