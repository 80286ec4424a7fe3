//! The answer: one byte a sample.

mod compare;

pub use compare::{Comparison, compare, difference_picture};

/// The light reaches the sample.
pub const LIT: u8 = 0;
/// At least one triangle blocks it.
pub const SHADOWED: u8 = 1;
/// No sample here (background).
pub const NONE: u8 = 255;
