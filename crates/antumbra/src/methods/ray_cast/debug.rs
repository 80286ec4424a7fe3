//! Pictures of the work: what the packet of each sample did.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::methods::DebugView;

pub(super) const VIEWS: &[DebugView] = &[
    DebugView::amount("visits", "nodes and leaves that the packet of the sample visited"),
    DebugView::amount("triangles", "triangles that were set up for the packet of the sample"),
    DebugView::label(
        "packet",
        "samples that walk together: 64, or fewer where a tile is parted at a depth edge",
    ),
];

/// What was done for one sample.
#[derive(Debug, Default)]
struct Work {
    visits: AtomicU32,
    triangles: AtomicU32,
    packet: AtomicU32,
}

/// What was done for all samples, in the order in which they are traced.
#[derive(Debug)]
pub(super) struct Record(Vec<Work>);

impl Record {
    pub(super) fn new(samples: usize) -> Record {
        Record(std::iter::repeat_with(Work::default).take(samples).collect())
    }

    /// Notes what the packet of a sample did.
    pub(super) fn note(&self, sample: usize, visits: u64, triangles: u64, packet: usize) {
        let work = &self.0[sample];
        work.visits.store(visits as u32, Relaxed);
        work.triangles.store(triangles as u32, Relaxed);
        work.packet.store(packet as u32, Relaxed);
    }

    /// From the order of tracing to that of the caller: `places` says where each sample belongs.
    pub(super) fn unsort(&mut self, places: impl Iterator<Item = usize>) {
        let mut other = Record::new(self.0.len());
        for (work, place) in self.0.drain(..).zip(places) {
            other.0[place] = work;
        }
        *self = other;
    }

    pub(super) fn numbers(&self, view: &str) -> Vec<f32> {
        let number = |work: &Work| match view {
            "visits" => work.visits.load(Relaxed),
            "triangles" => work.triangles.load(Relaxed),
            _ => work.packet.load(Relaxed),
        };
        self.0.iter().map(|work| number(work) as f32).collect()
    }
}
