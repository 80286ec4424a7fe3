//! The triangle pass: each triangle goes to the lists of the tiles whose samples it may block.
//!
//! Most triangles are seen small from the light: bounds of their directions, the cells around them (around 32 neighbours, or eight, where they are
//! seen close together), the tiles of the cells. Those that span more than some four tiles descend the tree of nodes with all four tests; a node
//! that a triangle covers is done for good. Triangles that cross from one face of the cube to another descend from the roots of all faces.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use antumbra_predicates::Triangle;
use antumbra_predicates::filter::LIMIT;
use antumbra_predicates::tile::{NEAREST, Region, WIDEN};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};

use super::boxes::{Coarse, Hull};
use super::descend::{Caster, Target, descend};
use super::frame::FACES;
use super::grid::{GRID, Grid, NODE, NOTHING, Tiles};
use super::lists::Lists;
use super::prefetch::prefetch_eight;
use super::shuffle::corners;
use super::sight::{Sight, Sights};
use super::tuning::{FEW_CELLS, LEAST_EIGHT, TRIANGLES};

/// What all workers share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass<'a> {
    pub(super) triangles: &'a [Triangle],
    pub(super) light: [f32; 3],
    pub(super) tiles: &'a Tiles,
    /// Tiles that one triangle covers.
    pub(super) covered: &'a [AtomicBool],
    /// The next triangle that no worker has taken.
    pub(super) next: &'a AtomicUsize,
    /// A worker stops when its lists take this much room ([`Binned::room`]).
    pub(super) capacity: usize,
}

/// A triangle in the list of a tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    pub(super) id: u32,
    /// Where it is seen, in sixteenths of the cells of its face: column, and row times 2^16. Only for the order of the tests.
    pub(super) at: u32,
}

impl Entry {
    /// A triangle that spans tiles.
    pub(super) fn large(id: u32) -> Entry {
        Entry { id, at: LARGE }
    }
}

/// Several of eight triangles that follow one another, in the list of a tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Eight {
    pub(super) first: u32,
    /// How near to the light the nearest of them comes ([`super::sight::Sight::nearness`]). Only for the order of the tests.
    pub(super) near: u16,
    /// Those that may block a sample of the tile; bits.
    pub(super) lanes: u8,
    /// Bounds of those as seen from the light, in steps of the tile.
    pub(super) hull: Coarse,
}

/// No place: seen all over the tile.
pub(super) const LARGE: u32 = u32::MAX;

/// What a worker leaves behind. Cache lines come in pairs, and no two workers should write to one.
#[derive(Debug, Default)]
#[repr(align(128))]
pub(super) struct Binned {
    /// Triangles by tile, on their own and several of eight. Chunks have 128 bytes.
    pub(super) ids: Lists<Entry, 14>,
    pub(super) eights: Lists<Eight, 10>,
    /// Triangles that it has taken and not done.
    pub(super) left: std::ops::Range<usize>,
    pub(super) counts: Counts,
    /// A coordinate was not finite.
    pub(super) broken: bool,
    stack: Vec<u32>,
}

impl Binned {
    /// Room that all lists take, in entries of 8 bytes.
    fn room(&self) -> usize {
        self.ids.items() + size_of::<Eight>().div_ceil(size_of::<Entry>()) * self.eights.items()
    }

    /// Entries of all lists.
    pub(super) fn entries(&self) -> usize {
        self.ids.items() + self.eights.items()
    }
}

/// Work of the pass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Triangles looked at, without those with two equal corners.
    pub(super) setup_tris: u64,
    /// Of those: seen by no sample, or behind all samples.
    pub(super) culled_tris: u64,
    /// Triangles that descended the tree.
    pub(super) descents: u64,
    /// Nodes they visited.
    pub(super) node_visits: u64,
    /// Nodes and tiles they covered.
    pub(super) node_accept: u64,
}

/// Vectors of triangles that are asked for ahead: hardware knows the row, but stops at each page.
const AHEAD: usize = 8;

