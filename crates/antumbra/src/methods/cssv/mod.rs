//! `cssv` and `zpass`: shadow volumes that are closed for any soup, counted along eye rays, without a stencil buffer.
//!
//! Sources: Kobrtek, Milet, Tóth, Herout 2021 ("Comparison of Modern Omnidirectional Precise Shadowing Techniques Versus
//! Ray Tracing"), section 3.1; Kim, Kim, Turk 2008 (multiplicities of non-manifold casters); Milet, Tóth, Pečiva, Starka,
//! Kobrtek, Zemčík 2014 (one orientation per triangle). Counting after Crow 1977 and, from behind, Bilodeau and Songy
//! 1999; Carmack 2000.
//!
//! Every triangle that is not edge-on owns a volume: what it hides from the light. Sides of neighbouring volumes cancel, an edge
//! keeps the signed rest as its *multiplicity*. A sample is shadowed iff some volume contains it, and the number of
//! volumes is counted along the line through an eye E and the sample P: `zpass` starts with those that contain E and
//! counts faces between E and P; `cssv` (z-fail) counts faces beyond P, of which triangles at infinity are one kind.
//!
//! What we changed. *Exact*: the definition's sample, moved off the planes it touches, is the one point
//! `P' = (1 - δ) P + (ε, ε², ε³)`, light at the origin, `1 >> δ >> ε > 0`: scaling towards the light leaves the side tests
//! alone and puts a touching sample on the light's side. All functionals are linear in P, so a zero is broken by the first
//! non-zero of its derivatives by δ, ε, ε², ε³:
//!
//! ```text
//! det[A, B, P']            (1 - δ) det[A, B, P] + ...: if 0, the first non-zero of A × B   (as in the definition)
//! det[A, E, P']            likewise A × E
//! det[A-E, B-E, P'-E]      if 0: -δ det[A, B, E], as there det[B-A, E-A, P] = det[A, B, E]; then (A-E) × (B-E)
//! (B-A) × (C-A) · (P'-A)   if 0: -δ det[A, B, C]
//! det[A, B, P'-E]          if 0: -δ det[A, B, P] = -δ det[A, B, E]; then A × B
//! ```
//!
//! E is chosen off all planes of light and silhouette edge, and off all planes of triangles (`reference.rs`): then the second column
//! never runs out, no line E P' meets the border of a face, and the signed sum over the faces crossed *is* the number of
//! volumes, whatever the rounding of the camera. That E need not be the eye changes cost only.
//! *Hierarchical*: faces are not rasterised one by one but walk down a tree of samples (`traverse.rs`); a face that all samples
//! of a node cross is one addition. Counts are exact, so nothing wraps at 256.
//! Front caps are not pushed to infinity: samples need not be what the eye sees first.
//!
//! Cost: adjacency O(T) by radix sort and silhouette O(T + E) every frame; counting O(faces × log N + their outlines in pixels).

mod adjacency;
mod debug;
mod direction;
mod face;
mod leaf;
mod reference;
mod silhouette;
mod tiles;
mod traverse;
mod tuning;

use std::sync::atomic::{AtomicI64, AtomicU64, Ordering::Relaxed};

use antumbra_predicates::resolve;
use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use self::adjacency::{Adjacency, MAX_TRIANGLES};
use self::face::{Face, Faces, Verdict};
use self::reference::Reference;
use self::silhouette::Casters;
use self::tiles::Tree;
use self::traverse::{Counts, Lists, Made, Trace, Walk};
use super::debug::{check_view, complete};
use super::{DebugView, Method, Options, Samples, Stats, StatsBuilder, check_input};
use crate::Isa;
use crate::mask::{LIT, NONE, SHADOWED};
use crate::scene::{InputError, Triangle};

/// Shadow volumes with silhouettes extracted anew every frame; counted beyond the samples (`cssv`) or before (`zpass`).
#[derive(Debug, Default)]
pub struct Cssv {
    isa: Isa,
    pass: bool,
    adjacency: Adjacency,
    casters: Casters,
    faces: Vec<Face>,
    tree: Tree,
    lists: Lists,
    shadowed: Vec<AtomicU64>,
}

