//! Blocks of 32 samples: 8 x 4 pixels of a picture, or 32 in a row of a list, which is taken for four lines of 8.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};

use super::shuffle::{columns, two};

/// Samples of a block.
pub(super) const BLOCK: usize = 32;
/// Samples of its left or right half, 4 x 4 pixels: numbers 0 to 15, or 16 to 31, row by row.
pub(super) const HALF: usize = 16;

/// Where the samples of a block are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Layout {
    /// Samples a line of blocks.
    width: usize,
    /// From line to line of a block, and from block to block.
    line: usize,
    step: usize,
    /// Blocks a row.
    pub(super) columns: usize,
    /// Rows of blocks.
    pub(super) rows: usize,
    len: usize,
}

/// Blocks a row of a list.
const LIST_COLUMNS: usize = 128;

/// The numbers of the four rows of a block, and one more each.
pub(super) type Rows<'a> = [&'a [f32; 25]; 4];

impl Layout {
    /// Of `len` samples, `width` a row (a last row may be short).
    pub(super) fn new(len: usize, width: usize) -> Layout {
        let width = width.max(1);
        // A narrow picture would leave half of each block empty, and number more samples than there are.
        if width >= len || width < 8 {
            let rows = len.div_ceil(BLOCK).div_ceil(LIST_COLUMNS);
            return Layout {
                width: 8 * LIST_COLUMNS,
                line: 8,
                step: BLOCK,
                columns: LIST_COLUMNS,
                rows,
                len,
            };
        }
        let rows = len.div_ceil(width).div_ceil(4);
        Layout { width, line: width, step: 8, columns: width.div_ceil(8), rows, len }
    }

    /// Blocks in all.
    pub(super) fn blocks(&self) -> usize {
        self.columns * self.rows
    }

    /// Samples of a row of blocks.
    pub(super) fn row_samples(&self) -> usize {
        4 * self.width
    }

    /// The place of the first sample of a block, and how far apart its lines are. Samples of blocks at the border may lie
    /// outside: [`Layout::index`] says which.
    #[inline(always)]
    pub(super) fn corner(&self, block: usize) -> (usize, usize) {
        let (row, column) = self.place(block);
        (4 * row * self.width + self.step * column, self.line)
    }

    /// The index of a sample that is in the picture, in a block at [`Layout::corner`].
    #[inline(always)]
    pub(super) fn index_from(&self, (start, line): (usize, usize), sample: usize) -> usize {
        start + sample % HALF / 4 * line + sample / HALF * 4 + sample % 4
    }

    /// From block to block of a row.
    pub(super) fn step(&self) -> usize {
        self.step
    }

    /// Row and column of a block.
    #[inline(always)]
    fn place(&self, block: usize) -> (usize, usize) {
        // Short numbers divide in half the time.
        let (block, columns) = (block as u32, self.columns as u32);
        ((block / columns) as usize, (block % columns) as usize)
    }

    /// The index of a sample of a block, if it is in the picture.
    #[inline(always)]
    pub(super) fn index(&self, block: usize, sample: usize) -> Option<usize> {
        let (row, column) = self.place(block);
        let (x, y) = (sample / HALF * 4 + sample % 4, sample % HALF / 4);
        if 8 * column + x >= self.width {
            return None;
        }
        let i = 4 * row * self.width + y * self.line + self.step * column + x;
        (i < self.len).then_some(i)
    }

    /// Which samples of a block lie within the columns of the picture; bits.
    #[inline(always)]
    pub(super) fn inside(&self, column: usize) -> u32 {
        let columns = self.width.saturating_sub(8 * column);
        if columns >= 8 {
            return u32::MAX;
        }
        let half = |columns: usize| 0x1111 * ((1 << columns.min(4)) - 1);
        half(columns) | half(columns.saturating_sub(4)) << HALF
    }

    /// Sets the bits of `value` for samples of a block in the mask of its row of blocks; `word` has one bit a sample, all of
    /// them within the picture's columns.
    #[inline(always)]
    pub(super) fn mark(&self, mask: &mut [u8], column: usize, word: u32, value: u8) {
        for y in 0..4 {
            // Eight bits in a line, of both halves.
            let start = self.step * column + self.line * y;
            let eight = word >> (4 * y) & 0xf | (word >> (HALF + 4 * y) & 0xf) << 4;
            // Bits 0 to 3 to the lowest bits of four bytes: copies 7 bits apart.
            let spread = |four: u32| u64::from((four * 0x0020_4081) & 0x0101_0101);
            let spread = (spread(eight & 0xf) | spread(eight >> 4) << 32) * u64::from(value);
            if let Some(bytes) = mask.get_mut(start..).and_then(|m| m.first_chunk_mut::<8>()) {
                *bytes = (u64::from_le_bytes(*bytes) | spread).to_le_bytes();
            } else {
                // At the end of the mask; samples outside the picture have no bits.
                let rest = mask.get_mut(start..).unwrap_or_default();
                rest.iter_mut().zip(spread.to_le_bytes()).for_each(|(m, s)| *m |= s);
            }
        }
    }

    /// Sets all samples of a block, within the picture, in the mask of its row of blocks.
    #[inline(always)]
    pub(super) fn fill(&self, mask: &mut [u8], column: usize, value: u8) {
        for y in 0..4 {
            if let Some(row) =
                mask.get_mut(self.step * column + self.line * y..).and_then(|m| m.first_chunk_mut::<8>())
            {
                *row = [value; 8];
            }
        }
    }

