//! The picture in square tiles over the threads, for engines that ask ray by ray.

use antumbra::mask::NONE;
use rayon::prelude::*;

/// Pixels of a tile's side: small enough for two threads to end together, large enough for neighbours to share what is in
/// the cache.
pub const TILE: usize = 32;

/// A piece of a band of rows.
#[derive(Debug)]
pub struct Tile<'a> {
    /// First column.
    pub x: usize,
    /// Columns.
    pub width: usize,
    /// First row.
    pub y: usize,
    /// Rows.
    pub height: usize,
    /// Samples a row of the whole picture.
    pub stride: usize,
    /// The answers of the tile, row by row of the tile: filled with "none".
    pub mask: &'a mut [u8],
}

impl Tile<'_> {
    /// The sample's index in the picture.
    pub fn sample(&self, x: usize, y: usize) -> usize {
        (self.y + y) * self.stride + self.x + x
    }
}

/// Calls `work` for every tile, on the threads of the current pool, and collects the answers in `mask`.
///
/// A tile writes into memory of its own, which is copied into the band of rows: safe code cannot share out columns, and the copy
/// costs nothing beside tracing. A bare list (one row) is cut into runs.
pub fn for_each_tile(mask: &mut [u8], width: usize, work: impl Fn(&mut Tile<'_>) + Sync) {
    let (stride, rows, columns) =
        if width >= mask.len() { (width, 1, TILE * TILE) } else { (width, TILE, TILE) };
    mask.par_chunks_mut(rows * stride).enumerate().for_each(|(index, band)| {
        let tiles = split_columns(band, stride, columns, index * rows);
        tiles.into_par_iter().with_max_len(1).for_each(|tile| ask(tile, stride, &work));
    });
}

fn ask(mut piece: Piece<'_>, stride: usize, work: &(impl Fn(&mut Tile<'_>) + Sync)) {
    let (width, height) = (piece.rows[0].len(), piece.rows.len());
    let mut buffer = [NONE; TILE * TILE];
    let mask = &mut buffer[..width * height];
    let mut tile = Tile { x: piece.x, width, y: piece.y, height, stride, mask };
    work(&mut tile);
    for (row, answers) in piece.rows.iter_mut().zip(buffer.chunks(width)) {
        row.copy_from_slice(answers);
    }
}

/// The rows of one tile.
struct Piece<'a> {
    x: usize,
    y: usize,
    rows: Vec<&'a mut [u8]>,
}

fn split_columns(mask: &mut [u8], stride: usize, columns: usize, y: usize) -> Vec<Piece<'_>> {
    let count = stride.min(mask.len()).div_ceil(columns);
    let mut pieces: Vec<Piece<'_>> =
        (0..count).map(|k| Piece { x: k * columns, y, rows: Vec::with_capacity(TILE) }).collect();
    for row in mask.chunks_mut(stride) {
        for (piece, columns) in pieces.iter_mut().zip(row.chunks_mut(columns)) {
            piece.rows.push(columns);
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_asked_once() {
        for (len, width) in [(0, 1), (1, 1), (100 * 70, 100), (64 * 64, 64), (5000, 5000), (1000, 4000)] {
            let mut mask = vec![0; len];
            for_each_tile(&mut mask, width, |tile| {
                for y in 0..tile.height {
                    for x in 0..tile.width {
                        tile.mask[y * tile.width + x] = (tile.sample(x, y) % 251) as u8;
                    }
                }
            });
            assert!(mask.iter().enumerate().all(|(i, &m)| usize::from(m) == i % 251), "{len} {width}");
        }
    }
}
