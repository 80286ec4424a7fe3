//! The switches of table 1 of the paper, and those that it discusses in the text.

use super::tuning;
use crate::Isa;
use crate::methods;

/// How a node is tested against a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ConeTest {
    /// Cone against the bounding sphere of the triangle: the test of earlier work that the paper compares with.
    Sphere,
    /// Cone against the triangle itself (section 3.2).
    #[default]
    Precise,
}

/// How a ray is tested against a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LeafKind {
    /// The shared test of antumbra: f32 filter, f64, exact arithmetic.
    #[default]
    Exact,
    /// The projected test of Wald 2004 in f32, which the paper uses (section 4.1). Not exact.
    Wald,
    /// The test of Möller and Trumbore 1997 in f32, which the paper names for its small storage. Not exact.
    MollerTrumbore,
}

/// What a [`super::RayHierarchy`] does; [`RayHierarchyOptions::named`] gives the seven variants of table 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHierarchyOptions {
    /// Instruction set of the kernels.
    pub isa: Isa,
    /// Fill the counters that cost time: visits by level, and mistakes of leaf tests that are not exact.
    pub count: bool,
    /// Node test.
    pub cone_test: ConeTest,
    /// Sort the rays by direction (section 3.5); otherwise they are taken in screen order.
    pub sorted: bool,
    /// Shadow all rays of a node at once when one triangle covers it, and never visit it again (section 3.3). Needs
    /// [`ConeTest::Precise`], and is ignored without it.
    pub early_accept: bool,
    /// Stream good blockers first, then rebuild the tree without the rays that they shadow (section 3.4).
    pub two_pass: bool,
    /// Leaf test.
    pub leaf: LeafKind,
    /// Let only triangles block whose outward normal (corners counter-clockwise) points away from the light (section
    /// 3.6). That is another set of casters, hence another answer where the meshes are not closed.
    pub front_face_culling: bool,
    /// Pairs that the queue of one level holds, at least 4.
    pub queue_capacity: usize,
    /// Triangles that one task streams through the tree.
    pub block: usize,
    /// Smallest blocker, in solid angles of a mean node of 64 rays.
    pub blocker_solid_angle: f64,
    /// Largest part of the triangles that are blockers.
    pub blocker_share: f64,
    /// Smallest part of the rays that pass 1 must shadow for the tree to be rebuilt.
    pub rebuild_share: f64,
}

impl Default for RayHierarchyOptions {
    /// PreciseSEATP: all improvements of the paper.
    fn default() -> RayHierarchyOptions {
        RayHierarchyOptions {
            isa: Isa::Auto,
            count: false,
            cone_test: ConeTest::Precise,
            sorted: true,
            early_accept: true,
            two_pass: true,
            leaf: LeafKind::Exact,
            front_face_culling: false,
            queue_capacity: tuning::QUEUE,
            block: tuning::BLOCK,
            blocker_solid_angle: tuning::BLOCKER_SOLID_ANGLE,
            blocker_share: tuning::BLOCKER_SHARE,
            rebuild_share: tuning::REBUILD_SHARE,
        }
    }
}

impl RayHierarchyOptions {
    /// The variant that a name of [`methods::CATALOGUE`] stands for; `None` if it is not one of this method's.
    pub fn named(name: &str, shared: &methods::Options) -> Option<RayHierarchyOptions> {
        let variant = |cone_test, sorted, early_accept, two_pass| RayHierarchyOptions {
            isa: shared.isa,
            count: shared.count,
            cone_test,
            sorted,
            early_accept,
            two_pass,
            ..RayHierarchyOptions::default()
        };
        use ConeTest::{Precise, Sphere};
        Some(match name {
            "rh-spheres" => variant(Sphere, false, false, false),
            "rh-spheres-sorted" => variant(Sphere, true, false, false),
            "rh-precise" => variant(Precise, false, false, false),
            "rh-precise-sorted" => variant(Precise, true, false, false),
            "rh-precise-sea" => variant(Precise, true, true, false),
            "rh-precise-eatp" => variant(Precise, false, true, true),
            "rh-precise-seatp" => variant(Precise, true, true, true),
            // Every answer is the leaf test's: no node is accepted.
            "rh-leaf-wald" => {
                RayHierarchyOptions { leaf: LeafKind::Wald, ..variant(Precise, true, false, false) }
            }
            "rh-leaf-moller-trumbore" => {
                RayHierarchyOptions { leaf: LeafKind::MollerTrumbore, ..variant(Precise, true, false, false) }
            }
            _ => return None,
        })
    }
}

impl RayHierarchyOptions {
    /// Whether nodes are accepted: only the precise test can tell that one is covered.
    pub(super) fn accepts(&self) -> bool {
        self.early_accept && self.cone_test == ConeTest::Precise
    }

    /// Whether a leaf test that is not exact is held against the exact one.
    pub(super) fn compares_leaves(&self) -> bool {
        self.count && self.leaf != LeafKind::Exact
    }
}
