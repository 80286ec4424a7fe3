//! Tiles: cells of directions around the light that hold some 3,000 to 12,000 samples each.
//!
//! Each face of the cube has a grid, fitted to the directions of its samples. A quadtree over its cells, counted from one
//! sample in every fourth block, says where a tile is large and where it is small. A cell that is crowded even at the finest level gets a
//! grid of its own, fitted again: clumps of samples thousands of times narrower than the face are parted all the same (unless few triangles are
//! near, [`super::sparse`]).
//!
//! Tiles are also the leaves of a tree of [`Node`]s, 16 children each, which large triangles descend.

use antumbra_predicates::tile::Region;

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdMask, f32x8, u32x8};
use rayon::prelude::*;

use super::boxes::Steps;
use super::frame::FACES;
use super::layout::BLOCK;
use super::sight::Sights;
use super::tuning::{
    CROWDED, DEPTH, EVERY, FAR, FEW_CELLS, LEAST_POINTS, LEVELS, SHARE_BLOCKS, SHARES, SPARE, SPARE_CROWDED,
    TILE_POINTS, TILE_POINTS_LEAST, TILE_POINTS_MOST, TILES, TILES_LEAST, TILES_MOST,
};

/// Marks an entry of a node or of a cell that is not a tile: a node.
pub(super) const NODE: u32 = 1 << 31;
/// Marks an entry of a cell that holds a grid of its own.
pub(super) const GRID: u32 = 1 << 30;
/// No tile, node or grid.
pub(super) const NOTHING: u32 = u32::MAX;

/// The direction of one sample of a block; `face` is [`NOTHING`] where the block seems empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) face: u32,
    pub(super) at: [f32; 2],
}

impl Point {
    /// No sample.
    pub(super) const NONE: Point = Point { face: NOTHING, at: [0.0; 2] };
}

fn of_face(points: &[Point], face: usize) -> impl Iterator<Item = [f32; 2]> {
    points.iter().filter(move |point| point.face == face as u32).map(|point| point.at)
}

/// Maps directions to cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fit {
    origin: [f32; 2],
    scale: [f32; 2],
    last: f32,
}

impl Fit {
    fn new(lo: [f32; 2], hi: [f32; 2], side: u32) -> Fit {
        // An empty extent maps everything to cell 0.
        let scale = [0, 1].map(|k| {
            let s = side as f32 / (hi[k] - lo[k]);
            if s.is_finite() { s } else { 0.0 }
        });
        Fit { origin: lo, scale, last: (side - 1) as f32 }
    }

    /// The cell's number along one axis. Monotone in `x`, whatever is rounded; border cells reach to infinity.
    #[inline(always)]
    pub(super) fn cell(&self, axis: usize, x: f32) -> u32 {
        let c = (x - self.origin[axis]) * self.scale[axis];
        // The comparisons are false for NaN (infinity times zero): the last cell, for every x.
        let c = if c < self.last { c } else { self.last };
        let c = if c > 0.0 { c } else { 0.0 };
        // The sum is rounded to a whole number, which is then in the low bits.
        (c + MAGIC).to_bits() & CELL_BITS
    }

    /// Cells in a square of directions from 0 to 1.
    pub(super) fn density(&self) -> f32 {
        self.scale[0] * self.scale[1]
    }

    /// The same for eight numbers.
    #[inline(always)]
    pub(super) fn cells<S: Simd>(&self, s: S, axis: usize, x: f32x8<S>) -> [u32; 8] {
        whole(s, (x - self.origin[axis]) * self.scale[axis], self.last).to_array()
    }

    /// Cells of packed bounds ([`Region::pack`]): column and row of the least are numbers 0 and 1, of the largest 4 and 5.
    #[inline(always)]
    fn ends<S: Simd>(&self, s: S, sides: f32x8<S>) -> [u32; 8] {
        let [[x, y], [a, b]] = [self.origin, self.scale];
        let at = sides * f32x8::load_array(s, [1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0]);
        let c = (at - f32x8::load_array(s, [x, y, 0.0, 0.0, x, y, 0.0, 0.0]))
            * f32x8::load_array(s, [a, b, 0.0, 0.0, a, b, 0.0, 0.0]);
        whole(s, c, self.last).to_array()
    }

