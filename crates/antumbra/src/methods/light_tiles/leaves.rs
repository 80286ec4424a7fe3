//! The sample pass: blocks of 8 x 4 pixels become leaves of tiles.
//!
//! Most blocks lie in one tile at one depth and become one leaf. Others are parted ([`super::parts`]).

use antumbra_predicates::filter::LIMIT;
use antumbra_predicates::tile::{NEAREST, Region};
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::frame::{FACES, Frame, face_of};
use super::grid::{NOTHING, Point, Tiles};
use super::layout::{Layout, Rows, is_background};
use super::leaf::{Leaf, Loose};
use super::lists::Lists;
use super::parts::parts;
use super::prefetch::prefetch;
use super::shuffle::least_of_halves;
use super::sight::{Sight, Sights, within};
use super::tuning::ALONE;
use crate::mask::{LIT, NONE};

/// Numbers that are asked for ahead in each line of a block: eight blocks of a picture.
const AHEAD: usize = 8 * 24;

/// Blocks whose sample is asked for ahead when tiles are chosen (past the end of a row it is one of another row: no harm).
const LOOK_AHEAD: usize = 32;

/// What a worker leaves behind. Cache lines come in pairs, and no two workers should write to one.
#[derive(Debug, Default)]
#[repr(align(128))]
pub(super) struct Gathered {
    /// Leaves by tile.
    pub(super) leaves: Lists<Leaf, 14>,
    /// Samples by tile, on their own.
    pub(super) loose: Lists<Loose, 14>,
    /// Samples without a direction that f32 can hold: on the light, or out of all proportion.
    pub(super) wild: Vec<u32>,
    /// Packed bounds by tile.
    pub(super) regions: Vec<[f32; 8]>,
    /// A coordinate was infinite.
    pub(super) broken: bool,
    /// Halves of blocks, one after another, that gave no leaf.
    pub(super) alone: u32,
}

impl Gathered {
    /// Whether a block is likely to give no leaf, as those of late gave none. One in sixteen is looked at all the same.
    #[inline(always)]
    pub(super) fn all_alone(&self, block: usize) -> bool {
        self.alone >= ALONE && !block.is_multiple_of(16)
    }

    pub(super) fn reset(&mut self, tiles: usize) {
        self.leaves.reset(tiles);
        self.loose.reset(tiles);
        self.wild.clear();
        self.regions.clear();
        self.regions.resize(tiles, Region::EMPTY.pack());
        self.broken = false;
    }
}

/// One sample of every block of a row of blocks, as seen from the light; bounds and numbers by face.
pub(super) fn look(
    layout: &Layout,
    positions: &[[f32; 3]],
    light: [f32; 3],
    sights: &Sights,
    row: usize,
    points: &mut [Point],
) -> ([Region; FACES], [usize; FACES]) {
    let (mut bounds, mut counts) = ([Region::EMPTY; FACES], [0; FACES]);
    for (column, point) in points.iter_mut().enumerate() {
        *point = Point::NONE;
        let (start, line) = layout.corner(row * layout.columns + column);
        // One of a row in the middle, now here, now there: what alternates from pixel to pixel must not hide. Others of the row if there
        // is none. Points only say where tiles should be small.
        let choice = |column: usize| (column as u32).wrapping_mul(0x9e37_79b9) as usize >> 29;
        prefetch(positions, start + (line + LOOK_AHEAD * layout.step() + choice(column + LOOK_AHEAD)));
        let x = choice(column);
        for i in [x, x ^ 5, x ^ 2, x ^ 7].map(|x| line + x) {
            // At the right border this may be a sample of another line: no harm either.
            let Some(&p) = positions.get(start + i).filter(|p| !p.iter().any(|v| v.is_nan())) else {
                continue;
            };
            let Some((face, mut at)) = direction(p, light) else { continue };
            if sights.any_far {
                let Sight { frame, aim, .. } = &sights.faces[face];
                at = aim.seen(frame.turn(p));
            }
            *point = Point { face: face as u32, at: [at[0], at[1]] };
            bounds[face] = bounds[face].union(&Region { lo: at, hi: at });
            counts[face] += 1;
            break;
        }
    }
    (bounds, counts)
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
    /// Rows of blocks of the mask that are filled with "lit" already.
    pub(super) filled: usize,
}

