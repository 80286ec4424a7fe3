//! One exact sign per triangle, and the silhouette edges that follow from it.

use antumbra_predicates::exact;
use rayon::prelude::*;

use super::adjacency::Adjacency;
use crate::scene::Triangle;

/// A silhouette edge: the sides of the volumes of its triangles that do not cancel.
#[derive(Clone, Copy, Debug)]
pub(super) struct SilhouetteEdge {
    pub(super) a: [f32; 3],
    pub(super) b: [f32; 3],
    /// How many volumes are entered when the plane light, `a`, `b` is crossed towards its positive side beyond the edge.
    pub(super) multiplicity: i32,
}

/// What casts shadows, for one light.
#[derive(Debug, Default)]
pub(super) struct Casters {
    pub(super) light: [f32; 3],
    /// By triangle: the sign of `det[A, B, C]`; 0 = has no volume.
    pub(super) facing: Vec<i8>,
    pub(super) edges: Vec<SilhouetteEdge>,
}

impl Casters {
    /// Step 1 of the definition for every triangle. Sides and caps use this one sign.
    pub(super) fn face(&mut self, triangles: &[Triangle], light: [f32; 3]) {
        self.light = light;
        self.facing.clear();
        self.facing.par_extend(triangles.par_iter().map(|t| exact::facing(t, light)));
    }

    /// The edges whose multiplicity is not 0.
    pub(super) fn extract(&mut self, adjacency: &Adjacency) {
        let facing = &self.facing;
        self.edges.clear();
        self.edges.par_extend((0..adjacency.edge_count()).into_par_iter().filter_map(|e| {
            let multiplicity = adjacency.multiplicity(e, facing);
            let [a, b] = adjacency.end_points(e);
            (multiplicity != 0).then_some(SilhouetteEdge { a, b, multiplicity })
        }));
    }

    /// Bytes of signs and edges.
    pub(super) fn bytes(&self) -> usize {
        self.facing.len() + size_of_val(&self.edges[..])
    }
}
