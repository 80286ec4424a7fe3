//! What is recorded, and how what is found is held against it.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use anyhow::{Context, Result};
use serde::Deserialize;

/// `bench/record/counts.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(crate) struct Record {
    /// Per cent that a number may rise before it counts as worse.
    pub(crate) tolerance: f64,
    #[serde(rename = "case")]
    pub(crate) cases: Vec<Case>,
}

/// One method on one frame.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Case {
    pub(crate) method: String,
    /// Of a built-in scene.
    pub(crate) scene: String,
    pub(crate) size: String,
    pub(crate) isa: String,
    pub(crate) shadowed: Option<u64>,
    pub(crate) instructions: Option<u64>,
    #[serde(default)]
    pub(crate) counters: BTreeMap<String, u64>,
}

/// One number, then and now.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line {
    name: String,
    now: u64,
    verdict: Verdict,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    /// Per cent of change.
    Same(f64),
    Better(f64),
    Worse(f64),
    /// It must be this and is not.
    Wrong(u64),
    Unrecorded,
}

impl Record {
    pub(crate) fn read(path: &Path) -> Result<Record> {
        let shown = || path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(shown)?;
        toml_edit::de::from_str(&text).with_context(shown)
    }

    /// Replaces the numbers in the file and leaves the rest as it is.
    pub(crate) fn write(&self, path: &Path) -> Result<()> {
        let shown = || path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(shown)?;
        let mut document: toml_edit::DocumentMut = text.parse().with_context(shown)?;
        let tables = document["case"].as_array_of_tables_mut().context("no [[case]]")?;
        for (table, case) in tables.iter_mut().zip(&self.cases) {
            for (name, value) in [("shadowed", case.shadowed), ("instructions", case.instructions)] {
                if let Some(value) = value {
                    table[name] = toml_edit::value(value as i64);
                }
            }
            if !case.counters.is_empty() {
                let mut counters = toml_edit::Table::new();
                for (name, value) in &case.counters {
                    counters[name] = toml_edit::value(*value as i64);
                }
                table["counters"] = toml_edit::Item::Table(counters);
            }
        }
        std::fs::write(path, document.to_string()).with_context(shown)
    }
}

impl Case {
    /// All numbers of `found` against those of this case.
    pub(crate) fn compare(&self, found: &Case, tolerance: f64) -> Vec<Line> {
        let mut lines = Vec::new();
        if let Some(now) = found.shadowed {
            let verdict = match self.shadowed {
                Some(then) if then != now => Verdict::Wrong(then),
                Some(_) => Verdict::Same(0.0),
                None => Verdict::Unrecorded,
            };
            lines.push(Line { name: "shadowed".to_owned(), now, verdict });
        }
        if let Some(now) = found.instructions {
            lines.push(Line::new("instructions", self.instructions, now, tolerance));
        }
        for (name, &now) in &found.counters {
            lines.push(Line::new(name, self.counters.get(name).copied(), now, tolerance));
        }
        lines
    }
}

impl Line {
    fn new(name: &str, then: Option<u64>, now: u64, tolerance: f64) -> Line {
        let verdict = match then {
            None => Verdict::Unrecorded,
            // A few more of a rare event are no trend.
            Some(then) if now.abs_diff(then) <= 8 => Verdict::Same(change(then, now)),
            Some(then) => match change(then, now) {
                c if c > tolerance => Verdict::Worse(c),
                c if c < -tolerance => Verdict::Better(c),
                c => Verdict::Same(c),
            },
        };
        Line { name: name.to_owned(), now, verdict }
    }

    pub(crate) fn is_worse(&self) -> bool {
        matches!(self.verdict, Verdict::Worse(_) | Verdict::Wrong(_))
    }
}

/// In per cent.
fn change(then: u64, now: u64) -> f64 {
    if then == 0 {
        if now == 0 { 0.0 } else { f64::INFINITY }
    } else {
        (now as f64 / then as f64 - 1.0) * 100.0
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Line { name, now, .. } = self;
        write!(f, "{name:<20} {now:>14}  ")?;
        match self.verdict {
            Verdict::Same(c) => write!(f, "{c:+.2} %"),
            Verdict::Better(c) => write!(f, "{c:+.2} %  better: record it with --update"),
            Verdict::Worse(c) => write!(f, "{c:+.2} %  WORSE"),
            Verdict::Wrong(then) => write!(f, "WRONG: must be {then}"),
            Verdict::Unrecorded => write!(f, "not recorded: --update does it"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rises_are_worse_and_falls_are_not() {
        let line = |then, now| Line::new("n", Some(then), now, 3.0);
        assert!(line(1000, 1040).is_worse());
        assert!(!line(1000, 1020).is_worse() && !line(1000, 900).is_worse());
        assert!(!line(0, 5).is_worse() && line(0, 50).is_worse());
        assert!(line(1000, 900).to_string().contains("better"));
        assert!(!Line::new("n", None, 7, 3.0).is_worse());
    }
}
