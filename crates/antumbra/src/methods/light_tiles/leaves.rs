//! The sample pass: blocks of 8 x 4 pixels become leaves of tiles.
//!
//! Most blocks lie in one tile at one depth and become one leaf. Of others, each half is one, or is parted; what would fall into
//! many leaves, and all samples of a bare list, go to their tiles one by one ("loose"), where they are sorted.

use antumbra_predicates::filter::LIMIT;
use antumbra_predicates::tile::{NEAREST, Region};
use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8, mask32x8};

use super::frame::{FACES, Frame, face_of};
use super::grid::{NOTHING, Point, Tiles};
use super::layout::{BLOCK, HALF, Layout};
use super::lists::Lists;
use super::tuning::{BLOCK_LEAVES, LEAST_PART};
use crate::mask::{LIT, NONE};

/// Samples of one block that the light sees close together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    /// Of those in the left half, of those in the right.
    pub(super) regions: [Region; 2],
    pub(super) block: u32,
    /// One bit a sample of the block.
    pub(super) mask: u32,
}

impl Leaf {
    /// Samples of one half.
    #[inline(always)]
    fn of_half(block: usize, half: usize, region: Region, mask: u16) -> Leaf {
        let regions = if half == 0 { [region, Region::EMPTY] } else { [Region::EMPTY, region] };
        Leaf { regions, block: block as u32, mask: u32::from(mask) << (HALF * half) }
    }
}

/// A sample on its own.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Loose {
    /// World space: kept here, as neighbours in a tile are far apart in memory.
    pub(super) at: [f32; 3],
    /// Block times 32 plus sample.
    pub(super) slot: u32,
}

impl Default for Leaf {
    fn default() -> Leaf {
        Leaf { regions: [Region::EMPTY; 2], block: 0, mask: 0 }
    }
}

/// What a worker leaves behind.
#[derive(Debug, Default)]
pub(super) struct Gathered {
    /// Leaves by tile.
    pub(super) leaves: Lists<Leaf>,
    /// Samples by tile, on their own.
    pub(super) loose: Lists<Loose>,
    /// Samples without a direction that f32 can hold: on the light, or out of all proportion.
    pub(super) wild: Vec<u32>,
    /// Bounds by tile.
    pub(super) regions: Vec<Region>,
    /// A coordinate was infinite.
    pub(super) broken: bool,
}

impl Gathered {
    pub(super) fn reset(&mut self, tiles: usize) {
        self.leaves.reset(tiles);
        self.loose.reset(tiles);
        self.wild.clear();
        self.regions.clear();
        self.regions.resize(tiles, Region::EMPTY);
        self.broken = false;
    }
}

/// One sample of every block of a row of blocks, as seen from the light; and bounds by face.
pub(super) fn look(
    layout: &Layout,
    positions: &[[f32; 3]],
    light: [f32; 3],
    row: usize,
    points: &mut [Point],
) -> [Region; FACES] {
    let mut bounds = [Region::EMPTY; FACES];
    for (column, point) in points.iter_mut().enumerate() {
        *point = Point { face: NOTHING, at: [0.0; 2] };
        let (start, line) = layout.corner(row * layout.columns + column);
        // One from the middle, else a corner. Others do not matter: points only say where tiles should be small.
        for i in [line + 1, 0, 3, 3 * line, 3 * line + 3] {
            // At the right border this may be a sample of another line: no harm either.
            let Some(&p) = positions.get(start + i) else { continue };
            let Some((face, at)) = direction(p, light) else { continue };
            *point = Point { face: face as u32, at: [at[0], at[1]] };
            bounds[face] = bounds[face].union(&Region { lo: at, hi: at });
            break;
        }
    }
    bounds
}

/// What the sample pass needs to know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass<'a> {
    pub(super) layout: &'a Layout,
    pub(super) positions: &'a [[f32; 3]],
    pub(super) light: [f32; 3],
    pub(super) tiles: &'a Tiles,
    /// By face: [`super::tuning::DEPTH_BAND`], less where the whole face is at one depth.
    pub(super) band: [f32; FACES],
}

/// A row of blocks: fills `mask` (the samples of the row) with "lit" or "none" and sorts the samples into tiles.
#[inline(always)]
pub(super) fn gather<S: Simd>(s: S, pass: &Pass<'_>, row: usize, mask: &mut [u8], out: &mut Gathered) {
    let layout = pass.layout;
    mask.fill(LIT);
    for column in 0..layout.columns {
        let block = row * layout.columns + column;
        let valid = if layout.is_list {
            let valid = exist(pass, block, out);
            scatter(pass, block, valid, out);
            valid
        } else {
            block_of(s, pass, block, layout.load(s, pass.positions, block), out)
        };
        if valid != u32::MAX {
            layout.mark(mask, column, !valid & layout.inside(column), NONE);
        }
    }
}