    /// The cells of two sides, and `margin` more all round ([`Tiles::margin`]).
    #[inline(always)]
    pub(super) fn wider<S: Simd>(
        &self,
        s: S,
        axis: usize,
        [lo, hi]: [f32x8<S>; 2],
        margin: u32,
    ) -> [[u32; 8]; 2] {
        let margin = margin as f32;
        let (origin, scale) = (self.origin[axis], self.scale[axis]);
        let lo = (clamped(s, (lo - origin) * scale, self.last) + MAGIC) - margin;
        let hi = (clamped(s, (hi - origin) * scale, self.last) + MAGIC) + margin;
        let lo: u32x8<S> = lo.max(MAGIC).bitcast();
        let hi: u32x8<S> = hi.min(MAGIC + self.last).bitcast();
        [(lo & CELL_BITS).to_array(), (hi & CELL_BITS).to_array()]
    }

    /// In [`PLACES`] of cells: columns, and rows times 2^16.
    #[inline(always)]
    pub(super) fn places<S: Simd>(&self, s: S, x: f32x8<S>, y: f32x8<S>) -> [u32; 8] {
        let places = PLACES as f32;
        let last = self.last * places;
        let columns = whole(s, (x - self.origin[0]) * (self.scale[0] * places), last);
        let rows = whole(s, (y - self.origin[1]) * (self.scale[1] * places), last);
        (columns | (rows << 16)).to_array()
    }
}

/// Whole numbers from 0 to `last`. Monotone; NaN is the last.
#[inline(always)]
fn whole<S: Simd>(s: S, c: f32x8<S>, last: f32) -> u32x8<S> {
    let bits: u32x8<S> = (clamped(s, c, last) + MAGIC).bitcast();
    bits & CELL_BITS
}

#[inline(always)]
fn clamped<S: Simd>(s: S, c: f32x8<S>, last: f32) -> f32x8<S> {
    let c = c.simd_lt(last).select(c, f32x8::splat(s, last));
    c.simd_gt(0.0).select(c, f32x8::splat(s, 0.0))
}

/// [`Fit::places`] are these parts of cells.
pub(super) const PLACES: u32 = 16;

/// 2^23: numbers from here to twice as much are whole.
pub(super) const MAGIC: f32 = 8_388_608.0;
const CELL_BITS: u32 = 0xffff;

/// The cells of a face, or of a crowded cell.
#[derive(Debug, Default)]
pub(super) struct Grid {
    pub(super) fit: Fit,
    pub(super) levels: u32,
    /// Row by row: tile, or [`GRID`] and a number.
    pub(super) cells: Vec<u32>,
    /// By half level, row by row: node, where there is one.
    nodes: Vec<Vec<u32>>,
    /// Tile, or [`NODE`] and a number; [`NOTHING`] where there are no samples.
    pub(super) root: u32,
    counts: Vec<Vec<u32>>,
    /// Cells around all that hold a grid: first and last column, first and last row.
    crowds: [u32; 4],
    /// Points of a crowded cell.
    points: Vec<[f32; 2]>,
    /// Of a face: points in crowded cells.
    pub(super) crowded_points: u32,
    /// Squares of crowded cells (column and row) that few triangles are near, or the whole face: tiles as they are.
    pub(super) sparse: Vec<Option<[u32; 2]>>,
    /// Such a square is 2 to this many cells wide.
    pub(super) sparse_shift: u32,
}

/// A crowded cell: the grid that it holds, and where its root goes.
#[derive(Clone, Copy, Debug)]
struct Crowded {
    number: usize,
    parent: Option<u32>,
    child: usize,
}

const NOWHERE: [u32; 4] = [u32::MAX, 0, u32::MAX, 0];