/// Triangles until none is left, or the lists are full. What was left the last time comes first.
#[inline(always)]
pub(super) fn bin<S: Simd>(s: S, pass: &Pass<'_>, out: &mut Binned) {
    loop {
        if out.left.is_empty() {
            let first = pass.next.fetch_add(TRIANGLES, Relaxed);
            if first >= pass.triangles.len() {
                return;
            }
            out.left = first..pass.triangles.len().min(first + TRIANGLES);
        }
        while !out.left.is_empty() {
            if out.room() >= pass.capacity {
                return;
            }
            let start = out.left.start;
            let end = out.left.end.min(start + 8 * GROUP);
            for n in 0..GROUP {
                prefetch_eight(pass.triangles, start + 8 * (AHEAD + n));
            }
            group(s, pass, start, end - start, out);
            out.left.start = end;
        }
    }
}

/// Eights of triangles that are looked up together: neighbours in a mesh are in the same few tiles.
const GROUP: usize = 4;
const _: () = assert!(TRIANGLES.is_multiple_of(8 * GROUP));

/// Up to [`GROUP`] times eight triangles: together if they are seen close together, else eight by eight.
#[inline(always)]
fn group<S: Simd>(s: S, pass: &Pass<'_>, first: usize, count: usize, out: &mut Binned) {
    let used = count.div_ceil(8);
    let mut group = [Projected::none(s); GROUP];
    for n in 0..used {
        group[n] = project(s, pass, first + 8 * n, (count - 8 * n).min(8), out);
    }
    let (mut found, mut left) = ([0; GROUP], [0; GROUP]);
    for n in 0..used {
        left[n] = group[n].live & group[n].simple;
    }
    // Face by face; mostly there is one.
    while let Some(n) = left.iter().position(|lanes| *lanes != 0) {
        let face = group[n].face[left[n].trailing_zeros() as usize];
        let mut here = [0; GROUP];
        for n in 0..used {
            here[n] = left[n] & group[n].face.simd_eq(face).to_bitmask() as u32;
            left[n] &= !here[n];
        }
        let face = face as usize;
        let grid = &pass.tiles.grids[face];
        if grid.root == NOTHING {
            continue;
        }
        // A quarter of the face; a quarter or twice as much of that costs the same.
        let most_cells = (1 << (2 * grid.levels)) / 4;
        if let Some(taken) = together(s, pass, face, first, &group, &here, most_cells, out) {
            for n in 0..GROUP {
                found[n] |= taken[n];
            }
            continue;
        }
        for n in 0..used {
            if here[n] != 0 {
                found[n] |= within(s, pass, face, first + 8 * n, here[n], &group[n], out);
            }
        }
    }
    for n in 0..used {
        let mut crossing = group[n].live & !group[n].simple;
        while crossing != 0 {
            let i = crossing.trailing_zeros() as usize;
            crossing &= crossing - 1;
            found[n] |= u32::from(cross(s, pass, (first + 8 * n + i) as u32, out)) << i;
        }
        out.counts.culled_tris += u64::from((group[n].live & !found[n]).count_ones());
    }
}

/// Eight triangles as seen from the light.
#[derive(Clone, Copy, Debug)]
struct Projected<S: Simd> {
    seen: SeenEight<S>,
    face: f32x8<S>,
    /// Triangles that count; bits.
    live: u32,
    /// Within one face, with room to spare.
    simple: u32,
}

impl<S: Simd> Projected<S> {
    /// No triangles.
    #[inline(always)]
    fn none(s: S) -> Self {
        let zero = f32x8::splat(s, 0.0);
        Self { seen: SeenEight { x: [zero; 2], y: [zero; 2], r: zero }, face: zero, live: 0, simple: 0 }
    }
}

