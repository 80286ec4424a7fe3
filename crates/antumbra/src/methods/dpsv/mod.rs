//! `dpsv-stack`, `dpsv-stackless`, `dpsv-hybrid`: deep partitioned shadow volumes, a ternary tree over the planes of the
//! triangles' shadow volumes, built every frame, asked once a sample.
//!
//! Sources: Gerhards, Mora, Aveneau, Ghazanfarpour 2015, "Partitioned Shadow Volumes" (the TOP tree); Mora, Gerhards, Aveneau,
//! Ghazanfarpour 2016, "Deep Partitioned Shadow Volumes Using Stackless and Hybrid Traversals"; Kobrtek et al. 2021, section
//! 3.3.
//!
//! What we changed, and why:
//! - The build is deterministic and parallel ([`build`]): one tree level a round, equal to sequential insertion. The
//!   published one leaves the order to the scheduler, and its speed changes from frame to frame.
//! - Signs are exact, in the insertion and in the query ([`node`]); so a corner on a plane is known to be on it, neighbours go to
//!   one side, and the discard of triangles in another's shadow is certain. No bias, no plane that two triangles round
//!   differently.
//! - Bounds hold over whole triangles ([`bounds`]), and crossing subtrees of cap planes are visited: published code
//!   loses shadows of triangles that look large from the light and of casters that cut each other.
//! - Packets of 4 x 2 samples walk together ([`query`]); the stackless query ([`stackless`]) walks alone.
//! - Triangles deeper than 512 levels are left to [`RayCast`]: all triangles in one chain would take O(T²) to build.
//!
//! Cost: build O(T log T) expected; query O(log T) a sample expected, O(T) at worst. 128 bytes a triangle. The tree forgets
//! triangles that lie in shadow, so it cannot be asked for all blockers of a sample, only for any.

mod bounds;
mod build;
mod debug;
mod node;
mod order;
mod query;
mod stackless;
#[cfg(test)]
mod tests;
mod tuning;

use rayon::prelude::*;

use self::build::Tree;
use super::debug::check_view;
use super::{DebugView, Method, Options, RayCast, Samples, Stats, StatsBuilder, check_input};
use crate::Isa;
use crate::bvh::build::morton;
use crate::mask::{NONE, SHADOWED};
use crate::scene::{InputError, Triangle};

/// How the tree is walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// Packets of samples with a stack.
    Stack,
    /// Samples one by one, with the way back stored in the tree.
    Stackless,
    /// Packets with a stack of so many entries, subtrees that do not fit without a stack.
    Hybrid {
        /// At least 1.
        stack: usize,
    },
}

impl Query {
    /// The hybrid of Mora et al. 2016.
    pub const HYBRID: Query = Query::Hybrid { stack: tuning::HYBRID_STACK };

    fn name(self) -> &'static str {
        match self {
            Query::Stack => "dpsv-stack",
            Query::Stackless => "dpsv-stackless",
            Query::Hybrid { .. } => "dpsv-hybrid",
        }
    }
}

/// Deep partitioned shadow volumes.
#[derive(Debug)]
pub struct Dpsv {
    isa: Isa,
    query: Query,
    max_depth: usize,
    tree: Tree,
    list: List,
    rest: Rest,
}

/// The samples of a bare list, sorted.
#[derive(Debug, Default)]
struct List {
    order: Vec<u64>,
    sorted: Vec<[f32; 3]>,
    mask: Vec<u8>,
}

/// What the tree left to ray casting.
#[derive(Debug)]
struct Rest {
    method: RayCast,
    triangles: Vec<Triangle>,
    positions: Vec<[f32; 3]>,
    mask: Vec<u8>,
}

/// Links are `8 node + 7` at most.
const MAX_TRIANGLES: usize = 1 << 28;

impl Dpsv {
    /// A method that builds its tree in every call.
    pub fn new(options: &Options, query: Query) -> Dpsv {
        Dpsv {
            isa: options.isa,
            query,
            max_depth: tuning::MAX_DEPTH,
            tree: Tree::default(),
            list: List::default(),
            rest: Rest {
                method: RayCast::new(options),
                triangles: Vec::new(),
                positions: Vec::new(),
                mask: Vec::new(),
            },
        }
    }

    /// Leaves triangles below this depth (1 to 512) to ray casting.
    #[must_use]
    pub fn with_max_depth(self, max_depth: usize) -> Dpsv {
        Dpsv { max_depth, ..self }
    }
}

