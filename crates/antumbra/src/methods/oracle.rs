//! `oracle`: the definition as a plain loop. Slow, and what every other method is held against.

use antumbra_predicates::exact;
use rayon::prelude::*;

use super::{Method, Samples, Stats, StatsBuilder, check_input};
use crate::mask::{LIT, NONE, SHADOWED};
use crate::scene::{InputError, Triangle};

/// Tests every triangle against every sample in exact arithmetic: O(T N).
#[derive(Clone, Copy, Debug, Default)]
pub struct Oracle;

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
        mask.par_iter_mut().zip(samples.positions).for_each(|(m, p)| {
            *m = if p.iter().any(|v| v.is_nan()) {
                NONE
            } else if triangles.iter().any(|t| exact::blocks(t, light, *p)) {
                SHADOWED
            } else {
                LIT
            };
        });
        stats.stage("test_all");
        Ok(stats.finish(triangles.len(), mask))
    }
}
