//! The leaf of every method that brings samples to a triangle: the shared test, stage by stage, with its counters.

use antumbra_predicates::Triangle;
use antumbra_predicates::resolve::Decided;
use antumbra_predicates::single::{LazyResolver, TriangleTest};
use fearless_simd::{Simd, SimdBase, f32x8};

use super::StatsBuilder;

/// Work at the leaves, under the names that all methods share.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LeafCounts {
    /// (triangle, sample) pairs tested.
    pub(crate) leaf_tests: u64,
    /// Of those: blocked.
    pub(crate) leaf_hits: u64,
    /// Decided in f32.
    pub(crate) filter_f32_sure: u64,
    /// Taken to f64.
    pub(crate) filter_f64: u64,
    /// Of those: taken to exact arithmetic.
    pub(crate) filter_exact: u64,
}

impl LeafCounts {
    pub(crate) fn add(&mut self, other: &LeafCounts) {
        self.leaf_tests += other.leaf_tests;
        self.leaf_hits += other.leaf_hits;
        self.filter_f32_sure += other.filter_f32_sure;
        self.filter_f64 += other.filter_f64;
        self.filter_exact += other.filter_exact;
    }

    pub(crate) fn report(&self, stats: &mut StatsBuilder) {
        stats.counter("leaf_tests", self.leaf_tests);
        stats.counter("leaf_hits", self.leaf_hits);
        stats.counter("filter_f32_sure", self.filter_f32_sure);
        stats.counter("filter_f64", self.filter_f64);
        stats.counter("filter_exact", self.filter_exact);
    }
}

/// One triangle at the leaves: its f32 test, and the later stages when they are needed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafTest<'a> {
    triangle: &'a Triangle,
    test: TriangleTest,
    resolver: LazyResolver,
}

impl<'a> LeafTest<'a> {
    /// `None` if the triangle is degenerate or edge-on: then it blocks nothing.
    #[inline]
    pub(crate) fn new(triangle: &'a Triangle, light: [f32; 3]) -> Option<LeafTest<'a>> {
        let test = TriangleTest::new(triangle, light)?;
        Some(LeafTest { triangle, test, resolver: LazyResolver::new(light) })
    }

    /// Which of up to eight samples (`asked`: one bit each) does the triangle block? Exact. `x`, `y`, `z` hold eight
    /// coordinates each; those not asked may be anything.
    #[inline(always)]
    pub(crate) fn eight<S: Simd>(
        &mut self,
        s: S,
        x: &[f32; 8],
        y: &[f32; 8],
        z: &[f32; 8],
        asked: u8,
        counts: &mut LeafCounts,
    ) -> u8 {
        let p = [f32x8::load_array_ref(s, x), f32x8::load_array_ref(s, y), f32x8::load_array_ref(s, z)];
        let lanes = self.test.lanes(s, p);
        let mut hits = lanes.blocked & asked;
        let mut open = lanes.unsure & asked;
        counts.leaf_tests += u64::from(asked.count_ones());
        counts.filter_f32_sure += u64::from((asked & !open).count_ones());
        while open != 0 {
            let lane = open.trailing_zeros() as usize;
            open &= open - 1;
            if self.one([x[lane], y[lane], z[lane]], counts) {
                hits |= 1 << lane;
            }
        }
        counts.leaf_hits += u64::from(hits.count_ones());
        hits
    }

    /// The f64 and exact stages for one sample.
    #[inline]
    pub(crate) fn one(&mut self, p: [f32; 3], counts: &mut LeafCounts) -> bool {
        counts.filter_f64 += 1;
        let Some(resolver) = self.resolver.get(0, self.triangle) else { return false };
        let (blocks, decided) = resolver.blocks(p);
        counts.filter_exact += u64::from(decided == Decided::Exact);
        blocks
    }
}
