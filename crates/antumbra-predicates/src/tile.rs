//! First stage for tiles of samples: eight triangles are prepared once for all samples of a tile.
//!
//! A *tile* is a set of samples that the light sees close together. Everything is in the frame of one cube face around the
//! light: coordinates `(u, v, w)` of a point are its world coordinates with the axes permuted and perhaps `w` negated
//! (exact), `w` pointing away from the light. Of a sample, `x = P.u / P.w`, `y = P.v / P.w` and `r = 1 / P.w` (with
//! `P = p - l`) are its *direction* and *nearness*. In these coordinates all four tests of a triangle are linear,
//!
//! ```text
//! sides: m · (x, y, 1)        plane: n · (x, y, 1) - det[A, B, C] r
//! ```
//!
//! so that a box of directions and nearnesses is culled, or found to be covered, by interval arithmetic
//! ([`TileBlock::cull`]), whatever triangles lie beside or behind the light. A light far away sees all samples in almost one direction:
//! then `x` and `y` are measured from a point among the samples ([`Aim`]), as the difference of two directions would be lost in their
//! rounding. Samples are then tested with the sums of
//! [`crate::filter`], relative to the first corner ([`TileBlock::test`]). The sides are divided by their own bounds for the tile,
//! so that one comparison decides all three: above 1 certain, below -1 certainly not; the plane is held against the bound of
//! the sample. `bounds.md` derives the bounds.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, f32x16, mask32x8, mask32x16};

use crate::aim::{Aim, seen_bounds};
use crate::filter::{KAPPA, LIMIT, TINY};
use crate::vector::{abs, cross, cross_abs, dot, load3, max3, scale, splat3, store3, sub};

/// A bound of directions is widened by this, relative to 1 and to itself: `bounds.md` needs 9 u.
pub const WIDEN: f32 = 16.0 * 0.5 * f32::EPSILON;
/// Samples and corners nearer than this to the light's plane, along `w`, have no direction.
pub const NEAREST: f32 = 1.0 / LIMIT;
/// Added to the distance of a sample from a corner, so that no bound vanishes where a tile is a single point.
const FLOOR: f32 = 1.0 / (1u64 << 60) as f32;

/// In units of a test's bound: covers underflow of coefficients (each at most 2^-150, times |q| up to 2^41).
const LEAST: f32 = 1.0 / (1u128 << 100) as f32;

/// Sums of the plane's bound are not smaller than this part of the bound. It makes the bound of a sample larger, by next to nothing, and
/// keeps it clear of subnormal numbers ([`TINY`] says why).
const PLANE_LEAST: f32 = 1.0 / (1u64 << 40) as f32;

/// Bounds of directions and nearness of samples, as computed in f32: `r = 1 / w`, `x = u r`, `y = v r`, measured from an [`Aim`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Least `x`, `y`, `r`.
    pub lo: [f32; 3],
    /// Largest `x`, `y`, `r`.
    pub hi: [f32; 3],
}

