//! Samples in no order, as in shuffled lists and in clumps that alternate from pixel to pixel, go to their tiles one by one, which costs more than
//! anything else. Where few triangles are near them, they need no small tiles: there, blocks are leaves as they are, or as many as
//! clumps alternate in them.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use antumbra_predicates::Triangle;
use antumbra_predicates::aim::seen_bounds;
use antumbra_predicates::tile::Region;
use fearless_simd::{Simd, SimdBase, SimdMask, dispatch};
use rayon::prelude::*;

use super::descend::Caster;
use super::frame::FACES;
use super::grid::{Grid, NOTHING, Node, Point, Tiles};
use super::prefetch::prefetch_eight;
use super::project::SeenEight;
use super::shuffle::corners;
use super::sight::Sight;
use super::tuning::{FEW_NEAR, LOOKED_AT, NEAR_EVERY, TRIANGLES};
use crate::Isa;
use crate::methods::simd_level;

/// Regions of one face, at most: those of a node.
const MOST: usize = 16;

/// Groups of triangles that are asked for ahead.
const AHEAD: usize = 4;

/// Neighbours that are looked at, about.
const PAIRS: usize = 4096;

/// Many samples of one face: a square of crowded cells (column and row), or all.
#[derive(Debug)]
struct Crowd {
    cell: Option<[u32; 2]>,
    region: Region,
    /// Triangles that may block some of them; no longer counted when they are more than a few.
    triangles: AtomicUsize,
}

impl Crowd {
    fn new(cell: Option<[u32; 2]>, region: Region) -> Crowd {
        Crowd { cell, region, triangles: AtomicUsize::new(0) }
    }

    fn has_few(&self) -> bool {
        self.triangles.load(Relaxed) <= FEW_NEAR
    }
}

/// Crowds by face. Memory is kept.
#[derive(Debug, Default)]
pub(super) struct Crowds {
    of_face: [Vec<Crowd>; FACES],
    squares: Vec<[u32; 2]>,
    larger: Vec<[u32; 2]>,
}

impl Crowds {
    /// Finds crowded cells and faces that few triangles are near, and tells the grids. `points` have `columns` a row; `bounds` are those of the
    /// points of each face. Nothing is looked at unless many samples are in a few cells, or neighbours far apart.
    pub(super) fn find(
        &mut self,
        isa: Isa,
        tiles: &mut Tiles,
        points: &[Point],
        columns: usize,
        bounds: &[Region; FACES],
        triangles: &[Triangle],
    ) {
        self.of_face.iter_mut().for_each(Vec::clear);
        if tiles.crowded_part() > LOOKED_AT {
            self.add_cells(tiles, points, bounds);
        } else if far_part(tiles, points, columns) > LOOKED_AT {
            for (face, crowds) in self.of_face.iter_mut().enumerate() {
                if tiles.grids[face].points_in_all() > tiles.most_points() {
                    crowds.push(Crowd::new(None, bounds[face]));
                }
            }
        }
        let (crowds, sights) = (&self.of_face, &tiles.sights.faces);
        if crowds.iter().all(Vec::is_empty) {
            return;
        }
        let nodes = crowds.each_ref().map(|crowds| node(crowds));
        let level = simd_level(isa);
        triangles.par_chunks(TRIANGLES).for_each(|triangles| {
            if crowds.iter().flatten().any(Crowd::has_few) {
                dispatch!(level, s => scan(s, triangles, sights, crowds, &nodes));
            }
        });
        for (grid, crowds) in tiles.grids.iter_mut().zip(crowds) {
            grid.sparse.extend(crowds.iter().filter(|crowd| crowd.has_few()).map(|crowd| crowd.cell));
        }
    }

    /// Squares of crowded cells, and the bounds of their points.
    fn add_cells(&mut self, tiles: &mut Tiles, points: &[Point], bounds: &[Region; FACES]) {
        let limit = tiles.most_points();
        let Crowds { of_face, squares, larger } = self;
        for (grid, crowds) in tiles.grids.iter_mut().zip(&mut *of_face) {
            grid.sparse_shift = grid.crowded_squares(limit, MOST, squares, larger);
            crowds.extend(squares.iter().map(|square| Crowd::new(Some(*square), Region::EMPTY)));
        }
        for point in points.iter().filter(|point| point.face != NOTHING) {
            let face = point.face as usize;
            let Grid { fit, sparse_shift, .. } = &tiles.grids[face];
            let [x, y] = point.at;
            let square = [fit.cell(0, x), fit.cell(1, y)].map(|c| c >> sparse_shift);
            if let Some(crowd) = of_face[face].iter_mut().find(|crowd| crowd.cell == Some(square)) {
                let Region { lo: [.., farthest], hi: [.., nearest] } = bounds[face];
                let region = Region { lo: [x, y, farthest], hi: [x, y, nearest] };
                crowd.region = crowd.region.union(&region);
            }
        }
    }
}

