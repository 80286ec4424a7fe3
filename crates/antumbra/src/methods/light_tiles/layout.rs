//! Blocks of 16 samples: 4 x 4 pixels of a picture, or 16 in a row of a list.

use fearless_simd::{Simd, SimdBase, f32x4, f32x8};

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
        // Halves of the width divide in half the time.
        let (row, column) = (block as u32 / self.columns as u32, block as u32 % self.columns as u32);
        (4 * row as usize * self.width + 4 * column as usize, self.width)
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

    /// The samples of a block, coordinates apart: rows 0 and 1, rows 2 and 3. Outside the picture they are NaN.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, s: S, positions: &[[f32; 3]], block: usize) -> [[f32x8<S>; 2]; 3] {
        let (start, line) = self.corner(block);
        let flat = positions.as_flattened();
        let row = |y: usize| flat.get(3 * (start + y * line)..).and_then(|f| f.first_chunk());
        if self.is_list || 4 * (block as u32 % self.columns as u32) as usize + 4 <= self.width {
            // Short at the very end of the samples.
            if let (Some(a), Some(b), Some(c), Some(d)) = (row(0), row(1), row(2), row(3)) {
                let (a, b, c, d) = (apart(s, a), apart(s, b), apart(s, c), apart(s, d));
                return [
                    [s.combine_f32x4(a[0], b[0]), s.combine_f32x4(c[0], d[0])],
                    [s.combine_f32x4(a[1], b[1]), s.combine_f32x4(c[1], d[1])],
                    [s.combine_f32x4(a[2], b[2]), s.combine_f32x4(c[2], d[2])],
                ];
            }
        }
        let at = self.load_border(positions, block);
        let [x, y, z] = &at;
        [halves(s, x), halves(s, y), halves(s, z)]
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

/// Four points, coordinates apart. One number more is read than they have.
#[inline(always)]
fn apart<S: Simd>(s: S, points: &[f32; 13]) -> [f32x4<S>; 3] {
    let a = f32x4::from_slice(s, &points[0..4]);
    let b = f32x4::from_slice(s, &points[3..7]);
    let c = f32x4::from_slice(s, &points[6..10]);
    let d = f32x4::from_slice(s, &points[9..13]);
    let (ac, bd) = (s.zip_low_f32x4(a, c), s.zip_low_f32x4(b, d));
    let z = s.zip_low_f32x4(s.zip_high_f32x4(a, c), s.zip_high_f32x4(b, d));
    [s.zip_low_f32x4(ac, bd), s.zip_high_f32x4(ac, bd), z]
}

/// Sixteen numbers as two vectors.
#[inline(always)]
pub(super) fn halves<S: Simd>(s: S, v: &[f32; BLOCK]) -> [f32x8<S>; 2] {
    [f32x8::from_slice(s, &v[..8]), f32x8::from_slice(s, &v[8..])]
}
