//! Which triangles meet at an edge: any number of them, in any winding, found anew from the soup.
//!
//! Corners with equal coordinates are one vertex (-0 equals 0); vertices are numbered in the order of their bits, and an
//! edge runs from the lower to the higher number. That order plays the part of the lexicographic order of Kim, Kim
//! and Turk 2008 (via Kobrtek et al. 2021, section 3.1): every triangle of an edge sees it in the same direction.

use rayon::prelude::*;
use rdst::{RadixKey, RadixSort};

use crate::scene::Triangle;

/// Triangles at most: corners and faces are numbered in 32 bits.
pub(super) const MAX_TRIANGLES: usize = 1 << 28;

/// An edge between two vertices; its items begin at `first` and end where those of the next edge begin.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Edge {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) first: u32,
}

/// Edges with their triangles, as compressed rows.
#[derive(Debug, Default)]
pub(super) struct Adjacency {
    /// Positions of the welded vertices.
    pub(super) vertices: Vec<[f32; 3]>,
    /// One more than there are edges: the last one is the end.
    edges: Vec<Edge>,
    /// First the corners on their way to becoming vertices, then the edges of the triangles.
    items: Vec<Item>,
    vertex_of: Vec<u32>,
}

/// What is sorted. A corner: the bits of its coordinates, and its number. An edge of one triangle: higher vertex, lower
/// vertex, 0, and the triangle, shifted left by one; the low bit says that the triangle runs against the edge. One type,
/// because one buffer then serves both: corners are done with when edges begin.
#[derive(Clone, Copy, Debug, Default)]
struct Item {
    key: [u32; 3],
    value: u32,
}

impl RadixKey for Item {
    const LEVELS: usize = 12;

    #[inline]
    fn get_level(&self, level: usize) -> u8 {
        (self.key[level / 4] >> (8 * (level % 4))) as u8
    }
}

impl Adjacency {
    /// Builds the adjacency of `triangles` anew: O(T) by radix sorts. Memory is kept.
    pub(super) fn build(&mut self, triangles: &[Triangle]) {
        self.weld(triangles);
        let of = &self.vertex_of;
        self.items.clear();
        self.items.par_extend((0..triangles.len()).into_par_iter().flat_map_iter(|t| {
            let v = [of[3 * t], of[3 * t + 1], of[3 * t + 2]];
            let proper = v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
            (0..if proper { 3 } else { 0 }).map(move |k| {
                let (from, to) = (v[k], v[(k + 1) % 3]);
                let key = [from.max(to), from.min(to), 0];
                Item { key, value: (t as u32) << 1 | u32::from(from > to) }
            })
        }));
        self.items.radix_sort_unstable();
        self.edges.clear();
        let mut last = None;
        for (i, Item { key, .. }) in self.items.iter().enumerate() {
            if last != Some(key) {
                last = Some(key);
                self.edges.push(Edge { a: key[1], b: key[0], first: i as u32 });
            }
        }
        self.edges.push(Edge { a: 0, b: 0, first: self.items.len() as u32 });
    }

    fn weld(&mut self, triangles: &[Triangle]) {
        self.items.clear();
        self.items.par_extend(triangles.as_flattened().par_iter().enumerate().map(|(i, p)| {
            // Adding zero turns -0 into 0 and changes nothing else.
            Item { key: p.map(|v| (v + 0.0).to_bits()), value: i as u32 }
        }));
        self.items.radix_sort_unstable();
        self.vertices.clear();
        self.vertex_of.resize(self.items.len(), 0);
        let mut last = None;
        for corner in &self.items {
            if last != Some(corner.key) {
                last = Some(corner.key);
                self.vertices.push(corner.key.map(f32::from_bits));
            }
            self.vertex_of[corner.value as usize] = (self.vertices.len() - 1) as u32;
        }
    }

    /// How many edges there are.
    pub(super) fn edge_count(&self) -> usize {
        self.edges.len().saturating_sub(1)
    }

    /// The end points of edge `edge`.
    pub(super) fn end_points(&self, edge: usize) -> [[f32; 3]; 2] {
        let e = &self.edges[edge];
        [self.vertices[e.a as usize], self.vertices[e.b as usize]]
    }

    /// The triangles of edge `edge`, and whether they run along it (1) or against it (-1).
    pub(super) fn triangles(&self, edge: usize) -> impl Iterator<Item = (usize, i32)> {
        let range = self.edges[edge].first as usize..self.edges[edge + 1].first as usize;
        self.items[range].iter().map(|r| ((r.value >> 1) as usize, 1 - 2 * (r.value & 1) as i32))
    }

    /// The sum over the triangles of an edge of facing times direction: 0 = not a silhouette edge.
    pub(super) fn multiplicity(&self, edge: usize, facing: &[i8]) -> i32 {
        self.triangles(edge).map(|(t, direction)| direction * i32::from(facing[t])).sum()
    }

    /// Bytes that are kept for a soup of this size.
    pub(super) fn bytes(&self) -> usize {
        self.vertices.len() * 12
            + self.edges.len() * size_of::<Edge>()
            + self.vertex_of.len() * size_of::<Item>()
            + self.vertex_of.len() * 4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [f32; 3] = [0.0, 0.0, 0.0];
    const B: [f32; 3] = [1.0, 0.0, 0.0];
    const C: [f32; 3] = [0.0, 1.0, 0.0];
    const D: [f32; 3] = [0.0, 0.0, 1.0];

    fn adjacency(triangles: &[Triangle]) -> Adjacency {
        let mut adjacency = Adjacency::default();
        adjacency.build(triangles);
        adjacency
    }

    #[test]
    fn a_tetrahedron_has_six_edges_of_two_triangles_each() {
        let t = [[A, C, B], [A, B, D], [B, C, D], [C, A, D]];
        let adjacency = adjacency(&t);
        assert_eq!((adjacency.vertices.len(), adjacency.edge_count()), (4, 6));
        for e in 0..6 {
            let sides: Vec<_> = adjacency.triangles(e).collect();
            assert_eq!(sides.len(), 2);
            assert_eq!(sides[0].1 + sides[1].1, 0, "wound alike, so they run against each other");
        }
        // Seen from inside all triangles face the same way: no silhouette.
        assert!((0..6).all(|e| adjacency.multiplicity(e, &[1; 4]) == 0));
    }

    #[test]
    fn minus_zero_is_zero_and_degenerate_triangles_have_no_edges() {
        let minus = [-0.0, 0.0, -0.0];
        let adjacency = adjacency(&[[A, B, C], [B, minus, D], [A, minus, B]]);
        assert_eq!(adjacency.vertices.len(), 4);
        assert_eq!(adjacency.edge_count(), 5);
    }

    #[test]
    fn duplicates_and_fins_add_up() {
        // The edge A B has four triangles, of which two are the same.
        let t = [[A, B, C], [A, B, C], [B, A, D], [A, B, [0.0, -1.0, 3.0]]];
        let adjacency = adjacency(&t);
        let shared = (0..adjacency.edge_count()).find(|&e| adjacency.triangles(e).count() == 4);
        let shared = shared.expect("A B");
        assert_eq!(adjacency.multiplicity(shared, &[1, 1, 1, 0]).abs(), 1);
        assert_eq!(adjacency.multiplicity(shared, &[1, 1, -1, 1]).abs(), 4);
    }
}