impl Grid {
    /// Fits the grid to points within `bounds`, and counts them.
    fn count(
        &mut self,
        points: impl Iterator<Item = [f32; 2]>,
        count: usize,
        bounds: &Region,
        limit: u32,
        spare: u32,
    ) {
        // Levels more than an even spread would need: on a face, triangles are looked up a cell or two wider than they are.
        let levels = spare + (count as u32 / limit).max(1).ilog2().div_ceil(2);
        let levels = levels.next_multiple_of(2).min(LEVELS);
        let side = 1usize << levels;
        self.levels = levels;
        self.fit = Fit::new([bounds.lo[0], bounds.lo[1]], [bounds.hi[0], bounds.hi[1]], side as u32);
        self.counts.resize_with(LEVELS as usize + 1, Vec::new);
        self.nodes.resize_with(LEVELS as usize / 2 + 1, Vec::new);
        self.cells.resize(side * side, NOTHING);
        self.crowds = NOWHERE;
        self.sparse.clear();
        self.sparse_shift = 0;
        let finest = &mut self.counts[levels as usize];
        finest.clear();
        finest.resize(side * side, 0);
        for p in points {
            finest[(self.fit.cell(1, p[1]) << levels | self.fit.cell(0, p[0])) as usize] += 1;
        }
        let crowded = finest.iter().filter(|points| **points > CROWDED * limit);
        self.crowded_points = crowded.sum();
        for level in (0..levels as usize).rev() {
            let (above, below) = self.counts.split_at_mut(level + 1);
            let (above, below) = (&mut above[level], &below[0]);
            above.resize(1 << (2 * level), 0);
            for (row, pair) in above.chunks_exact_mut(1 << level).zip(below.chunks_exact(4 << level)) {
                let (top, bottom) = pair.split_at(2 << level);
                for ((sum, a), b) in row.iter_mut().zip(top.chunks_exact(2)).zip(bottom.chunks_exact(2)) {
                    *sum = a[0] + a[1] + b[0] + b[1];
                }
            }
            if level % 2 == 0 {
                self.nodes[level / 2].resize(1 << (2 * level), NOTHING);
            }
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, x: u32, y: u32) -> u32 {
        self.cells[(y << self.levels | x) as usize]
    }

    /// Points in all cells.
    pub(super) fn points_in_all(&self) -> u32 {
        self.counts[0][0]
    }

    /// Squares that hold all crowded cells, and how many cells they are wide (by powers of two): the smallest of which there are `most` or fewer, and
    /// larger ones as long as neighbours become one. `limit` is what a tile may have.
    pub(super) fn crowded_squares(
        &self,
        limit: u32,
        most: usize,
        squares: &mut Vec<[u32; 2]>,
        larger: &mut Vec<[u32; 2]>,
    ) -> u32 {
        let cells = self.counts[self.levels as usize].iter().enumerate();
        let crowded = cells.filter(|(_, points)| **points > CROWDED * limit);
        squares.clear();
        squares.extend(
            crowded.map(|(cell, _)| [cell & ((1 << self.levels) - 1), cell >> self.levels].map(|c| c as u32)),
        );
        let mut shift = 0;
        loop {
            larger.clear();
            larger.extend(squares.iter().map(|square| square.map(|c| c >> 1)));
            larger.sort_unstable();
            larger.dedup();
            // Without any, there are no fewer.
            if squares.len() <= most && 4 * larger.len() >= 3 * squares.len() {
                return shift;
            }
            std::mem::swap(squares, larger);
            shift += 1;
        }
    }

    /// Whether two directions are so far apart that few samples between them would fill a tile.
    pub(super) fn are_far(&self, a: [f32; 2], b: [f32; 2]) -> bool {
        (0..2).any(|k| self.fit.cell(k, a[k]).abs_diff(self.fit.cell(k, b[k])) > FAR)
    }

    /// Whether a range of cells (first and last column, first and last row) holds one that has a grid of its own; or may, if it is large.
    #[inline(always)]
    pub(super) fn crowded(&self, [x0, x1, y0, y1]: [u32; 4]) -> bool {
        let [first_x, last_x, first_y, last_y] = self.crowds;
        let (columns, rows) = (x0.max(first_x)..=x1.min(last_x), y0.max(first_y)..=y1.min(last_y));
        if columns.is_empty() || rows.is_empty() {
            return false;
        }
        (x1 - x0 + 1) * (y1 - y0 + 1) > FEW_CELLS
            || rows.into_iter().any(|y| columns.clone().any(|x| self.at(x, y) & GRID != 0))
    }

    /// The node at an even level, if the tree is that deep there.
    #[inline(always)]
    pub(super) fn node(&self, level: u32, x: u32, y: u32) -> u32 {
        self.nodes[(level / 2) as usize][(y << level | x) as usize]
    }
}

/// Sixteen children of the tree above the tiles.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Node {
    /// Bounds of the children: least x, y, r, largest x, y, r.
    pub(super) bounds: [[f32; 16]; 6],
    /// Tile, or [`NODE`] and a number.
    pub(super) child: [u32; 16],
    pub(super) count: usize,
    pub(super) region: Region,
}