/// A row of blocks: sorts its samples into tiles. `mask` (of the samples of the row) becomes "lit", or "none" where there is no sample.
#[inline(always)]
pub(super) fn gather<S: Simd>(s: S, pass: &Pass<'_>, row: usize, mask: &mut [u8], out: &mut Gathered) {
    let layout = pass.layout;
    if row >= pass.filled {
        mask.fill(LIT);
    }
    let mut batch = Batch::new();
    out.alone = 0;
    for column in 0..layout.columns {
        let block = row * layout.columns + column;
        let rows = layout.rows_at(pass.positions, row, column);
        if let Some(rows) = rows {
            for row in rows {
                prefetch(row, AHEAD);
                prefetch(row, AHEAD + 16);
            }
            if is_background(s, rows) {
                layout.fill(mask, column, NONE);
                continue;
            }
        }
        let q = from_light(pass, layout.load_rows(s, pass.positions, block, rows));
        if !out.all_alone(block)
            && let Some((face, sides)) = whole_block(s, pass, block, rows, &q)
        {
            batch.push(block, face, sides);
            if batch.len == BATCH || out.alone >= ALONE {
                settle(s, pass, &mut batch, out);
            }
            continue;
        }
        let valid = parts(s, pass, block, &q, out);
        if valid != u32::MAX {
            layout.mark(mask, column, !valid & layout.inside(column), NONE);
        }
    }
    settle(s, pass, &mut batch, out);
}

/// Blocks that lie within one face, to be settled together: what a processor waits for in one, it does in the meantime in others.
#[derive(Debug)]
struct Batch {
    sides: [[f32; 8]; BATCH],
    /// Block and face.
    blocks: [(u32, u32); BATCH],
    len: usize,
}

/// Blocks that are settled together.
const BATCH: usize = 16;

impl Batch {
    #[inline(always)]
    fn new() -> Batch {
        Batch { sides: [[0.0; 8]; BATCH], blocks: [(0, 0); BATCH], len: 0 }
    }

    #[inline(always)]
    fn push<S: Simd>(&mut self, block: usize, face: usize, sides: f32x8<S>) {
        let i = self.len % BATCH;
        sides.store_array(&mut self.sides[i]);
        self.blocks[i] = (block as u32, face as u32);
        self.len = i + 1;
    }
}

/// Blocks in one tile at one depth become a leaf each, others are parted.
#[inline(always)]
fn settle<S: Simd>(s: S, pass: &Pass<'_>, batch: &mut Batch, out: &mut Gathered) {
    let mut tiles = [NOTHING; BATCH];
    for i in 0..batch.len {
        let (sides, face) = (f32x8::load_array_ref(s, &batch.sides[i]), batch.blocks[i].1 as usize);
        let tile = pass.tiles.home(s, face, sides, true).unwrap_or(NOTHING);
        let is_deep = !shallow(sides, pass.band[face]) && !pass.tiles.is_sparse(tile);
        tiles[i] = if is_deep { NOTHING } else { tile };
    }
    for i in 0..batch.len {
        let (block, tile) = (batch.blocks[i].0 as usize, tiles[i]);
        if tile == NOTHING {
            let q = from_light(pass, pass.layout.load(s, pass.positions, block));
            parts(s, pass, block, &q, out);
        } else {
            out.alone = 0;
            add(s, pass, out, tile, f32x8::load_array_ref(s, &batch.sides[i]), block, u32::MAX);
        }
    }
    batch.len = 0;
}

/// Samples of a block from the light.
#[inline(always)]
fn from_light<S: Simd>(pass: &Pass<'_>, p: [[f32x8<S>; 4]; 3]) -> [[f32x8<S>; 4]; 3] {
    let l = pass.light;
    [
        [p[0][0] - l[0], p[0][1] - l[0], p[0][2] - l[0], p[0][3] - l[0]],
        [p[1][0] - l[1], p[1][1] - l[1], p[1][2] - l[1], p[1][3] - l[1]],
        [p[2][0] - l[2], p[2][1] - l[2], p[2][2] - l[2], p[2][3] - l[2]],
    ]
}

