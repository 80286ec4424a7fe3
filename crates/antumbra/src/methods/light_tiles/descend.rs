//! A large triangle descends the tree of nodes, sixteen children at a time.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use antumbra_predicates::Triangle;
use antumbra_predicates::filter::{KAPPA, LIMIT, TINY};
use antumbra_predicates::tile::{NEAREST, WIDEN};
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::bin::{Counts, Entry};
use super::frame::Frame;
use super::grid::{NODE, Node, Tiles};
use super::lists::Lists;

/// A triangle in the frame of a face: bounds of its directions and the four tests, as in
/// [`antumbra_predicates::tile::TileBlock`], one triangle instead of eight: all lanes are the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caster<S: Simd> {
    /// Least x, largest x, least y, largest y, largest r.
    bounds: [f32x8<S>; 5],
    m: [[f32x8<S>; 3]; 4],
    margin: [f32x8<S>; 4],
    det: f32x8<S>,
    det_margin: f32x8<S>,
    /// The facing is certain: the tests may be used.
    certain: bool,
}

impl<S: Simd> Caster<S> {
    #[inline(always)]
    pub(super) fn new(s: S, triangle: &Triangle, light: [f32; 3], face: usize) -> Caster<S> {
        let frame = Frame::of(face);
        let l = frame.turn(light);
        let raw = triangle.map(|p| frame.turn(p));
        let (zero, one) = (f32x8::splat(s, 0.0), f32x8::splat(s, 1.0));
        let (tiny, kappa) = (f32x8::splat(s, TINY), f32x8::splat(s, KAPPA));
        let (mut rel, mut edge) = ([[zero; 3]; 3], [[zero; 3]; 3]);
        let (mut largest, mut front) = (zero, true);
        for i in 0..3 {
            let (from, to) = (raw[i], raw[(i + 1) % 3]);
            for k in 0..3 {
                rel[i][k] = f32x8::splat(s, from[k]) - l[k];
                edge[i][k] = f32x8::splat(s, to[k]) - from[k];
                largest = largest.max(rel[i][k].abs());
            }
            front &= rel[i][2][0] >= NEAREST;
        }
        let tame = largest[0] <= LIMIT;
        let n = cross(edge[2], edge[0]);
        let n_mag = magnitude(edge[2], edge[0], tiny);
        let det = n[2].mul_add(rel[0][2], n[1].mul_add(rel[0][1], n[0] * rel[0][0]));
        let [x, y, z] = [rel[0][0].abs(), rel[0][1].abs(), rel[0][2].abs()];
        let det_bound = kappa.mul_add(n_mag[2].mul_add(z, n_mag[1].mul_add(y, n_mag[0] * x)), tiny);
        let sign = if det[0] < 0.0 { -1.0 } else { 1.0 };
        let mut m = [cross(rel[0], edge[0]), cross(rel[1], edge[1]), cross(rel[2], edge[2]), n];
        let mags = [
            magnitude(rel[0], edge[0], tiny),
            magnitude(rel[1], edge[1], tiny),
            magnitude(rel[2], edge[2], tiny),
            n_mag,
        ];
        let mut margin = [zero; 4];
        for k in 0..4 {
            m[k] = [m[k][0] * sign, m[k][1] * sign, m[k][2] * sign];
            margin[k] = (kappa + kappa) * (mags[k][0] + mags[k][1] + mags[k][2]);
        }
        let infinity = f32x8::splat(s, f32::INFINITY);
        let mut bounds = [-infinity, infinity, -infinity, infinity, infinity];
        if tame && front {
            let r = [one / rel[0][2], one / rel[1][2], one / rel[2][2]];
            let widen = f32x8::splat(s, WIDEN);
            for k in 0..2 {
                let c = [rel[0][k] * r[0], rel[1][k] * r[1], rel[2][k] * r[2]];
                let (lo, hi) = (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2]));
                bounds[2 * k] = lo - lo.abs().mul_add(widen, widen);
                bounds[2 * k + 1] = hi + hi.abs().mul_add(widen, widen);
            }
            let r = r[0].max(r[1]).max(r[2]);
            bounds[4] = r.mul_add(widen, r);
        }
        Caster {
            bounds,
            m,
            margin,
            det: det * sign,
            det_margin: det_bound + det_bound,
            certain: tame && det.abs().simd_gt(det_bound).any_true(),
        }
    }

    /// Of eight children: which may the triangle block, which does it cover? Bits are children.
    #[inline(always)]
    fn against(&self, s: S, node: &Node, first: usize) -> (u8, u8) {
        let lo = [
            part(s, &node.bounds[0], first),
            part(s, &node.bounds[1], first),
            part(s, &node.bounds[2], first),
        ];
        let hi = [
            part(s, &node.bounds[3], first),
            part(s, &node.bounds[4], first),
            part(s, &node.bounds[5], first),
        ];
        let near = hi[0].simd_ge(self.bounds[0])
            & lo[0].simd_le(self.bounds[1])
            & hi[1].simd_ge(self.bounds[2])
            & lo[1].simd_le(self.bounds[3])
            & lo[2].simd_le(self.bounds[4]);
        let near = near.to_bitmask() as u8;
        if near == 0 || !self.certain {
            return (near, 0);
        }
        let (xc, xh) = middle(s, lo[0], hi[0]);
        let (yc, yh) = middle(s, lo[1], hi[1]);
        let zero = f32x8::splat(s, 0.0);
        let (mut out, mut least) = (zero, f32x8::splat(s, f32::INFINITY));
        for k in 0..4 {
            let m = self.m[k];
            let value = m[1].mul_add(yc, m[0].mul_add(xc, m[2]));
            let reach = m[1].abs().mul_add(yh, m[0].abs().mul_add(xh, self.margin[k]));
            if k == 3 {
                let reach = hi[2].mul_add(self.det_margin, reach);
                out = out.min((value - self.det * lo[2]) + reach);
                least = least.min((value - self.det * hi[2]) - reach);
            } else {
                out = out.min(value + reach);
                least = least.min(value - reach);
            }
        }
        let maybe = near & !(out.simd_lt(0.0).to_bitmask() as u8);
        (maybe, maybe & least.simd_gt(0.0).to_bitmask() as u8)
    }
}

