//! The lists: samples sorted by counting into tiles, and inside each tile into cells (methods 6.2 step 4, 6.5).
//!
//! Histogram, scan, scatter; then each list is put into the order of sample numbers, so that the result does not depend
//! on which thread came first.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rayon::prelude::*;

use super::face::{FACES, direction};
use super::grid::{Axis, Grid};
use super::tuning::{CELL_SAMPLES, LEVELS, LIST_MAX};
use super::windows::Window;

/// Eight samples of one cell, world coordinates; those that are missing repeat the first.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Block {
    pub(super) x: [f32; 8],
    pub(super) y: [f32; 8],
    pub(super) z: [f32; 8],
    pub(super) id: [u32; 8],
}

/// `Block::id` of a missing sample.
pub(super) const NO_ID: u32 = u32::MAX;

/// `Cell::blocks` of a cell that has a sub-grid instead of a list.
pub(super) const SUB_GRID: u32 = u32::MAX;

/// One cell: a list of blocks, or a sub-grid.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    /// First block, or the number of the sub-grid.
    pub(super) first: u32,
    /// Blocks in the list.
    pub(super) blocks: u32,
    /// No sample that is not in shadow yet is deeper (major component); 0: none is left.
    pub(super) far: f32,
}

/// A grid of cells inside a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) grid: Grid,
    pub(super) first_cell: u32,
    pub(super) level: u32,
}

/// The samples of one tile. Node 0 is its root.
#[derive(Debug, Default)]
pub(super) struct Tile {
    pub(super) face: usize,
    pub(super) nodes: Vec<Node>,
    pub(super) cells: Vec<Cell>,
    pub(super) blocks: Vec<Block>,
    /// Samples of each block that are not in shadow yet.
    pub(super) alive: Vec<u8>,
    /// Samples that are not in shadow yet.
    pub(super) alive_count: u32,
    /// Tests of each sample; empty unless a debug view asks for them.
    pub(super) tests: Vec<[u32; 8]>,
    pub(super) lists: Lists,
}

/// How long the lists are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lists {
    pub(super) longest: u64,
    pub(super) occupied: u64,
    pub(super) samples: u64,
    pub(super) sub_grids: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    uv: [f64; 2],
    depth: f32,
    id: u32,
}

/// Memory of one thread while it builds tiles.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    entries: Vec<Entry>,
    sorted: Vec<Entry>,
    starts: Vec<u32>,
    open: Vec<(usize, usize, u32, u32)>,
}

/// Which tile each sample is in, as lists. Kept between frames.
#[derive(Debug, Default)]
pub(super) struct TileLists {
    key: Vec<u32>,
    cursor: Vec<AtomicU32>,
    pub(super) starts: Vec<u32>,
    ids: Vec<AtomicU32>,
}

const NO_TILE: u32 = u32::MAX;

impl TileLists {
    /// Sorts the samples into the tiles of the windows. Returns how many there are.
    pub(super) fn sort(
        &mut self,
        positions: &[[f32; 3]],
        light: [f32; 3],
        windows: &[Window; FACES],
    ) -> usize {
        let tiles: usize = windows.iter().filter(|w| w.samples > 0).map(|w| w.tiles.cells()).sum();
        self.cursor.clear();
        self.cursor.resize_with(tiles, AtomicU32::default);
        self.key.resize(positions.len(), NO_TILE);
        let cursor = &self.cursor;
        self.key.par_chunks_mut(4096).zip(positions.par_chunks(4096)).for_each(|(keys, positions)| {
            for (key, p) in keys.iter_mut().zip(positions) {
                *key = direction(*p, light).map_or(NO_TILE, |d| {
                    let window = &windows[d.face];
                    window.first + window.tiles.cell(d.uv) as u32
                });
                if *key != NO_TILE {
                    cursor[*key as usize].fetch_add(1, Relaxed);
                }
            }
        });
        self.starts.clear();
        let mut sum = 0;
        for c in &mut self.cursor {
            self.starts.push(sum);
            let count = std::mem::replace(c.get_mut(), sum);
            sum += count;
        }
        self.starts.push(sum);
        self.ids.resize_with(positions.len(), AtomicU32::default);
        let (cursor, ids) = (&self.cursor, &self.ids);
        self.key.par_chunks(4096).enumerate().for_each(|(chunk, keys)| {
            for (i, &key) in keys.iter().enumerate() {
                if key != NO_TILE {
                    let slot = cursor[key as usize].fetch_add(1, Relaxed);
                    ids[slot as usize].store((chunk * 4096 + i) as u32, Relaxed);
                }
            }
        });
        sum as usize
    }

