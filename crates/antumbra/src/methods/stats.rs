//! What a method reports: times by stage in pipeline order, bytes by buffer, counters. Returned, never printed.

use std::time::Instant;

use rayon::prelude::*;
use smallvec::SmallVec;

/// One stage of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// A verb and its object, e.g. `build_hierarchy`.
    pub name: &'static str,
    /// Wall time in milliseconds.
    pub ms: f64,
}

/// Statistics of one call of [`super::Method::shadow`]. They stand where they are returned: no frame allocates for them.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// The method's name.
    pub method: &'static str,
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// The instruction set that ran.
    pub isa: &'static str,
    /// Threads of the pool.
    pub threads: usize,
    /// Samples asked, without background.
    pub samples: usize,
    /// Casters.
    pub triangles: usize,
    /// Samples in shadow.
    pub shadowed: usize,
    /// Times in pipeline order.
    pub stages: SmallVec<[Stage; 8]>,
    /// From arrays in memory to mask in memory, nothing precomputed.
    pub total_ms: f64,
    /// Bytes by buffer.
    pub bytes: SmallVec<[(&'static str, u64); 8]>,
    /// Work counters (names of the methods' pages); those that cost time are only there when asked for.
    pub counters: SmallVec<[(&'static str, u64); 32]>,
}

/// Measures the stages of one frame.
#[derive(Debug)]
pub struct StatsBuilder {
    stats: Stats,
    start: Instant,
    last: Instant,
}

impl StatsBuilder {
    /// Starts the clock.
    pub fn start(method: &'static str, isa: &'static str) -> StatsBuilder {
        let now = Instant::now();
        let stats =
            Stats { method, backend: "cpu", isa, threads: rayon::current_num_threads(), ..Stats::default() };
        StatsBuilder { stats, start: now, last: now }
    }

    /// Ends the stage that began at the last call (or at the start).
    pub fn stage(&mut self, name: &'static str) {
        let now = Instant::now();
        self.stats.stages.push(Stage { name, ms: (now - self.last).as_secs_f64() * 1e3 });
        self.last = now;
    }

    /// Notes a buffer's size.
    pub fn bytes(&mut self, name: &'static str, bytes: usize) {
        self.stats.bytes.push((name, bytes as u64));
    }

    /// Notes a counter.
    pub fn counter(&mut self, name: &'static str, value: u64) {
        self.stats.counters.push((name, value));
    }

    /// Stops the clock and counts the answers (the counting is not timed).
    pub fn finish(mut self, triangles: usize, mask: &[u8]) -> Stats {
        self.stats.total_ms = self.start.elapsed().as_secs_f64() * 1e3;
        self.stats.triangles = triangles;
        let [none, shadowed] = count(mask, [crate::mask::NONE, crate::mask::SHADOWED]);
        self.stats.samples = mask.len() - none;
        self.stats.shadowed = shadowed;
        self.stats
    }
}

/// How often two values occur. Counts in bytes, so that a vector counts as many as it has bytes, and on all threads: callers wait for
/// this after every frame.
fn count(mask: &[u8], values: [u8; 2]) -> [usize; 2] {
    let few = |m: &[u8], value: u8| usize::from(m.iter().fold(0u8, |n, &v| n + u8::from(v == value)));
    let some =
        |m: &[u8]| m.chunks(255).fold([0, 0], |[a, b], m| [a + few(m, values[0]), b + few(m, values[1])]);
    mask.par_chunks(255 << 8).map(some).reduce(|| [0, 0], |[a, b], [c, d]| [a + c, b + d])
}