/// Of neighbours in the picture, the part that is in different tiles, mostly. A few thousand are looked at.
fn far_part(tiles: &Tiles, points: &[Point], columns: usize) -> f32 {
    let (mut pairs, mut far) = (0, 0);
    for row in points.chunks(columns.max(1)).step_by(1 + points.len() / PAIRS) {
        for [a, b] in row.array_windows() {
            if a.face != NOTHING && b.face != NOTHING {
                pairs += 1;
                far += u32::from(a.face != b.face || tiles.grids[a.face as usize].are_far(a.at, b.at));
            }
        }
    }
    far as f32 / pairs.max(1) as f32
}

/// The regions of some crowds, to be held against triangles at once.
fn node(crowds: &[Crowd]) -> Node {
    let mut node = Node::EMPTY;
    for (i, crowd) in crowds.iter().enumerate() {
        for k in 0..3 {
            node.bounds[k][i] = crowd.region.lo[k];
            node.bounds[3 + k][i] = crowd.region.hi[k];
        }
    }
    node.count = crowds.len();
    node
}

/// The first of the eight triangles that are looked at, now these, now those, as what repeats in a mesh must not hide.
fn pick(group: usize) -> usize {
    8 * ((group as u32).wrapping_mul(0x9e37_79b9) >> 16) as usize % (8 * NEAR_EVERY)
}

/// Counts triangles near the crowds.
#[inline(always)]
fn scan<S: Simd>(
    s: S,
    triangles: &[Triangle],
    sights: &[Sight; FACES],
    crowds: &[Vec<Crowd>; FACES],
    nodes: &[Node; FACES],
) {
    let few = 8 * NEAR_EVERY;
    for (i, group) in triangles.chunks(few).enumerate() {
        prefetch_eight(triangles, few * (i + AHEAD) + pick(i + AHEAD));
        let eight = &group[pick(i).min(group.len().saturating_sub(8))..];
        let eight = &eight[..eight.len().min(8)];
        let at = |i: usize| &eight[i.min(eight.len() - 1)];
        let world = corners(s, [at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)]);
        for (face, crowds) in crowds.iter().enumerate().filter(|(_, crowds)| !crowds.is_empty()) {
            let Sight { frame, aim, depth, .. } = &sights[face];
            let turned = [frame.turn_eight(world[0]), frame.turn_eight(world[1]), frame.turn_eight(world[2])];
            // What is behind the light in this direction has open bounds.
            let farthest = turned[0][2].max(turned[1][2]).max(turned[2][2]);
            let ahead = farthest.simd_gt(aim.light()[2]).to_bitmask() as u32;
            let [x_lo, x_hi, y_lo, y_hi, r_hi] = seen_bounds::<S, true>(s, aim, *depth, &turned);
            let seen = SeenEight { x: [x_lo, x_hi], y: [y_lo, y_hi], r: r_hi };
            let mut near = 0;
            for crowd in crowds {
                near |= seen.near(&crowd.region);
            }
            near &= ahead & ((1 << eight.len()) - 1);
            while near != 0 {
                let i = near.trailing_zeros() as usize;
                near &= near - 1;
                count(s, &eight[i], &sights[face], crowds, &nodes[face]);
            }
        }
    }
}

/// Holds a triangle against the crowds of a face with all four tests.
#[inline(never)]
fn count<S: Simd>(s: S, triangle: &Triangle, sight: &Sight, crowds: &[Crowd], node: &Node) {
    s.vectorize(
        #[inline(always)]
        || {
            let caster = Caster::new::<true>(s, triangle, sight);
            for (first, crowds) in crowds.chunks(8).enumerate() {
                let (maybe, _) = caster.against(s, node, 8 * first);
                for (i, crowd) in crowds.iter().enumerate() {
                    if maybe >> i & 1 == 1 && crowd.has_few() {
                        crowd.triangles.fetch_add(1, Relaxed);
                    }
                }
            }
        },
    );
}
