//! Blocks that are not one leaf: at depth edges, borders of tiles and of the background, and where samples are in no order.
//!
//! Each half of a block is a leaf, or is parted; what would fall into many leaves goes to its tiles sample by sample ("loose"). In tiles that few
//! triangles are near ([`super::sparse`]) all samples of the block are one leaf.

use antumbra_predicates::filter::LIMIT;
use antumbra_predicates::tile::NEAREST;
use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x4, f32x8, mask32x8, u32x8};

use super::frame::{Frame, face_of};
use super::grid::NOTHING;
use super::layout::{BLOCK, HALF};
use super::leaf::Loose;
use super::leaves::{Gathered, Pass, add, bounds, directions, least, most, pack, shallow, straight, widen};
use super::shuffle::columns;
use super::tuning::{BLOCK_LEAVES, LEAST_PART};

#[inline(always)]
fn both<S: Simd>(m: [mask32x8<S>; 2]) -> u16 {
    (m[0].to_bitmask() | m[1].to_bitmask() << 8) as u16
}

/// A block that is not one leaf: each half is, or is parted. Returns which samples exist.
#[inline(never)]
pub(super) fn parts<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    q: &[[f32x8<S>; 4]; 3],
    out: &mut Gathered,
) -> u32 {
    s.vectorize(
        #[inline(always)]
        || {
            let zero = f32x8::splat(s, 0.0);
            // Infinity and NaN times zero are NaN; background is NaN throughout, what is infinite is looked at one by one.
            let (mut mask, mut none) = (0, 0);
            for i in 0..4 {
                let [x, y, z] = [q[0][i], q[1][i], q[2][i]];
                let exists = ((x + y + z) * zero).simd_eq(zero);
                let nothing = x.simd_ne(x) & y.simd_ne(y) & z.simd_ne(z);
                mask |= (exists.to_bitmask() as u32) << (8 * i);
                none |= (nothing.to_bitmask() as u32) << (8 * i);
            }
            if mask | none != u32::MAX {
                mask = exist(pass, block, out);
            }
            let mut left = mask;
            if pass.tiles.any_sparse {
                left = sparse_parts(s, pass, block, mask, q, out);
            }
            for half in 0..2 {
                let mask = (left >> (HALF * half)) as u16;
                if mask != 0 {
                    let i = 2 * half;
                    let q = [[q[0][i], q[0][i + 1]], [q[1][i], q[1][i + 1]], [q[2][i], q[2][i + 1]]];
                    part_half(s, pass, block, half, mask, &q, out);
                }
            }
            mask
        },
    )
}

/// Samples of a block in tiles that few triangles are near: each tile takes its own, wherever they are in the block. Returns those that are left.
#[inline(always)]
fn sparse_parts<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    mask: u32,
    q: &[[f32x8<S>; 4]; 3],
    out: &mut Gathered,
) -> u32 {
    let (mut left, mut other) = (mask, 0);
    for _ in 0..2 * BLOCK_LEAVES {
        let open = left & !other;
        if open == 0 {
            break;
        }
        let i = open.trailing_zeros() as usize;
        let face = face_of([q[0][i / 8][i % 8], q[1][i / 8][i % 8], q[2][i / 8][i % 8]]);
        let sight = &pass.tiles.sights.faces[face];
        let [u, v, w] = sight.frame.turn_all(*q);
        let mut here = 0;
        for k in 0..4 {
            here |= (inside(u[k], v[k], w[k]).to_bitmask() as u32) << (8 * k);
        }
        here &= open;
        if here >> i & 1 == 0 {
            break;
        }
        let [low, high] = if sight.aim.is_straight() {
            [
                straight(s, [[u[0], u[1]], [v[0], v[1]], [w[0], w[1]]]),
                straight(s, [[u[2], u[3]], [v[2], v[3]], [w[2], w[3]]]),
            ]
        } else {
            [
                directions(s, sight, &pass.layout.load_half(s, pass.positions, block, 0)),
                directions(s, sight, &pass.layout.load_half(s, pass.positions, block, 1)),
            ]
        };
        let mut x = [low[0][0], low[0][1], high[0][0], high[0][1]];
        let mut y = [low[1][0], low[1][1], high[1][0], high[1][1]];
        let mut r = [low[2][0], low[2][1], high[2][0], high[2][1]];
        let tile = pass.tiles.find(face, x[i / 8][i % 8], y[i / 8][i % 8]);
        if !pass.tiles.is_sparse(tile) {
            other |= 1 << i;
            continue;
        }
        let part = pass.tiles.same_cells(s, face, tile, &x, &y) & here;
        if part.count_ones() < LEAST_PART {
            other |= 1 << i;
            continue;
        }
        let (fx, fy, fr) = (x[i / 8][i % 8], y[i / 8][i % 8], r[i / 8][i % 8]);
        for k in 0..4 {
            let keep = mask32x8::from_bitmask(s, u64::from(part >> (8 * k) & 0xff));
            x[k] = keep.select(x[k], f32x8::splat(s, fx));
            y[k] = keep.select(y[k], f32x8::splat(s, fy));
            r[k] = keep.select(r[k], f32x8::splat(s, fr));
        }
        let sides = pack(s, [least(&x), least(&y), least(&r)], [most(&x), most(&y), most(&r)]);
        out.alone = 0;
        add(s, pass, out, tile, sides, block, part);
        left &= !part;
    }
    left
}

