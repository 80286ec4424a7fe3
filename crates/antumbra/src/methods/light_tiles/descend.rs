//! A large triangle descends the tree of nodes, sixteen children at a time.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use antumbra_predicates::Triangle;
use antumbra_predicates::aim::seen_bounds;
use antumbra_predicates::filter::{KAPPA, LIMIT, TINY};
use antumbra_predicates::vector::{abs, cross, cross_abs, dot, max3, scale, splat3, sub};
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::bin::{Counts, Entry};
use super::grid::{NODE, Node, Tiles};
use super::lists::Lists;
use super::sight::Sight;

/// A triangle in the frame of a face: bounds of its directions and the four tests, as in
/// [`antumbra_predicates::tile::TileBlock`], one triangle instead of eight: all lanes are the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caster<S: Simd> {
    /// Least x, largest x, least y, largest y, largest r.
    bounds: [f32x8<S>; 5],
    /// Normals; their third coordinate as the aim has it.
    m: [[f32x8<S>; 3]; 4],
    margin: [f32x8<S>; 4],
    det: f32x8<S>,
    det_margin: f32x8<S>,
    /// The facing is certain: the tests may be used.
    certain: bool,
}

impl<S: Simd> Caster<S> {
    /// `FAR` may be false if the aim is straight: less work.
    #[inline(always)]
    pub(super) fn new<const FAR: bool>(s: S, triangle: &Triangle, sight: &Sight) -> Caster<S> {
        let Sight { frame, aim, depth, weight, .. } = sight;
        let [a, b, c] = triangle;
        let raw = [splat3(s, frame.turn(*a)), splat3(s, frame.turn(*b)), splat3(s, frame.turn(*c))];
        let l = splat3(s, aim.light());
        let rel = [sub(raw[0], l), sub(raw[1], l), sub(raw[2], l)];
        let edge = [sub(raw[1], raw[0]), sub(raw[2], raw[1]), sub(raw[0], raw[2])];
        let rel_abs = [abs(rel[0]), abs(rel[1]), abs(rel[2])];
        let edge_abs = [abs(edge[0]), abs(edge[1]), abs(edge[2])];
        let (zero, tiny, kappa) = (f32x8::splat(s, 0.0), f32x8::splat(s, TINY), f32x8::splat(s, KAPPA));
        let tame = max3(rel_abs[0]).max(max3(rel_abs[1])).max(max3(rel_abs[2])).simd_le(LIMIT).all_true();
        let n = cross(edge[2], edge[0]);
        let n_mag = cross_abs(edge_abs[2], edge_abs[0], tiny);
        let det = dot(n, rel[0]);
        let det_bound = kappa.mul_add(dot(n_mag, rel_abs[0]), tiny);
        let sign = if det[0] < 0.0 { -1.0 } else { 1.0 };
        let mut m = [cross(rel[0], edge[0]), cross(rel[1], edge[1]), cross(rel[2], edge[2]), n];
        let mut mags = [
            cross_abs(rel_abs[0], edge_abs[0], tiny),
            cross_abs(rel_abs[1], edge_abs[1], tiny),
            cross_abs(rel_abs[2], edge_abs[2], tiny),
            n_mag,
        ];
        if FAR {
            for k in 0..4 {
                (m[k][2], mags[k][2]) = aim.constant(s, &raw, &edge, k);
                mags[k] = [mags[k][0] * weight[0], mags[k][1] * weight[1], mags[k][2]];
            }
        }
        let mut margin = [zero; 4];
        for k in 0..4 {
            m[k] = scale(m[k], f32x8::splat(s, sign));
            margin[k] = (kappa + kappa) * (mags[k][0] + mags[k][1] + mags[k][2]);
        }
        let infinity = f32x8::splat(s, f32::INFINITY);
        let open = [-infinity, infinity, -infinity, infinity, infinity];
        let bounds = if tame { seen_bounds::<S, FAR>(s, aim, *depth, &raw) } else { open };
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
    pub(super) fn against(&self, s: S, node: &Node, first: usize) -> (u8, u8) {
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
    pub(super) ids: &'a mut Lists<Entry, 14>,
    pub(super) counts: &'a mut Counts,
}

impl Target<'_> {
    fn cover(&mut self, entry: u32) {
        if entry & NODE == 0 {
            // Writing would take the cache line away from all others.
            let covered = &self.covered[entry as usize];
            if !covered.load(Relaxed) {
                covered.store(true, Relaxed);
            }
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
