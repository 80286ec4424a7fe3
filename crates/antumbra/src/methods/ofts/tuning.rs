//! Constants that trade memory for time, each with its trade-off. None of them can change a mask.

/// Cells a side of the heat map of a face. Larger: tighter windows and a better guess of how much of a window is
/// occupied; costs 24 bytes times its square. 512 is what the framework of Kobrtek et al. 2021 uses.
pub(super) const HEAT: u32 = 512;

/// A window that spans at most this many heat cells on both axes gets a heat map of its own (a light that is far away
/// sees everything in one cell). Each such zoom is one more pass over the samples.
pub(super) const ZOOM_BELOW: u32 = 32;

/// Zooms at most: 4 shrink a window by 16^4 each axis. What is left to do then, sub-grids do.
pub(super) const ZOOMS: u32 = 4;

/// Samples of an occupied tile, about. Smaller: more (tile, triangle) pairs to sort and more set-ups of triangles.
/// Larger: fewer tasks to share among threads, and coarser culling before the cells.
pub(super) const TILE_SAMPLES: f64 = 2048.0;

/// Tiles a side of a window at most.
pub(super) const TILES_A_SIDE: u32 = 1024;

/// Samples of a cell, about. One vector test takes eight; cells of two vectors lose little to padding and cost less
/// to rasterise than to test. Also the unit of the lists: 96 bytes for eight samples.
pub(super) const CELL_SAMPLES: f64 = 16.0;

/// A list that is longer gets a sub-grid (methods 6.5).
pub(super) const LIST_MAX: usize = 64;

/// Sub-grids inside sub-grids. One level is what a picture needs; more are for samples that crowd around a point
/// again and again. Samples in the very same direction stay in one list whatever the number of levels.
pub(super) const LEVELS: u32 = 8;

/// Triangles that are looked at between two rounds of traversal, at most.
pub(super) const ROUND_TRIANGLES: usize = 1 << 16;

/// (tile, triangle) pairs of one round: 8 MiB. Fewer: more rounds, each of which waits for its slowest tile; but
/// tiles that are wholly in shadow by then take no more pairs.
pub(super) const ROUND_PAIRS: usize = 1 << 20;
