//! Which triangles meet which tiles: sorted pairs, in rounds of bounded size.

use antumbra_predicates::Triangle;
use rayon::prelude::*;

use super::face::{FACES, FaceTriangle, PAD, Shadow};
use super::windows::Window;

/// Pairs of the current round, and what tells where they go. Kept between frames.
#[derive(Debug, Default)]
pub(super) struct Bins {
    /// `tile << 32 | triangle`, sorted.
    pairs: Vec<u64>,
    /// For each triangle of the current run, at how many pairs it starts (an upper bound).
    offsets: Vec<usize>,
}

impl Bins {
    pub(super) fn bytes(&self) -> usize {
        8 * self.pairs.capacity() + size_of::<usize>() * self.offsets.capacity()
    }
}

/// No pair: sorts to the end.
const NO_PAIR: u64 = u64::MAX;

/// What culling did.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BinCounts {
    /// Triangles that meet no window.
    pub(super) culled: u64,
    /// (triangle, tile) pairs that the edges left but the depth of the tile's samples did not.
    pub(super) behind: u64,
}

impl BinCounts {
    fn add(self, other: BinCounts) -> BinCounts {
        BinCounts { culled: self.culled + other.culled, behind: self.behind + other.behind }
    }
}

/// First and last column, first and last row.
type Cells = [[u32; 2]; 2];

/// The tiles of a window that the triangle's rectangle meets.
#[inline]
fn rectangle(shadow: &Shadow, face: usize, window: &Window) -> Option<(FaceTriangle, Cells)> {
    let triangle = shadow.on_face(face, window.tiles.window())?;
    let columns = window.tiles.u.range([triangle.lo[0], triangle.hi[0]], PAD)?;
    let rows = window.tiles.v.range([triangle.lo[1], triangle.hi[1]], PAD)?;
    Some((triangle, [columns, rows]))
}

fn active(windows: &[Window; FACES]) -> impl Iterator<Item = (usize, &Window)> {
    windows.iter().enumerate().filter(|(_, w)| w.samples > 0)
}

/// At most how many tiles a triangle meets.
fn pairs_bound(t: &Triangle, light: [f32; 3], windows: &[Window; FACES]) -> usize {
    let Some(shadow) = Shadow::new(t, light) else { return 0 };
    active(windows)
        .filter_map(|(face, window)| rectangle(&shadow, face, window))
        .map(|(_, [c, r])| (c[1] - c[0] + 1) as usize * (r[1] - r[0] + 1) as usize)
        .sum()
}

/// Everything that does not change during a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<'a> {
    pub(super) triangles: &'a [Triangle],
    pub(super) light: [f32; 3],
    pub(super) windows: &'a [Window; FACES],
}

impl Frame<'_> {
    /// Writes the pairs of one triangle, at most as many as `pairs_bound` said.
    fn emit(&self, index: usize, far: &[f32], out: &mut [u64], counts: &mut BinCounts) {
        out.fill(NO_PAIR);
        let mut n = 0;
        if out.is_empty() {
            counts.culled += 1;
            return;
        }
        let Some(shadow) = Shadow::new(&self.triangles[index], self.light) else { return };
        for (face, window) in active(self.windows) {
            let Some((triangle, [columns, rows])) = rectangle(&shadow, face, window) else { continue };
            let (u, v) = (&window.tiles.u, &window.tiles.v);
            for row in rows[0]..=rows[1] {
                let ends = v.ends(row, row);
                let span = match columns[0] == columns[1] {
                    true => Some(columns),
                    false => triangle.span(ends).and_then(|s| u.range(s, PAD)),
                };
                let Some(span) = span else { continue };
                for column in span[0]..=span[1] {
                    let tile = window.first + row * u.n + column;
                    let depth = far[tile as usize];
                    if depth == 0.0 {
                        continue;
                    }
                    if triangle.in_front_of_plane(u.ends(column, column), ends, f64::from(depth)) {
                        counts.behind += 1;
                        continue;
                    }
                    out[n] = u64::from(tile) << 32 | index as u64;
                    n += 1;
                }
            }
        }
    }

    /// Parts triangles and room for their pairs until a task is small.
    fn emit_all(
        &self,
        first: usize,
        offsets: &[usize],
        base: usize,
        far: &[f32],
        out: &mut [u64],
    ) -> BinCounts {
        let count = offsets.len() - 1;
        if count <= 256 {
            let mut counts = BinCounts::default();
            let mut rest = out;
            for i in 0..count {
                let (own, after) = rest.split_at_mut(offsets[i + 1] - offsets[i]);
                self.emit(first + i, far, own, &mut counts);
                rest = after;
            }
            return counts;
        }
        let middle = count / 2;
        let (left, right) = out.split_at_mut(offsets[middle] - base);
        let (a, b) = rayon::join(
            || self.emit_all(first, &offsets[..=middle], base, far, left),
            || self.emit_all(first + middle, &offsets[middle..], offsets[middle], far, right),
        );
        a.add(b)
    }

    /// Cuts all triangles into rounds of at most `limit` pairs (or one triangle) and hands over each round's pairs, sorted by
    /// tile and then by triangle. `far[tile]` is the depth of the tile's deepest sample that is not in shadow yet, 0 if
    /// there is none; `work` may change it. Returns the number of rounds, the most pairs of one, and what was culled.
    pub(super) fn rounds(
        &self,
        bins: &mut Bins,
        run: usize,
        limit: usize,
        far: &mut [f32],
        mut work: impl FnMut(&[u64], &mut [f32]),
    ) -> (u64, u64, BinCounts) {
        let (mut rounds, mut peak, mut counts) = (0, 0, BinCounts::default());
        for (number, triangles) in self.triangles.chunks(run).enumerate() {
            bins.offsets.clear();
            bins.offsets.push(0);
            bins.offsets.par_extend(triangles.par_iter().map(|t| pairs_bound(t, self.light, self.windows)));
            for i in 1..bins.offsets.len() {
                bins.offsets[i] += bins.offsets[i - 1];
            }
            let mut from = 0;
            while from < triangles.len() {
                let base = bins.offsets[from];
                let within = bins.offsets[from + 1..].partition_point(|&o| o - base <= limit);
                let to = from + within.max(1);
                let room = bins.offsets[to] - base;
                // Grows only; the rest of the last round's pairs is not looked at.
                if bins.pairs.len() < room {
                    bins.pairs.resize(room, NO_PAIR);
                }
                let pairs = &mut bins.pairs[..room];
                let first = number * run + from;
                counts = counts.add(self.emit_all(first, &bins.offsets[from..=to], base, far, pairs));
                pairs.par_sort_unstable();
                let used = pairs.partition_point(|&p| p != NO_PAIR);
                rounds += 1;
                peak = peak.max(used as u64);
                work(&pairs[..used], far);
                from = to;
            }
        }
        (rounds, peak, counts)
    }
}
