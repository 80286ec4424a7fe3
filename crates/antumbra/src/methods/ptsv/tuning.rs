//! Numbers that trade one cost against another. None of them changes a mask.

/// How the work of triangles is shared out, and which casters there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tuning {
    /// Nodes that a triangle may visit before the rest of its walk becomes jobs of the queue. Smaller: huge triangles are
    /// shared between more tasks, at one more frustum setup a job. Larger: one thread may be left with a huge triangle.
    pub budget: usize,
    /// Jobs that the queue holds at most (16 bytes each). When it is full, walks go on in place.
    pub queue: usize,
    /// Leave triangles out whose counter-clockwise side faces the light. For closed casters this changes nothing but the
    /// time (a closed surface shadows with its far side what it shadows with its near side, self-shadowing apart);
    /// for open ones it changes the casters, hence the mask.
    pub cull_front_faces: bool,
}

impl Default for Tuning {
    fn default() -> Self {
        Tuning { budget: 256, queue: 1 << 16, cull_front_faces: false }
    }
}

/// Triangles of one task. Smaller: more slack for work stealing. Larger: fewer tasks.
pub(super) const TRIANGLES_PER_TASK: usize = 64;

/// Jobs of one task. Few: each job may be a whole budget.
pub(super) const JOBS_PER_TASK: usize = 4;
