//! A bounding volume hierarchy over the triangles: eight children a node, up to eight triangles a leaf.
//!
//! Shared by primary visibility ([`crate::samples::gbuffer`]) and by the method `ray-cast`. Boxes hold the exact minima
//! and maxima of `f32` coordinates, so they need no padding of their own; the rounding of the box test is covered in
//! [`packet`]. Nodes and leaves live in *arenas* that are built in parallel and never copied; memory is kept between
//! builds.
//!
//! Sources: Lauterbach, Garland, Sengupta, Luebke, Manocha 2009, "Fast BVH Construction on GPUs" (Morton order, split at
//! the highest differing bit); Wald, Benthin, Boulos 2008, "Getting Rid of Packets" (wide nodes).

pub(crate) mod build;
pub(crate) mod packet;

use antumbra_predicates::TriangleBlock;

/// Triangles in a leaf at most, children of a node at most: one lane each.
pub(crate) const WIDTH: usize = 8;

/// Eight boxes, lane by lane. In unused lanes the box repeats a used one, and the child is [`Ref::NONE`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Node {
    pub(crate) lo: [[f32; WIDTH]; 3],
    pub(crate) hi: [[f32; WIDTH]; 3],
    pub(crate) child: [Ref; WIDTH],
}

/// Up to eight triangles. Unused lanes repeat a used one, but for the number.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Leaf {
    pub(crate) block: TriangleBlock,
    /// Indices into the soup, [`Leaf::NONE`] in unused lanes.
    pub(crate) id: [u32; WIDTH],
}

/// Triangles of a [`HalfLeaf`] at most.
const HALF: usize = 4;

/// A leaf of few triangles, as it is kept. A third of Sponza's leaves are; as whole ones they would take a sixth more memory.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct HalfLeaf {
    corner: [[[f32; HALF]; 3]; 3],
    id: [u32; HALF],
}

impl HalfLeaf {
    #[inline(always)]
    fn widen(&self) -> Leaf {
        let mut block = TriangleBlock { corner: [[[0.0; WIDTH]; 3]; 3] };
        let mut id = [Leaf::NONE; WIDTH];
        for (wide, corner) in block.corner.iter_mut().flatten().zip(self.corner.iter().flatten()) {
            wide[..HALF].copy_from_slice(corner);
            wide[HALF..].copy_from_slice(corner);
        }
        id[..HALF].copy_from_slice(&self.id);
        Leaf { block, id }
    }
}

impl Leaf {
    const NONE: u32 = u32::MAX;

    /// Used lanes; bits.
    #[inline(always)]
    pub(crate) fn live(&self) -> u8 {
        (0..WIDTH).fold(0, |live, i| live | u8::from(self.id[i] != Leaf::NONE) << i)
    }
}

impl Node {
    /// Used lanes; bits.
    #[inline(always)]
    pub(crate) fn live(&self) -> u32 {
        (0..WIDTH).fold(0, |live, i| live | u32::from(self.child[i] != Ref::NONE) << i)
    }
}

/// Points at a node or a leaf: top bit "leaf", then arena, then place in the arena.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Ref(u32);

impl Ref {
    const LEAF: u32 = 1 << 31;
    /// Points nowhere.
    const NONE: Ref = Ref(u32::MAX);

    pub(crate) fn is_leaf(self) -> bool {
        self.0 & Ref::LEAF != 0
    }

    /// Place of a leaf in its arena: the lowest bit says "half".
    fn whole(index: usize) -> u32 {
        (index << 1) as u32
    }

    fn half(index: usize) -> u32 {
        (index << 1 | 1) as u32
    }
}

/// Nodes and leaves that one task built.
#[derive(Debug, Default)]
struct Arena {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    halves: Vec<HalfLeaf>,
}

/// Smallest and largest coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) lo: [f32; 3],
    pub(crate) hi: [f32; 3],
}

impl Bounds {
    pub(crate) const EMPTY: Bounds = Bounds { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    #[inline(always)]
    pub(crate) fn add(&mut self, p: [f32; 3]) {
        for k in 0..3 {
            self.lo[k] = self.lo[k].min(p[k]);
            self.hi[k] = self.hi[k].max(p[k]);
        }
    }

    #[inline(always)]
    pub(crate) fn union(self, other: Bounds) -> Bounds {
        let mut all = self;
        all.add(other.lo);
        all.add(other.hi);
        all
    }
}

/// The hierarchy. Scratch memory is kept between builds.
#[derive(Debug)]
pub(crate) struct Bvh {
    arenas: Vec<Arena>,
    /// Arenas in use; the rest is kept memory. Arena 0 is the top of the tree.
    used: usize,
    root: Option<Ref>,
    pub(crate) bounds: Bounds,
    /// Bits of a [`Ref`] that say where in its arena.
    local_bits: u32,
    scratch: build::Scratch,
}

impl Default for Bvh {
    fn default() -> Self {
        let scratch = build::Scratch::default();
        Bvh { arenas: Vec::new(), used: 0, root: None, bounds: Bounds::EMPTY, local_bits: 0, scratch }
    }
}

impl Bvh {
    /// The root, `None` without triangles.
    pub(crate) fn root(&self) -> Option<Ref> {
        self.root
    }

    #[inline(always)]
    fn split(&self, r: Ref) -> (usize, usize) {
        let index = r.0 & !Ref::LEAF;
        ((index >> self.local_bits) as usize, (index & ((1 << self.local_bits) - 1)) as usize)
    }

    #[inline(always)]
    pub(crate) fn node(&self, r: Ref) -> &Node {
        let (arena, local) = self.split(r);
        &self.arenas[arena].nodes[local]
    }

    /// A leaf; one of few triangles is written to `wide`.
    #[inline(always)]
    pub(crate) fn leaf<'a>(&'a self, r: Ref, wide: &'a mut Option<Leaf>) -> &'a Leaf {
        let (arena, local) = self.split(r);
        let arena = &self.arenas[arena];
        if local & 1 == 1 { wide.insert(arena.halves[local >> 1].widen()) } else { &arena.leaves[local >> 1] }
    }

    /// Bytes of nodes and of leaves.
    pub(crate) fn bytes(&self) -> (usize, usize) {
        let arenas = &self.arenas[..self.used];
        let nodes: usize = arenas.iter().map(|a| a.nodes.len()).sum();
        let leaves = arenas.iter().map(|a| size_of_val(&a.leaves[..]) + size_of_val(&a.halves[..])).sum();
        (nodes * size_of::<Node>(), leaves)
    }

    /// Bytes of what only the build needs.
    pub(crate) fn scratch_bytes(&self) -> usize {
        self.scratch.bytes()
    }
}
