//! Shapes. Neighbouring triangles share their corners bit for bit: every corner is computed once or by one formula.

use rayon::prelude::*;

use super::build::{Builder, frame, round, square_to};
use super::math::{V3, add, around, cross, dot, lerp, scale, sub, turn, unit};

/// Neighbouring faces that are turned by less than this (a cosine) are shaded as one smooth surface.
const CREASE: f64 = 0.75;

/// Grids with more points than this are computed on all cores.
const PARALLEL: usize = 1 << 14;

impl Builder {
    /// A grid of `n[0] x n[1]` quadrangles: `f(u, v)` with both in `[0, 1]` gives the corners. Where `closed[k]`, the
    /// last column is the first one. Quadrangles that collapse (at poles) become single triangles.
    pub(super) fn surface(&mut self, n: [usize; 2], closed: [bool; 2], f: impl Fn(f64, f64) -> V3 + Sync) {
        let points = [0, 1].map(|k| if closed[k] { n[k] } else { n[k] + 1 });
        let point = |k: usize| {
            let (i, j) = (k % points[0], k / points[0]);
            self.placed(f(i as f64 / n[0] as f64, j as f64 / n[1] as f64))
        };
        let grid: Vec<V3> = if points[0] * points[1] > PARALLEL {
            (0..points[0] * points[1]).into_par_iter().map(point).collect()
        } else {
            (0..points[0] * points[1]).map(point).collect()
        };
        let at = |i: usize, j: usize| grid[(j % points[1]) * points[0] + i % points[0]];
        let corners = |i, j| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        let face = |i: usize, j: usize| {
            let [a, b, c, d] = corners(i, j);
            unit(cross(sub(c, a), sub(d, b)))
        };
        let faces: Vec<V3> = if n[0] * n[1] > PARALLEL {
            (0..n[0] * n[1]).into_par_iter().map(|k| face(k % n[0], k / n[0])).collect()
        } else {
            (0..n[0] * n[1]).map(|k| face(k % n[0], k / n[0])).collect()
        };
        // The faces on both sides of grid line `i` of direction `k`.
        let beside = |k: usize, i: usize| {
            let last = n[k] - 1;
            if closed[k] { [(i + last) % n[k], i % n[k]] } else { [i.saturating_sub(1), i.min(last)] }
        };
        let normal = |own: V3, i: usize, j: usize| {
            let mut sum = [0.0; 3];
            for q in beside(1, j) {
                for p in beside(0, i) {
                    let other = faces[q * n[0] + p];
                    if dot(own, other) > CREASE {
                        sum = add(sum, other);
                    }
                }
            }
            round(unit(sum))
        };
        for j in 0..n[1] {
            for i in 0..n[0] {
                let [a, b, c, d] = corners(i, j).map(round);
                let own = faces[j * n[0] + i];
                let [na, nb, nc, nd] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| normal(own, i, j));
                for (corners, normals) in [([a, b, c], [na, nb, nc]), ([a, c, d], [na, nc, nd])] {
                    if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
                        self.smooth_triangle(corners, normals);
                    }
                }
            }
        }
    }

    /// A box, closed: 12 triangles that share 8 corners.
    pub(super) fn block(&mut self, lo: V3, hi: V3) -> &mut Self {
        let p = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { lo[axis] } else { hi[axis] });
        for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            self.quad(face.map(p));
        }
        self
    }

    /// A box given by the middle of its lower face and its size.
    pub(super) fn block_on(&mut self, [x, y, z]: V3, [w, h, d]: V3) -> &mut Self {
        self.block([x - w / 2.0, y, z - d / 2.0], [x + w / 2.0, y + h, z + d / 2.0])
    }

    /// A sphere, closed, of `sides` meridians.
    pub(super) fn sphere(&mut self, centre: V3, radius: f64, sides: usize) -> &mut Self {
        self.surface([sides, sides.div_ceil(2)], [true, false], |u, v| {
            let (cos, sin) = turn(v / 2.0);
            add(centre, around(radius * sin, -u, -radius * cos))
        });
        self
    }

    /// A surface of revolution about the y axis through points `[radius, y]`; closed if it starts and ends on the axis.
    pub(super) fn lathe(&mut self, profile: &[[f64; 2]], sides: usize) -> &mut Self {
        let rows = profile.len() - 1;
        self.surface([sides, rows], [true, false], |u, v| {
            let [radius, y] = profile[(v * rows as f64).round() as usize];
            around(radius, -u, y)
        });
        self
    }

    /// An upright cylinder or cone, closed.
    pub(super) fn cone(&mut self, foot: V3, radii: [f64; 2], height: f64, sides: usize) -> &mut Self {
        let profile = [[0.0, 0.0], [radii[0], 0.0], [radii[1], height], [0.0, height]];
        self.within(super::build::Place::at(foot), |b| {
            b.lathe(&profile, sides);
        })
    }

    /// A tube along a path, closed at both ends; `radius(t)` with `t` from 0 to 1.
    pub(super) fn tube(
        &mut self,
        path: &[V3],
        sides: usize,
        radius: impl Fn(f64) -> f64 + Sync,
    ) -> &mut Self {
        let frames = frames(path);
        let last = path.len() - 1;
        // Rows 0 and last + 2 are the middles of the two caps.
        self.surface([sides, last + 2], [true, false], |u, v| {
            let row = (v * (last + 2) as f64).round() as usize;
            let k = row.clamp(1, last + 1) - 1;
            if row == 0 || row == last + 2 {
                return path[k];
            }
            let (cos, sin) = turn(u);
            let r = radius(k as f64 / last as f64);
            add(path[k], add(scale(frames[k][0], r * cos), scale(frames[k][1], r * sin)))
        });
        self
    }

    /// A straight round bar, closed.
    pub(super) fn bar(&mut self, from: V3, to: V3, radius: f64, sides: usize) -> &mut Self {
        self.tube(&[from, to], sides, |_| radius)
    }

    /// A ring about the y axis, closed.
    pub(super) fn ring(&mut self, centre: V3, radius: f64, thick: f64, n: [usize; 2]) -> &mut Self {
        self.surface(n, [true, true], |u, v| {
            let (cos, sin) = turn(v);
            add(centre, around(radius + thick * cos, -u, thick * sin))
        });
        self
    }

    /// A flat floor at height `y` as a chequerboard of two materials.
    pub(super) fn tiles(
        &mut self,
        lo: [f64; 2],
        hi: [f64; 2],
        y: f64,
        n: [usize; 2],
        colours: [(&str, u32); 2],
    ) {
        let x = |i: usize| lerp(lo[0], hi[0], i as f64 / n[0] as f64);
        let z = |j: usize| lerp(lo[1], hi[1], j as f64 / n[1] as f64);
        for (parity, (name, rgb)) in colours.into_iter().enumerate() {
            self.paint(name, rgb);
            for (i, j) in (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| (i, j))) {
                if (i + j) % 2 == parity {
                    self.quad([
                        [x(i), y, z(j)],
                        [x(i), y, z(j + 1)],
                        [x(i + 1), y, z(j + 1)],
                        [x(i + 1), y, z(j)],
                    ]);
                }
            }
        }
    }
}

/// A frame at each point of a path, turned as little as possible from one to the next.
pub(super) fn frames(path: &[V3]) -> Vec<[V3; 2]> {
    let last = path.len() - 1;
    let tangent = |k: usize| unit(sub(path[(k + 1).min(last)], path[k.saturating_sub(1)]));
    let mut x = frame(tangent(0))[0];
    (0..=last)
        .map(|k| {
            let z = tangent(k);
            x = square_to(x, z);
            [x, cross(z, x)]
        })
        .collect()
}