    /// The samples of a block of a picture, coordinates apart: rows 0 and 1, rows 2 and 3 of the left half, then of the right.
    /// Outside the picture they are NaN.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, s: S, positions: &[[f32; 3]], block: usize) -> [[f32x8<S>; 4]; 3] {
        self.load_rows(s, positions, block, self.rows_of(positions, block))
    }

    /// The same, of a block whose rows are known.
    #[inline(always)]
    pub(super) fn load_rows<S: Simd>(
        &self,
        s: S,
        positions: &[[f32; 3]],
        block: usize,
        rows: Option<Rows<'_>>,
    ) -> [[f32x8<S>; 4]; 3] {
        let ([x, y, z], [x2, y2, z2]) = if let Some(rows) = rows {
            (half_of::<S, 0>(s, rows), half_of::<S, 12>(s, rows))
        } else {
            (self.load_half(s, positions, block, 0), self.load_half(s, positions, block, 1))
        };
        [[x[0], x[1], x2[0], x2[1]], [y[0], y[1], y2[0], y2[1]], [z[0], z[1], z2[0], z2[1]]]
    }

    /// The same of one half.
    #[inline(always)]
    pub(super) fn load_half<S: Simd>(
        &self,
        s: S,
        positions: &[[f32; 3]],
        block: usize,
        half: usize,
    ) -> [[f32x8<S>; 2]; 3] {
        match (self.rows_of(positions, block), half) {
            (Some(rows), 0) => half_of::<S, 0>(s, rows),
            (Some(rows), _) => half_of::<S, 12>(s, rows),
            _ => {
                let at = self.load_border(positions, block);
                let range = HALF * half..HALF * (half + 1);
                [halves(s, &at[0][range.clone()]), halves(s, &at[1][range.clone()]), halves(s, &at[2][range])]
            }
        }
    }

    /// The coordinates of the four rows of a block, and one number more. `None` at the border.
    #[inline(always)]
    pub(super) fn rows_of<'a>(&self, positions: &'a [[f32; 3]], block: usize) -> Option<Rows<'a>> {
        let (row, column) = self.place(block);
        self.rows_at(positions, row, column)
    }

    /// The same of the block in a row and column.
    #[inline(always)]
    pub(super) fn rows_at<'a>(
        &self,
        positions: &'a [[f32; 3]],
        row: usize,
        column: usize,
    ) -> Option<Rows<'a>> {
        if 8 * column + 8 > self.width {
            return None;
        }
        let line = 3 * self.line;
        let block = positions.as_flattened().get(3 * (4 * row * self.width + self.step * column)..)?;
        let last = block.get(3 * line..)?.first_chunk()?;
        Some([block.first_chunk()?, block[line..].first_chunk()?, block[2 * line..].first_chunk()?, last])
    }

    #[inline(never)]
    fn load_border(&self, positions: &[[f32; 3]], block: usize) -> [[f32; BLOCK]; 3] {
        let mut at = [[f32::NAN; BLOCK]; 3];
        for i in 0..BLOCK {
            if let Some(p) = self.index(block, i).map(|i| positions[i]) {
                (at[0][i], at[1][i], at[2][i]) = (p[0], p[1], p[2]);
            }
        }
        at
    }
}

/// Whether a block has no sample: every number is NaN.
#[inline(always)]
pub(super) fn is_background<S: Simd>(s: S, rows: Rows<'_>) -> bool {
    let first = f32x8::from_slice(s, &rows[0][..8]);
    let mut none = first.simd_ne(first);
    // One look tells of nearly all others.
    if none.to_bitmask() != 0xff {
        return false;
    }
    for row in rows {
        for i in [0, 8, 16] {
            let v = f32x8::from_slice(s, &row[i..i + 8]);
            none &= v.simd_ne(v);
        }
    }
    none.to_bitmask() == 0xff
}

/// Four points of each row, from number `AT` on, coordinates apart: two rows a vector.
#[inline(always)]
fn half_of<S: Simd, const AT: usize>(s: S, [a, b, c, d]: Rows<'_>) -> [[f32x8<S>; 2]; 3] {
    let ([x, y, z], [x2, y2, z2]) = (points::<S, AT>(s, a, b), points::<S, AT>(s, c, d));
    [[x, x2], [y, y2], [z, z2]]
}

/// Of two rows. One number more is read than the points have.
#[inline(always)]
fn points<S: Simd, const AT: usize>(s: S, a: &[f32; 25], b: &[f32; 25]) -> [f32x8<S>; 3] {
    let (a, b) = (&a[AT..AT + 13], &b[AT..AT + 13]);
    let [x, y, z, _] = columns(
        s,
        [two(s, a, b), two(s, &a[3..], &b[3..]), two(s, &a[6..], &b[6..]), two(s, &a[9..], &b[9..])],
    );
    [x, y, z]
}

/// Sixteen numbers as two vectors.
#[inline(always)]
fn halves<S: Simd>(s: S, v: &[f32]) -> [f32x8<S>; 2] {
    [f32x8::from_slice(s, &v[..8]), f32x8::from_slice(s, &v[8..HALF])]
}