/// Up to eight triangles.
#[inline(always)]
fn project<S: Simd>(s: S, pass: &Pass<'_>, first: usize, count: usize, out: &mut Binned) -> Projected<S> {
    let zero = f32x8::splat(s, 0.0);
    let one = f32x8::splat(s, 1.0);
    let raw = match pass.triangles[first..].first_chunk() {
        Some([a, b, c, d, e, f, g, h]) => corners(s, [a, b, c, d, e, f, g, h]),
        None => {
            let at = |i: usize| &pass.triangles[first + i.min(count - 1)];
            corners(s, [at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)])
        }
    };
    // Infinity and NaN times zero are NaN. What is behind `count` is the last again: no harm.
    let mut finite = zero;
    for v in raw.as_flattened() {
        finite = v.mul_add(zero, finite);
    }
    out.broken |= finite.simd_eq(zero).to_bitmask() as u8 != 0xff;
    let degenerate = same(raw[0], raw[1]) | same(raw[1], raw[2]) | same(raw[2], raw[0]);
    let live = !degenerate & ((1 << count) - 1);
    out.counts.setup_tris += u64::from(live.count_ones());
    let mut rel = raw;
    for v in &mut rel {
        *v = [v[0] - pass.light[0], v[1] - pass.light[1], v[2] - pass.light[2]];
    }
    let [(f0, w0), (f1, w1), (f2, w2)] = [face(s, rel[0]), face(s, rel[1]), face(s, rel[2])];
    let r = [one / w0, one / w1, one / w2];
    let ([x_lo, x_hi, y_lo, y_hi], within) = if pass.tiles.sights.any_far {
        bounds_far(s, &pass.tiles.sights, f0, live, &raw, &r)
    } else {
        let is_x = f0.simd_lt(2.0);
        let is_z = f0.simd_ge(4.0);
        let (mut x, mut y) = ([zero; 3], [zero; 3]);
        for c in 0..3 {
            x[c] = is_x.select(rel[c][1], rel[c][0]) * r[c];
            y[c] = is_z.select(rel[c][1], rel[c][2]) * r[c];
        }
        let widen = 2.0 * WIDEN;
        let x_lo = x[0].min(x[1]).min(x[2]) - widen;
        let x_hi = x[0].max(x[1]).max(x[2]) + widen;
        let y_lo = y[0].min(y[1]).min(y[2]) - widen;
        let y_hi = y[0].max(y[1]).max(y[2]) + widen;
        let within = x_lo.simd_gt(-1.0) & x_hi.simd_lt(1.0) & y_lo.simd_gt(-1.0) & y_hi.simd_lt(1.0);
        ([x_lo, x_hi, y_lo, y_hi], within)
    };
    let r_hi = r[0].max(r[1]).max(r[2]) * (1.0 + WIDEN);
    // Inside one face with room to spare, and no coordinate that rounds badly.
    let simple = f0.simd_eq(f1)
        & f0.simd_eq(f2)
        & within
        & w0.min(w1).min(w2).simd_ge(NEAREST)
        & w0.max(w1).max(w2).simd_le(LIMIT);
    let simple = simple.to_bitmask() as u32;
    let seen = SeenEight { x: [x_lo, x_hi], y: [y_lo, y_hi], r: r_hi };
    Projected { seen, face: f0, live, simple }
}

/// Bounds of eight triangles, where some face measures directions from a point: least x, largest x, least y, largest y, with room for rounding; and
/// which of them are within the face, if their corners are.
#[inline(always)]
fn bounds_far<S: Simd>(
    s: S,
    sights: &Sights,
    faces: f32x8<S>,
    live: u32,
    raw: &[[f32x8<S>; 3]; 3],
    r: &[f32x8<S>; 3],
) -> ([f32x8<S>; 4], mask32x8<S>) {
    let one = f32x8::splat(s, 1.0);
    let is_x = faces.simd_lt(2.0);
    let is_z = faces.simd_ge(4.0);
    let aims = Aims::of(s, sights, faces, live);
    let (mut x, mut y) = (*r, *r);
    for c in 0..3 {
        let [u, v, w] = [
            is_x.select(raw[c][1], raw[c][0]),
            is_z.select(raw[c][1], raw[c][2]),
            is_x.select(raw[c][0], is_z.select(raw[c][2], raw[c][1])),
        ];
        let from = w.mul_sub(aims.sign, aims.anchor[2]);
        x[c] = (u - aims.anchor[0] - from * aims.slope[0]) * r[c];
        y[c] = (v - aims.anchor[1] - from * aims.slope[1]) * r[c];
    }
    let (least, most) = (r[0].min(r[1]).min(r[2]), r[0].max(r[1]).max(r[2]));
    let depth = (one - least * aims.reach).abs().max((one - most * aims.reach).abs()).max(aims.depth);
    let ([x_lo, x_hi], x_within) = sides_far(x, depth, aims.slope[0]);
    let ([y_lo, y_hi], y_within) = sides_far(y, depth, aims.slope[1]);
    ([x_lo, x_hi, y_lo, y_hi], x_within & y_within)
}