/// Face and packed bounds of a block all of whose samples exist and lie in one face.
#[inline(always)]
fn whole_block<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    rows: Option<Rows<'_>>,
    q: &[[f32x8<S>; 4]; 3],
) -> Option<(usize, f32x8<S>)> {
    // Blocks at the border of the background hold NaN.
    let x = (q[0][0] + q[0][1]) + (q[0][2] + q[0][3]);
    if x.simd_eq(x).to_bitmask() != 0xff {
        return None;
    }
    let face = face_of([q[0][0][0], q[1][0][0], q[2][0][0]]);
    if pass.tiles.sights.any_far {
        let p = pass.layout.load_rows(s, pass.positions, block, rows);
        return Some((face, whole_far(s, &pass.tiles.sights.faces[face], p, q)?));
    }
    let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    let sides = match face / 2 {
        0 => whole(s, sign, &WITHIN, [&q[1], &q[2], &q[0]]),
        1 => whole(s, sign, &WITHIN, [&q[0], &q[2], &q[1]]),
        _ => whole(s, sign, &WITHIN, [&q[0], &q[1], &q[2]]),
    };
    Some((face, sides?))
}

/// Packed bounds of [`whole`] are larger: directions a few ulp within the face, nearness of lengths that f32 can hold.
const WITHIN: [f32; 8] = within([0.0; 2], 4.0 * f32::EPSILON);

/// As [`whole`] in a face that measures from a point among the samples, which are read once more.
#[inline(always)]
fn whole_far<S: Simd>(
    s: S,
    sight: &Sight,
    p: [[f32x8<S>; 4]; 3],
    q: &[[f32x8<S>; 4]; 3],
) -> Option<f32x8<S>> {
    let (anchor, slope) = (sight.aim.anchor(), sight.aim.slope());
    let ([mut u, mut v, w], [.., from_light]) = (sight.frame.turn_all(p), sight.frame.turn_all(*q));
    // The same numbers as those of `directions`.
    for i in 0..4 {
        let from = w[i] - anchor[2];
        u[i] = from.mul_add(-slope[0], u[i] - anchor[0]);
        v[i] = from.mul_add(-slope[1], v[i] - anchor[1]);
    }
    whole(s, 1.0, &sight.within, [&u, &v, &from_light])
}

/// Whether packed bounds are narrow in depth.
#[inline(always)]
pub(super) fn shallow<S: Simd>(sides: f32x8<S>, band: f32) -> bool {
    let nearest = -sides[6];
    nearest - sides[2] <= band * nearest
}

/// Packed bounds of a block's samples, from the light: u, v, w of a face, w without its sign. `None` unless all lie within the face
/// with room to spare (only then what is rounded here cannot matter).
#[inline(always)]
fn whole<S: Simd>(s: S, sign: f32, border: &[f32; 8], [u, v, w]: [&[f32x8<S>; 4]; 3]) -> Option<f32x8<S>> {
    let sign = f32x8::splat(s, sign);
    let mut r = [sign; 4];
    let (mut x, mut y) = (r, r);
    for i in 0..4 {
        r[i] = sign / w[i];
        x[i] = u[i] * r[i];
        y[i] = v[i] * r[i];
    }
    let sides = pack(s, [least(&x), least(&y), least(&r)], [most(&x), most(&y), most(&r)]);
    // A minimum may forget a NaN, a sum does not: NaN in w is NaN in r, x and y.
    let sum = ((x[0] + y[0]) + (x[1] + y[1])) + ((x[2] + y[2]) + (x[3] + y[3]));
    let within = sides.simd_gt(f32x8::load_array_ref(s, border)) & sum.simd_eq(sum);
    (within.to_bitmask() == 0xff).then_some(sides)
}

