//! One face against the samples of a packet: in f32 relative to the packet, then in f64, then exactly.
//!
//! Divided by `w`, and measured from the middle of the packet's region in units of its half sides, a functional is
//!
//! ```text
//! n · p / w = c + x u + y v      c = n · (middle, 1)   x = n_x half_x   y = n_y half_y   |u|, |v| ≤ 1
//! ```
//!
//! and its place against K gets one more term, `K / w = K (middle of 1/w) + K half t`. So f32 need not resolve the scene but
//! only the packet: `c`, `x`, `y` are of one size wherever the outline of a face crosses it.
//!
//! # Error bound
//!
//! The node test's margin covers everything up to `c` and the exact offsets of a sample (`face.rs`). Beyond that, with h = 2^-24:
//! `c` is rounded to f32 once and goes through at most three sums, 4 h; a product has two rounded factors and its own rounding, and
//! goes through three sums at most, 6 h. The sum stays within 6.01 h (|c| + |x| + |y| + |K half|); fused or not makes it smaller, not
//! larger. [`F32`] = 2^-21 = 8 h. Each functional is divided by its bound, in f64, which adds parts in 2^50: then more than 1
//! is certainly positive, less than -1 certainly negative. What underflows in f32 is off by 2^-149, against 1.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, i32x8};

use super::face::{Face, Faces, MARGIN};
use super::tiles::{Packet, Region};
use super::traverse::Counts;
use super::tuning::PACKET;

/// Lanes of a vector of samples.
pub(super) const LANES: usize = 8;

/// Error of a functional in f32, in parts of the sum of its absolute terms.
const F32: f64 = 1.0 / (1u64 << 21) as f64;

/// Coefficients beyond this, or none at all, mean that f32 knows nothing: sound ones are at most 2^21.
const SOUND: f32 = (1u32 << 24) as f32;

/// The samples of a packet as offsets from the middle of its region, in half sides.
pub(super) struct Offsets {
    at: [[f32; PACKET]; 3],
}

impl Offsets {
    pub(super) fn new(packet: &Packet, region: &Region) -> Offsets {
        let mut at = [[0.0; PACKET]; 3];
        for i in 0..packet.count {
            // The same quotients as those that the region bounds.
            let w = packet.w[i];
            let v = [packet.x[i] / w, packet.y[i] / w, 1.0 / w];
            for k in 0..3 {
                if region.half[k] > 0.0 {
                    at[k][i] = ((v[k] - region.middle[k]) / region.half[k]) as f32;
                }
            }
        }
        Offsets { at }
    }
}

/// Five functionals, each in units of its error bound: the four of the face, and its place with the sign that counts.
struct Local {
    c: [f32; 5],
    x: [f32; 5],
    y: [f32; 5],
    /// Of the place alone.
    t: f32,
}

impl Local {
    /// `None` if f32 is no help.
    #[inline(always)]
    fn new(face: &Face, pass: bool, region: &Region) -> Option<Local> {
        let margin = MARGIN * (face.mag * region.scale + face.k_mag * region.inverse[1]);
        let [mx, my, mt] = region.middle;
        let [hx, hy, ht] = region.half;
        let (mut c, mut x, mut y) = ([0.0; 5], [0.0; 5], [0.0; 5]);
        for i in 0..4 {
            c[i] = face.n[0][i] * mx + face.n[1][i] * my + face.n[2][i];
            x[i] = face.n[0][i] * hx;
            y[i] = face.n[1][i] * hy;
        }
        let sign = if pass { 1.0 } else { -1.0 };
        let far = face.k == f64::INFINITY;
        // A face at infinity is beyond every sample: its place is never in question.
        let (k, t) = if far { (0.0, 0.0) } else { (face.k * mt, face.k * ht) };
        (c[4], x[4], y[4]) = (sign * (c[3] - k), sign * x[3], sign * y[3]);
        let t = -sign * t;
        let (mut cs, mut xs, mut ys, mut ts) = ([0.0; 5], [0.0; 5], [0.0; 5], 0.0);
        let mut size = 0.0f32;
        for i in 0..5 {
            let last = if i == 4 { t } else { 0.0 };
            let bound = margin + F32 * (c[i].abs() + x[i].abs() + y[i].abs() + last.abs());
            let unit = 1.0 / bound;
            (cs[i], xs[i], ys[i]) = ((c[i] * unit) as f32, (x[i] * unit) as f32, (y[i] * unit) as f32);
            ts = (last * unit) as f32;
            size += cs[i].abs() + xs[i].abs() + ys[i].abs() + ts.abs();
        }
        if far {
            (cs[4], xs[4], ys[4], ts) = (2.0, 0.0, 0.0, 0.0);
        }
        // NaN fails, too.
        (size < SOUND).then_some(Local { c: cs, x: xs, y: ys, t: ts })
    }
}