/// Least and largest of three directions, and whether they are within a face whose point has direction `slope`.
#[inline(always)]
fn sides_far<S: Simd>(v: [f32x8<S>; 3], depth: f32x8<S>, slope: f32x8<S>) -> ([f32x8<S>; 2], mask32x8<S>) {
    let (least, most) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
    // Twice what is needed.
    let widen = (least.abs().max(most.abs()) + depth + WIDEN) * (2.0 * WIDEN);
    let (lo, hi) = (least - widen, most + widen);
    // A few ulp within, as the slope is rounded.
    let edge = 1.0 - 12.0 * f32::EPSILON;
    ([lo, hi], lo.simd_gt(-slope - edge) & hi.simd_lt(-slope + edge))
}

/// How the faces of eight triangles see them ([`super::sight::Sight`]): one face or several.
#[derive(Clone, Copy, Debug)]
struct Aims<S: Simd> {
    sign: f32x8<S>,
    anchor: [f32x8<S>; 3],
    slope: [f32x8<S>; 2],
    reach: f32x8<S>,
    depth: f32x8<S>,
}

impl<S: Simd> Aims<S> {
    /// `faces` as numbers, of which those in `live` count.
    #[inline(always)]
    fn of(s: S, sights: &Sights, faces: f32x8<S>, live: u32) -> Self {
        let first = faces[live.trailing_zeros() as usize % 8];
        if faces.simd_eq(first).to_bitmask() as u32 & live == live {
            let n = Self::numbers(&sights.faces[first as usize]);
            let all = |k: usize| f32x8::splat(s, n[k]);
            return Self::new([all(0), all(1), all(2), all(3), all(4), all(5), all(6), all(7)]);
        }
        let mut at = [[0.0; 8]; 8];
        for (lane, face) in faces.to_array().into_iter().enumerate() {
            let numbers = Self::numbers(&sights.faces[face as usize]);
            for k in 0..8 {
                at[k][lane] = numbers[k];
            }
        }
        let each = |k: usize| f32x8::load_array_ref(s, &at[k]);
        Self::new([each(0), each(1), each(2), each(3), each(4), each(5), each(6), each(7)])
    }

    #[inline(always)]
    fn new([sign, u, v, w, x, y, reach, depth]: [f32x8<S>; 8]) -> Self {
        Self { sign, anchor: [u, v, w], slope: [x, y], reach, depth }
    }

    #[inline(always)]
    fn numbers(sight: &Sight) -> [f32; 8] {
        let ([u, v, w], [x, y]) = (sight.aim.anchor(), sight.aim.slope());
        [sight.frame.sign, u, v, w, x, y, sight.aim.reach(), sight.depth]
    }
}

/// Triangles of eight that are seen within one face: those in `live`. Returns those that some tile took.
#[inline(always)]
fn within<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    face: usize,
    first: usize,
    mut live: u32,
    eight: &Projected<S>,
    out: &mut Binned,
) -> u32 {
    if let Some([taken]) = together(s, pass, face, first, &[*eight], &[live], FEW_CELLS, out) {
        return taken;
    }
    let (seen, grid) = (&eight.seen, &pass.tiles.grids[face]);
    let at = grid.fit.places(s, seen.x[0], seen.y[0]);
    let [x0, x1] = grid.fit.wider(s, 0, seen.x, pass.tiles.margin);
    let [y0, y1] = grid.fit.wider(s, 1, seen.y, pass.tiles.margin);
    let (x, y, r) = (seen.x, seen.y, seen.r.to_array());
    let (x, y) = ([x[0].to_array(), x[1].to_array()], [y[0].to_array(), y[1].to_array()]);
    let mut found = 0;
    while live != 0 {
        let i = live.trailing_zeros() as usize;
        live &= live - 1;
        let seen = Seen { x: [x[0][i], x[1][i]], y: [y[0][i], y[1][i]], r: r[i] };
        let entry = Entry { id: (first + i) as u32, at: at[i] };
        let took = place(s, pass, face, entry, [x0[i], x1[i], y0[i], y1[i]], &seen, out);
        found |= u32::from(took) << i;
    }
    found
}