/// Which samples lie in the face of the frame.
#[inline(always)]
fn inside<S: Simd>(u: f32x8<S>, v: f32x8<S>, w: f32x8<S>) -> mask32x8<S> {
    w.simd_ge(u.abs().max(v.abs()).max(NEAREST)) & w.simd_le(LIMIT)
}

/// One half of a block, from the light: face by face, mostly there is one.
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
    let mut left = mask;
    while left != 0 {
        let i = left.trailing_zeros() as usize;
        let face = face_of([q[0][i / 8][i % 8], q[1][i / 8][i % 8], q[2][i / 8][i % 8]]);
        let turned = Frame::of(face).turn_all(*q);
        let [u, v, w] = turned;
        let here = left & both([inside(u[0], v[0], w[0]), inside(u[1], v[1], w[1])]);
        if here == 0 {
            // The first has no direction.
            out.wild.push((block * BLOCK + HALF * half + i) as u32);
            left &= left - 1;
            continue;
        }
        part_face(s, pass, block, half, here, face, turned, out);
        left &= !here;
    }
}

/// Samples of half a block that lie in one face, in its frame.
#[inline(always)]
fn part_face<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    half: usize,
    mask: u16,
    face: usize,
    turned: [[f32x8<S>; 2]; 3],
    out: &mut Gathered,
) {
    let sight = &pass.tiles.sights.faces[face];
    let mut c = if sight.aim.is_straight() {
        straight(s, turned)
    } else {
        directions(s, sight, &pass.layout.load_half(s, pass.positions, block, half))
    };
    if mask != 0xffff {
        repeat(s, &mut c, mask);
    }
    if out.all_alone(block) {
        loosen(s, pass, block, half, mask, &tiles_of(s, pass, face, &c), &c, out);
        return;
    }
    let place = |mask: u16| u32::from(mask) << (HALF * half);
    let sides = bounds(s, &c);
    let (mut left, mut alone) = (mask, 0);
    let (mut tiles, mut known) = ([u32x8::splat(s, NOTHING); 2], false);
    let is_shallow = shallow(sides, pass.band[face]);
    if is_shallow || pass.tiles.any_sparse {
        if let Some(tile) = pass.tiles.home(s, face, sides, true)
            && (is_shallow || pass.tiles.is_sparse(tile))
        {
            out.alone = 0;
            add(s, pass, out, tile, sides, block, place(mask));
            return;
        }
        // Too large for any tile, or samples of a sparse one among others.
        (tiles, known) = (tiles_of(s, pass, face, &c), true);
        let now = if is_shallow { mask } else { mask & sparse(pass, &tiles) };
        alone = pieces(s, pass, block, half, now, &tiles, &c, out);
        left = mask & !now;
    }
    // Several depths.
    for _ in 0..BLOCK_LEAVES {
        if left == 0 {
            break;
        }
        let first = left.trailing_zeros() as usize;
        let near = c[2][first / 8][first % 8];
        let band = f32x8::splat(s, pass.band[face] * near);
        let part = left & both([(c[2][0] - near).abs().simd_le(band), (c[2][1] - near).abs().simd_le(band)]);
        if part.count_ones() < LEAST_PART {
            break;
        }
        let mut only = c;
        repeat(s, &mut only, part);
        let sides = bounds(s, &only);
        if let Some(tile) = pass.tiles.home(s, face, sides, false) {
            add(s, pass, out, tile, sides, block, place(part));
        } else {
            if !known {
                (tiles, known) = (tiles_of(s, pass, face, &c), true);
            }
            alone |= pieces(s, pass, block, half, part, &tiles, &c, out);
        }
        left &= !part;
    }
    alone |= left;
    out.alone = match alone {
        alone if alone != mask => 0,
        // A few at the border of the background say little.
        _ => out.alone + u32::from(mask.count_ones() >= 4),
    };
    if alone != 0 {
        if !known {
            tiles = tiles_of(s, pass, face, &c);
        }
        loosen(s, pass, block, half, alone, &tiles, &c, out);
    }
}

