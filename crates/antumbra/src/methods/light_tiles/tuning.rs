//! Numbers that are neither right nor wrong; the mask does not depend on them. What they must be is asserted where they are used.

/// Faces whose samples are seen within so small a part of the face, and of their distance, measure directions from a point among them
/// ([`super::sight`]). With 1/16 a forest gains a twentieth from a light ten scene sizes away, and simple scenes lose as much.
pub(super) const NARROW: f32 = 1.0 / 32.0;

/// Samples that are looked at for that, places where they are looked for at most, and how many a face must have to say something.
pub(super) const SIGHT_SAMPLES: u32 = 64;
pub(super) const SIGHT_PLACES: u32 = 256;
pub(super) const SIGHT_LEAST: u32 = 8;

/// Tiles are chosen from one sample of every block of every so many rows.
pub(super) const EVERY: usize = 4;

/// Such points in a tile: 20 times the square root of the samples for each triangle, within limits (24 up to 1.4 samples a triangle, 96 from 23 on;
/// 3,072 to 12,288 samples). Large tiles have fewer blocks that belong to two, small ones fewer triangles for each sample. With 24 throughout
/// robots take a ninth longer, and all scenes a twelfth at 3840x2160; with 72 throughout hair takes a sixth longer.
pub(super) const TILE_POINTS: f32 = 20.0;
pub(super) const TILE_POINTS_LEAST: f32 = 24.0;
pub(super) const TILE_POINTS_MOST: f32 = 96.0;

/// Fewer points where the samples are few, so that there are some 32 to 128 tiles or more, for the threads to share: 96 tiles by the square root of the
/// samples for each triangle, as few samples of many triangles are best kept apart. With 96 tiles throughout pine takes a sixth longer, with 48 a small
/// picture of black-forest takes a quarter longer, with 256 small pictures a tenth.
pub(super) const TILES: f32 = 96.0;
pub(super) const TILES_LEAST: f32 = 32.0;
pub(super) const TILES_MOST: f32 = 128.0;
pub(super) const LEAST_POINTS: u32 = 4;

/// A cell of the finest level with so many times the points of a tile gets a grid of its own.
pub(super) const CROWDED: u32 = 4;

/// Levels of the grid of a face at most, even: 256 x 256 cells. Fewer merge tiles that belong apart where samples are spread
/// unevenly; two more are sixteen times the cells to clear and to sum in every frame.
pub(super) const LEVELS: u32 = 8;

/// Levels more than an even spread of samples would need: of a face's grid, which triangles and leaves look up with a margin of a
/// cell or two, and of the grid of a crowded cell, where only samples are looked up. The smaller one stays in the first cache.
pub(super) const SPARE: u32 = 4;
pub(super) const SPARE_CROWDED: u32 = 2;

/// With so many samples for each triangle, leaves may stick out of their tiles by two cells instead of one: fewer blocks are parted. It
/// saves a twentieth of the time of simple scenes, and costs black-forest a sixth, as its triangles are looked up farther, too.
pub(super) const WIDE: usize = 16;

/// If a larger part of the samples than this is in crowded cells, or far from its neighbours (more cells than [`FAR`]), the triangles near them are
/// counted ([`super::sparse`]). The largest part of neighbours that are far apart is 0.24 in pictures of our scenes (neuron tubes), and none has more
/// than 0.07 in crowded cells; a forest as a list has 0.30, shuffled Sponza 0.81, clumps 0.94 to 0.98.
pub(super) const LOOKED_AT: f32 = 0.25;
pub(super) const FAR: u32 = 16;

/// So many triangles near samples are few, of eight in every so many eights. With four times as many, leaves that are as wide as their tile cost
/// as much as finding a small tile for each sample.
pub(super) const FEW_NEAR: usize = 4;
pub(super) const NEAR_EVERY: usize = 4;

/// A tile that few triangles are near is shared by so many, for the threads, this many blocks at a time.
pub(super) const SHARES: u32 = 16;
pub(super) const SHARE_BLOCKS: u32 = 32;

/// After so many halves of blocks, one after another in a row, that gave no leaf, the next one goes sample by sample at once.
pub(super) const ALONE: u32 = 8;

/// How often a crowded cell may hold another grid.
pub(super) const DEPTH: u32 = 6;

/// A leaf's samples lie within this part of one another's nearness (of the range of the face, where that is narrow): mixing
/// near and far samples in a leaf is what costs most in hair and foliage.
pub(super) const DEPTH_BAND: f32 = 0.1;

/// Half a block that falls into more leaves than this is given up: its samples are sorted one by one.
pub(super) const BLOCK_LEAVES: u32 = 3;

/// Fewer samples than this are not worth a leaf of their own: they are sorted one by one, with all that are left of their half.
/// With 3 the pine tree has 38,000 loose samples instead of 22,000, and times are the same; with 5 hair takes a tenth less, foliage,
/// rooms and crowds some hundredths more.
pub(super) const LEAST_PART: u32 = 2;

/// Leaves whose samples are asked for ahead. 4 to 12 cost the same; with 32 the tile pass takes a twentieth longer at 3840x2160.
pub(super) const AHEAD: usize = 6;

/// Leaves of a tile whose samples are kept while its triangles go by (600 bytes each); more are another turn. Only tiles that cannot be parted
/// have so many.
pub(super) const MOST_LEAVES: usize = 2048;

/// In tiles with more triangles than this for each block of samples, halves of blocks are leaves of their own: blocks save what
/// is done once a leaf, halves save tests. With 4 simple scenes take three hundredths longer, with no limit the statue takes eight.
pub(super) const DENSE: usize = 8;

/// Triangles that a worker takes at a time.
pub(super) const TRIANGLES: usize = 1024;

/// A triangle, or eight neighbours, that touch no more cells than this (some four tiles) go to the tiles of the cells without a descent.
pub(super) const FEW_CELLS: u32 = 1024;

/// Tiles with no more triangles than this: all are prepared at once, and samples on their own are not sorted.
pub(super) const FEW: usize = 16;

/// Of eight triangles that follow one another and are seen close together, so many go to a tile as one block of eight; fewer go one by one, and
/// are sorted. 3 to 7 cost the same: neighbours in a mesh are neighbours in space.
pub(super) const LEAST_EIGHT: u32 = 6;
