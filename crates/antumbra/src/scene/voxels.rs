//! A coarse picture of where things are: enough to tell a room from a statue and to stand in free space.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::Triangle;
use crate::vec3::{V3, add, cross, dot, scale, sub};

/// Cells along the longest side. Walls and door openings of a building are seen; it costs some 20 ms for a million triangles.
const RESOLUTION: f32 = 48.0;

/// Cubes in a box; full where a triangle passes through.
pub(super) struct Voxels {
    lo: V3,
    pub(super) cell: f32,
    pub(super) size: [usize; 3],
    full: Vec<AtomicBool>,
}

impl Voxels {
    /// Fills the cells of the box `lo..hi` that the triangles touch (separating axes: box, plane, 9 edge products).
    pub(super) fn new(triangles: &[Triangle], lo: V3, hi: V3) -> Voxels {
        let extent = sub(hi, lo);
        let longest = extent.into_iter().fold(0.0, f32::max);
        let cell = if longest > 0.0 && longest.is_finite() { longest / RESOLUTION } else { 1.0 };
        let size = extent.map(|e| (e / cell).ceil().clamp(1.0, RESOLUTION) as usize + 2);
        let cells = size[0] * size[1] * size[2];
        let full = std::iter::repeat_with(AtomicBool::default).take(cells).collect();
        // One cell of margin on each side: walls on the border of the box are inside the grid.
        let voxels = Voxels { lo: lo.map(|v| v - cell), cell, size, full };
        triangles.par_iter().with_min_len(1024).for_each(|t| voxels.fill(t));
        voxels
    }

    fn fill(&self, t: &Triangle) {
        let (mut first, mut last) = ([0; 3], [0; 3]);
        for k in 0..3 {
            let lo = t[0][k].min(t[1][k]).min(t[2][k]) - self.lo[k];
            let hi = t[0][k].max(t[1][k]).max(t[2][k]) - self.lo[k];
            let end = self.size[k] as f32;
            let (a, b) = (lo / self.cell, hi / self.cell);
            // Written so that NaN (an overflow of huge coordinates) also leaves.
            if !(a < end && b >= 0.0) {
                return;
            }
            (first[k], last[k]) = (a.max(0.0) as usize, b.min(end - 1.0) as usize);
        }
        if first == last {
            self.full[self.index(first)].store(true, Ordering::Relaxed);
            return;
        }
        let edges = [sub(t[1], t[0]), sub(t[2], t[1]), sub(t[0], t[2])];
        let mut axes = [[0.0; 3]; 10];
        axes[0] = cross(edges[0], edges[1]);
        for (e, edge) in edges.iter().enumerate() {
            for k in 0..3 {
                let mut unit = [0.0; 3];
                unit[k] = 1.0;
                axes[1 + 3 * e + k] = cross(*edge, unit);
            }
        }
        let spans = axes.map(|axis| {
            let p = t.map(|corner| dot(axis, corner));
            let reach = 0.5 * self.cell * (axis[0].abs() + axis[1].abs() + axis[2].abs()) * 1.01;
            (p[0].min(p[1]).min(p[2]) - reach, p[0].max(p[1]).max(p[2]) + reach)
        });
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let centre = self.centre([x, y, z]);
                    let apart = |k: usize| {
                        let c = dot(axes[k], centre);
                        c < spans[k].0 || c > spans[k].1
                    };
                    if !(0..10).any(apart) {
                        self.full[self.index([x, y, z])].store(true, Ordering::Relaxed);
                    }
                }
            }
        }
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// The middle of a cell.
    pub(super) fn centre(&self, cell: [usize; 3]) -> V3 {
        [0, 1, 2].map(|k| self.lo[k] + (cell[k] as f32 + 0.5) * self.cell)
    }

    /// Whether the cell at `p` is full; `None` outside the grid.
    pub(super) fn is_full(&self, p: V3) -> Option<bool> {
        let at = [0, 1, 2].map(|k| (p[k] - self.lo[k]) / self.cell);
        let inside = (0..3).all(|k| at[k] >= 0.0 && at[k] < self.size[k] as f32);
        inside.then(|| self.full[self.index(at.map(|v| v as usize))].load(Ordering::Relaxed))
    }

    /// Whether the cell is full.
    pub(super) fn cell_is_full(&self, cell: [usize; 3]) -> bool {
        self.full[self.index(cell)].load(Ordering::Relaxed)
    }

    /// How far one gets from `p` along the unit vector `direction`: `Ok` up to something, `Err` up to the grid's border.
    pub(super) fn free_path(&self, p: V3, direction: V3) -> Result<f32, f32> {
        let step = 0.4 * self.cell;
        let steps = 1 + (3.0 * RESOLUTION / 0.4) as usize;
        for k in 1..steps {
            let distance = step * k as f32;
            match self.is_full(add(p, scale(direction, distance))) {
                Some(true) => return Ok(distance),
                Some(false) => {}
                None => return Err(distance),
            }
        }
        Err(step * steps as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slanted_wall_has_no_hole_and_is_thin() {
        let wall = [[-1.0, -1.0, -1.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]];
        let voxels = Voxels::new(&[wall], [-1.0; 3], [1.0; 3]);
        let full = voxels.full.iter().filter(|f| f.load(Ordering::Relaxed)).count();
        assert!(full > 48 * 48 / 2 && full < 48 * 48 * 4, "{full}");
        for i in 0..40 {
            for j in 0..40 {
                let p = [-0.9 + 0.04 * i as f32, -0.9 + 0.04 * j as f32, 1.0];
                let height = -1.0 + (p[0] + 1.0) / 4.0 + (p[1] + 1.0) / 4.0;
                let met = voxels.free_path(p, [0.0, 0.0, -1.0]).expect("the wall is there");
                assert!((met - (1.0 - height)).abs() < 0.1);
            }
        }
        assert!(voxels.free_path([0.0; 3], [0.0, 0.0, 1.0]).is_err());
    }

    #[test]
    fn hard_numbers_do_not_panic() {
        for v in [0.0, 1e-40, 1e30, 3e38] {
            let t = [[v, -v, v], [-v, v, 0.0], [v, v, -v]];
            let voxels = Voxels::new(&[t], [-v; 3], [v; 3]);
            let _ = voxels.free_path([0.0; 3], [1.0, 0.0, 0.0]);
        }
    }
}