impl Node {
    /// Without children.
    pub(super) const EMPTY: Node =
        Node { bounds: [[0.0; 16]; 6], child: [NOTHING; 16], count: 0, region: Region::EMPTY };
}

/// All grids, tiles and nodes of a frame.
#[derive(Debug, Default)]
pub(super) struct Tiles {
    pub(super) sights: Sights,
    /// The six faces, then crowded cells.
    pub(super) grids: Vec<Grid>,
    used: usize,
    pub(super) face: Vec<u8>,
    /// Level of each tile within its grid.
    pub(super) level: Vec<u8>,
    /// Few triangles are near: takes whole blocks, whatever their depth.
    pub(super) sparse: Vec<bool>,
    pub(super) any_sparse: bool,
    /// The tile whose list of triangles is this one's: itself, or of several that share the samples of a sparse one the first.
    pub(super) list: Vec<u32>,
    /// Cells of each tile: first and last column, first and last row.
    pub(super) cells: Vec<[u16; 4]>,
    /// Bounds of the samples.
    pub(super) region: Vec<Region>,
    /// What its steps are ([`super::boxes`]).
    pub(super) steps: Vec<Steps>,
    pub(super) nodes: Vec<Node>,
    /// Cells whose grids are still to be made.
    crowded: Vec<Crowded>,
    /// Points of a tile at most, where they can be parted.
    limit: u32,
    /// Leaves may stick out of their tiles by so many cells of a face's grid; [`super::bin`] looks so much farther.
    pub(super) margin: u32,
}

impl Tiles {
    /// Fits grids to the points, and counts them. `bounds` and `counts` are those of the points of each face.
    pub(super) fn count(
        &mut self,
        points: &[Point],
        bounds: &[Region; FACES],
        counts: &[usize; FACES],
        triangles: usize,
        margin: u32,
    ) {
        self.margin = margin;
        if self.grids.len() < FACES {
            self.grids.resize_with(FACES, Grid::default);
        }
        let there = counts.iter().sum::<usize>() as u32;
        // Samples for each triangle, by the square root.
        let each = (there as f32 * (EVERY * BLOCK) as f32 / triangles.max(1) as f32).sqrt();
        let most = (TILE_POINTS * each).clamp(TILE_POINTS_LEAST, TILE_POINTS_MOST);
        let least_tiles = (TILES / each).clamp(TILES_LEAST, TILES_MOST);
        let limit = (there / least_tiles as u32).clamp(LEAST_POINTS, most as u32);
        self.limit = limit;
        // Faces do not touch.
        self.grids.par_iter_mut().take(FACES).enumerate().for_each(|(face, grid)| {
            grid.root = NOTHING;
            grid.count(of_face(points, face), counts[face], &bounds[face], limit, SPARE);
        });
    }