impl Method for Dpsv {
    fn name(&self) -> &'static str {
        self.query.name()
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let isa = self.isa.resolved();
        let mut stats = StatsBuilder::start(self.name(), isa.name());
        check_input(triangles, samples, light, mask)?;
        check_count(triangles)?;
        stats.stage("check_input");
        self.tree.build(triangles, light, self.max_depth);
        stats.stage("build_tree");
        let Samples { positions, width, .. } = samples;
        let counts = if width >= positions.len() {
            self.list.sort(positions, light);
            stats.stage("sort_samples");
            let List { order, sorted, mask: sorted_mask } = &mut self.list;
            let width = sorted.len();
            let counts =
                query::query(isa, self.query, &self.tree, triangles, sorted, width, light, sorted_mask);
            mask.fill(NONE);
            for (key, m) in order.iter().zip(sorted_mask) {
                mask[(*key & 0xffff_ffff) as usize] = *m;
            }
            counts
        } else {
            query::query(isa, self.query, &self.tree, triangles, positions, width, light, mask)
        };
        stats.stage("query_tree");
        if !self.tree.rest.is_empty() {
            self.rest.cast(&self.tree.rest, triangles, samples, light, mask)?;
            stats.stage("cast_rest");
        }
        let (nodes, scratch) = self.tree.bytes();
        stats.bytes("nodes", nodes);
        stats.bytes("pending", scratch);
        stats.bytes("sorted_list", self.list.bytes());
        stats.bytes("rest", self.rest.bytes());
        let built = &self.tree.counts;
        stats.counter("setup_tris", triangles.len() as u64);
        stats.counter("culled_tris", built.culled);
        stats.counter("discarded_tris", built.discarded);
        stats.counter("rest_tris", self.tree.rest.len() as u64);
        stats.counter("tree_depth", built.depth);
        stats.counter("insert_steps", built.steps);
        stats.counter("insert_crossings", built.crossings);
        counts.report(&mut stats);
        Ok(stats.finish(triangles.len(), mask))
    }

    fn debug_views(&self) -> &'static [DebugView] {
        debug::VIEWS
    }

    fn debug_view(
        &mut self,
        view: &str,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
    ) -> Result<Option<Vec<f32>>, InputError> {
        if !check_view(debug::VIEWS, view, triangles, samples, light)? {
            return Ok(None);
        }
        check_count(triangles)?;
        self.tree.build(triangles, light, self.max_depth);
        Ok(Some(debug::draw(&self.tree, view, triangles, samples, light)))
    }
}

fn check_count(triangles: &[Triangle]) -> Result<(), InputError> {
    let limit = MAX_TRIANGLES;
    if triangles.len() > limit {
        return Err(InputError::TooMany { what: "triangles", got: triangles.len(), limit });
    }
    Ok(())
}

impl List {
    /// Bytes of keys, sorted samples and their mask.
    fn bytes(&self) -> usize {
        self.order.len() * 8 + size_of_val(&self.sorted[..]) + self.mask.len()
    }

    /// Sorts samples by direction from the light, background left out: nearly all planes of the tree go through the
    /// light, so samples in about the same direction walk the same path.
    fn sort(&mut self, positions: &[[f32; 3]], light: [f32; 3]) {
        let key = |(i, p): (usize, &[f32; 3])| {
            let q = [p[0] - light[0], p[1] - light[1], p[2] - light[2]];
            let scale = 511.0 / q.iter().fold(0.0f32, |m, v| m.max(v.abs()));
            u64::from(morton(q.map(|v| v * scale + 512.0))) << 32 | i as u64
        };
        let valid = |p: &[f32; 3]| !p.iter().any(|v| v.is_nan());
        self.order.clear();
        self.order.par_extend(positions.par_iter().enumerate().filter(|(_, p)| valid(p)).map(key));
        self.order.par_sort_unstable();
        self.sorted.clear();
        self.sorted.par_extend(self.order.par_iter().map(|key| positions[(key & 0xffff_ffff) as usize]));
        self.mask.clear();
        self.mask.resize(self.sorted.len(), NONE);
    }
}

impl Rest {
    /// Bytes of the copies that are handed on.
    fn bytes(&self) -> usize {
        size_of_val(&self.triangles[..]) + size_of_val(&self.positions[..]) + self.mask.len()
    }

    /// Asks the remaining triangles about the samples that are not in shadow yet.
    fn cast(
        &mut self,
        rest: &[u32],
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<(), InputError> {
        self.triangles.clear();
        self.triangles.extend(rest.iter().map(|&i| triangles[i as usize]));
        self.positions.clear();
        let open = |(p, m): (&[f32; 3], &u8)| if *m == SHADOWED { [f32::NAN; 3] } else { *p };
        self.positions.extend(samples.positions.iter().zip(mask.iter()).map(open));
        self.mask.clear();
        self.mask.resize(mask.len(), NONE);
        let samples = Samples { positions: &self.positions, ..samples };
        self.method.shadow(&self.triangles, samples, light, &mut self.mask)?;
        for (m, rest) in mask.iter_mut().zip(&self.mask) {
            if *rest == SHADOWED {
                *m = SHADOWED;
            }
        }
        Ok(())
    }
}