impl Region {
    /// Holds nothing.
    pub const EMPTY: Region = Region { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    /// Holds what either holds.
    #[inline(always)]
    pub fn union(&self, other: &Region) -> Region {
        Region {
            lo: [0, 1, 2].map(|k| if other.lo[k] < self.lo[k] { other.lo[k] } else { self.lo[k] }),
            hi: [0, 1, 2].map(|k| if other.hi[k] > self.hi[k] { other.hi[k] } else { self.hi[k] }),
        }
    }

    /// Least `x`, `y`, `r`, then the largest with their signs turned: a union is a minimum. Numbers 3 and 7 are of no use.
    #[inline(always)]
    pub fn pack(&self) -> [f32; 8] {
        let [lo, hi] = [self.lo, self.hi];
        [lo[0], lo[1], lo[2], f32::INFINITY, -hi[0], -hi[1], -hi[2], f32::INFINITY]
    }

    /// The region of such numbers.
    #[inline(always)]
    pub fn unpack(s: &[f32; 8]) -> Region {
        Region { lo: [s[0], s[1], s[2]], hi: [-s[4], -s[5], -s[6]] }
    }

    /// Middle and half size of the directions: the half is rounded up.
    #[inline(always)]
    fn middle(&self) -> [[f32; 2]; 2] {
        let side = |k: usize| {
            let c = 0.5 * (self.lo[k] + self.hi[k]);
            let h = if self.hi[k] - c > c - self.lo[k] { self.hi[k] - c } else { c - self.lo[k] };
            [c, h + h * f32::EPSILON]
        };
        [side(0), side(1)]
    }

    /// A box, relative to the light, that holds every sample of the region: middle and half size in the face's frame.
    fn points(&self, aim: &Aim) -> [[f32; 3]; 2] {
        let slope = aim.slope();
        // w from 1/r, then u and v as products of intervals; widened for the rounding of samples and of these lines.
        let w = [1.0 / self.hi[2], 1.0 / self.lo[2]];
        let product = |k: usize| {
            let [lo, hi] = [self.lo[k] + slope[k], self.hi[k] + slope[k]];
            let all = [lo * w[0], lo * w[1], hi * w[0], hi * w[1]];
            [all.into_iter().fold(f32::INFINITY, f32::min), all.into_iter().fold(f32::NEG_INFINITY, f32::max)]
        };
        let bounds = [product(0), product(1), w];
        let center = bounds.map(|[lo, hi]| 0.5 * lo + 0.5 * hi);
        let half = [0, 1, 2].map(|k| {
            let h = (bounds[k][1] - center[k]).max(center[k] - bounds[k][0]);
            // The direction may be small because the slope takes away from it: its rounding is that of the slope, and of how far the anchor is.
            let turned = if k < 2 { slope[k].abs() * (w[1] + aim.reach()) } else { 0.0 };
            h + 2.0 * WIDEN * (h + center[k].abs() + turned)
        });
        [center, half]
    }
}

/// A region within a tile's, made ready to be held against triangles.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Part {
    /// Least `x`, `y`, `r`; the fourth number means nothing, here and below.
    pub lo: [f32; 4],
    /// Largest `x`, `y`, `r`.
    pub hi: [f32; 4],
    middle: [f32; 4],
    /// Rounded up.
    half: [f32; 4],
}

impl Part {
    /// All zero: to be overwritten.
    pub const ZERO: Part = Part { lo: [0.0; 4], hi: [0.0; 4], middle: [0.0; 4], half: [0.0; 4] };

    /// The region that is packed in `sides` ([`Region::pack`]).
    #[inline(always)]
    pub fn new<S: Simd>(s: S, sides: f32x8<S>) -> Part {
        let (lo, hi) = s.split_f32x8(sides);
        let hi = -hi;
        let middle = (lo + hi) * 0.5;
        let half = (hi - middle).max(middle - lo);
        let half = half + half * f32::EPSILON;
        Part { lo: lo.to_array(), hi: hi.to_array(), middle: middle.to_array(), half: half.to_array() }
    }
}

/// Eight triangles, prepared for the samples of one tile.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct TileBlock {
    /// Bounds of the triangle as seen from the light: least x, largest x, least y, largest y, largest r.
    bounds: [[f32; 8]; 5],
    /// Corners, world coordinates in the face's frame.
    corners: [[[f32; 8]; 3]; 3],
    /// Normals of the tests ab, bc, ca, plane, oriented and each divided by its bound.
    m: [[[f32; 8]; 3]; 4],
    /// `det[A, B, C]` in units of test bc, and of the plane test.
    det: [[f32; 8]; 2],
    /// How far a test may be off when it is evaluated over a region.
    margin: [[f32; 8]; 4],
    /// Sums of absolute products of the plane's normal, times [`KAPPA`], in units of the plane test.
    plane_mag: [[f32; 8]; 3],
    /// The third coordinate of the normals as the [`Aim`] has it: of directions, the constant of each test.
    constant: [[f32; 8]; 4],
    /// The constant of each side, plus its margin.
    outer: [[f32; 8]; 3],
}