    /// Makes tiles of what has been counted.
    pub(super) fn choose(&mut self, points: &[Point]) {
        self.face.clear();
        self.level.clear();
        self.sparse.clear();
        self.list.clear();
        self.cells.clear();
        self.nodes.clear();
        self.used = FACES;
        for face in 0..FACES {
            // A face without points gets a tile as well: samples that were not looked at may be in it.
            self.fill(face, face, of_face(points, face), 0);
        }
        self.any_sparse = self.sparse.contains(&true);
    }

    /// Points of a tile, at most.
    pub(super) fn most_points(&self) -> u32 {
        self.limit
    }

    /// The part of all points that is in crowded cells of faces.
    pub(super) fn crowded_part(&self) -> f32 {
        let sum = |f: fn(&Grid) -> u32| self.grids[..FACES].iter().map(f).sum::<u32>() as f32;
        sum(|grid| grid.crowded_points) / sum(Grid::points_in_all).max(1.0)
    }

    /// A tile is 2 to this many cells wide.
    #[inline(always)]
    pub(super) fn shift(&self, tile: usize) -> u32 {
        let [first, last, ..] = self.cells[tile];
        u32::from(last - first + 1).trailing_zeros()
    }

    /// Whether few triangles are near a tile ([`NOTHING`]: no).
    #[inline(always)]
    pub(super) fn is_sparse(&self, tile: u32) -> bool {
        self.sparse.get(tile as usize) == Some(&true)
    }

    /// Of those that share a sparse tile, the one that takes a block.
    #[inline(always)]
    pub(super) fn share(&self, tile: u32, block: usize) -> u32 {
        if self.any_sparse && self.is_sparse(tile) {
            tile + (block as u32 / SHARE_BLOCKS) % SHARES
        } else {
            tile
        }
    }

    /// Number of tiles.
    pub(super) fn len(&self) -> usize {
        self.level.len()
    }

    /// The tile of a direction in a face, or below a crowded cell.
    #[inline(always)]
    pub(super) fn find(&self, grid: usize, x: f32, y: f32) -> u32 {
        let mut grid = &self.grids[grid];
        loop {
            let at = grid.at(grid.fit.cell(0, x), grid.fit.cell(1, y));
            if at & GRID == 0 {
                return at;
            }
            grid = &self.grids[(at & !GRID) as usize];
        }
    }

    /// The tile that takes all samples within packed bounds: they may stick out of its square by the margin. `None` if no tile takes
    /// them all; or, unless `crowded`, if they are in a crowded cell, where finding that out takes time.
    #[inline(always)]
    pub(super) fn home<S: Simd>(&self, s: S, face: usize, sides: f32x8<S>, crowded: bool) -> Option<u32> {
        let grid = &self.grids[face];
        let [x0, y0, _, _, x1, y1, _, _] = grid.fit.ends(s, sides);
        let at = grid.at((x0 + x1) / 2, (y0 + y1) / 2);
        if at & GRID != 0 {
            if !crowded {
                return None;
            }
            let tile = self.find(face, sides[0], sides[1]);
            return (tile == self.find(face, -sides[4], -sides[5])).then_some(tile);
        }
        let [first_x, last_x, first_y, last_y] = self.cells[at as usize].map(u32::from);
        let m = self.margin;
        let inside = (x0 + m >= first_x) & (x1 <= last_x + m) & (y0 + m >= first_y) & (y1 <= last_y + m);
        inside.then_some(at)
    }

    /// Which of 32 directions are in the cells of a tile of the face's own grid, or within the margin beside them; bits.
    #[inline(always)]
    pub(super) fn same_cells<S: Simd>(
        &self,
        s: S,
        face: usize,
        tile: u32,
        x: &[f32x8<S>; 4],
        y: &[f32x8<S>; 4],
    ) -> u32 {
        let fit = &self.grids[face].fit;
        let [first_x, last_x, first_y, last_y] = self.cells[tile as usize].map(u32::from);
        let m = self.margin;
        let (first_x, first_y) = (first_x.saturating_sub(m), first_y.saturating_sub(m));
        let (last_x, last_y) = (last_x + m, last_y + m);
        let mut found = 0;
        for k in 0..4 {
            let column = whole(s, (x[k] - fit.origin[0]) * fit.scale[0], fit.last);
            let row = whole(s, (y[k] - fit.origin[1]) * fit.scale[1], fit.last);
            let near =
                column.simd_ge(first_x) & column.simd_le(last_x) & row.simd_ge(first_y) & row.simd_le(last_y);
            found |= (near.to_bitmask() as u32) << (8 * k);
        }
        found
    }