/// A packet on which faces are counted.
pub(super) struct Leaf<'a> {
    pub(super) decide: &'a Faces<'a>,
    pub(super) positions: &'a [[f32; 3]],
    pub(super) packet: &'a Packet,
    /// Where the samples have a region.
    pub(super) offsets: Option<(&'a Offsets, &'a Region)>,
    pub(super) count: [i32; PACKET],
}

impl Leaf<'_> {
    /// Adds the face to the counters of all samples that it is crossed for.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, s: S, face: &Face, counts: &mut Counts) {
        let Packet { count: samples, .. } = *self.packet;
        counts.leaf_tests += samples as u64;
        let Some((offsets, region)) = self.offsets else { return self.add_one_by_one(face, counts) };
        let Some(local) = Local::new(face, self.decide.pass, region) else {
            return self.add_one_by_one(face, counts);
        };
        let Local { c, x, y, t } = &local;
        let weight = i32x8::splat(s, face.weight);
        let zero = i32x8::splat(s, 0);
        for base in (0..samples).step_by(LANES) {
            let u = f32x8::from_slice(s, &offsets.at[0][base..base + LANES]);
            let v = f32x8::from_slice(s, &offsets.at[1][base..base + LANES]);
            let w = f32x8::from_slice(s, &offsets.at[2][base..base + LANES]);
            let f0 = v.mul_add(y[0], u.mul_add(x[0], c[0]));
            let f1 = v.mul_add(y[1], u.mul_add(x[1], c[1]));
            let f2 = v.mul_add(y[2], u.mul_add(x[2], c[2]));
            let f3 = v.mul_add(y[3], u.mul_add(x[3], c[3]));
            let f4 = w.mul_add(*t, v.mul_add(y[4], u.mul_add(x[4], c[4])));
            let low = f0.min(f1).min(f2.min(f3)).min(f4);
            let crossed = low.simd_gt(1.0);
            let at = &mut self.count[base..base + LANES];
            (i32x8::from_slice(s, at) + crossed.select(weight, zero)).store_slice(at);
            let used = (1u64 << (samples - base).min(LANES)) - 1;
            let crossed = crossed.to_bitmask() & used;
            let mut open = !(crossed | low.simd_lt(-1.0).to_bitmask()) & used;
            counts.leaf_hits += u64::from(crossed.count_ones());
            while open != 0 {
                let lane = base + open.trailing_zeros() as usize;
                open &= open - 1;
                self.add_one(face, lane, counts);
            }
        }
    }

    #[cold]
    fn add_one_by_one(&mut self, face: &Face, counts: &mut Counts) {
        for lane in 0..self.packet.count {
            self.add_one(face, lane, counts);
        }
    }

    /// The f64 stage, with the bound that `face.rs` derives, and the exact one.
    #[inline(never)]
    fn add_one(&mut self, face: &Face, lane: usize, counts: &mut Counts) {
        counts.filter_f64 += 1;
        let p = [self.packet.x[lane], self.packet.y[lane], self.packet.w[lane]];
        let at = |f: usize| p[2] * face.n[2][f] + p[1] * face.n[1][f] + p[0] * face.n[0][f];
        let place = at(3) - face.k;
        let place = if self.decide.pass { place } else { -place };
        let low = at(0).min(at(1)).min(at(2)).min(at(3)).min(place);
        let bound = MARGIN * (face.mag * self.packet.scale + face.k_mag);
        let crossed = low > bound
            || low >= -bound && {
                counts.filter_exact += 1;
                self.decide.decide(face.source, self.positions[self.packet.id[lane] as usize])
            };
        if crossed {
            counts.leaf_hits += 1;
            self.count[lane] += face.weight;
        }
    }
}
