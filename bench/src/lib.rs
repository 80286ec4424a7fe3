//! antumbra against its rivals, on the same arrays, in one process.
//!
//! [`engines`] makes engines by name → [`measure`] runs them by turns → [`compare`] holds masks and times against each other
//! → [`report`] prints and writes. [`suite`] does so for a folder of [`definition`]s, some of them under [`stress`].

pub mod args;
pub mod compare;
pub mod definition;
pub mod engines;
pub mod measure;
pub mod report;
pub mod run;
pub mod stage;
pub mod stress;
pub mod suite;