    /// As [`Tiles::find`], for eight directions.
    #[inline(always)]
    pub(super) fn find_eight<S: Simd>(&self, s: S, face: usize, x: f32x8<S>, y: f32x8<S>) -> u32x8<S> {
        let grid = &self.grids[face];
        let (column, row) = (grid.fit.cells(s, 0, x), grid.fit.cells(s, 1, y));
        let mut tiles = [0; 8];
        for i in 0..8 {
            let at = grid.at(column[i], row[i]);
            tiles[i] = if at & GRID == 0 { at } else { self.find((at & !GRID) as usize, x[i], y[i]) };
        }
        u32x8::load_array(s, tiles)
    }

    /// Makes tiles of a grid whose points have been counted.
    fn fill(&mut self, grid: usize, face: usize, points: impl Iterator<Item = [f32; 2]>, depth: u32) {
        let mut g = std::mem::take(&mut self.grids[grid]);
        let before = self.crowded.len();
        g.root = self.split(&mut g, face, [0, 0, 0], None, depth);
        if depth == 0 && g.root & NODE == 0 {
            // Large triangles are held against children of nodes.
            let mut node = Node { count: 1, ..Node::EMPTY };
            node.child[0] = g.root;
            g.root = NODE | self.nodes.len() as u32;
            self.nodes.push(node);
        }
        // Points of crowded cells go to grids of their own.
        if before < self.crowded.len() {
            for p in points {
                let at = g.at(g.fit.cell(0, p[0]), g.fit.cell(1, p[1]));
                if at & GRID != 0 {
                    self.grids[(at & !GRID) as usize].points.push(p);
                }
            }
        }
        self.grids[grid] = g;
        for i in before..self.crowded.len() {
            let Crowded { number, parent, child } = self.crowded[i];
            let points = std::mem::take(&mut self.grids[number].points);
            let bounds = points.iter().fold(Region::EMPTY, |sum, p| {
                let at = [p[0], p[1], 0.0];
                sum.union(&Region { lo: at, hi: at })
            });
            let each = || points.iter().copied();
            self.grids[number].count(each(), points.len(), &bounds, self.limit, SPARE_CROWDED);
            self.fill(number, face, each(), depth + 1);
            self.grids[number].points = points;
            let root = self.grids[number].root;
            match parent {
                Some(node) => self.nodes[node as usize].child[child] = root,
                None => self.grids[grid].root = root,
            }
        }
        self.crowded.truncate(before);
    }

