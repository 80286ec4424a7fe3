//! A bundle of segments with one common end, walked through the hierarchy as one.
//!
//! The other ends are up to 64 points that lie close together. A node is visited when some segment *may* meet its
//! box: interval arithmetic over the box of the points, with a margin that covers every rounding (see [`Cone::meets`]).
//! The leaves decide; here nothing is ever lost.

use antumbra_predicates::SampleGroup;
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::{Bounds, Bvh, Leaf, Node, Ref, WIDTH};

/// Points of a packet at most.
pub(crate) const PACKET: usize = 64;
/// Vectors of a packet at most.
pub(crate) const VECTORS: usize = PACKET / WIDTH;

/// Up to 64 points, world space; unused lanes repeat the last one.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Packet {
    pub(crate) position: [[f32; PACKET]; 3],
    /// What the caller calls them.
    pub(crate) id: [u32; PACKET],
    pub(crate) count: usize,
}

impl Packet {
    pub(crate) const EMPTY: Packet = Packet { position: [[0.0; PACKET]; 3], id: [0; PACKET], count: 0 };

    #[inline(always)]
    pub(crate) fn push(&mut self, p: [f32; 3], id: u32) {
        for k in 0..3 {
            self.position[k][self.count] = p[k];
        }
        self.id[self.count] = id;
        self.count += 1;
    }

    #[inline(always)]
    pub(crate) fn point(&self, i: usize) -> [f32; 3] {
        [self.position[0][i], self.position[1][i], self.position[2][i]]
    }

    /// Fills the last vector up.
    pub(crate) fn pad(&mut self) {
        let last = self.count - 1;
        for i in self.count..self.count.next_multiple_of(WIDTH) {
            for k in 0..3 {
                self.position[k][i] = self.position[k][last];
            }
        }
    }

    pub(crate) fn vectors(&self) -> usize {
        self.count.div_ceil(WIDTH)
    }

    /// One bit a point.
    pub(crate) fn all(&self) -> u64 {
        u64::MAX >> (PACKET - self.count)
    }

    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, s: S, vector: usize) -> [f32x8<S>; 3] {
        [0, 1, 2].map(|k| f32x8::from_slice(s, &self.position[k][vector * WIDTH..vector * WIDTH + WIDTH]))
    }

    /// The box of the points of one vector, padding included (it repeats a point).
    #[inline(always)]
    pub(crate) fn vector_group(&self, vector: usize) -> SampleGroup {
        let (mut lo, mut hi) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let lanes = &self.position[k][vector * WIDTH..(vector + 1) * WIDTH];
            (lo[k], hi[k]) = lanes.iter().fold((lanes[0], lanes[0]), |(l, h), v| (l.min(*v), h.max(*v)));
        }
        SampleGroup::from_bounds(lo, hi)
    }

    pub(crate) fn bounds(&self) -> Bounds {
        let mut b = Bounds::EMPTY;
        for i in 0..self.count {
            b.add(self.point(i));
        }
        b
    }
}

/// Magnitudes outside `[1 / SAFE, SAFE]` could overflow or vanish in the box test: then every node is visited.
const SAFE: f32 = (1u64 << 60) as f32;

/// Relative margin of the box test: five roundings of at most 2^-24 on each side, and as much again.
const MARGIN: f32 = 1.0 + 20.0 * 0.5 * f32::EPSILON;

/// One axis of a [`Cone`].
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// The points are certainly on one side of the origin on this axis: +1, -1, or 0 if not.
    side: i8,
    /// Reciprocals of the farthest and of the nearest point on that side; with side 0 those of the largest and of the
    /// smallest (negative) point, or 0 where there is none.
    inverse: [f32; 2],
}

/// The segments from `origin` to all points of a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    origin: [f32; 3],
    axis: [Axis; 3],
    /// Numbers are too large for the box test: visit everything.
    wild: bool,
    pub(crate) group: SampleGroup,
}

impl Cone {
    /// All segments from `origin` to points in `points`. `scene` bounds all boxes that will be tested.
    pub(crate) fn new(origin: [f32; 3], points: Bounds, scene: &Bounds) -> Cone {
        let axis = [0, 1, 2].map(|k| {
            let (lo, hi) = (points.lo[k] - origin[k], points.hi[k] - origin[k]);
            if lo > 1.0 / SAFE {
                Axis { side: 1, inverse: [1.0 / hi, 1.0 / lo] }
            } else if hi < -1.0 / SAFE {
                Axis { side: -1, inverse: [1.0 / lo, 1.0 / hi] }
            } else {
                // A smaller reciprocal only makes the bound weaker.
                let up = if hi > 0.0 { (1.0 / hi).min(SAFE) } else { 0.0 };
                let down = if lo < 0.0 { (1.0 / lo).max(-SAFE) } else { 0.0 };
                // No point above (below) the origin: the whole half space is out of reach, but that is rare.
                Axis { side: 0, inverse: [up, down] }
            }
        });
        let small = |v: &f32| v.abs() <= SAFE;
        let tame =
            [&points.lo, &points.hi, &scene.lo, &scene.hi, &origin].into_iter().all(|p| p.iter().all(small));
        Cone { origin, axis, wild: !tame, group: SampleGroup::from_bounds(points.lo, points.hi) }
    }

