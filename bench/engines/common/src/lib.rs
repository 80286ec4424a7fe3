//! What every engine of the bench has in common: the question, the answer's form, and what is timed.

mod case;
mod tiles;

pub use case::Case;
pub use tiles::{TILE, Tile, for_each_tile};

use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;

/// Wall times of one frame, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTime {
    /// Building whatever is searched; all that depends on the triangles.
    pub build_ms: f64,
    /// Everything else: asking the samples and writing the mask.
    pub trace_ms: f64,
    /// From arrays in memory to mask in memory, as a caller's clock sees it.
    pub total_ms: f64,
}

/// Somebody who can tell which samples are in shadow.
///
/// `frame` runs inside a rayon pool of as many threads as the engine was made for, and must leave no thread busy behind.
pub trait Engine: Send {
    /// As asked for on the command line.
    fn name(&self) -> &str;

    /// How it was set up, in a few words for a report.
    fn setup(&self) -> String;

    /// Whether its masks are to equal exact arithmetic in every sample.
    fn exact(&self) -> bool {
        false
    }

    /// Gets hold of the arrays. What a renderer would do once for a scene whose triangles move from now on may be done here; a
    /// hierarchy may not.
    ///
    /// # Errors
    /// What the engine has to say against the input.
    fn prepare(&mut self, case: &Arc<Case>) -> Result<()>;

    /// Answers as if every triangle had moved since the last frame.
    ///
    /// # Errors
    /// What went wrong in the engine.
    fn frame(&mut self, mask: &mut [u8]) -> Result<FrameTime>;
}

/// Milliseconds since `start`.
pub fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
