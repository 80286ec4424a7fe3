//! The triangle pass: each triangle goes to the lists of the tiles whose samples it may block.
//!
//! Most triangles are seen small from the light: bounds of their directions, the cells around them (around 32 neighbours, or eight, where they are
//! seen close together), the tiles of the cells. Those that span more than some four tiles descend the tree of nodes with all four tests; a node
//! that a triangle covers is done for good. Triangles that cross from one face of the cube to another descend from the roots of all faces.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use antumbra_predicates::Triangle;
use antumbra_predicates::tile::Region;
use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8, mask32x8};

use super::boxes::Coarse;
use super::descend::{Caster, Target, descend};
use super::frame::FACES;
use super::grid::{GRID, Grid, NODE, NOTHING, Tiles};
use super::lists::Lists;
use super::prefetch::prefetch_eight;
use super::project::{Projected, SeenEight, project};
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
