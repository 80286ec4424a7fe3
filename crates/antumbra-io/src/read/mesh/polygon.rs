//! Polygons to triangles.
//!
//! Sources: D. H. Eberly, "Triangulation by Ear Clipping", Geometric Tools, 2002 (reflex vertices only are tested);
//! M. E. Newell's normal as in I. E. Sutherland et al., ACM Computing Surveys 6(1), 1974.

/// Cuts polygons; holds scratch memory, and how much work it may still do.
#[derive(Debug)]
pub(in crate::read) struct Cutter {
    points: Vec<[f32; 3]>,
    flat: Vec<[f64; 2]>,
    next: Vec<usize>,
    previous: Vec<usize>,
    reflex: Vec<usize>,
    is_reflex: Vec<bool>,
    /// Corners, three a triangle, as positions in the polygon.
    pub(in crate::read) corners: Vec<[usize; 3]>,
    work: u64,
}

/// Point-in-triangle tests a file may cost: about a second. Ear clipping is quadratic, so that one polygon of a
/// million concave corners would never end.
const WORK: u64 = 1 << 27;

impl Default for Cutter {
    fn default() -> Self {
        Cutter {
            points: Vec::new(),
            flat: Vec::new(),
            next: Vec::new(),
            previous: Vec::new(),
            reflex: Vec::new(),
            is_reflex: Vec::new(),
            corners: Vec::new(),
            work: WORK,
        }
    }
}

impl Cutter {
    /// Cuts a polygon of finite corners into `points.len() - 2` triangles, left in `corners`. Convex polygons (and
    /// triangles) become fans around their first corner; where a polygon is too broken for ears, the rest is a fan.
    pub(in crate::read) fn cut(
        &mut self,
        points: impl ExactSizeIterator<Item = [f32; 3]>,
    ) -> Result<(), String> {
        self.corners.clear();
        let len = points.len();
        if len > 3 {
            self.points.clear();
            self.points.extend(points);
            if !self.convex() {
                return self.clip();
            }
        }
        self.corners.extend((2..len).map(|i| [0, i - 1, i]));
        Ok(())
    }