/// Which of sixteen tiles few triangles are near.
#[inline(always)]
fn sparse<S: Simd>(pass: &Pass<'_>, tiles: &[u32x8<S>; 2]) -> u16 {
    (0..16).map(|i| u16::from(pass.tiles.is_sparse(tiles[i / 8][i % 8])) << i).sum()
}

/// Tiles of sixteen samples.
#[inline(always)]
fn tiles_of<S: Simd>(s: S, pass: &Pass<'_>, face: usize, c: &[[f32x8<S>; 2]; 3]) -> [u32x8<S>; 2] {
    [pass.tiles.find_eight(s, face, c[0][0], c[1][0]), pass.tiles.find_eight(s, face, c[0][1], c[1][1])]
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

/// Samples of half a block at one depth that are too far apart for any tile: each tile takes its own. Returns those that are left, if they
/// are too many.
#[inline(always)]
fn pieces<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    half: usize,
    mask: u16,
    tiles: &[u32x8<S>; 2],
    c: &[[f32x8<S>; 2]; 3],
    out: &mut Gathered,
) -> u16 {
    let mut left = mask;
    for _ in 0..BLOCK_LEAVES {
        if left == 0 {
            break;
        }
        let first = left.trailing_zeros() as usize;
        let tile = tiles[first / 8][first % 8];
        let part = left & both([tiles[0].simd_eq(tile), tiles[1].simd_eq(tile)]);
        if part.count_ones() < LEAST_PART {
            break;
        }
        let mut only = *c;
        repeat(s, &mut only, part);
        add(s, pass, out, tile, bounds(s, &only), block, u32::from(part) << (HALF * half));
        left &= !part;
    }
    left
}

/// Samples of half a block, one by one.
#[inline(never)]
fn loosen<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    block: usize,
    half: usize,
    mask: u16,
    tiles: &[u32x8<S>; 2],
    c: &[[f32x8<S>; 2]; 3],
    out: &mut Gathered,
) {
    s.vectorize(
        #[inline(always)]
        || {
            let corner = pass.layout.corner(block);
            // x, y, r, r of samples 0 and 4, 1 and 5, ...
            let (low, high) = (
                columns(s, [c[0][0], c[1][0], c[2][0], c[2][0]]),
                columns(s, [c[0][1], c[1][1], c[2][1], c[2][1]]),
            );
            let mut at = [[0.0; 8]; 8];
            for i in 0..4 {
                low[i].store_array(&mut at[i]);
                high[i].store_array(&mut at[4 + i]);
            }
            let mut left = mask;
            while left != 0 {
                let i = left.trailing_zeros() as usize;
                left &= left - 1;
                out.loose.ask_for_end(tiles[i / 8][i % 8]);
            }
            let mut left = mask;
            while left != 0 {
                let i = left.trailing_zeros() as usize;
                left &= left - 1;
                let sample = HALF * half + i;
                let world = pass.positions[pass.layout.index_from(corner, sample)];
                let at = f32x4::from_slice(s, &at[4 * (i / 8) + i % 4][i % 8 / 4 * 4..][..4]);
                let tile = tiles[i / 8][i % 8];
                widen(s, &mut out.regions[tile as usize], s.combine_f32x4(at, -at));
                out.loose.push(tile, Loose::new(world, block * BLOCK + sample));
            }
        },
    );
}