    /// Makes a tile of a square of cells, or splits it. Returns the tile or node, or [`NOTHING`] if its children went to
    /// `parent`.
    fn split(
        &mut self,
        g: &mut Grid,
        face: usize,
        [level, x, y]: [u32; 3],
        parent: Option<u32>,
        depth: u32,
    ) -> u32 {
        let count = g.counts[level as usize][(y << level | x) as usize];
        let add = |tiles: &mut Tiles, entry: u32| {
            let Some(parent) = parent else { return 0 };
            let node = &mut tiles.nodes[parent as usize];
            node.child[node.count] = entry;
            node.count += 1;
            node.count - 1
        };
        // All points in one place: no grid parts them.
        let together = g.fit.scale == [0.0; 2];
        let whole = level == 0 && g.sparse.contains(&None);
        let sparse = whole || (level + g.sparse_shift == g.levels && g.sparse.contains(&Some([x, y])));
        if count > CROWDED * self.limit && level == g.levels && depth < DEPTH && !together && !sparse {
            let number = self.used;
            self.used += 1;
            if self.grids.len() < self.used {
                self.grids.push(Grid::default());
            }
            self.grids[number].root = NOTHING;
            self.grids[number].points.clear();
            let child = add(self, NOTHING);
            self.crowded.push(Crowded { number, parent, child });
            g.cells[(y << level | x) as usize] = GRID | number as u32;
            let [first_x, last_x, first_y, last_y] = g.crowds;
            g.crowds = [first_x.min(x), last_x.max(x), first_y.min(y), last_y.max(y)];
            return NOTHING;
        }
        if count <= self.limit || level == g.levels || sparse {
            let tile = self.level.len() as u32;
            let shift = g.levels - level;
            let [first, last] =
                [[x, y].map(|v| (v << shift) as u16), [x, y].map(|v| (((v + 1) << shift) - 1) as u16)];
            for _ in 0..if sparse { SHARES } else { 1 } {
                self.level.push(level as u8);
                self.sparse.push(sparse);
                self.face.push(face as u8);
                self.list.push(tile);
                self.cells.push([first[0], last[0], first[1], last[1]]);
            }
            for row in y << shift..(y + 1) << shift {
                let start = (row << g.levels | x << shift) as usize;
                g.cells[start..start + (1 << shift)].fill(tile);
            }
            add(self, tile);
            return tile;
        }
        let quarters = [0, 1, 2, 3].map(|i| [level + 1, 2 * x + (i & 1), 2 * y + (i >> 1)]);
        if level % 2 == 0 {
            let node = self.nodes.len() as u32;
            self.nodes.push(Node::EMPTY);
            g.nodes[(level / 2) as usize][(y << level | x) as usize] = node;
            add(self, NODE | node);
            for q in quarters {
                self.split(g, face, q, Some(node), depth);
            }
            NODE | node
        } else {
            for q in quarters {
                self.split(g, face, q, parent, depth);
            }
            NOTHING
        }
    }

    /// Bounds of what shares a list, and of nodes, once those of the tiles are known. Children come after their parents. Faces without samples lose their
    /// roots.
    pub(super) fn bound_nodes(&mut self) {
        for tile in 0..if self.any_sparse { self.len() } else { 0 } {
            let list = self.list[tile] as usize;
            self.region[list] = self.region[list].union(&self.region[tile]);
        }
        self.steps.clear();
        self.steps.extend(self.region.iter().map(Steps::new));
        for i in (0..self.nodes.len()).rev() {
            let (before, after) = self.nodes.split_at_mut(i + 1);
            let node = &mut before[i];
            node.region = Region::EMPTY;
            let mut kept = 0;
            for c in 0..node.count {
                let child = node.child[c];
                let region = if child & NODE != 0 {
                    after[(child & !NODE) as usize - i - 1].region
                } else {
                    self.region[child as usize]
                };
                // Children without samples are left out.
                if region.lo[0] > region.hi[0] {
                    continue;
                }
                node.child[kept] = child;
                for k in 0..3 {
                    node.bounds[k][kept] = region.lo[k];
                    node.bounds[3 + k][kept] = region.hi[k];
                }
                node.region = node.region.union(&region);
                kept += 1;
            }
            node.count = kept;
        }
        for (grid, sight) in self.grids[..FACES].iter_mut().zip(&mut self.sights.faces) {
            if grid.root == NOTHING {
                continue;
            }
            let region = self.nodes[(grid.root & !NODE) as usize].region;
            sight.bound(&region);
            if region.lo[0] > region.hi[0] {
                grid.root = NOTHING;
            }
        }
    }

    /// Bytes in use.
    pub(super) fn bytes(&self) -> usize {
        let grid =
            |g: &Grid| (g.cells.len() + g.counts.iter().chain(&g.nodes).map(Vec::len).sum::<usize>()) * 4;
        self.grids[..self.used].iter().map(grid).sum::<usize>()
            + self.nodes.len() * size_of::<Node>()
            // Region, steps, cells, list; face, level, and whether few triangles are near.
            + self.len() * (size_of::<Region>() + size_of::<Steps>() + size_of::<[u16; 4]>() + 4 + 3)
    }
}