/// What a block of triangles does to a tile; bits are lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileVerdict {
    /// May block some sample.
    pub maybe: u8,
    /// Blocks every sample, for certain.
    pub covers: u8,
    /// Of `maybe`: facing open. Ask [`crate::exact::facing`], **in the frame's coordinates**; drop those with 0 and
    /// [`TileBlock::flip`] those with -1.
    pub edge_on: u8,
}

/// What a block of triangles does to a part of the tile; bits are lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartVerdict {
    /// May block some sample.
    pub maybe: u8,
    /// Of `maybe`: every sample is within the three sides, for certain.
    pub within: u8,
    /// Of `within`: every sample is beyond the plane as well, and so blocked.
    pub covers: u8,
}

/// What one triangle does to samples; one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tested {
    /// Blocked for certain.
    pub blocked: u32,
    /// Inside all three sides for certain, plane test open.
    pub plane: u32,
    /// Some side open, none certainly wrong.
    pub sides: u32,
}

#[inline(always)]
fn bits<S: Simd, M: SimdMask<S>>(mask: M) -> u8 {
    mask.to_bitmask() as u8
}

#[inline(always)]
fn sixteen<S: Simd>(mask: mask32x16<S>) -> u32 {
    mask.to_bitmask() as u32
}

/// A tile, as [`TileBlock::look`] and [`TileBlock::prepare`] need it.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    aim: Aim,
    region: Region,
    /// Of the samples ([`Aim::depth_of`]).
    depth: f32,
    weight: [f32; 2],
    center: [f32; 3],
    half: [f32; 3],
}

impl Tile {
    /// The samples of a region around a light.
    pub fn new(aim: Aim, region: Region) -> Tile {
        let [center, half] = region.points(&aim);
        Tile { aim, region, depth: aim.depth_of(&region), weight: aim.weight(&region), center, half }
    }
}

impl TileBlock {
    /// All zero: to be filled by [`TileBlock::look`] and [`TileBlock::prepare`].
    pub const ZERO: TileBlock = TileBlock {
        bounds: [[0.0; 8]; 5],
        corners: [[[0.0; 8]; 3]; 3],
        m: [[[0.0; 8]; 3]; 4],
        det: [[0.0; 8]; 2],
        margin: [[0.0; 8]; 4],
        plane_mag: [[0.0; 8]; 3],
        constant: [[0.0; 8]; 4],
        outer: [[0.0; 8]; 3],
    };

    /// Takes eight triangles, `raw[corner][axis]` in the face's frame, and bounds what the light sees of them; `live` says which
    /// lanes hold triangles. Returns those that may block some sample of the tile, by their bounds alone.
    #[inline(always)]
    pub fn look<S: Simd>(&mut self, s: S, raw: [[f32x8<S>; 3]; 3], live: u8, tile: &Tile) -> u8 {
        if tile.aim.is_straight() {
            return self.look_along::<S, false>(s, raw, live, tile);
        }
        apart(
            s,
            #[inline(always)]
            || self.look_along::<S, true>(s, raw, live, tile),
        )
    }

