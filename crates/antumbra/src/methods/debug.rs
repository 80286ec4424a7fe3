//! Debug views: one number a sample that shows what a method does there. What all methods share is here.

use super::{Samples, check_asked};
use crate::scene::{InputError, Triangle};

/// How the numbers of a view are to be read, so that a picture can choose its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// An amount, 0 or more. Few samples may have far more than the rest: a picture may cut them off.
    Amount,
    /// A level, a class, or the name of a group: whole numbers from 0, of which none may be cut off.
    Label,
}

/// A picture that a method can make of its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DebugView {
    /// What [`super::Method::debug_view`] is asked for.
    pub name: &'static str,
    /// What its numbers are.
    pub shows: &'static str,
    /// How to read them.
    pub scale: Scale,
}

impl DebugView {
    /// A view of amounts.
    pub const fn amount(name: &'static str, shows: &'static str) -> DebugView {
        DebugView { name, shows, scale: Scale::Amount }
    }

    /// A view of levels, classes or groups.
    pub const fn label(name: &'static str, shows: &'static str) -> DebugView {
        DebugView { name, shows, scale: Scale::Label }
    }
}

/// Whether `views` has a view of this name; if so, checks the input as [`super::Method::shadow`] does.
pub(crate) fn check_view(
    views: &[DebugView],
    view: &str,
    triangles: &[Triangle],
    samples: Samples<'_>,
    light: [f32; 3],
) -> Result<bool, InputError> {
    if !views.iter().any(|v| v.name == view) {
        return Ok(false);
    }
    check_asked(triangles, samples, light)?;
    Ok(true)
}

/// A number from 0 to 255 for a group. Neighbours get far numbers (Fibonacci hashing), so that they can be told apart.
pub(crate) fn group(index: usize) -> f32 {
    ((index as u32).wrapping_mul(0x9e37_79b9) >> 24) as f32
}

/// Makes the numbers NaN exactly where there is no sample. A sample that the method had nothing to do with (one at
/// the light itself, say) gets 0.
pub(crate) fn complete(mut numbers: Vec<f32>, positions: &[[f32; 3]]) -> Vec<f32> {
    for (number, p) in numbers.iter_mut().zip(positions) {
        if p.iter().any(|v| v.is_nan()) {
            *number = f32::NAN;
        } else if number.is_nan() {
            *number = 0.0;
        }
    }
    numbers
}
