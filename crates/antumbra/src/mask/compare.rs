//! How two masks differ, in numbers and as a picture.

use super::{LIT, NONE, SHADOWED};
use crate::scene::InputError;

/// A mask held against a reference.
///
/// `mismatches = leaks + acne + stray`: an exact method has none against any other exact method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Samples of the reference, without background.
    pub samples: usize,
    /// Entries that differ.
    pub mismatches: usize,
    /// Shadowed in the reference, lit here: light comes through.
    pub leaks: usize,
    /// Lit in the reference, shadowed here.
    pub acne: usize,
    /// Differences that are neither: background on one side only, or a value that is no mask value.
    pub stray: usize,
    /// Index of the first entry that differs.
    pub first: Option<usize>,
}

/// Counts where `mask` differs from `reference`.
///
/// # Errors
/// [`InputError::Length`] if the masks differ in length.
pub fn compare(reference: &[u8], mask: &[u8]) -> Result<Comparison, InputError> {
    check_lengths(reference, mask)?;
    let mut found =
        Comparison { samples: reference.iter().filter(|&&r| r != NONE).count(), ..Comparison::default() };
    for (i, (&r, &m)) in reference.iter().zip(mask).enumerate() {
        if r == m {
            continue;
        }
        found.first.get_or_insert(i);
        found.mismatches += 1;
        match (r, m) {
            (SHADOWED, LIT) => found.leaks += 1,
            (LIT, SHADOWED) => found.acne += 1,
            _ => found.stray += 1,
        }
    }
    Ok(found)
}

/// The mask in greys with what differs in colour: leaks red, acne blue, strays yellow. sRGB, one entry a sample.
///
/// # Errors
/// [`InputError::Length`] if the masks differ in length.
pub fn difference_picture(reference: &[u8], mask: &[u8]) -> Result<Vec<[u8; 3]>, InputError> {
    check_lengths(reference, mask)?;
    let color = |(&r, &m): (&u8, &u8)| match (r, m) {
        (SHADOWED, LIT) => [230, 30, 30],
        (LIT, SHADOWED) => [30, 60, 240],
        _ if r != m => [240, 210, 0],
        (_, LIT) => [190; 3],
        (_, SHADOWED) => [80; 3],
        _ => [20; 3],
    };
    Ok(reference.iter().zip(mask).map(color).collect())
}

fn check_lengths(reference: &[u8], mask: &[u8]) -> Result<(), InputError> {
    match mask.len() == reference.len() {
        true => Ok(()),
        false => Err(InputError::Length { what: "mask", got: mask.len(), expected: reference.len() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_difference_is_counted_once() {
        let reference = [LIT, SHADOWED, NONE, LIT, SHADOWED, NONE, LIT];
        let mask = [LIT, LIT, LIT, SHADOWED, SHADOWED, NONE, 7];
        let found = compare(&reference, &mask).unwrap();
        let expected = Comparison { samples: 5, mismatches: 4, leaks: 1, acne: 1, stray: 2, first: Some(1) };
        assert_eq!(found, expected);
        let picture = difference_picture(&reference, &mask).unwrap();
        let colored = picture.iter().filter(|p| p[0] != p[1] || p[1] != p[2]).count();
        assert_eq!(colored, found.mismatches);
    }

    #[test]
    fn lengths_must_agree() {
        assert!(compare(&[0], &[0, 0]).is_err());
        assert!(difference_picture(&[0, 1], &[0]).is_err());
        assert_eq!(compare(&[], &[]).unwrap(), Comparison::default());
    }
}