#[inline(always)]
fn both<S: Simd>(m: [mask32x8<S>; 2]) -> u16 {
    (m[0].to_bitmask() | m[1].to_bitmask() << 8) as u16
}

/// One block, samples outside the picture NaN. Returns which exist.
#[inline(always)]
fn block_of<S: Simd>(s: S, pass: &Pass<'_>, block: usize, p: [[f32x8<S>; 4]; 3], out: &mut Gathered) -> u32 {
    let l = pass.light;
    let q = [
        [p[0][0] - l[0], p[0][1] - l[0], p[0][2] - l[0], p[0][3] - l[0]],
        [p[1][0] - l[1], p[1][1] - l[1], p[1][2] - l[1], p[1][3] - l[1]],
        [p[2][0] - l[2], p[2][1] - l[2], p[2][2] - l[2], p[2][3] - l[2]],
    ];
    let zero = f32x8::splat(s, 0.0);
    // Infinity and NaN times zero are NaN.
    let sum = [
        q[0][0] + q[1][0] + q[2][0],
        q[0][1] + q[1][1] + q[2][1],
        q[0][2] + q[1][2] + q[2][2],
        q[0][3] + q[1][3] + q[2][3],
    ];
    let mut mask = all(
        (sum[0] * zero).simd_eq(zero),
        (sum[1] * zero).simd_eq(zero),
        (sum[2] * zero).simd_eq(zero),
        (sum[3] * zero).simd_eq(zero),
    );
    if mask == u32::MAX {
        if let Some((tile, leaf)) = whole(s, pass, block, &q) {
            add(out, tile, leaf);
            return mask;
        }
    } else {
        // Background is NaN throughout; what is infinite is looked at one by one.
        let none = all(
            q[0][0].simd_ne(q[0][0]) & q[1][0].simd_ne(q[1][0]) & q[2][0].simd_ne(q[2][0]),
            q[0][1].simd_ne(q[0][1]) & q[1][1].simd_ne(q[1][1]) & q[2][1].simd_ne(q[2][1]),
            q[0][2].simd_ne(q[0][2]) & q[1][2].simd_ne(q[1][2]) & q[2][2].simd_ne(q[2][2]),
            q[0][3].simd_ne(q[0][3]) & q[1][3].simd_ne(q[1][3]) & q[2][3].simd_ne(q[2][3]),
        );
        if mask | none != u32::MAX {
            mask = exist(pass, block, out);
        }
    }
    for half in 0..2 {
        let mask = (mask >> (HALF * half)) as u16;
        if mask != 0 {
            let q = if half == 0 {
                [[q[0][0], q[0][1]], [q[1][0], q[1][1]], [q[2][0], q[2][1]]]
            } else {
                [[q[0][2], q[0][3]], [q[1][2], q[1][3]], [q[2][2], q[2][3]]]
            };
            half_of(s, pass, block, half, mask, &q, out);
        }
    }
    mask
}

#[inline(always)]
fn all<S: Simd>(a: mask32x8<S>, b: mask32x8<S>, c: mask32x8<S>, d: mask32x8<S>) -> u32 {
    (a.to_bitmask() | b.to_bitmask() << 8 | c.to_bitmask() << 16 | d.to_bitmask() << 24) as u32
}

/// The leaf of a whole block, if its samples exist all, and lie at one depth in one tile.
#[inline(always)]
fn whole<S: Simd>(s: S, pass: &Pass<'_>, block: usize, q: &[[f32x8<S>; 4]; 3]) -> Option<(u32, Leaf)> {
    let face = face_of([q[0][0][0], q[1][0][0], q[2][0][0]]);
    let [u, v, w] = Frame::of(face).turn_all(*q);
    let inside = inside(u[0], v[0], w[0])
        & inside(u[1], v[1], w[1])
        & inside(u[2], v[2], w[2])
        & inside(u[3], v[3], w[3]);
    if inside.to_bitmask() != 0xff || pass.tiles.grids[face].root == NOTHING {
        return None;
    }
    let one = f32x8::splat(s, 1.0);
    let r = [one / w[0], one / w[1], one / w[2], one / w[3]];
    let left = bounds(s, &[[u[0] * r[0], u[1] * r[1]], [v[0] * r[0], v[1] * r[1]], [r[0], r[1]]]);
    let right = bounds(s, &[[u[2] * r[2], u[3] * r[3]], [v[2] * r[2], v[3] * r[3]], [r[2], r[3]]]);
    let region = left.union(&right);
    if region.hi[2] - region.lo[2] > pass.band[face] * region.hi[2] {
        return None;
    }
    let tile = pass.tiles.home(face, &region)?;
    Some((tile, Leaf { regions: [left, right], block: block as u32, mask: u32::MAX }))
}

