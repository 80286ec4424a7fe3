//! Numbers that settle trade-offs. None of them can change a mask.

/// Triangles passed on the way down at most. A triangle that would lie deeper is left to ray casting. Random order gives
/// depths of some tens for a million triangles that do not interlock; only triangles that all cut each other's
/// planes make longer chains, and a chain costs its length squared to build. Larger: such scenes build slower; smaller:
/// more triangles leave the tree.
pub(super) const MAX_DEPTH: usize = 512;

/// Entries of the small stack of the hybrid query: that of Mora et al. 2016. Here an entry holds a packet's samples, so
/// it is filled by diverging samples too. Larger: fewer restarts of single samples; smaller: less memory a walk, which is
/// what matters to a GPU and not to a CPU.
pub(super) const HYBRID_STACK: usize = 12;

/// Tasks that the triangles are split into during the build, in the order of the soup. More: better balance, but shorter
/// runs of neighbouring triangles that go down the same path and find it in the cache.
pub(super) const BUILD_TASKS: usize = 256;

/// Pending triangles below which a round of the build runs on one thread: waking the others costs more.
pub(super) const SERIAL_ROUND: usize = 512;

/// Pixels of a packet: 4 x 2, one lane each.
pub(super) const PACKET_WIDTH: usize = 4;
/// See [`PACKET_WIDTH`].
pub(super) const PACKET_HEIGHT: usize = 2;

/// Seed of the order of insertion.
pub(super) const SEED: u64 = 0x6470_7376;