    pub(super) fn bytes(&self) -> usize {
        4 * (self.key.capacity() + self.cursor.capacity() + self.starts.capacity() + self.ids.capacity())
    }

    /// Builds the cells of all tiles; `tiles` keeps the memory of earlier frames.
    pub(super) fn build_cells(
        &self,
        positions: &[[f32; 3]],
        light: [f32; 3],
        windows: &[Window; FACES],
        tiles: &mut Vec<Tile>,
    ) -> Lists {
        let count = self.starts.len() - 1;
        if tiles.len() < count {
            tiles.resize_with(count, Tile::default);
        }
        let face_of = |tile: usize| {
            (0..FACES)
                .rev()
                .find(|&f| windows[f].samples > 0 && windows[f].first as usize <= tile)
                .unwrap_or_default()
        };
        tiles[..count]
            .par_iter_mut()
            .enumerate()
            .map_init(Scratch::default, |scratch, (index, tile)| {
                let ids = &self.ids[self.starts[index] as usize..self.starts[index + 1] as usize];
                tile.face = face_of(index);
                scratch.entries.clear();
                for id in ids {
                    let id = id.load(Relaxed);
                    if let Some(d) = direction(positions[id as usize], light) {
                        // Rounded up: half a unit in the last place of f32 covers the rounding of the depth, too.
                        let depth = (d.depth as f32).next_up();
                        scratch.entries.push(Entry { uv: d.uv, depth, id });
                    }
                }
                tile.build(positions, scratch);
                tile.lists
            })
            .reduce(Lists::default, |mut a, b| {
                a.longest = a.longest.max(b.longest);
                a.occupied += b.occupied;
                a.samples += b.samples;
                a.sub_grids += b.sub_grids;
                a
            })
    }
}