    #[inline(always)]
    fn look_along<S: Simd, const FAR: bool>(
        &mut self,
        s: S,
        raw: [[f32x8<S>; 3]; 3],
        live: u8,
        tile: &Tile,
    ) -> u8 {
        let l = splat3(s, tile.aim.light());
        let rel = [sub(raw[0], l), sub(raw[1], l), sub(raw[2], l)];
        let far = max3(abs(rel[0])).max(max3(abs(rel[1]))).max(max3(abs(rel[2])));
        let tame = far.simd_le(LIMIT);
        let bounds = seen_bounds::<S, FAR>(s, &tile.aim, tile.depth, &raw);
        let infinity = f32x8::splat(s, f32::INFINITY);
        let open = [-infinity, infinity, -infinity, infinity, infinity];
        let mut seen = open;
        for k in 0..5 {
            seen[k] = tame.select(bounds[k], open[k]);
            seen[k].store_array(&mut self.bounds[k]);
            if k < 3 {
                store3(raw[k], &mut self.corners[k]);
            }
        }
        let [x_lo, x_hi, y_lo, y_hi, r_hi] = seen;
        let t = &tile.region;
        let near = x_lo.simd_le(t.hi[0])
            & x_hi.simd_ge(t.lo[0])
            & y_lo.simd_le(t.hi[1])
            & y_hi.simd_ge(t.lo[1])
            & r_hi.simd_ge(t.lo[2]);
        live & bits(near)
    }

    /// Prepares the triangles that [`TileBlock::look`] has taken, for the same tile; `live` says which count. A triangle that is not in
    /// `maybe` blocks no sample of the tile.
    #[inline(always)]
    pub fn prepare<S: Simd>(&mut self, s: S, live: u8, tile: &Tile) -> TileVerdict {
        if tile.aim.is_straight() {
            return self.prepare_along::<S, false>(s, live, tile);
        }
        apart(
            s,
            #[inline(always)]
            || self.prepare_along::<S, true>(s, live, tile),
        )
    }

