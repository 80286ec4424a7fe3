//! Numbers that trade time for memory or one cost for another. None changes the mask.

/// Children of a node of samples. 4 keeps nodes square on the screen (2 x 2); larger makes fewer lists, smaller culls
/// earlier.
pub(super) const CHILDREN: usize = 4;

/// Samples of a packet: the leaves of the tree of samples. One bit each in a word.
pub(super) const PACKET: usize = 64;

/// Pixels of a packet's side.
pub(super) const PACKET_SIDE: usize = 8;

/// Pixels of a tile's side: packets within a tile are in Morton order, tiles are row by row.
pub(super) const TILE_SIDE: usize = 64;

/// Nodes of this level and below are walked by one task: 4^3 packets, a tile. Lower: more tasks and more lists in
/// flight; higher: less parallel slack in small pictures.
pub(super) const TASK_LEVEL: usize = 3;

/// How often another reference point is tried. Two nearly always suffice; each try moves it twice as far.
pub(super) const REFERENCE_TRIES: u32 = 64;