/// Packed bounds of sixteen samples.
#[inline(always)]
pub(super) fn bounds<S: Simd>(s: S, c: &[[f32x8<S>; 2]; 3]) -> f32x8<S> {
    let lo = [c[0][0].min(c[0][1]), c[1][0].min(c[1][1]), c[2][0].min(c[2][1])];
    let hi = [c[0][0].max(c[0][1]), c[1][0].max(c[1][1]), c[2][0].max(c[2][1])];
    pack(s, lo, hi)
}

/// Packed bounds of sixteen samples that are known to have a direction within a face.
#[inline(always)]
pub(super) fn bounds_of<S: Simd>(s: S, sight: &Sight, p: &[[f32x8<S>; 2]; 3]) -> f32x8<S> {
    bounds(s, &directions(s, sight, p))
}

/// x, y, r of such samples.
#[inline(always)]
pub(super) fn directions<S: Simd>(s: S, sight: &Sight, p: &[[f32x8<S>; 2]; 3]) -> [[f32x8<S>; 2]; 3] {
    let (light, anchor, [x, y]) = (sight.aim.light(), sight.aim.anchor(), sight.aim.slope());
    let [u, v, w] = sight.frame.turn_all(*p);
    let one = f32x8::splat(s, 1.0);
    let r = [one / (w[0] - light[2]), one / (w[1] - light[2])];
    // Without an anchor the slope is zero: no branch.
    let from = [w[0] - anchor[2], w[1] - anchor[2]];
    let u = [from[0].mul_add(-x, u[0] - anchor[0]), from[1].mul_add(-x, u[1] - anchor[0])];
    let v = [from[0].mul_add(-y, v[0] - anchor[1]), from[1].mul_add(-y, v[1] - anchor[1])];
    [[u[0] * r[0], u[1] * r[1]], [v[0] * r[0], v[1] * r[1]], r]
}

/// The same of samples from the light, in the frame of a face whose directions are measured from the axis.
#[inline(always)]
pub(super) fn straight<S: Simd>(s: S, [u, v, w]: [[f32x8<S>; 2]; 3]) -> [[f32x8<S>; 2]; 3] {
    let one = f32x8::splat(s, 1.0);
    let r = [one / w[0], one / w[1]];
    [[u[0] * r[0], u[1] * r[1]], [v[0] * r[0], v[1] * r[1]], r]
}

#[inline(always)]
pub(super) fn least<S: Simd>(v: &[f32x8<S>; 4]) -> f32x8<S> {
    v[0].min(v[1]).min(v[2].min(v[3]))
}

#[inline(always)]
pub(super) fn most<S: Simd>(v: &[f32x8<S>; 4]) -> f32x8<S> {
    v[0].max(v[1]).max(v[2].max(v[3]))
}

/// The least lane of `lo`, the largest of `hi` (x, y, r), packed.
#[inline(always)]
pub(super) fn pack<S: Simd>(s: S, lo: [f32x8<S>; 3], hi: [f32x8<S>; 3]) -> f32x8<S> {
    least_of_halves(s, [fold(s, lo[0], hi[0]), fold(s, lo[1], hi[1]), fold(s, lo[2], hi[2])])
}

/// Four numbers whose least is that of `lo`, and four whose least is the largest of `hi` with its sign turned.
#[inline(always)]
fn fold<S: Simd>(s: S, lo: f32x8<S>, hi: f32x8<S>) -> f32x8<S> {
    let ((a, b), (c, d)) = (s.split_f32x8(lo), s.split_f32x8(-hi));
    s.combine_f32x4(a, c).min(s.combine_f32x4(b, d))
}

#[inline(always)]
pub(super) fn add<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    out: &mut Gathered,
    tile: u32,
    sides: f32x8<S>,
    block: usize,
    mask: u32,
) {
    let tile = pass.tiles.share(tile, block);
    widen(s, &mut out.regions[tile as usize], sides);
    out.leaves.push(tile, Leaf::new(s, sides, block as u32, mask));
}

#[inline(always)]
pub(super) fn widen<S: Simd>(s: S, bounds: &mut [f32; 8], sides: f32x8<S>) {
    f32x8::load_array_ref(s, bounds).min(sides).store_array(bounds);
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