    #[inline(always)]
    fn prepare_along<S: Simd, const FAR: bool>(&mut self, s: S, live: u8, tile: &Tile) -> TileVerdict {
        let l = splat3(s, tile.aim.light());
        let raw = [load3(s, &self.corners[0]), load3(s, &self.corners[1]), load3(s, &self.corners[2])];
        let rel = [sub(raw[0], l), sub(raw[1], l), sub(raw[2], l)];
        let t = &tile.region;
        let tiny = f32x8::splat(s, TINY);
        let kappa = f32x8::splat(s, KAPPA);
        let one = f32x8::splat(s, 1.0);
        let zero = f32x8::splat(s, 0.0);
        let edge = [sub(raw[1], raw[0]), sub(raw[2], raw[1]), sub(raw[0], raw[2])];
        let rel_abs = [abs(rel[0]), abs(rel[1]), abs(rel[2])];
        let edge_abs = [abs(edge[0]), abs(edge[1]), abs(edge[2])];
        // |p - a| <= |center - A| + half, and a floor.
        let away = abs(sub(splat3(s, tile.center), rel[0]));
        let half = splat3(s, [tile.half[0] + FLOOR, tile.half[1] + FLOOR, tile.half[2] + FLOOR]);
        let q_max = [away[0] + half[0], away[1] + half[1], away[2] + half[2]];

        // N = (B - A) × (C - A) = (A - C) × (B - A); det[A, B, C] = N · A.
        let n = cross(edge[2], edge[0]);
        let n_mag = cross_abs(edge_abs[2], edge_abs[0], tiny);
        let det = dot(n, rel[0]);
        let det_bound = kappa.mul_add(dot(n_mag, rel_abs[0]), tiny);
        let largest = max3(rel_abs[0]).max(max3(rel_abs[1])).max(max3(rel_abs[2])).max(max3(q_max));
        let tame = largest.simd_le(LIMIT);
        let faces = bits(det.abs().simd_gt(det_bound) & tame);
        // Lanes whose facing is open keep the orientation of the corners: the caller finds the facing and flips.
        let sign = det.simd_lt(-det_bound).select(-one, one);

        let m = [cross(rel[0], edge[0]), cross(rel[1], edge[1]), cross(rel[2], edge[2]), n];
        let mag = [
            cross_abs(rel_abs[0], edge_abs[0], tiny),
            cross_abs(rel_abs[1], edge_abs[1], tiny),
            cross_abs(rel_abs[2], edge_abs[2], tiny),
            n_mag,
        ];
        // Of `det r` over the region, for the plane.
        let det_reach = det_bound * (2.0 * t.hi[2]);
        let (mut out, mut least) = (zero, f32x8::splat(s, f32::INFINITY));
        let [[xc, xh], [yc, yh]] = t.middle();
        for k in 0..4 {
            let more = if k == 1 { det_bound } else { tiny };
            let bound = kappa.mul_add(dot(mag[k], q_max), more);
            // Nothing is certain in a lane that is not tame: all its values are zero.
            let inverse = tame.select(one / bound, zero);
            let by = sign * inverse;
            let scaled = scale(m[k], by);
            let scaled =
                [tame.select(scaled[0], zero), tame.select(scaled[1], zero), tame.select(scaled[2], zero)];
            // Of directions, the normal is bent as space is: its first two coordinates stay the same.
            let (constant, mags) = if FAR {
                let (constant, of_constant) = tile.aim.constant(s, &raw, &edge, k);
                let [x, y] = tile.weight;
                (tame.select(constant * by, zero), mag[k][0] * x + mag[k][1] * y + of_constant)
            } else {
                (scaled[2], mag[k][0] + mag[k][1] + mag[k][2])
            };
            let margin = tame.select((kappa + kappa) * mags * inverse, zero);
            let value = scaled[1].mul_add(yc, scaled[0].mul_add(xc, constant));
            let reach = scaled[1].abs().mul_add(yh, scaled[0].abs().mul_add(xh, margin));
            if k == 1 {
                tame.select(det * by, zero).store_array(&mut self.det[0]);
            }
            if k == 3 {
                let det = tame.select(det * by, zero);
                det.store_array(&mut self.det[1]);
                let more = tame.select(det_reach * inverse, zero);
                (margin + more).store_array(&mut self.margin[3]);
                out = out.min((value - det * t.lo[2]) + (reach + more));
                least = least.min((value - det * t.hi[2]) - (reach + more));
                let floor = bound * PLANE_LEAST;
                let mag = [mag[3][0].max(floor), mag[3][1].max(floor), mag[3][2].max(floor)];
                store3(scale(mag, kappa * inverse), &mut self.plane_mag);
            } else {
                margin.store_array(&mut self.margin[k]);
                (constant + margin).store_array(&mut self.outer[k]);
                out = out.min(value + reach);
                least = least.min(value - reach);
            }
            store3(scaled, &mut self.m[k]);
            constant.store_array(&mut self.constant[k]);
        }
        let open = live & !faces;
        let maybe = (live & !bits(out.simd_lt(0.0))) | open;
        TileVerdict { maybe, covers: maybe & !open & bits(least.simd_gt(0.0)), edge_on: open }
    }

    /// Bounds of the triangles in `live`, as the light sees them: least x, largest x, least y, largest y, largest r. What they
    /// block is within, as for [`TileBlock::cull`].
    #[inline(always)]
    pub fn hull<S: Simd>(&self, s: S, live: u8) -> [f32; 5] {
        let live = mask32x8::from_bitmask(s, u64::from(live));
        let (none, all) = (f32x8::splat(s, f32::INFINITY), f32x8::splat(s, f32::NEG_INFINITY));
        let b = &self.bounds;
        [
            live.select(f32x8::load_array_ref(s, &b[0]), none).reduce_min(),
            live.select(f32x8::load_array_ref(s, &b[1]), all).reduce_max(),
            live.select(f32x8::load_array_ref(s, &b[2]), none).reduce_min(),
            live.select(f32x8::load_array_ref(s, &b[3]), all).reduce_max(),
            live.select(f32x8::load_array_ref(s, &b[4]), all).reduce_max(),
        ]
    }

    /// Turns triangle `lane` to the other facing.
    pub fn flip(&mut self, lane: usize) {
        for m in self.m.iter_mut().flatten().chain(&mut self.det).chain(&mut self.constant) {
            m[lane] = -m[lane];
        }
        for k in 0..3 {
            self.outer[k][lane] = self.constant[k][lane] + self.margin[k][lane];
        }
    }