    /// Projects along the polygon's main direction, and tells whether every corner turns the same way and the whole
    /// turns only once.
    fn convex(&mut self) -> bool {
        let points = &self.points;
        let n = points.len();
        let mut normal = [0.0f64; 3];
        for i in 0..n {
            let (p, q) = (points[i].map(f64::from), points[(i + 1) % n].map(f64::from));
            for k in 0..3 {
                let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                normal[k] += (p[a] - q[a]) * (p[b] + q[b]);
            }
        }
        let size = normal.map(f64::abs);
        let k = if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 1 + usize::from(size[2] > size[1]) };
        let (a, b) = if normal[k] < 0.0 { ((k + 2) % 3, (k + 1) % 3) } else { ((k + 1) % 3, (k + 2) % 3) };
        self.flat.clear();
        self.flat.extend(points.iter().map(|p| [f64::from(p[a]), f64::from(p[b])]));
        // Seen from its first corner a convex polygon's corners come in order: then the fan is right.
        (1..n - 1).all(|i| self.turn(0, i, i + 1) >= 0.0)
            && (0..n).all(|i| self.turn(i, (i + 1) % n, (i + 2) % n) >= 0.0)
    }

    fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        let [a, b, c] = [self.flat[a], self.flat[b], self.flat[c]];
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    fn clip(&mut self) -> Result<(), String> {
        let n = self.flat.len();
        self.next.clear();
        self.next.extend((0..n).map(|i| (i + 1) % n));
        self.previous.clear();
        self.previous.extend((0..n).map(|i| (i + n - 1) % n));
        self.is_reflex.clear();
        for i in 0..n {
            self.is_reflex.push(self.turn(self.previous[i], i, self.next[i]) <= 0.0);
        }
        self.reflex.clear();
        self.reflex.extend((0..n).filter(|&i| self.is_reflex[i]));
        let (mut at, mut left, mut misses, mut gone) = (0, n, 0, 0);
        while left > 3 && misses <= left {
            let (before, after) = (self.previous[at], self.next[at]);
            if !self.is_ear(at)? {
                (at, misses) = (after, misses + 1);
                continue;
            }
            self.corners.push([before, at, after]);
            (self.next[before], self.previous[after]) = (after, before);
            left -= 1;
            misses = 0;
            // A corner can only lose its reflex angle when a neighbour goes.
            for i in [before, after] {
                if self.is_reflex[i] && self.turn(self.previous[i], i, self.next[i]) > 0.0 {
                    self.is_reflex[i] = false;
                    gone += 1;
                }
            }
            // Compacted when half is gone, so that this costs nothing on the whole.
            if 2 * gone > self.reflex.len() {
                let is_reflex = &self.is_reflex;
                self.reflex.retain(|&i| is_reflex[i]);
                gone = 0;
            }
            at = after;
        }
        let first = at;
        let mut second = self.next[first];
        for _ in 2..left {
            let third = self.next[second];
            self.corners.push([first, second, third]);
            second = third;
        }
        Ok(())
    }

    fn is_ear(&mut self, at: usize) -> Result<bool, String> {
        if self.is_reflex[at] {
            return Ok(false);
        }
        self.work = self
            .work
            .checked_sub(self.reflex.len() as u64 + 1)
            .ok_or("its concave polygons are too large to triangulate; triangulate them first")?;
        let (before, after) = (self.previous[at], self.next[at]);
        let triangle = [before, at, after];
        Ok(!self.reflex.iter().any(|&i| {
            self.is_reflex[i]
                && !triangle.iter().any(|&t| self.flat[t] == self.flat[i])
                && self.turn(before, at, i) >= 0.0
                && self.turn(at, after, i) >= 0.0
                && self.turn(after, before, i) >= 0.0
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Signed areas of the triangles in the plane z = 0.
    fn areas(points: &[[f32; 2]]) -> Vec<f32> {
        let mut cutter = Cutter::default();
        cutter.cut(points.iter().map(|p| [p[0], p[1], 0.0])).unwrap();
        let area = |&[a, b, c]: &[usize; 3]| {
            let [a, b, c] = [points[a], points[b], points[c]];
            ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
        };
        cutter.corners.iter().map(area).collect()
    }

    #[test]
    fn a_concave_quad_is_cut_at_its_reflex_corner() {
        for start in 0..4 {
            let mut dart = [[0.0, 0.0], [4.0, -2.0], [1.0, 0.0], [4.0, 2.0]];
            dart.rotate_left(start);
            let areas = areas(&dart);
            assert!(areas.iter().all(|a| *a > 0.0), "{start}: {areas:?}");
            assert_eq!(areas.iter().sum::<f32>(), 2.0);
        }
    }

    #[test]
    fn a_comb_keeps_its_area_in_both_directions() {
        let mut comb = vec![[0.0, 0.0], [40.0, 0.0]];
        for i in (0..20).rev() {
            comb.extend([[2.0 * i as f32 + 1.5, 9.0], [2.0 * i as f32 + 1.0, 1.0]]);
        }
        let area = areas(&comb);
        assert_eq!(area.len(), comb.len() - 2);
        assert!(area.iter().all(|a| *a >= 0.0));
        let shoelace: f32 = (0..comb.len())
            .map(|i| (comb[i], comb[(i + 1) % comb.len()]))
            .map(|(p, q)| (p[0] * q[1] - p[1] * q[0]) / 2.0)
            .sum();
        assert!((area.iter().sum::<f32>() - shoelace).abs() < 1e-3);
        comb.reverse();
        let area = areas(&comb);
        assert!(area.iter().all(|a| *a <= 0.0));
        assert!((area.iter().sum::<f32>() + shoelace).abs() < 1e-3);
    }

    #[test]
    fn a_polygon_of_one_point_repeated_still_gives_its_triangles() {
        assert_eq!(areas(&[[1.0, 1.0]; 7]).len(), 5);
        assert_eq!(areas(&[[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.5, 2.0]]).len(), 3);
    }

    #[test]
    fn a_huge_concave_polygon_is_refused_in_time() {
        let zigzag = |i: usize| [(i / 2) as f32, (i % 2) as f32 * (1.0 + (i % 7) as f32), 0.0];
        let start = std::time::Instant::now();
        let _either = Cutter::default().cut((0..2_000_000).map(zigzag));
        assert!(start.elapsed().as_secs() < 20);
    }
}
