//! From a name to an engine.

use anyhow::{Result, bail};
use bench_antumbra::Antumbra;
use bench_common::Engine;
use bench_embree::Embree;
use bench_obvhs::Obvhs;

/// Makes an engine for `threads` threads. `antumbra:METHOD` or a rival with its options after a colon.
///
/// # Errors
/// A name that nobody knows, or what keeps the engine from starting.
pub fn create(name: &str, threads: usize) -> Result<Box<dyn Engine>> {
    let (kind, options) = name.split_once(':').unwrap_or((name, ""));
    Ok(match kind {
        "antumbra" => Box::new(Antumbra::new(if options.is_empty() { "auto" } else { options })?),
        "embree" => Box::new(Embree::new(options, threads)?),
        "obvhs" => Box::new(Obvhs::new(options)?),
        _ => bail!("unknown engine '{name}'; known are antumbra:METHOD, embree[:OPTION...], obvhs[:PRESET]"),
    })
}