impl Cssv {
    /// Counts beyond the samples: z-fail.
    pub fn new(options: &Options) -> Cssv {
        Cssv { isa: options.isa, ..Cssv::default() }
    }

    /// Counts between eye and samples: z-pass.
    pub fn z_pass(options: &Options) -> Cssv {
        Cssv { isa: options.isa, pass: true, ..Cssv::default() }
    }

    fn faces<'a>(&'a self, triangles: &'a [Triangle], reference: Reference) -> Faces<'a> {
        let Casters { light, facing, edges } = &self.casters;
        Faces { pass: self.pass, reference, light: *light, triangles, facing, edges }
    }

    /// Makes the faces that some sample may have to do with. Returns how many were made, and the counter of a sample
    /// that none of those kept has been added to.
    fn build_faces(&mut self, triangles: &[Triangle], reference: Reference, level: Level) -> Made {
        let mut faces = std::mem::take(&mut self.faces);
        let make = self.faces(triangles, reference);
        let (facing, pass) = (make.facing, self.pass);
        let volumes = (0..facing.len()).into_par_iter().filter(|&t| facing[t] != 0);
        let region = self.tree.bounds(self.tree.top(), 0).region();
        let (accepted, sum) = (AtomicU64::new(0), AtomicI64::new(0));
        // Most faces of a large scene lie off the picture or before all samples: they are not worth their memory.
        let keep = |face: &Face| {
            let Some(region) = &region else { return true };
            match dispatch!(level, s => face.against(s, pass, region)) {
                Verdict::Refine => true,
                Verdict::Reject => false,
                Verdict::Accept => {
                    accepted.fetch_add(1, Relaxed);
                    sum.fetch_add(i64::from(face.weight), Relaxed);
                    false
                }
            }
        };
        faces.clear();
        let sides = make.edges.len();
        faces.par_extend((0..sides).into_par_iter().map(|e| make.side(e as u32)).filter(keep));
        faces.par_extend(volumes.clone().map(|t| make.cap(t as u32)).filter(keep));
        let volume_count = volumes.clone().count();
        let (made, eye_volumes) = if pass {
            let contain = |t: &usize| resolve::blocks(&triangles[*t], make.light, reference.point);
            (sides + volume_count, volumes.filter(contain).count() as u64)
        } else {
            // At infinity beyond all far caps there is no volume.
            faces.par_extend(volumes.map(|t| make.far_cap(t as u32)).filter(keep));
            (sides + 2 * volume_count, 0)
        };
        self.faces = faces;
        let start = eye_volumes as i64 + sum.into_inner();
        Made { faces: made as u64, accepted: accepted.into_inner(), eye_volumes, start }
    }

    /// All stages up to the shadow bits; `None` if there is no reference point. `trace` is filled if it is there.
    fn run(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        stats: &mut StatsBuilder,
        trace: Option<&mut Trace>,
    ) -> Option<Counts> {
        self.adjacency.build(triangles);
        stats.stage("build_adjacency");
        self.casters.face(triangles, light);
        self.casters.extract(&self.adjacency);
        stats.stage("extract_silhouette");
        let reference = reference::choose(samples.view, samples.positions, triangles, &self.casters);
        stats.stage("choose_reference");
        let reference = reference?;
        self.tree.build(samples, &reference);
        self.shadowed.resize_with(self.tree.packets(), AtomicU64::default);
        stats.stage("arrange_samples");
        let level = self.isa.level().unwrap_or_else(Level::new);
        let made = self.build_faces(triangles, reference, level);
        stats.stage("build_faces");
        let trace = trace.map(|trace| {
            *trace = Trace::new(self.tree.packets());
            &*trace
        });
        let walk = Walk {
            level,
            tree: &self.tree,
            positions: samples.positions,
            faces: &self.faces,
            decide: self.faces(triangles, reference),
            lists: &self.lists,
            shadowed: &self.shadowed,
            trace,
        };
        let counts = walk.run(&made);
        stats.stage("count");
        stats.counter("faces", made.faces);
        stats.counter("eye_volumes", made.eye_volumes);
        stats.counter("reference_tries", u64::from(reference.tries));
        Some(counts)
    }