    /// Which boxes of `node` may be met by a segment within `limit` of its length (1 = all of it), and where at the
    /// earliest. Conservative.
    ///
    /// A point `t P` of a segment, `0 < t <= limit`, lies in the box only if on every axis `lo <= t P <= hi` (light at
    /// the origin). With `P` in `[P_lo, P_hi] > 0` that needs `lo / P_hi <= t <= hi / P_lo`, mirrored for negative sides;
    /// where the points straddle the origin only `t >= lo / P_hi` and `t >= hi / P_lo` remain. Every quotient carries at
    /// most five roundings (two differences, reciprocal, product, and one to spare), signs are right because differences
    /// of floats have the right sign. Quotients under 2^-126 vanish: an absolute 2^-100 covers them.
    #[inline(always)]
    pub(crate) fn meets<S: Simd>(&self, s: S, node: &Node, limit: f32) -> (u32, f32x8<S>) {
        let used = node.live();
        let zero = f32x8::splat(s, 0.0);
        if self.wild {
            return (used, zero);
        }
        let mut near = zero;
        let mut far = f32x8::splat(s, limit);
        for k in 0..3 {
            let axis = self.axis[k];
            let lo = f32x8::load_array_ref(s, &node.lo[k]) - self.origin[k];
            let hi = f32x8::load_array_ref(s, &node.hi[k]) - self.origin[k];
            if axis.side > 0 {
                near = near.max(lo * axis.inverse[0]);
                far = far.min(hi * axis.inverse[1]);
            } else if axis.side < 0 {
                near = near.max(hi * axis.inverse[0]);
                far = far.min(lo * axis.inverse[1]);
            } else {
                near = near.max(lo * axis.inverse[0]).max(hi * axis.inverse[1]);
            }
        }
        let reach = far.mul_add(f32x8::splat(s, MARGIN), f32x8::splat(s, 1.0 / (1u128 << 100) as f32));
        (near.simd_le(reach).to_bitmask() as u32 & used, near)
    }
}

/// What to do at the leaves of one walk.
pub(crate) trait Visitor {
    /// How far along the segments it is still worth looking, 1 = all of it.
    fn limit(&self) -> f32;

    /// Looks at a leaf; `true` ends the walk.
    fn leaf<S: Simd>(&mut self, s: S, leaf: &Leaf) -> bool;
}

/// Nodes that wait: seven a level at most, 64 levels of at most 2^30 cuts each way.
#[derive(Debug)]
pub(crate) struct Stack(Vec<(Ref, f32)>);

impl Default for Stack {
    fn default() -> Self {
        Stack(Vec::with_capacity(512))
    }
}

/// Work of walks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WalkCounts {
    pub(crate) nodes: u64,
    pub(crate) leaves: u64,
}

/// Walks the segments of `cone` through the hierarchy. `NEAR_FIRST` visits the nearer children first (for closest hits).
#[inline(always)]
pub(crate) fn walk<S: Simd, V: Visitor, const NEAR_FIRST: bool>(
    s: S,
    bvh: &Bvh,
    cone: &Cone,
    stack: &mut Stack,
    counts: &mut WalkCounts,
    visitor: &mut V,
) {
    let Some(root) = bvh.root() else { return };
    let stack = &mut stack.0;
    stack.clear();
    stack.push((root, 0.0));
    while let Some((at, near)) = stack.pop() {
        if NEAR_FIRST && near > visitor.limit() {
            continue;
        }
        if at.is_leaf() {
            counts.leaves += 1;
            if visitor.leaf(s, bvh.leaf(at, &mut None)) {
                return;
            }
            continue;
        }
        counts.nodes += 1;
        let node = bvh.node(at);
        let (mut hits, near) = cone.meets(s, node, visitor.limit());
        if NEAR_FIRST {
            let near = near.to_array();
            let base = stack.len();
            while hits != 0 {
                let lane = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                // Insertion keeps the nearest on top.
                let mut place = stack.len();
                stack.push((node.child[lane], near[lane]));
                while place > base && stack[place - 1].1 < near[lane] {
                    stack.swap(place, place - 1);
                    place -= 1;
                }
            }
        } else {
            while hits != 0 {
                let lane = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                stack.push((node.child[lane], 0.0));
            }
        }
    }
}

/// Parts a packet into packets of points that lie closer together, where that makes them much tighter, and hands each
/// one on. `scratch` is overwritten.
///
/// A packet over a depth edge has a box that is mostly empty; its parts on both sides of the edge have small ones. Parts
/// are cut in the middle of the longest side, as long as the extents of the two parts sum up to less than 7/10 of
/// the whole (a cut of an evenly filled square gives 3/2).
pub(crate) fn part(packet: &mut Packet, origin: [f32; 3], each: &mut impl FnMut(&mut Packet, Bounds)) {
    if packet.count == 0 {
        return;
    }
    let bounds = packet.bounds();
    let size = |b: &Bounds| [0, 1, 2].map(|k| b.hi[k] - b.lo[k]);
    let extent = |b: &Bounds| size(b).iter().sum::<f32>();
    let whole = extent(&bounds);
    let _ = origin;
    if packet.count > 1 && whole > 0.0 {
        let sides = size(&bounds);
        let axis = (0..3).fold(0, |best, k| if sides[k] > sides[best] { k } else { best });
        let middle = bounds.lo[axis] * 0.5 + bounds.hi[axis] * 0.5;
        let (mut low, mut high) = (Bounds::EMPTY, Bounds::EMPTY);
        for i in 0..packet.count {
            let p = packet.point(i);
            if p[axis] < middle { low.add(p) } else { high.add(p) }
        }
        if low.lo[0] <= low.hi[0] && high.lo[0] <= high.hi[0] && extent(&low) + extent(&high) < 0.7 * whole {
            let (mut a, mut b) = (Packet::EMPTY, Packet::EMPTY);
            for i in 0..packet.count {
                let p = packet.point(i);
                if p[axis] < middle { a.push(p, packet.id[i]) } else { b.push(p, packet.id[i]) }
            }
            part(&mut a, origin, each);
            part(&mut b, origin, each);
            return;
        }
    }
    packet.pad();
    each(packet, bounds);
}