    /// Which triangles may block some sample of `part`, and what they do to all of them, for certain; bits are lanes.
    ///
    /// The part must lie within the region of the tile; the facing of edge-on triangles must have been settled.
    #[inline(always)]
    pub fn cull<S: Simd>(&self, s: S, part: &Part) -> PartVerdict {
        let b = &self.bounds;
        let near = f32x8::load_array_ref(s, &b[0]).simd_le(part.hi[0])
            & f32x8::load_array_ref(s, &b[1]).simd_ge(part.lo[0])
            & f32x8::load_array_ref(s, &b[2]).simd_le(part.hi[1])
            & f32x8::load_array_ref(s, &b[3]).simd_ge(part.lo[1])
            & f32x8::load_array_ref(s, &b[4]).simd_ge(part.lo[2]);
        let near = bits(near);
        let [xc, yc, ..] = part.middle;
        let [xh, yh, ..] = part.half;
        let zero = f32x8::splat(s, 0.0);
        let (mut out, mut least) = (zero, f32x8::splat(s, f32::INFINITY));
        for k in 0..3 {
            let (value, reach) = self.over(s, k, [xc, yc], [xh, yh]);
            out = out.min(value + reach);
            least = least.min(value - reach);
        }
        let (value, reach) = self.over(s, 3, [xc, yc], [xh, yh]);
        let det = f32x8::load_array_ref(s, &self.det[1]);
        out = out.min((value - det * part.lo[2]) + reach);
        let beyond = (value - det * part.hi[2]) - reach;
        let maybe = near & !bits(out.simd_lt(0.0));
        let within = maybe & bits(least.simd_gt(0.0));
        PartVerdict { maybe, within, covers: within & bits(beyond.simd_gt(0.0)) }
    }

    /// Test `k` at the middle of a region of directions, and how far it may be from that anywhere in it.
    #[inline(always)]
    fn over<S: Simd>(&self, s: S, k: usize, at: [f32; 2], half: [f32; 2]) -> (f32x8<S>, f32x8<S>) {
        let m = [f32x8::load_array_ref(s, &self.m[k][0]), f32x8::load_array_ref(s, &self.m[k][1])];
        let constant = f32x8::load_array_ref(s, &self.constant[k]);
        let margin = f32x8::load_array_ref(s, &self.margin[k]);
        let value = m[1].mul_add(at[1], m[0].mul_add(at[0], constant));
        (value, m[1].abs().mul_add(half[1], m[0].abs().mul_add(half[0], margin)))
    }

    /// Which of sixteen samples are not for certain beside triangle `lane`, by their directions alone: a third of the work of
    /// [`TileBlock::test`]. What lanes without a sample say does not matter.
    ///
    /// Samples must lie within the tile, their x and y computed as those of its [`Region`]; the triangle must be prepared, and the facing of
    /// edge-on ones settled.
    #[inline(always)]
    pub fn not_beside<S: Simd>(&self, s: S, lane: usize, [x, y]: [&[f32; 16]; 2]) -> u32 {
        let (x, y) = (f32x16::load_array_ref(s, x), f32x16::load_array_ref(s, y));
        let mut least = f32x16::splat(s, f32::INFINITY);
        for (m, outer) in self.m[..3].iter().zip(&self.outer) {
            least = least.min(y.mul_add(m[1][lane], x.mul_add(m[0][lane], outer[lane])));
        }
        !sixteen(least.simd_lt(0.0)) & 0xffff
    }