/// Which samples lie in the face of the frame.
#[inline(always)]
fn inside<S: Simd>(u: f32x8<S>, v: f32x8<S>, w: f32x8<S>) -> mask32x8<S> {
    w.simd_ge(u.abs().max(v.abs()).max(NEAREST)) & w.simd_le(LIMIT)
}

/// One half of a block, from the light.
#[inline(never)]
fn half_of<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    half: usize,
    mask: u16,
    q: &[[f32x8<S>; 2]; 3],
    out: &mut Gathered,
) {
    s.vectorize(
        #[inline(always)]
        || part_half(s, pass, block, half, mask, q, out),
    );
}

#[inline(always)]
fn part_half<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    half: usize,
    mask: u16,
    q: &[[f32x8<S>; 2]; 3],
    out: &mut Gathered,
) {
    let first = mask.trailing_zeros() as usize;
    let face = face_of([q[0][first / 8][first % 8], q[1][first / 8][first % 8], q[2][first / 8][first % 8]]);
    let [u, v, w] = Frame::of(face).turn_all(*q);
    let inside = both([inside(u[0], v[0], w[0]), inside(u[1], v[1], w[1])]);
    if mask & !inside != 0 || pass.tiles.grids[face].root == NOTHING {
        scatter(pass, block, u32::from(mask) << (HALF * half), out);
        return;
    }
    let one = f32x8::splat(s, 1.0);
    let r = [one / w[0], one / w[1]];
    let mut c = [[u[0] * r[0], u[1] * r[1]], [v[0] * r[0], v[1] * r[1]], r];
    if mask != 0xffff {
        repeat(s, &mut c, mask);
    }
    let region = bounds(s, &c);
    if region.hi[2] - region.lo[2] <= pass.band[face] * region.hi[2]
        && let Some(tile) = pass.tiles.home(face, &region)
    {
        add(out, tile, Leaf::of_half(block, half, region, mask));
        return;
    }
    // Several depths, or too large for a tile.
    let mut left = mask;
    for _ in 0..BLOCK_LEAVES {
        let first = left.trailing_zeros() as usize;
        let near = c[2][first / 8][first % 8];
        let band = f32x8::splat(s, pass.band[face] * near);
        let part = left & both([(c[2][0] - near).abs().simd_le(band), (c[2][1] - near).abs().simd_le(band)]);
        if part.count_ones() < LEAST_PART {
            break;
        }
        let mut only = c;
        repeat(s, &mut only, part);
        let region = bounds(s, &only);
        match pass.tiles.home(face, &region) {
            Some(tile) => add(out, tile, Leaf::of_half(block, half, region, part)),
            None => pieces(s, pass, block, half, part, face, &c, out),
        }
        left &= !part;
        if left == 0 {
            return;
        }
    }
    loosen(pass, block, half, left, face, &c, out);
}

/// Lanes that are not in `mask` repeat the first that is.
#[inline(always)]
fn repeat<S: Simd>(s: S, c: &mut [[f32x8<S>; 2]; 3], mask: u16) {
    let first = mask.trailing_zeros() as usize;
    for h in 0..2 {
        let keep = mask32x8::from_bitmask(s, u64::from(mask >> (8 * h) & 0xff));
        for k in 0..3 {
            // Half 0 may have been filled already: its lane `first` is unchanged.
            let fill = c[k][first / 8][first % 8];
            c[k][h] = keep.select(c[k][h], f32x8::splat(s, fill));
        }
    }
}

#[inline(always)]
fn bounds<S: Simd>(s: S, c: &[[f32x8<S>; 2]; 3]) -> Region {
    let lo = least(s, [c[0][0].min(c[0][1]), c[1][0].min(c[1][1]), c[2][0].min(c[2][1])]);
    let hi = least(s, [-c[0][0].max(c[0][1]), -c[1][0].max(c[1][1]), -c[2][0].max(c[2][1])]);
    Region { lo, hi: [-hi[0], -hi[1], -hi[2]] }
}

/// Which samples of a block exist, where not all differences from the light are finite.
#[inline(never)]
fn exist(pass: &Pass<'_>, block: usize, out: &mut Gathered) -> u32 {
    let mut mask = 0;
    for sample in 0..BLOCK {
        let Some(i) = pass.layout.index(block, sample) else { continue };
        let p = pass.positions[i];
        if !(p[0].is_nan() || p[1].is_nan() || p[2].is_nan()) {
            out.broken |= p.iter().any(|v| v.is_infinite());
            mask |= 1 << sample;
        }
    }
    mask
}

