//! The numbers that trade one cost for another. None of them can change the mask.

/// Pairs (triangle, node) that the queue of one level holds, 8 bytes each, for every level of every thread. Larger:
/// longer batches, so that a node killed by one triangle is noticed by more pairs in the next pass. Smaller: the queues
/// of all levels (some ten) stay in the first-level cache. Fewer than [`MIN_QUEUE`] cannot take the output of one pair.
pub(super) const QUEUE: usize = 1024;

/// A pair expands into at most four pairs.
pub(super) const MIN_QUEUE: usize = 4;

/// Triangles that one task streams through the tree. Larger: fewer tasks and longer batches. Smaller: the prepared
/// triangles (about 800 bytes each) stay in the cache, and the last task of a frame is shorter.
pub(super) const BLOCK: usize = 64;

/// Tasks that a small soup is cut into at least, so that few large triangles (the blockers of pass 1) are shared out.
/// A constant, not the number of threads: the queues' counters are then the same for every thread count.
pub(super) const MIN_TASKS: usize = 64;

/// A good blocker fills at least this part of the solid angle of a mean node of level [`BLOCKER_LEVEL`]. Smaller: more
/// triangles in pass 1, each of less use.
pub(super) const BLOCKER_SOLID_ANGLE: f64 = 1.0 / 64.0;

/// Level of the nodes that blockers are compared with: 64 rays.
pub(super) const BLOCKER_LEVEL: usize = 3;

/// Pass 1 streams at most this part of the soup.
pub(super) const BLOCKER_SHARE: f64 = 0.05;

/// The hierarchy is rebuilt after pass 1 if at least this part of the rays is shadowed by then (section 3.4: "the update
/// step can be skipped"); a rebuild costs about as much as the build.
pub(super) const REBUILD_SHARE: f64 = 0.15;