/// Bounds of eight triangles as seen from the light, within one face.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenEight<S: Simd> {
    pub(super) x: [f32x8<S>; 2],
    pub(super) y: [f32x8<S>; 2],
    pub(super) r: f32x8<S>,
}

impl<S: Simd> SeenEight<S> {
    /// Which of them may block some sample of a region; bits.
    #[inline(always)]
    pub(super) fn near(&self, region: &Region) -> u32 {
        let near = self.r.simd_ge(region.lo[2])
            & self.x[0].simd_le(region.hi[0])
            & self.x[1].simd_ge(region.lo[0])
            & self.y[0].simd_le(region.hi[1])
            & self.y[1].simd_ge(region.lo[1]);
        near.to_bitmask() as u32
    }

    /// Bounds of some of them.
    #[inline(always)]
    fn hull(&self, s: S, lanes: u32) -> Hull {
        let lanes = mask32x8::from_bitmask(s, u64::from(lanes));
        let infinity = f32x8::splat(s, f32::INFINITY);
        [
            lanes.select(self.x[0], infinity).reduce_min(),
            lanes.select(self.x[1], -infinity).reduce_max(),
            lanes.select(self.y[0], infinity).reduce_min(),
            lanes.select(self.y[1], -infinity).reduce_max(),
            lanes.select(self.r, -infinity).reduce_max(),
        ]
    }
}

/// Triangles that are seen close together, as neighbours in a mesh are: each tile in the cells around all of them is held against all at once. Returns
/// those that some tile took; `None`, and nothing done, where they are too far apart, or one of several eights is large.
#[inline(always)]
fn together<S: Simd, const N: usize>(
    s: S,
    pass: &Pass<'_>,
    face: usize,
    first: usize,
    eights: &[Projected<S>; N],
    live: &[u32; N],
    most_cells: u32,
    out: &mut Binned,
) -> Option<[u32; N]> {
    let tiles = pass.tiles;
    let grid = &tiles.grids[face];
    let infinity = f32x8::splat(s, f32::INFINITY);
    let (mut lo, mut hi, mut area) = ([infinity; 2], [-infinity; 2], f32x8::splat(s, 0.0));
    for n in 0..N {
        let SeenEight { x, y, .. } = &eights[n].seen;
        let lanes = mask32x8::from_bitmask(s, u64::from(live[n]));
        lo = [lo[0].min(lanes.select(x[0], infinity)), lo[1].min(lanes.select(y[0], infinity))];
        hi = [hi[0].max(lanes.select(x[1], -infinity)), hi[1].max(lanes.select(y[1], -infinity))];
        area = area.max(lanes.select((x[1] - x[0]) * (y[1] - y[0]), area));
    }
    // Large ones had better descend, each by itself. Of one eight, none is larger than all.
    if N > 1 && area.reduce_max() * grid.fit.density() > FEW_CELLS as f32 {
        return None;
    }
    let x = [lo[0].reduce_min(), hi[0].reduce_max()];
    let y = [lo[1].reduce_min(), hi[1].reduce_max()];
    let last = (1 << grid.levels) - 1;
    let [x0, y0] = [
        grid.fit.cell(0, x[0]).saturating_sub(tiles.margin),
        grid.fit.cell(1, y[0]).saturating_sub(tiles.margin),
    ];
    let [x1, y1] = [
        (grid.fit.cell(0, x[1]) + tiles.margin).min(last),
        (grid.fit.cell(1, y[1]) + tiles.margin).min(last),
    ];
    if (x1 - x0 + 1) * (y1 - y0 + 1) > most_cells || grid.crowded([x0, x1, y0, y1]) {
        return None;
    }
    let mut at = [[0; 8]; N];
    for n in 0..N {
        at[n] = grid.fit.places(s, eights[n].seen.x[0], eights[n].seen.y[0]);
    }
    let at = at.as_flattened();
    let mut found = [0; N];
    each_tile(tiles, grid, [x0, x1, y0, y1], |tile| {
        let region = &tiles.region[tile as usize];
        let (mut near, mut any) = ([0; N], 0);
        for n in 0..N {
            near[n] = live[n] & eights[n].seen.near(region);
            any |= near[n];
        }
        if any == 0 || pass.covered[tile as usize].load(Relaxed) {
            return;
        }
        let mut singles = 0;
        for n in 0..N {
            let (near, first) = (near[n], first + 8 * n);
            found[n] |= near;
            if near.count_ones() >= LEAST_EIGHT && first + 8 <= pass.triangles.len() {
                let hull = eights[n].seen.hull(s, near);
                let eight = Eight {
                    first: first as u32,
                    near: tiles.sights.faces[face].nearness(hull[4]),
                    lanes: near as u8,
                    hull: tiles.steps[tile as usize].of(s, hull),
                };
                out.eights.push(tile, eight);
            } else {
                singles |= near << (8 * n);
            }
        }
        // One loop: how often each of several goes round cannot be foretold.
        out.ids.push_each(tile, singles, |i| Entry { id: (first + i) as u32, at: at[i % (8 * N)] });
    });
    Some(found)
}

