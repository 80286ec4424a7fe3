//! Which stage decided how often: the statistic that every method reports.

use core::{fmt, ops::AddAssign};

use crate::Decided;

/// Numbers of (triangle, sample) tests decided by each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shares {
    /// Decided by [`crate::filter`], in f32.
    pub single: u64,
    /// Decided by [`crate::resolve`], in f64.
    pub double: u64,
    /// Decided by [`crate::exact`], by expansions.
    pub exact: u64,
}

impl Shares {
    /// Counts what [`crate::Resolver::blocks`] said.
    pub fn count(&mut self, decided: Decided) {
        match decided {
            Decided::Double => self.double += 1,
            Decided::Exact => self.exact += 1,
        }
    }

    /// All tests.
    pub fn total(&self) -> u64 {
        self.single + self.double + self.exact
    }
}

impl AddAssign for Shares {
    fn add_assign(&mut self, other: Shares) {
        self.single += other.single;
        self.double += other.double;
        self.exact += other.exact;
    }
}

impl fmt::Display for Shares {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |n: u64| 100.0 * n as f64 / self.total().max(1) as f64;
        let (single, double, exact) = (percent(self.single), percent(self.double), percent(self.exact));
        write!(f, "f32 {single:.4} %, f64 {double:.4} %, exact {exact:.4} % of {} tests", self.total())
    }
}
