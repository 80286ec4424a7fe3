//! The leaves of a tile while its triangles go by: what is known of their samples, and what is left to f64.

use antumbra_predicates::plane::PlaneResolver;
use antumbra_predicates::resolve::{Decided, Resolver};
use antumbra_predicates::tile::Part;
use fearless_simd::{Simd, SimdBase, SimdMask, f32x8, u32x16};

use super::boxes::{Boxes, Coarse, LEAVES};
use super::chunk::Setup;
use super::layout::HALF;
use super::leaf::{LOOSE, LOW, Leaf, Loose, load_loose};
use super::leaves::{bounds, directions};
use super::tuning::AHEAD;
use super::work::{Counts, Pass, ask_for};

/// A triangle and the samples of a leaf for which f32 was not enough.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub(super) id: u32,
    pub(super) leaf: u32,
    pub(super) plane: u32,
    pub(super) sides: u32,
}

/// Samples of a leaf: world coordinates of two times sixteen. What lanes without a sample hold does not matter.
pub(super) type Points = [[[f32; HALF]; 2]; 3];

/// The leaves of a tile while its triangles go by.
#[derive(Debug, Default)]
pub(super) struct State {
    pub(super) parts: Vec<Part>,
    pub(super) boxes: Vec<Boxes>,
    /// Samples that are not known to be in shadow, for whole 64s of leaves. Those of half a block are the first sixteen, whichever half it is.
    pub(super) alive: Vec<u32>,
    /// Of each 64 leaves those that [`State::find_alive`] has found last; bits.
    pub(super) there: Vec<u64>,
    pub(super) points: Vec<Points>,
    /// x and y of the samples, in tiles of many triangles, whose leaves have sixteen at most.
    pub(super) seen: Vec<[[f32; HALF]; 2]>,
    pub(super) open: Vec<Open>,
}

impl State {
    /// Nothing is known yet.
    #[inline(always)]
    pub(super) fn start<S: Simd>(&mut self, s: S, setup: &Setup<'_>, leaves: &[Leaf]) {
        self.make_room(leaves.len());
        for (i, leaf) in leaves.iter().enumerate() {
            self.push(s, setup, i, leaf, leaf.sides(s));
        }
        self.alive.resize(leaves.len().next_multiple_of(LEAVES), 0);
        self.find_alive(s);
    }

    /// The same for a dense tile, where leaves have sixteen samples at most: loads them as well, and bounds each half of a block by itself.
    #[inline(always)]
    pub(super) fn start_dense<S: Simd>(
        &mut self,
        s: S,
        pass: &Pass<'_>,
        setup: &Setup<'_>,
        leaves: &[Leaf],
        loose: &[Loose],
    ) {
        debug_assert!(leaves.iter().all(|leaf| !leaf.is_whole()));
        self.make_room(leaves.len());
        if self.seen.len() < leaves.len() {
            self.seen.resize(leaves.len(), [[0.0; HALF]; 2]);
        }
        for (i, leaf) in leaves.iter().enumerate() {
            ask_for(pass, leaves.get(i + 2 * AHEAD));
            let points = load_half(s, pass, leaf, loose);
            let c = directions(s, setup.sight, &points);
            for k in 0..3 {
                s.combine_f32x8(points[k][0], points[k][1]).store_array(&mut self.points[i][k][0]);
            }
            s.combine_f32x8(c[0][0], c[0][1]).store_array(&mut self.seen[i][0]);
            s.combine_f32x8(c[1][0], c[1][1]).store_array(&mut self.seen[i][1]);
            let is_half = leaf.mask() >> shift(leaf) == LOW;
            let sides = if is_half { bounds(s, &c) } else { leaf.sides(s) };
            self.push(s, setup, i, leaf, sides);
        }
        self.alive.resize(leaves.len().next_multiple_of(LEAVES), 0);
        self.find_alive(s);
    }

    fn make_room(&mut self, leaves: usize) {
        self.parts.clear();
        self.alive.clear();
        self.open.clear();
        // What is in them does not matter yet.
        self.boxes.resize(leaves.div_ceil(LEAVES), Boxes::ZERO);
        if self.points.len() < leaves {
            self.points.resize(leaves, [[[0.0; HALF]; 2]; 3]);
        }
    }

    #[inline(always)]
    fn push<S: Simd>(&mut self, s: S, setup: &Setup<'_>, i: usize, leaf: &Leaf, sides: f32x8<S>) {
        self.boxes[i / LEAVES].set(s, i % LEAVES, sides, &setup.steps);
        self.parts.push(Part::new(s, sides));
        self.alive.push(leaf.mask() >> shift(leaf));
    }

    /// Loads the samples of some leaves, and asks for those of the next.
    #[inline(always)]
    pub(super) fn load<S: Simd>(
        &mut self,
        s: S,
        pass: &Pass<'_>,
        leaves: &[Leaf],
        loose: &[Loose],
        range: std::ops::Range<usize>,
    ) {
        for i in range {
            ask_for(pass, leaves.get(i + AHEAD));
            load_points(s, pass, &leaves[i], loose, &mut self.points[i]);
        }
    }

    /// Finds the leaves with samples that are not known to be in shadow. False if there is none.
    #[inline(always)]
    pub(super) fn find_alive<S: Simd>(&mut self, s: S) -> bool {
        self.there.clear();
        let mut any = 0;
        for alive in self.alive.as_chunks::<LEAVES>().0 {
            let mut there = 0;
            for (i, alive) in alive.as_chunks().0.iter().enumerate() {
                there |= u32x16::load_array_ref(s, alive).simd_gt(0).to_bitmask() << (16 * i);
            }
            self.there.push(there);
            any |= there;
        }
        any != 0
    }