impl Tile {
    pub(super) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.cells.capacity() * size_of::<Cell>()
            + self.blocks.capacity() * size_of::<Block>()
            + self.alive.capacity()
            + self.tests.capacity() * size_of::<[u32; 8]>()
    }

    /// Makes the grids and lists of the entries in `scratch`.
    fn build(&mut self, positions: &[[f32; 3]], scratch: &mut Scratch) {
        self.nodes.clear();
        self.cells.clear();
        self.blocks.clear();
        self.alive.clear();
        self.tests.clear();
        self.lists = Lists::default();
        let count = scratch.entries.len();
        self.alive_count = count as u32;
        if count == 0 {
            return;
        }
        scratch.entries.sort_unstable_by_key(|e| e.id);
        scratch.sorted.resize(count.max(scratch.sorted.len()), Entry::default());
        scratch.open.clear();
        let root = count as f64 / CELL_SAMPLES;
        self.make_grid(0, count, root, 0, positions, scratch);
        while let Some((begin, end, cell, level)) = scratch.open.pop() {
            // A sub-grid of 2^ceil(log4(count / LIST_MAX)) cells a side.
            let ratio = (end - begin).div_ceil(LIST_MAX);
            let side = ratio.next_power_of_two().trailing_zeros().div_ceil(2);
            let node = self.nodes.len() as u32;
            self.make_grid(begin, end, f64::from(1u32 << (2 * side)), level, positions, scratch);
            self.cells[cell as usize].first = node;
            self.cells[cell as usize].blocks = SUB_GRID;
            self.lists.sub_grids += 1;
        }
        debug_assert_eq!(self.lists.samples, count as u64);
    }

    /// A grid of about `cells` cells over the rectangle that the entries really occupy.
    fn make_grid(
        &mut self,
        begin: usize,
        end: usize,
        cells: f64,
        level: u32,
        positions: &[[f32; 3]],
        scratch: &mut Scratch,
    ) {
        let entries = &mut scratch.entries[begin..end];
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for e in &*entries {
            for k in 0..2 {
                lo[k] = lo[k].min(e.uv[k]);
                hi[k] = hi[k].max(e.uv[k]);
            }
        }
        let size = [hi[0] - lo[0], hi[1] - lo[1]];
        // Sides in the proportion of the rectangle; all cells along one side if the other has no length.
        let columns = (cells * size[0] / size[1]).sqrt().ceil().clamp(1.0, cells.ceil().max(1.0));
        let columns = if columns.is_nan() { 1.0 } else { columns };
        let rows = (cells / columns).ceil().max(1.0);
        let grid =
            Grid { u: Axis::new(lo[0], hi[0], columns as u32), v: Axis::new(lo[1], hi[1], rows as u32) };
        // The rounded ratio may leave a single cell where the rectangle is not a point: part the longer side.
        let grid = if grid.cells() == 1 && cells > 1.0 {
            let n = |k: usize| if size[k] >= size[1 - k] { 2 } else { 1 };
            Grid { u: Axis::new(lo[0], hi[0], n(0)), v: Axis::new(lo[1], hi[1], n(1)) }
        } else {
            grid
        };

        scratch.starts.clear();
        scratch.starts.resize(grid.cells() + 1, 0);
        for e in &*entries {
            scratch.starts[grid.cell(e.uv) + 1] += 1;
        }
        for i in 1..scratch.starts.len() {
            scratch.starts[i] += scratch.starts[i - 1];
        }
        let sorted = &mut scratch.sorted[begin..end];
        for e in &*entries {
            let start = &mut scratch.starts[grid.cell(e.uv)];
            sorted[*start as usize] = *e;
            *start += 1;
        }
        entries.copy_from_slice(sorted);

        let first_cell = self.cells.len() as u32;
        self.nodes.push(Node { grid, first_cell, level });
        let mut from = begin;
        for i in 0..grid.cells() {
            // After the scatter each start is the end of its list.
            let to = begin + scratch.starts[i] as usize;
            let list = &scratch.entries[from..to];
            let far = list.iter().fold(0.0, |far: f32, e| far.max(e.depth));
            let cell = self.cells.len() as u32;
            self.cells.push(Cell { first: 0, blocks: 0, far });
            if list.len() > LIST_MAX && grid.cells() > 1 && level + 1 < LEVELS {
                scratch.open.push((from, to, cell, level + 1));
            } else if !list.is_empty() {
                let first = self.blocks.len() as u32;
                for eight in list.chunks(8) {
                    let at = |i: usize| positions[eight.get(i).unwrap_or(&eight[0]).id as usize];
                    let p = [0, 1, 2, 3, 4, 5, 6, 7].map(at);
                    let id = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| eight.get(i).map_or(NO_ID, |e| e.id));
                    self.blocks.push(Block {
                        x: p.map(|p| p[0]),
                        y: p.map(|p| p[1]),
                        z: p.map(|p| p[2]),
                        id,
                    });
                    self.alive.push(((1u32 << eight.len()) - 1) as u8);
                }
                let made = &mut self.cells[cell as usize];
                made.first = first;
                made.blocks = self.blocks.len() as u32 - first;
                self.lists.occupied += 1;
                self.lists.samples += list.len() as u64;
                self.lists.longest = self.lists.longest.max(list.len() as u64);
            }
            from = to;
        }
    }
}
