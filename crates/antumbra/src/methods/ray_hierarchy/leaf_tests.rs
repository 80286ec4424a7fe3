//! The leaf: the shared exact test, and the two that the paper speaks of (section 4.1), for comparison.
//!
//! Sources: Wald 2004, "Realtime Ray Tracing and Interactive Global Illumination", section 7.1 (projection along the
//! dominant axis); Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection". Both in f32, relative to
//! the light, without tolerances: neither is watertight along shared edges, and both confuse a sample with its own surface.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};

use super::build::Eight;
use super::options::LeafKind;
use crate::methods::leaf::{LeafCounts, LeafTest};
use crate::scene::Triangle;

type Point<S> = [f32x8<S>; 3];

/// One triangle at the leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf<'a> {
    exact: LeafTest<'a>,
    rough: Option<Rough>,
}

/// A test that is not exact.
#[derive(Clone, Copy, Debug)]
enum Rough {
    Wald(Wald),
    MollerTrumbore(MollerTrumbore),
}

/// Pairs that a test in plain f32 gets wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Mistakes {
    /// It says "blocked" and is wrong.
    pub(super) false_hits: u64,
    /// It says "not blocked" and is wrong.
    pub(super) false_misses: u64,
}

impl<'a> Leaf<'a> {
    /// `None` if the triangle is degenerate or edge-on.
    pub(super) fn new(t: &'a Triangle, light: [f32; 3], kind: LeafKind) -> Option<Leaf<'a>> {
        let exact = LeafTest::new(t, light)?;
        let rough = match kind {
            LeafKind::Exact => None,
            LeafKind::Wald => Some(Rough::Wald(Wald::new(t, light))),
            LeafKind::MollerTrumbore => Some(Rough::MollerTrumbore(MollerTrumbore::new(t, light))),
        };
        Some(Leaf { exact, rough })
    }

    /// Which of the rays `asked` does the triangle block? If `compare` is given, a rough test is held against the exact one.
    #[inline(always)]
    pub(super) fn eight<S: Simd>(
        &mut self,
        s: S,
        rays: &Eight,
        asked: u8,
        counts: &mut LeafCounts,
        compare: Option<&mut Mistakes>,
    ) -> u8 {
        let [x, y, z] = &rays.0;
        let mut hits = 0;
        if let Some(rough) = &self.rough {
            let p = [f32x8::load_array_ref(s, x), f32x8::load_array_ref(s, y), f32x8::load_array_ref(s, z)];
            hits = asked
                & match rough {
                    Rough::Wald(test) => test.lanes(s, p),
                    Rough::MollerTrumbore(test) => test.lanes(s, p),
                };
            if compare.is_none() {
                counts.leaf_tests += u64::from(asked.count_ones());
                counts.leaf_hits += u64::from(hits.count_ones());
                return hits;
            }
        }
        // With a comparison the leaf counters are those of the exact test.
        let right = self.exact.eight(s, x, y, z, asked, counts);
        if let Some(mistakes) = compare {
            mistakes.false_hits += u64::from((hits & !right).count_ones());
            mistakes.false_misses += u64::from((right & !hits).count_ones());
            return hits;
        }
        right
    }
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot<S: Simd>(a: Point<S>, b: [f32; 3]) -> f32x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn bits<S: Simd, M: SimdMask<S>>(m: M) -> u8 {
    m.to_bitmask() as u8
}

/// Wald's ten numbers: the plane divided by its largest component, and the two barycentric coordinates as linear functions
/// of the two other coordinates.
#[derive(Clone, Copy, Debug)]
struct Wald {
    light: [f32; 3],
    /// Dominant axis and the two others.
    axis: [usize; 3],
    /// Plane: `d_k + n_u d_u + n_v d_v = n_d`.
    n: [f32; 3],
    /// `beta = (h_u, h_v) · beta`, with h relative to corner a.
    beta: [f32; 2],
    gamma: [f32; 2],
    a: [f32; 2],
}

impl Wald {
    fn new(t: &Triangle, light: [f32; 3]) -> Wald {
        let a = sub(t[0], light);
        let (b, c) = (sub(t[2], t[0]), sub(t[1], t[0]));
        let n = cross(c, b);
        let k = (1..3).fold(0, |k, i| if n[i].abs() > n[k].abs() { i } else { k });
        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
        let det = b[u] * c[v] - b[v] * c[u];
        Wald {
            light,
            axis: [k, u, v],
            n: [n[u] / n[k], n[v] / n[k], (n[0] * a[0] + n[1] * a[1] + n[2] * a[2]) / n[k]],
            beta: [c[v] / det, -c[u] / det],
            gamma: [-b[v] / det, b[u] / det],
            a: [a[u], a[v]],
        }
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, s: S, p: Point<S>) -> u8 {
        let [k, u, v] = self.axis.map(|axis| p[axis] - self.light[axis]);
        let [nu, nv, nd] = self.n;
        let t = f32x8::splat(s, nd) / (k + u * nu + v * nv);
        let (hu, hv) = (t * u - self.a[0], t * v - self.a[1]);
        let beta = hu * self.beta[0] + hv * self.beta[1];
        let gamma = hu * self.gamma[0] + hv * self.gamma[1];
        bits(beta.simd_ge(0.0))
            & bits(gamma.simd_ge(0.0))
            & bits((beta + gamma).simd_le(1.0))
            & bits(t.simd_gt(0.0))
            & bits(t.simd_lt(1.0))
    }
}

/// Nothing is prepared but differences of the corners.
#[derive(Clone, Copy, Debug)]
struct MollerTrumbore {
    light: [f32; 3],
    edge: [[f32; 3]; 2],
    /// From corner a to the light.
    back: [f32; 3],
}

impl MollerTrumbore {
    fn new(t: &Triangle, light: [f32; 3]) -> MollerTrumbore {
        MollerTrumbore { light, edge: [sub(t[1], t[0]), sub(t[2], t[0])], back: sub(light, t[0]) }
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, s: S, p: Point<S>) -> u8 {
        let d = [0, 1, 2].map(|k| p[k] - self.light[k]);
        let [e1, e2] = self.edge;
        let h = [d[1] * e2[2] - d[2] * e2[1], d[2] * e2[0] - d[0] * e2[2], d[0] * e2[1] - d[1] * e2[0]];
        let inverse = f32x8::splat(s, 1.0) / dot(h, e1);
        let u = dot(h, self.back) * inverse;
        let q = cross(self.back, e1);
        let v = dot(d, q) * inverse;
        let t = inverse * (q[0] * e2[0] + q[1] * e2[1] + q[2] * e2[2]);
        bits(u.simd_ge(0.0))
            & bits(v.simd_ge(0.0))
            & bits((u + v).simd_le(1.0))
            & bits(t.simd_gt(0.0))
            & bits(t.simd_lt(1.0))
    }
}
