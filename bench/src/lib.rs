//! antumbra against its rivals, on the same arrays, in one process.
//!
//! [`engines`] makes engines by name → [`measure`] runs them by turns → [`compare`] holds masks and times against each other
//! → [`report`] prints and writes.

pub mod args;
pub mod compare;
pub mod engines;
pub mod measure;
pub mod report;
pub mod run;
