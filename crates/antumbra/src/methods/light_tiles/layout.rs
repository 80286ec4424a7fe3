//! Blocks of 16 samples: 4 x 4 pixels of a picture, or 16 in a row of a list.

/// Samples of a block.
pub(super) const BLOCK: usize = 16;

/// Where the samples of a block are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Layout {
    /// Samples a row of the picture.
    width: usize,
    /// Blocks a row.
    pub(super) columns: usize,
    /// Rows of blocks.
    pub(super) rows: usize,
    /// Samples in no order.
    pub(super) is_list: bool,
    len: usize,
}

/// Blocks a row of a list.
const LIST_COLUMNS: usize = 256;

impl Layout {
    /// Of `len` samples, `width` a row (a last row may be short).
    pub(super) fn new(len: usize, width: usize) -> Layout {
        let width = width.max(1);
        if width >= len {
            let blocks = len.div_ceil(BLOCK);
            let rows = blocks.div_ceil(LIST_COLUMNS);
            return Layout { width, columns: LIST_COLUMNS, rows, is_list: true, len };
        }
        let rows = len.div_ceil(width).div_ceil(4);
        Layout { width, columns: width.div_ceil(4), rows, is_list: false, len }
    }

    /// Blocks in all.
    pub(super) fn blocks(&self) -> usize {
        self.columns * self.rows
    }

    /// Samples of a row of blocks.
    pub(super) fn row_samples(&self) -> usize {
        if self.is_list { LIST_COLUMNS * BLOCK } else { 4 * self.width }
    }

    /// The place of the first sample of a block, and how far apart its lines are. Samples of blocks at the border may lie
    /// outside: [`Layout::index`] says which.
    #[inline(always)]
    pub(super) fn corner(&self, block: usize) -> (usize, usize) {
        if self.is_list {
            return (block * BLOCK, 4);
        }
        let (row, column) = (block / self.columns, block % self.columns);
        (4 * row * self.width + 4 * column, self.width)
    }

    /// The index of a sample of a block, if it is in the picture.
    #[inline(always)]
    pub(super) fn index(&self, block: usize, sample: usize) -> Option<usize> {
        if !self.is_list && 4 * (block % self.columns) + sample % 4 >= self.width {
            return None;
        }
        let (start, line) = self.corner(block);
        let i = start + sample / 4 * line + sample % 4;
        (i < self.len).then_some(i)
    }

    /// Which samples of a block lie within the columns of the picture; bits.
    #[inline(always)]
    pub(super) fn inside(&self, column: usize) -> u16 {
        let left = self.width.saturating_sub(4 * column);
        if self.is_list || left >= 4 { u16::MAX } else { 0x1111 * ((1 << left) - 1) }
    }

    /// Sets the bits of `value` for samples of a block in the mask of its row of blocks; `word` has one bit a sample, all of
    /// them within the picture's columns.
    #[inline(always)]
    pub(super) fn mark(&self, mask: &mut [u8], column: usize, word: u16, value: u8) {
        let (start, line) = if self.is_list { (column * BLOCK, 4) } else { (4 * column, self.width) };
        for y in 0..4 {
            let four = u32::from(word >> (4 * y) & 0xf);
            // Bits 0 to 3 to the lowest bits of four bytes: copies 7 bits apart.
            let spread = (((four * 0x0020_4081) & 0x0101_0101) * u32::from(value)).to_le_bytes();
            if let Some(bytes) = mask.get_mut(start + y * line..).and_then(|m| m.first_chunk_mut::<4>()) {
                *bytes = (u32::from_le_bytes(*bytes) | u32::from_le_bytes(spread)).to_le_bytes();
            } else {
                // At the end of the mask; samples outside the picture have no bits.
                let rest = mask.get_mut(start + y * line..).unwrap_or_default();
                rest.iter_mut().zip(spread).for_each(|(m, s)| *m |= s);
            }
        }
    }

    /// Line `y` (of four) of `count` blocks of a row of a picture, coordinates apart: NaN outside the picture.
    #[inline(always)]
    pub(super) fn load(
        &self,
        positions: &[[f32; 3]],
        row: usize,
        first: usize,
        count: usize,
        y: usize,
        out: [&mut [f32]; 3],
    ) {
        let [xs, ys, zs] = out;
        let (xs, ys, zs) = (&mut xs[..4 * count], &mut ys[..4 * count], &mut zs[..4 * count]);
        let start = ((4 * row + y) * self.width + 4 * first).min(self.len);
        let end = ((4 * row + y) * self.width + self.width.min(4 * (first + count))).min(self.len);
        let line = positions.get(start..end).unwrap_or(&[]);
        for (((p, x), y), z) in line.iter().zip(&mut *xs).zip(&mut *ys).zip(&mut *zs) {
            (*x, *y, *z) = (p[0], p[1], p[2]);
        }
        for out in [xs, ys, zs] {
            out[line.len()..].fill(f32::NAN);
        }
    }
}