/// Calls `visit` once with every tile of a range of cells, none of which has a grid of its own.
#[inline(always)]
fn each_tile(tiles: &Tiles, grid: &Grid, [x0, x1, y0, y1]: [u32; 4], mut visit: impl FnMut(u32)) {
    let mut y = y0;
    while y <= y1 {
        let (mut x, mut next) = (x0, y1 + 1);
        while x <= x1 {
            let tile = grid.at(x, y);
            let [_, last_x, first_y, last_y] = tiles.cells[tile as usize].map(u32::from);
            // A tile is met again in each band of rows that it spans; it is new in the first.
            if y == y0 || first_y == y {
                visit(tile);
            }
            x = last_x + 1;
            next = next.min(last_y + 1);
        }
        y = next;
    }
}

/// A triangle that crosses from face to face, or is badly rounded: down from all roots. True if any tile took it.
#[inline(never)]
fn cross<S: Simd>(s: S, pass: &Pass<'_>, id: u32, out: &mut Binned) -> bool {
    let before = (out.entries(), out.counts.node_accept);
    for face in 0..FACES {
        let root = pass.tiles.grids[face].root;
        if root != NOTHING {
            out.stack.clear();
            out.stack.push(root);
            start(s, pass, id, face, out);
        }
    }
    before != (out.entries(), out.counts.node_accept)
}

/// Lanes in which two corners are one point.
#[inline(always)]
fn same<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> u32 {
    (a[0].simd_eq(b[0]) & a[1].simd_eq(b[1]) & a[2].simd_eq(b[2])).to_bitmask() as u32
}

/// The face a vector points through (0, 2, 4 by axis, one more on the negative side), and its largest coordinate.
#[inline(always)]
fn face<S: Simd>(s: S, q: [f32x8<S>; 3]) -> (f32x8<S>, f32x8<S>) {
    let zero = f32x8::splat(s, 0.0);
    let a = [q[0].abs(), q[1].abs(), q[2].abs()];
    let x = a[0].simd_ge(a[1]) & a[0].simd_ge(a[2]);
    let y = a[1].simd_ge(a[2]);
    let major = x.select(q[0], y.select(q[1], q[2]));
    let axis = x.select(zero, y.select(f32x8::splat(s, 2.0), f32x8::splat(s, 4.0)));
    (axis + major.simd_lt(0.0).select(f32x8::splat(s, 1.0), zero), major.abs())
}