    /// Tests triangle `lane` against up to 32 samples, sixteen a vector, of which those in `alive` count.
    ///
    /// Samples come as their coordinates along u, v and w: world coordinates but for the order, w without the face's sign, which
    /// is `sign`. `within` says that [`TileBlock::cull`] has found all of them within the sides.
    #[inline(always)]
    pub fn test<S: Simd, const V: usize>(
        &self,
        s: S,
        lane: usize,
        [u, v, w]: [&[[f32; 16]; V]; 3],
        sign: f32,
        alive: u32,
        within: bool,
    ) -> Tested {
        let zero = f32x16::splat(s, 0.0);
        let mut q = [[zero; 3]; V];
        let a = [self.corners[0][0][lane], self.corners[0][1][lane], self.corners[0][2][lane]];
        for i in 0..V {
            // The product is exact: the same difference as in the frame.
            let [u, v, w] = [
                f32x16::load_array_ref(s, &u[i]),
                f32x16::load_array_ref(s, &v[i]),
                f32x16::load_array_ref(s, &w[i]),
            ];
            q[i] = [u - a[0], v - a[1], w.mul_sub(sign, a[2])];
        }
        // The plane with the bound of each sample itself: most samples lie on a triangle of their own.
        let mut plane = [zero; V];
        self.values(s, 3, lane, zero, &q, &mut plane);
        let mag = &self.plane_mag;
        let floor = f32x16::splat(s, LEAST);
        let mut bound = [zero; V];
        for i in 0..V {
            let [x, y, z] = [q[i][0].abs(), q[i][1].abs(), q[i][2].abs()];
            bound[i] = z.mul_add(mag[2][lane], y.mul_add(mag[1][lane], x.mul_add(mag[0][lane], floor)));
        }
        let (mut blocked, mut out) = (0, 0);
        if within {
            for i in 0..V {
                blocked |= sixteen(plane[i].simd_gt(bound[i])) << (16 * i);
                out |= sixteen(plane[i].simd_lt(-bound[i])) << (16 * i);
            }
            blocked &= alive;
            return Tested { blocked, plane: alive & !blocked & !out, sides: 0 };
        }
        let (mut sides, mut more) = ([zero; V], [zero; V]);
        self.values(s, 0, lane, zero, &q, &mut sides);
        self.values(s, 1, lane, f32x16::splat(s, self.det[0][lane]), &q, &mut more);
        for i in 0..V {
            sides[i] = sides[i].min(more[i]);
        }
        self.values(s, 2, lane, zero, &q, &mut more);
        for i in 0..V {
            sides[i] = sides[i].min(more[i]);
            let (beyond, before) = (plane[i].simd_gt(bound[i]), plane[i].simd_lt(-bound[i]));
            blocked |= sixteen(beyond & sides[i].simd_gt(1.0)) << (16 * i);
            out |= sixteen(before | sides[i].simd_lt(-1.0)) << (16 * i);
        }
        blocked &= alive;
        let open = alive & !blocked & !out;
        if open == 0 {
            return Tested { blocked, plane: 0, sides: 0 };
        }
        let mut inside = 0;
        for i in 0..V {
            inside |= sixteen(sides[i].simd_gt(1.0)) << (16 * i);
        }
        Tested { blocked, plane: open & inside, sides: open & !inside }
    }

    /// Test `k` of one triangle at vectors of samples.
    #[inline(always)]
    fn values<S: Simd, const V: usize>(
        &self,
        s: S,
        k: usize,
        lane: usize,
        constant: f32x16<S>,
        q: &[[f32x16<S>; 3]; V],
        out: &mut [f32x16<S>; V],
    ) {
        let m = &self.m[k];
        let [x, y, z] = [m[0][lane], m[1][lane], m[2][lane]];
        let [x, y, z] = [f32x16::splat(s, x), f32x16::splat(s, y), f32x16::splat(s, z)];
        for i in 0..V {
            out[i] = q[i][2].mul_add(z, q[i][1].mul_add(y, q[i][0].mul_add(x, constant)));
        }
    }
}

/// Calls a function that is compiled for the instruction set, and by itself.
#[inline(never)]
fn apart<S: Simd, R>(s: S, f: impl FnOnce() -> R) -> R {
    s.vectorize(f)
}
