//! `oracle`: the definition as a plain loop. Slow, and what every other method is held against.
//!
//! Every triangle is tested against every sample: in f64 where the error bound of
//! [`antumbra_predicates::resolve`] leaves no doubt, else in exact arithmetic. No culling, no hierarchy, no f32.

use antumbra_predicates::Resolver;
use antumbra_predicates::resolve::Decided;
use rayon::prelude::*;

use super::debug::{check_view, complete};
use super::{DebugView, Method, Samples, Stats, StatsBuilder, check_input};
use crate::mask::{LIT, NONE, SHADOWED};
use crate::scene::{InputError, Triangle};

/// Samples that one task takes through all triangles: a triangle's coefficients are read once for all of them.
const RUN: usize = 64;

/// Tests every triangle against every sample: O(T N).
#[derive(Clone, Copy, Debug, Default)]
pub struct Oracle;

const VIEWS: &[DebugView] = &[
    DebugView::amount("blockers", "triangles that block the sample"),
    DebugView::amount("exact", "triangles that only exact arithmetic could decide on"),
];

impl Method for Oracle {
    fn name(&self) -> &'static str {
        "oracle"
    }

    fn shadow(
        &mut self,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
        mask: &mut [u8],
    ) -> Result<Stats, InputError> {
        let mut stats = StatsBuilder::start("oracle", "scalar");
        check_input(triangles, samples, light, mask)?;
        let resolvers: Vec<Resolver> = triangles.par_iter().filter_map(|t| Resolver::new(t, light)).collect();
        stats.stage("prepare_triangles");
        stats.bytes("triangles", size_of_val(resolvers.as_slice()));
        mask.par_chunks_mut(RUN).zip(samples.positions.par_chunks(RUN)).for_each(|(mask, positions)| {
            for (m, p) in mask.iter_mut().zip(positions) {
                *m = if p.iter().any(|v| v.is_nan()) { NONE } else { LIT };
            }
            for resolver in &resolvers {
                for (m, p) in mask.iter_mut().zip(positions) {
                    if *m == LIT && resolver.blocks(*p).0 {
                        *m = SHADOWED;
                    }
                }
            }
        });
        stats.stage("test_all");
        Ok(stats.finish(triangles.len(), mask))
    }

    fn debug_views(&self) -> &'static [DebugView] {
        VIEWS
    }

    fn debug_view(
        &mut self,
        view: &str,
        triangles: &[Triangle],
        samples: Samples<'_>,
        light: [f32; 3],
    ) -> Result<Option<Vec<f32>>, InputError> {
        if !check_view(VIEWS, view, triangles, samples, light)? {
            return Ok(None);
        }
        let resolvers: Vec<Resolver> = triangles.par_iter().filter_map(|t| Resolver::new(t, light)).collect();
        let mut out = complete(vec![0.0; samples.positions.len()], samples.positions);
        out.par_chunks_mut(RUN).zip(samples.positions.par_chunks(RUN)).for_each(|(out, positions)| {
            for resolver in &resolvers {
                for (number, p) in out.iter_mut().zip(positions).filter(|(number, _)| !number.is_nan()) {
                    let (blocks, decided) = resolver.blocks(*p);
                    let counts = if view == "blockers" { blocks } else { decided == Decided::Exact };
                    *number += f32::from(u8::from(counts));
                }
            }
        });
        Ok(Some(out))
    }
}
