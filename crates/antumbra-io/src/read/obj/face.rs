//! Faces: corners, and what they point to.

use super::super::mesh::{Budget, Text, quote};
use super::values;

/// Points to nothing.
pub(super) const NONE: u32 = u32::MAX;

const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Indices of position, texture coordinate and normal, from 0; [`NONE`] where there is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner(pub(super) [u32; 3]);

impl Corner {
    /// Index of the position.
    pub(super) fn position(&self) -> usize {
        self.0[0] as usize
    }
}

/// How many positions, texture coordinates and normals there are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts(pub(super) [usize; 3]);

/// The largest index of each kind that pointed beyond what there was, and the line that it stands in.
#[derive(Debug, Default)]
pub(super) struct Furthest([(u32, usize); 3]);

impl Furthest {
    /// At the end of the file, nothing may point beyond what there is.
    pub(super) fn check(&self, counts: Counts) -> Result<(), String> {
        for ((&(index, line), kind), count) in self.0.iter().zip(KINDS).zip(counts.0) {
            if line > 0 && index as usize >= count {
                return Err(format!("line {line}: {}", out_of_range(kind, i64::from(index) + 1, count)));
            }
        }
        Ok(())
    }
}

fn out_of_range(kind: &str, index: i64, count: usize) -> String {
    format!("{kind} index {index} out of range (there are {count})")
}

/// The corners of one face; memory is used again for the next.
#[derive(Debug, Default)]
pub(super) struct Polygon {
    pub(super) corners: Vec<Corner>,
    longest: usize,
}

/// Bytes a corner of the longest face that it takes to hold and cut it, with slack for growth.
const SCRATCH: usize = 160;

impl Polygon {
    pub(super) fn read(
        &mut self,
        words: Text,
        counts: Counts,
        line: usize,
        furthest: &mut Furthest,
        budget: &mut Budget,
    ) -> Result<(), String> {
        self.corners.clear();
        for word in values(words) {
            self.corners.push(corner(word, counts, line, furthest)?);
            if self.corners.len() > self.longest {
                budget.take(1, SCRATCH)?;
                self.longest = self.corners.len();
            }
        }
        Ok(())
    }
}

fn corner(word: &[u8], counts: Counts, line: usize, furthest: &mut Furthest) -> Result<Corner, String> {
    let mut corner = [NONE; 3];
    for (k, part) in word.split(|b| *b == b'/').enumerate() {
        if k == 3 || (k == 0 && part.is_empty()) {
            return Err(format!("{} is no corner of a face", quote(word)));
        }
        if part.is_empty() {
            continue;
        }
        let index = integer(part).ok_or_else(|| format!("{} is no corner of a face", quote(word)))?;
        // From 1, or backwards from the last one so far.
        let from_zero = if index > 0 { index - 1 } else { counts.0[k] as i64 + index };
        if index == 0 || !(0..i64::from(NONE)).contains(&from_zero) {
            return Err(out_of_range(KINDS[k], index, counts.0[k]));
        }
        corner[k] = from_zero as u32;
        if corner[k] as usize >= counts.0[k] && corner[k] >= furthest.0[k].0 {
            furthest.0[k] = (corner[k], line);
        }
    }
    Ok(Corner(corner))
}

fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        _ => (false, word),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let value = digits.iter().try_fold(0i64, |value, digit| {
        digit.is_ascii_digit().then(|| value * 10 + i64::from(digit - b'0'))
    })?;
    Some(if negative { -value } else { value })
}