/// Bounds of a triangle as seen from the light, within one face.
#[derive(Clone, Copy, Debug)]
struct Seen {
    x: [f32; 2],
    y: [f32; 2],
    r: f32,
}

impl Seen {
    /// Whether it may block some sample of a region.
    #[inline(always)]
    fn meets(&self, region: &Region) -> bool {
        (self.r >= region.lo[2])
            & (self.x[0] <= region.hi[0])
            & (self.x[1] >= region.lo[0])
            & (self.y[0] <= region.hi[1])
            & (self.y[1] >= region.lo[1])
    }
}

/// A triangle within one face, in a range of cells. True if any tile took it.
#[inline(always)]
fn place<S: Simd>(
    s: S,
    pass: &Pass<'_>,
    face: usize,
    entry: Entry,
    [x0, x1, y0, y1]: [u32; 4],
    seen: &Seen,
    out: &mut Binned,
) -> bool {
    let tiles = pass.tiles;
    let grid = &tiles.grids[face];
    // Tiles are squares: opposite corners in one tile, all in it.
    let first = grid.at(x0, y0);
    if first == grid.at(x1, y1) && first & GRID == 0 {
        return push(pass, first, entry, seen, out);
    }
    // A few cells: their tiles one by one cost less than a descent.
    if (x1 - x0 + 1) * (y1 - y0 + 1) <= FEW_CELLS && !grid.crowded([x0, x1, y0, y1]) {
        let mut found = false;
        each_tile(tiles, grid, [x0, x1, y0, y1], |tile| found |= push(pass, tile, entry, seen, out));
        return found;
    }
    let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)];
    // The finest level at which two by two cells hold the triangle. Nodes are at even levels.
    let mut shift = (x1 - x0).max(y1 - y0).max(1).ilog2();
    if (x1 >> shift) - (x0 >> shift) > 1 || (y1 >> shift) - (y0 >> shift) > 1 {
        shift += 1;
    }
    let level = (grid.levels - shift.min(grid.levels)) & !1;
    let shift = grid.levels - level;
    out.stack.clear();
    for (x, y) in corners {
        let at = grid.at(x, y);
        let child = if at & GRID == 0 && u32::from(tiles.level[at as usize]) <= level {
            at
        } else if level == grid.levels {
            tiles.grids[(at & !GRID) as usize].root
        } else {
            NODE | grid.node(level, x >> shift, y >> shift)
        };
        let region = match child & NODE {
            0 => &tiles.region[child as usize],
            _ => &tiles.nodes[(child & !NODE) as usize].region,
        };
        if seen.meets(region) && !out.stack.contains(&child) {
            out.stack.push(child);
        }
    }
    if out.stack.is_empty() {
        return false;
    }
    let before = (out.entries(), out.counts.node_accept);
    start(s, pass, entry.id, face, out);
    before != (out.entries(), out.counts.node_accept)
}

/// Adds a triangle to the list of a tile, unless it is seen beside or behind all its samples, or the tile is covered. True if it was added.
#[inline(always)]
fn push(pass: &Pass<'_>, tile: u32, entry: Entry, seen: &Seen, out: &mut Binned) -> bool {
    let take = seen.meets(&pass.tiles.region[tile as usize]) && !pass.covered[tile as usize].load(Relaxed);
    if take {
        out.ids.push(tile, entry);
    }
    take
}

/// Descends from the entries on the stack.
#[inline(never)]
fn start<S: Simd>(s: S, pass: &Pass<'_>, id: u32, face: usize, out: &mut Binned) {
    out.counts.descents += 1;
    let Binned { ids, stack, counts, .. } = out;
    let mut target = Target { tiles: pass.tiles, covered: pass.covered, id, ids, counts };
    let (triangle, sight) = (&pass.triangles[id as usize], &pass.tiles.sights.faces[face]);
    if sight.aim.is_straight() {
        s.vectorize(
            #[inline(always)]
            || descend(s, &Caster::new::<false>(s, triangle, sight), stack, &mut target),
        );
    } else {
        s.vectorize(
            #[inline(always)]
            || descend(s, &Caster::new::<true>(s, triangle, sight), stack, &mut target),
        );
    }
}
