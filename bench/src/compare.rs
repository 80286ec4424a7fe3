//! Holds times and masks of engines against each other.

use antumbra::mask;
use anyhow::{Context, Result};
use serde::Serialize;

use crate::measure::{Frame, Measured};

/// What a list of numbers comes to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The smallest.
    pub min: f64,
    /// The one in the middle.
    pub median: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// Of at least one number.
    pub fn of(numbers: impl Iterator<Item = f64>) -> Spread {
        let mut sorted: Vec<f64> = numbers.collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let at = |k: usize| sorted.get(k).copied().unwrap_or(f64::NAN);
        let middle = sorted.len() / 2;
        let median =
            if sorted.len() % 2 == 1 { at(middle) } else { 0.5 * (at(middle.wrapping_sub(1)) + at(middle)) };
        Spread { min: at(0), median, max: at(sorted.len().wrapping_sub(1)) }
    }
}

/// One engine's times and answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// As asked for.
    pub engine: String,
    /// How it was set up.
    pub setup: String,
    /// Milliseconds.
    pub build_ms: Spread,
    /// Milliseconds.
    pub trace_ms: Spread,
    /// Milliseconds.
    pub total_ms: Spread,
    /// Milliseconds of processor time, by threads.
    pub cpu_ms: Spread,
    /// Samples in shadow.
    pub shadowed: usize,
    /// Samples that differ from the first exact engine; `None` if there is none.
    pub mismatches: Option<usize>,
    /// Whether there must be none.
    pub exact: bool,
}

/// One engine's time by another's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ratio {
    /// The one.
    pub engine: String,
    /// The other.
    pub rival: String,
    /// What of both: `total`, `total to trace alone`, `cpu`.
    pub of: &'static str,
    /// Medians of all rounds, divided.
    pub of_medians: f64,
    /// Minima of all rounds, divided.
    pub of_minima: f64,
    /// Round by round, divided.
    pub rounds: Spread,
}

/// Makes the rows. The first exact engine's mask is the reference.
///
/// # Errors
/// Masks of different lengths: an engine is broken.
pub fn rows(all: &[Measured]) -> Result<Vec<Row>> {
    let reference = all.iter().find(|m| m.exact);
    let row = |m: &Measured| {
        let spread = |f: fn(&Frame) -> f64| Spread::of(m.frames.iter().map(f));
        let mismatches = match reference {
            Some(r) => Some(mask::compare(&r.mask, &m.mask).context("masks differ in length")?.mismatches),
            None => None,
        };
        Ok(Row {
            engine: m.name.clone(),
            setup: m.setup.clone(),
            build_ms: spread(|f| f.time.build_ms),
            trace_ms: spread(|f| f.time.trace_ms),
            total_ms: spread(|f| f.time.total_ms),
            cpu_ms: spread(|f| f.cpu_ms),
            shadowed: m.mask.iter().filter(|&&v| v == mask::SHADOWED).count(),
            mismatches,
            exact: m.exact,
        })
    };
    all.iter().map(row).collect()
}

/// Every engine of ours by every rival.
pub fn ratios(all: &[Measured]) -> Vec<Ratio> {
    let ours = |m: &&Measured| m.name.starts_with("antumbra");
    let mut ratios = Vec::new();
    for engine in all.iter().filter(ours) {
        for rival in all.iter().filter(|m| !ours(m)) {
            let mut push = |of, a: fn(&Frame) -> f64, b: fn(&Frame) -> f64| {
                let (x, y) =
                    (Spread::of(engine.frames.iter().map(a)), Spread::of(rival.frames.iter().map(b)));
                let rounds = engine.frames.iter().zip(&rival.frames).map(|(f, g)| a(f) / b(g));
                ratios.push(Ratio {
                    engine: engine.name.clone(),
                    rival: rival.name.clone(),
                    of,
                    of_medians: x.median / y.median,
                    of_minima: x.min / y.min,
                    rounds: Spread::of(rounds),
                });
            };
            push("total", |f| f.time.total_ms, |f| f.time.total_ms);
            push("total to trace alone", |f| f.time.total_ms, |f| f.time.trace_ms);
            push("cpu", |f| f.cpu_ms, |f| f.cpu_ms);
        }
    }
    ratios
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_an_even_number_is_between_two() {
        let spread = Spread::of([4.0, 1.0, 3.0, 2.0].into_iter());
        assert_eq!((spread.min, spread.median, spread.max), (1.0, 2.5, 4.0));
        assert_eq!(Spread::of([7.0].into_iter()).median, 7.0);
    }
}