    /// Whether a block of triangles may meet a leaf that [`State::find_alive`] has found.
    #[inline(always)]
    pub(super) fn meets<S: Simd>(&self, s: S, hull: Coarse) -> bool {
        let mut near = 0;
        for (boxes, there) in self.boxes.iter().zip(&self.there) {
            near |= boxes.near(s, hull) & there;
        }
        near != 0
    }

    /// Decides what f32 could not, and notes the samples that are in shadow.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(
        &mut self,
        s: S,
        pass: &Pass<'_>,
        leaves: &[Leaf],
        loose: &[Loose],
        words: &mut [u32],
        counts: &mut Counts,
    ) {
        let State { alive, points, open, .. } = self;
        for o in open.iter() {
            let leaf = o.leaf as usize;
            let (plane, sides) = (o.plane & alive[leaf], o.sides & alive[leaf]);
            if plane | sides != 0 {
                alive[leaf] &= !resolve(s, pass, o.id, &points[leaf], plane, sides, counts);
            }
        }
        for (leaf, alive) in leaves.iter().zip(alive) {
            note(words, loose, leaf, leaf.mask() & !(*alive << shift(leaf)));
        }
    }
}

/// Of half a block that is the right one, how far its samples are moved to be the first.
#[inline(always)]
fn shift(leaf: &Leaf) -> usize {
    if leaf.mask() & LOW == 0 { HALF } else { 0 }
}

#[inline(always)]
fn load_points<S: Simd>(s: S, pass: &Pass<'_>, leaf: &Leaf, loose: &[Loose], points: &mut Points) {
    if leaf.is_whole() {
        let whole = pass.layout.load(s, pass.positions, leaf.block() as usize);
        for k in 0..3 {
            for i in 0..2 {
                s.combine_f32x8(whole[k][2 * i], whole[k][2 * i + 1]).store_array(&mut points[k][i]);
            }
        }
        return;
    }
    let half = load_half(s, pass, leaf, loose);
    for k in 0..3 {
        s.combine_f32x8(half[k][0], half[k][1]).store_array(&mut points[k][0]);
    }
}

/// World coordinates of up to sixteen samples.
#[inline(always)]
fn load_half<S: Simd>(s: S, pass: &Pass<'_>, leaf: &Leaf, loose: &[Loose]) -> [[f32x8<S>; 2]; 3] {
    let block = leaf.block();
    if block & LOOSE != 0 {
        let first = (block & !LOOSE) as usize;
        load_loose(s, &loose[first..loose.len().min(first + HALF)])
    } else {
        pass.layout.load_half(s, pass.positions, block as usize, usize::from(leaf.mask() & LOW == 0))
    }
}

/// The samples that an open triangle blocks: f64, then exact arithmetic. `plane` and `sides` are those to decide.
#[inline(never)]
fn resolve<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    id: u32,
    p: &Points,
    plane: u32,
    sides: u32,
    counts: &mut Counts,
) -> u32 {
    s.vectorize(
        #[inline(always)]
        || {
            let triangle = &pass.triangles[id as usize];
            let mut blocked = 0;
            let mut hard = sides;
            counts.leaf.filter_f64 += u64::from((plane | hard).count_ones());
            if plane != 0 {
                if let Some(resolver) = PlaneResolver::new(triangle, pass.light) {
                    for v in 0..2 {
                        for half in 0..2 {
                            let shift = HALF * v + 8 * half;
                            if plane >> shift & 0xff == 0 {
                                continue;
                            }
                            counts.plane_f64 += 1;
                            let at = |v: &[f32; HALF]| f32x8::from_slice(s, &v[8 * half..8 * half + 8]);
                            let (beyond, unsure) =
                                resolver.lanes(s, [at(&p[0][v]), at(&p[1][v]), at(&p[2][v])]);
                            blocked |= plane & u32::from(beyond) << shift;
                            hard |= plane & u32::from(unsure) << shift;
                        }
                    }
                } else {
                    hard |= plane;
                }
            }
            if hard != 0
                && let Some(resolver) = Resolver::new(triangle, pass.light)
            {
                for i in (0..2 * HALF).filter(|i| hard >> i & 1 == 1) {
                    let (blocks, decided) = resolver.blocks([
                        p[0][i / HALF][i % HALF],
                        p[1][i / HALF][i % HALF],
                        p[2][i / HALF][i % HALF],
                    ]);
                    counts.leaf.filter_exact += u64::from(decided == Decided::Exact);
                    blocked |= u32::from(blocks) << i;
                }
            }
            blocked
        },
    )
}

/// Notes samples of a leaf that are in shadow.
#[inline(always)]
fn note(words: &mut [u32], loose: &[Loose], leaf: &Leaf, shadowed: u32) {
    if shadowed == 0 {
        return;
    }
    if leaf.block() & LOOSE == 0 {
        words[leaf.block() as usize] |= shadowed;
        return;
    }
    let first = (leaf.block() & !LOOSE) as usize;
    for i in (0..HALF).filter(|i| shadowed >> i & 1 == 1) {
        let (block, sample) = loose[first + i].slot();
        words[block] |= 1 << sample;
    }
}