#[inline(always)]
fn cross<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [a[1].mul_sub(b[2], a[2] * b[1]), a[2].mul_sub(b[0], a[0] * b[2]), a[0].mul_sub(b[1], a[1] * b[0])]
}

/// Sums of absolute products of the cross product, underflow covered.
#[inline(always)]
fn magnitude<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3], tiny: f32x8<S>) -> [f32x8<S>; 3] {
    let (a, b) = ([a[0].abs(), a[1].abs(), a[2].abs()], [b[0].abs(), b[1].abs(), b[2].abs()]);
    [
        a[1].mul_add(b[2], a[2].mul_add(b[1], tiny)),
        a[2].mul_add(b[0], a[0].mul_add(b[2], tiny)),
        a[0].mul_add(b[1], a[1].mul_add(b[0], tiny)),
    ]
}

#[inline(always)]
fn part<S: Simd>(s: S, v: &[f32; 16], first: usize) -> f32x8<S> {
    f32x8::from_slice(s, &v[first..first + 8])
}

/// Middle and half size, rounded up.
#[inline(always)]
fn middle<S: Simd>(s: S, lo: f32x8<S>, hi: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
    let c = (lo + hi) * 0.5;
    let h = (hi - c).max(c - lo);
    (c, h.mul_add(f32x8::splat(s, f32::EPSILON), h))
}

/// Where a descent leaves its results.
#[derive(Debug)]
pub(super) struct Target<'a> {
    pub(super) tiles: &'a Tiles,
    pub(super) covered: &'a [AtomicBool],
    pub(super) id: u32,
    pub(super) ids: &'a mut Lists<Entry>,
    pub(super) counts: &'a mut Counts,
}

impl Target<'_> {
    fn cover(&mut self, entry: u32) {
        if entry & NODE == 0 {
            self.covered[entry as usize].store(true, Relaxed);
            return;
        }
        let node = &self.tiles.nodes[(entry & !NODE) as usize];
        for i in 0..node.count {
            self.cover(node.child[i]);
        }
    }
}

/// Visits all entries on the stack and below.
#[inline(always)]
pub(super) fn descend<S: Simd>(s: S, caster: &Caster<S>, stack: &mut Vec<u32>, target: &mut Target<'_>) {
    while let Some(entry) = stack.pop() {
        if entry & NODE == 0 {
            // A tile that was an entry itself: tested in the tile pass.
            if caster.bounds[4][0] >= target.tiles.region[entry as usize].lo[2]
                && !target.covered[entry as usize].load(Relaxed)
            {
                target.ids.push(entry, Entry::large(target.id));
            }
            continue;
        }
        let node = &target.tiles.nodes[(entry & !NODE) as usize];
        target.counts.node_visits += 1;
        for first in [0, 8] {
            if first >= node.count {
                break;
            }
            let exists = 0xffu32 >> (8 - (node.count - first).min(8));
            let (maybe, covers) = caster.against(s, node, first);
            let mut left = u32::from(maybe) & exists;
            while left != 0 {
                let bit = left.trailing_zeros() as usize;
                left &= left - 1;
                let child = node.child[first + bit];
                if covers >> bit & 1 == 1 {
                    target.counts.node_accept += 1;
                    target.cover(child);
                } else if child & NODE != 0 {
                    stack.push(child);
                } else if !target.covered[child as usize].load(Relaxed) {
                    target.ids.push(child, Entry::large(target.id));
                }
            }
        }
    }
}
