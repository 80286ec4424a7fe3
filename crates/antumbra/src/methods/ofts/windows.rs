//! Heat maps, and the tight window of every face that has samples (methods 6.2, steps 1 to 3).

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rayon::prelude::*;

use super::face::{FACES, direction};
use super::grid::{Axis, Grid};
use super::tuning::{HEAT, TILE_SAMPLES, TILES_A_SIDE, ZOOM_BELOW, ZOOMS};

/// The tiles of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Window {
    /// Samples counted in it; 0: the face is not active.
    pub(super) samples: u32,
    pub(super) tiles: Grid,
    /// Number of its first tile, over all windows.
    pub(super) first: u32,
}

/// What a face's heat map says.
struct Heat {
    samples: u64,
    occupied: u64,
    columns: [u32; 2],
    rows: [u32; 2],
}

fn read(heat: &[AtomicU32]) -> Heat {
    let mut out = Heat { samples: 0, occupied: 0, columns: [HEAT, 0], rows: [HEAT, 0] };
    for (row, cells) in (0..).zip(heat.chunks_exact(HEAT as usize)) {
        for (column, cell) in (0..).zip(cells) {
            let count = cell.load(Relaxed);
            if count > 0 {
                out.samples += u64::from(count);
                out.occupied += 1;
                out.columns = [out.columns[0].min(column), out.columns[1].max(column)];
                out.rows = [out.rows[0].min(row), out.rows[1].max(row)];
            }
        }
    }
    out
}

/// Finds the windows. Their ends are ends of heat cells, and which samples a heat cell has was decided by the same
/// function of the same numbers, so no sample can be outside by more than the rounding that `PAD` covers.
pub(super) fn find_windows(
    positions: &[[f32; 3]],
    light: [f32; 3],
    heat: &mut Vec<AtomicU32>,
) -> [Window; FACES] {
    let map = (HEAT * HEAT) as usize;
    heat.resize_with(FACES * map, AtomicU32::default);
    let mut maps = [Grid { u: Axis::new(-1.0, 1.0, HEAT), v: Axis::new(-1.0, 1.0, HEAT) }; FACES];
    let mut open = [true; FACES];
    let mut windows = [Window::default(); FACES];
    for zoom in 0..=ZOOMS {
        for (face, cells) in heat.chunks_exact_mut(map).enumerate() {
            if open[face] {
                cells.iter_mut().for_each(|c| *c.get_mut() = 0);
            }
        }
        let shared = &*heat;
        positions.par_chunks(4096).for_each(|chunk| {
            for p in chunk {
                if let Some(d) = direction(*p, light)
                    && open[d.face]
                {
                    let cells = &maps[d.face];
                    let cell = cells.v.index(d.uv[1]) * HEAT + cells.u.index(d.uv[0]);
                    shared[d.face * map + cell as usize].fetch_add(1, Relaxed);
                }
            }
        });
        for face in 0..FACES {
            if !open[face] {
                continue;
            }
            let found = read(&heat[face * map..(face + 1) * map]);
            open[face] = false;
            if found.samples == 0 {
                continue;
            }
            let old = maps[face];
            let u = old.u.ends(found.columns[0], found.columns[1]);
            let v = old.v.ends(found.rows[0], found.rows[1]);
            let columns = found.columns[1] - found.columns[0] + 1;
            let rows = found.rows[1] - found.rows[0] + 1;
            if columns.max(rows) <= ZOOM_BELOW && zoom < ZOOMS && old.u.n == HEAT && old.v.n == HEAT {
                maps[face] = Grid { u: Axis::new(u[0], u[1], HEAT), v: Axis::new(v[0], v[1], HEAT) };
                open[face] = true;
                continue;
            }
            windows[face] = Window {
                samples: found.samples as u32,
                tiles: tiles(u, v, [columns, rows], &found),
                first: 0,
            };
        }
        if open == [false; FACES] {
            break;
        }
    }
    let mut first = 0;
    for window in &mut windows {
        window.first = first;
        first += if window.samples > 0 { window.tiles.cells() as u32 } else { 0 };
    }
    windows
}

/// As many tiles that an occupied one has about [`TILE_SAMPLES`], with sides in the proportion of the window's heat cells.
fn tiles(u: [f64; 2], v: [f64; 2], size: [u32; 2], heat: &Heat) -> Grid {
    let wanted = heat.samples as f64 / TILE_SAMPLES;
    let occupied = heat.occupied as f64 / (f64::from(size[0]) * f64::from(size[1]));
    // Samples along a thin line occupy little of their window: 16 times as many tiles as they fill are enough.
    let count = (wanted / occupied).min(16.0 * wanted + 1.0).max(1.0);
    let side = |a: u32, b: u32| {
        let n = (count * f64::from(a) / f64::from(b)).sqrt().ceil();
        (n as u32).clamp(1, TILES_A_SIDE)
    };
    Grid {
        u: Axis::new(u[0], u[1], side(size[0], size[1])),
        v: Axis::new(v[0], v[1], side(size[1], size[0])),
    }
}
