//! Triangles meet the lists of a tile: cells by edge functions and depth, then eight samples at a time (methods 6.2 step 6).

use antumbra_predicates::Triangle;
use fearless_simd::Simd;

use super::build::{SUB_GRID, Tile};
use super::face::{FaceTriangle, PAD, Shadow};
use crate::methods::leaf::{LeafCounts, LeafTest};

/// Work of one or more tiles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// (cell, triangle) pairs that the edges left, sub-grids' cells included.
    pub(super) node_visits: u64,
    /// Of those: no sample of the cell is deep enough, or left.
    pub(super) node_reject: u64,
    /// Of those: went on to a sub-grid.
    pub(super) node_refine: u64,
    /// (tile, triangle) pairs not looked at because the tile was wholly in shadow.
    pub(super) early_out_shadowed: u64,
    pub(super) leaf: LeafCounts,
}

impl Counts {
    pub(super) fn add(mut self, other: Counts) -> Counts {
        self.node_visits += other.node_visits;
        self.node_reject += other.node_reject;
        self.node_refine += other.node_refine;
        self.early_out_shadowed += other.early_out_shadowed;
        self.leaf.add(&other.leaf);
        self
    }
}

/// Brings the triangles of `pairs` to one tile. Each list of the tile meets each triangle at most once. Returns the new depth of
/// the tile's deepest sample that is not in shadow, 0 if there is none.
#[inline(always)]
pub(super) fn process<S: Simd>(
    s: S,
    tile: &mut Tile,
    pairs: &[u64],
    triangles: &[Triangle],
    light: [f32; 3],
    stack: &mut Vec<u32>,
    counts: &mut Counts,
) -> f32 {
    for (done, pair) in pairs.iter().enumerate() {
        if tile.alive_count == 0 {
            counts.early_out_shadowed += (pairs.len() - done) as u64;
            break;
        }
        let triangle = &triangles[(pair & 0xffff_ffff) as usize];
        let Some(shadow) = Shadow::new(triangle, light) else { continue };
        let Some(on_face) = shadow.on_face(tile.face, tile.nodes[0].grid.window()) else { continue };
        one_triangle(s, tile, triangle, &on_face, light, stack, counts);
    }
    tile.cells.iter().filter(|c| c.blocks != SUB_GRID).fold(0.0, |far, c| far.max(c.far))
}

#[inline(always)]
fn one_triangle<S: Simd>(
    s: S,
    tile: &mut Tile,
    triangle: &Triangle,
    on_face: &FaceTriangle,
    light: [f32; 3],
    stack: &mut Vec<u32>,
    counts: &mut Counts,
) {
    let mut leaf = None;
    stack.clear();
    stack.push(0);
    while let Some(node) = stack.pop() {
        let node = tile.nodes[node as usize];
        let (u, v) = (&node.grid.u, &node.grid.v);
        let Some(rows) = v.range([on_face.lo[1], on_face.hi[1]], PAD) else { continue };
        for row in rows[0]..=rows[1] {
            let ends = v.ends(row, row);
            let Some(columns) = on_face.span(ends).and_then(|span| u.range(span, PAD)) else { continue };
            let first = (node.first_cell + row * u.n) as usize;
            for column in columns[0]..=columns[1] {
                let cell = tile.cells[first + column as usize];
                counts.node_visits += 1;
                if cell.far == 0.0
                    || on_face.in_front_of_plane(u.ends(column, column), ends, f64::from(cell.far))
                {
                    counts.node_reject += 1;
                    continue;
                }
                if cell.blocks == SUB_GRID {
                    counts.node_refine += 1;
                    stack.push(cell.first);
                    continue;
                }
                let leaf = match &mut leaf {
                    Some(leaf) => leaf,
                    none => match LeafTest::new(triangle, light) {
                        Some(made) => none.insert(made),
                        None => return,
                    },
                };
                if test_list(s, tile, cell.first, cell.blocks, leaf, &mut counts.leaf) {
                    tile.cells[first + column as usize].far = 0.0;
                }
            }
        }
    }
}

/// Tests the samples of a list that are not in shadow yet. True if none is left.
#[inline(always)]
fn test_list<S: Simd>(
    s: S,
    tile: &mut Tile,
    first: u32,
    blocks: u32,
    leaf: &mut LeafTest<'_>,
    counts: &mut LeafCounts,
) -> bool {
    let mut left = 0;
    for i in first as usize..(first + blocks) as usize {
        let asked = tile.alive[i];
        if asked == 0 {
            continue;
        }
        let block = &tile.blocks[i];
        let hits = leaf.eight(s, &block.x, &block.y, &block.z, asked, counts);
        if let Some(tests) = tile.tests.get_mut(i) {
            for (lane, count) in tests.iter_mut().enumerate() {
                *count += u32::from(asked >> lane & 1);
            }
        }
        tile.alive[i] = asked & !hits;
        tile.alive_count -= hits.count_ones();
        left |= asked & !hits;
    }
    left == 0
}