/// Least of the lanes of three vectors.
#[inline(always)]
fn least<S: Simd>(s: S, v: [f32x8<S>; 3]) -> [f32; 3] {
    let ((a0, a1), (b0, b1), (c0, c1)) = (s.split_f32x8(v[0]), s.split_f32x8(v[1]), s.split_f32x8(v[2]));
    let (a, b, c) = (a0.min(a1), b0.min(b1), c0.min(c1));
    let ac = s.zip_low_f32x4(a, c).min(s.zip_high_f32x4(a, c));
    let bb = s.zip_low_f32x4(b, b).min(s.zip_high_f32x4(b, b));
    let m = s.zip_low_f32x4(ac, bb).min(s.zip_high_f32x4(ac, bb));
    [m[0], m[1], m[2]]
}

#[inline(always)]
fn add(out: &mut Gathered, tile: u32, leaf: Leaf) {
    let bounds = &mut out.regions[tile as usize];
    *bounds = bounds.union(&leaf.regions[0]).union(&leaf.regions[1]);
    out.leaves.push(tile, leaf);
}

/// Samples of half a block at one depth that are too far apart for any tile: each tile takes its own, unless they are too many.
#[inline(always)]
fn pieces<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    half: usize,
    mask: u16,
    face: usize,
    c: &[[f32x8<S>; 2]; 3],
    out: &mut Gathered,
) {
    let tiles =
        [pass.tiles.find_eight(s, face, c[0][0], c[1][0]), pass.tiles.find_eight(s, face, c[0][1], c[1][1])];
    let mut left = mask;
    for _ in 0..BLOCK_LEAVES {
        let first = left.trailing_zeros() as usize;
        let tile = tiles[first / 8][first % 8];
        let part = left & both([tiles[0].simd_eq(tile), tiles[1].simd_eq(tile)]);
        if part.count_ones() < LEAST_PART {
            break;
        }
        let mut only = *c;
        repeat(s, &mut only, part);
        add(out, tile, Leaf::of_half(block, half, bounds(s, &only), part));
        left &= !part;
        if left == 0 {
            return;
        }
    }
    loosen(pass, block, half, left, face, c, out);
}

/// Samples of half a block, one by one.
#[inline(never)]
fn loosen<S: Simd>(
    pass: &Pass<'_>,
    block: usize,
    half: usize,
    mask: u16,
    face: usize,
    c: &[[f32x8<S>; 2]; 3],
    out: &mut Gathered,
) {
    let corner = pass.layout.corner(block);
    for i in bits(u32::from(mask)) {
        let at = [c[0][i / 8][i % 8], c[1][i / 8][i % 8], c[2][i / 8][i % 8]];
        let sample = HALF * half + i;
        let world = pass.positions[pass.layout.index_from(corner, sample)];
        add_loose(out, pass.tiles.find(face, at[0], at[1]), world, block * BLOCK + sample, at);
    }
}

/// A block that crosses from face to face, or of a list: every sample goes to its tile alone.
#[inline(never)]
fn scatter(pass: &Pass<'_>, block: usize, mask: u32, out: &mut Gathered) {
    let corner = pass.layout.corner(block);
    for i in bits(mask) {
        let world = pass.positions[pass.layout.index_from(corner, i)];
        match direction(world, pass.light) {
            Some((face, at)) if pass.tiles.grids[face].root != NOTHING => {
                let tile = pass.tiles.find(face, at[0], at[1]);
                add_loose(out, tile, world, block * BLOCK + i, at);
            }
            // No point of the face was seen when the tiles were chosen, or there is no direction.
            _ => out.wild.push((block * BLOCK + i) as u32),
        }
    }
}

#[inline(always)]
fn add_loose(out: &mut Gathered, tile: u32, world: [f32; 3], slot: usize, at: [f32; 3]) {
    let bounds = &mut out.regions[tile as usize];
    *bounds = bounds.union(&Region { lo: at, hi: at });
    out.loose.push(tile, Loose { at: world, slot: slot as u32 });
}

/// Face, and x, y, r of a sample; `None` where f32 cannot hold them.
#[inline(always)]
pub(super) fn direction(p: [f32; 3], light: [f32; 3]) -> Option<(usize, [f32; 3])> {
    let q = [p[0] - light[0], p[1] - light[1], p[2] - light[2]];
    let face = face_of(q);
    let [u, v, w] = Frame::of(face).turn(q);
    if !(NEAREST..=LIMIT).contains(&w) {
        return None;
    }
    let r = 1.0 / w;
    Some((face, [u * r, v * r, r]))
}

/// The numbers of the bits that are set.
fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = (mask != 0).then(|| mask.trailing_zeros() as usize)?;
        mask &= mask - 1;
        Some(bit)
    })
}