    /// The numbers of a view, from a run of its own.
    fn draw(
        &mut self,
        view: &str,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
    ) -> Vec<f32> {
        let positions = samples.positions;
        let mut stats = StatsBuilder::start(self.name(), self.isa.resolved().name());
        let mut trace = Trace::default();
        let counted = self.run(triangles, samples, light, &mut stats, Some(&mut trace)).is_some();
        if view == "silhouette" {
            return debug::silhouettes(&self.casters.edges, samples);
        }
        if !counted {
            return debug::test_all(view, triangles, positions, light);
        }
        let mut out = vec![0.0; positions.len()];
        self.tree.scatter(&mut out, |out, packet, slot| {
            let value = match view {
                "faces" => &trace.list_len[packet],
                _ => &trace.volumes[packet * tuning::PACKET + slot],
            };
            *out = value.load(Relaxed) as f32;
        });
        out
    }

    fn write_mask(&self, positions: &[[f32; 3]], mask: &mut [u8]) {
        self.tree.scatter(mask, |m, packet, slot| {
            *m = if self.shadowed[packet].load(Relaxed) >> slot & 1 == 1 { SHADOWED } else { LIT };
        });
        mask.par_iter_mut().zip(positions).for_each(|(m, p)| {
            if p.iter().any(|v| v.is_nan()) {
                *m = NONE;
            }
        });
    }
}

/// The definition, for all samples and triangles: for the day that no generic reference point is found.
fn test_all(triangles: &[Triangle], positions: &[[f32; 3]], light: [f32; 3], mask: &mut [u8]) {
    mask.par_iter_mut().zip(positions).for_each(|(m, p)| {
        *m = if p.iter().any(|v| v.is_nan()) {
            NONE
        } else if triangles.iter().any(|t| resolve::blocks(t, light, *p)) {
            SHADOWED
        } else {
            LIT
        };
    });
}

fn check_count(triangles: &[Triangle]) -> Result<(), InputError> {
    let limit = MAX_TRIANGLES;
    if triangles.len() > limit {
        return Err(InputError::TooMany { what: "triangles", got: triangles.len(), limit });
    }
    Ok(())
}

impl Method for Cssv {
    fn name(&self) -> &'static str {
        if self.pass { "zpass" } else { "cssv" }
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let mut stats = StatsBuilder::start(self.name(), self.isa.resolved().name());
        check_input(triangles, samples, light, mask)?;
        check_count(triangles)?;
        stats.stage("check_input");
        let mut fallback = 0;
        if let Some(counts) = self.run(triangles, samples, light, &mut stats, None) {
            self.write_mask(samples.positions, mask);
            stats.stage("write_mask");
            counts.report(&mut stats);
        } else {
            test_all(triangles, samples.positions, light, mask);
            fallback = mask.iter().filter(|&&m| m != NONE).count() as u64;
            stats.stage("test_all");
        }
        stats.counter("fallback_samples", fallback);
        stats.counter("edges_tested", self.adjacency.edge_count() as u64);
        stats.counter("silhouette_edges", self.casters.edges.len() as u64);
        stats.counter("faces_kept", self.faces.len() as u64);
        stats.bytes("adjacency", self.adjacency.bytes());
        stats.bytes("silhouette", self.casters.bytes());
        stats.bytes("faces", self.faces.len() * size_of::<Face>());
        stats.bytes("tree", self.tree.bytes());
        stats.bytes("lists", self.lists.bytes());
        stats.bytes("shadow_bits", self.shadowed.len() * 8);
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
        Ok(Some(complete(self.draw(view, triangles, samples, light), samples.positions)))
    }
}
