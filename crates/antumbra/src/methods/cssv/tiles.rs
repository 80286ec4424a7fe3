//! The samples as a tree: packets of 8 x 8 pixels (or 64 neighbours of a list), four of them to a node, and so on.
//!
//! Seen from the reference point, a node is a box in `x / w`, `y / w` and `1 / w` (camera axes): on it, linear functionals
//! are bounded from their values in the middle and at the end of two intervals.

use rayon::prelude::*;

use super::reference::Reference;
use super::tuning::{CHILDREN, PACKET, PACKET_SIDE, TILE_SIDE};
use crate::bvh::build::morton;
use crate::methods::Samples;

/// Packets in a row of a tile.
const TILE_PACKETS: usize = TILE_SIDE / PACKET_SIDE;

/// Bounds of the samples of a node; empty if `lo > hi`, boundless if some sample is not in front of the reference point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// `x / w`, `y / w`, `1 / w`.
    lo: [f64; 3],
    hi: [f64; 3],
    samples: u32,
}

/// A node's bounds as the face test wants them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    /// Of `x / w`, `y / w`, `1 / w`.
    pub(super) middle: [f64; 3],
    /// Rounded up.
    pub(super) half: [f64; 3],
    /// Smallest and largest `1 / w`.
    pub(super) inverse: [f64; 2],
    /// At least `(|x| + |y| + |w|) / w`.
    pub(super) scale: f64,
    /// How many samples there are.
    pub(super) samples: u64,
}

impl Bounds {
    const EMPTY: Bounds = Bounds { lo: [f64::INFINITY; 3], hi: [f64::NEG_INFINITY; 3], samples: 0 };
    const BOUNDLESS: Bounds = Bounds { lo: [f64::NEG_INFINITY; 3], hi: [f64::INFINITY; 3], samples: 0 };

    fn union(self, other: Bounds) -> Bounds {
        Bounds {
            lo: [0, 1, 2].map(|k| self.lo[k].min(other.lo[k])),
            hi: [0, 1, 2].map(|k| self.hi[k].max(other.hi[k])),
            samples: self.samples + other.samples,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.lo[0] > self.hi[0]
    }

    /// `None` if nothing can be said about the samples.
    pub(super) fn region(&self) -> Option<Region> {
        let finite = self.lo.iter().chain(&self.hi).all(|v| v.is_finite());
        let middle = [0, 1, 2].map(|k| self.lo[k] * 0.5 + self.hi[k] * 0.5);
        // Three roundings; more than enough is added.
        let slack = 1.0 / (1u64 << 50) as f64;
        let half = [0, 1, 2].map(|k| {
            let h = (self.hi[k] - middle[k]).max(middle[k] - self.lo[k]);
            h + slack * (h + middle[k].abs())
        });
        let scale = 1.0 + middle[0].abs() + half[0] + middle[1].abs() + half[1];
        let samples = u64::from(self.samples);
        finite.then_some(Region { middle, half, inverse: [self.lo[2], self.hi[2]], scale, samples })
    }
}

/// Where the samples of a packet are.
#[derive(Debug, Default)]
enum Layout {
    /// Rows of pixels, tiles of packets.
    Image { width: usize, tiles: usize },
    /// Sorted: the lower half of each key is the sample.
    #[default]
    List,
}

/// All samples. Memory is kept between frames.
#[derive(Debug, Default)]
pub(super) struct Tree {
    layout: Layout,
    order: Vec<u64>,
    packets: usize,
    /// Bounds of the packets, of groups of four, and so on up to the root.
    levels: Vec<Vec<Bounds>>,
}

/// The samples of a packet in camera axes; unused lanes repeat the last sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet {
    pub(super) x: [f64; PACKET],
    pub(super) y: [f64; PACKET],
    pub(super) w: [f64; PACKET],
    /// Index of the sample, and its place in the packet's word of bits.
    pub(super) id: [u32; PACKET],
    pub(super) slot: [u8; PACKET],
    pub(super) count: usize,
    /// The largest `|x| + |y| + |w|`.
    pub(super) scale: f64,
}

impl Packet {
    pub(super) const EMPTY: Packet = Packet {
        x: [0.0; PACKET],
        y: [0.0; PACKET],
        w: [0.0; PACKET],
        id: [0; PACKET],
        slot: [0; PACKET],
        count: 0,
        scale: 0.0,
    };

    fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for i in 0..self.count {
            let w = self.w[i];
            if w <= 0.0 {
                return Bounds { samples: self.count as u32, ..Bounds::BOUNDLESS };
            }
            let v = [self.x[i] / w, self.y[i] / w, 1.0 / w];
            bounds = bounds.union(Bounds { lo: v, hi: v, samples: 1 });
        }
        bounds
    }
}

impl Tree {
    /// Arranges the samples as seen from `reference`.
    pub(super) fn build(&mut self, samples: Samples<'_>, reference: &Reference) {
        let n = samples.positions.len();
        let width = samples.width;
        if width == 0 || width >= n {
            self.layout = Layout::List;
            self.sort_list(samples.positions);
            self.packets = self.order.len().div_ceil(PACKET);
        } else {
            let tiles = width.div_ceil(TILE_SIDE);
            self.layout = Layout::Image { width, tiles };
            let rows = n.div_ceil(width).div_ceil(TILE_SIDE);
            self.packets = tiles * rows * TILE_PACKETS * TILE_PACKETS;
        }
        let mut levels = std::mem::take(&mut self.levels);
        let mut count = self.packets.max(1);
        let mut level = 0;
        loop {
            if levels.len() == level {
                levels.push(Vec::new());
            }
            let (below, rest) = levels.split_at_mut(level);
            let bounds = &mut rest[0];
            bounds.resize(count, Bounds::EMPTY);
            bounds.par_iter_mut().enumerate().with_min_len(16).for_each(|(i, bounds)| {
                *bounds = match below.last() {
                    Some(below) => below[i * CHILDREN..below.len().min((i + 1) * CHILDREN)]
                        .iter()
                        .fold(Bounds::EMPTY, |a, b| a.union(*b)),
                    None => {
                        let mut packet = Packet::EMPTY;
                        self.load(samples.positions, reference, i, &mut packet);
                        packet.bounds()
                    }
                };
            });
            level += 1;
            if count == 1 {
                break;
            }
            count = count.div_ceil(CHILDREN);
        }
        levels.truncate(level);
        self.levels = levels;
    }

    /// Level of the root.
    pub(super) fn top(&self) -> usize {
        self.levels.len() - 1
    }

    /// Nodes of a level.
    pub(super) fn count(&self, level: usize) -> usize {
        self.levels[level].len()
    }

    pub(super) fn bounds(&self, level: usize, node: usize) -> &Bounds {
        &self.levels[level][node]
    }

    /// Calls `each` with the samples of packet `index`, background included, after their places in the packet.
    fn samples_of(&self, n: usize, index: usize, mut each: impl FnMut(usize, usize)) {
        match self.layout {
            Layout::Image { width, tiles } => {
                let per_tile = TILE_PACKETS * TILE_PACKETS;
                let (tile, inner) = (index / per_tile, index % per_tile);
                let x0 = tile % tiles * TILE_SIDE + gather_even(inner) * PACKET_SIDE;
                let y0 = tile / tiles * TILE_SIDE + gather_even(inner >> 1) * PACKET_SIDE;
                for y in 0..PACKET_SIDE {
                    for x in x0..width.min(x0 + PACKET_SIDE) {
                        let i = (y0 + y) * width + x;
                        if i < n {
                            each(y * PACKET_SIDE + x - x0, i);
                        }
                    }
                }
            }
            Layout::List => {
                let range = index * PACKET..self.order.len().min((index + 1) * PACKET);
                for (slot, key) in self.order[range].iter().enumerate() {
                    each(slot, (key & 0xffff_ffff) as usize);
                }
            }
        }
    }

    /// Fills `packet` with the samples of packet `index` that are there.
    pub(super) fn load(
        &self,
        positions: &[[f32; 3]],
        reference: &Reference,
        index: usize,
        packet: &mut Packet,
    ) {
        (packet.count, packet.scale) = (0, 0.0);
        self.samples_of(positions.len(), index, |slot, i| {
            let p = positions[i];
            if p.iter().any(|v| v.is_nan()) {
                return;
            }
            let d = [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(reference.point[k]));
            let [x, y, w] = reference.axes.map(|a| a[0] * d[0] + a[1] * d[1] + a[2] * d[2]);
            let at = packet.count;
            (packet.x[at], packet.y[at], packet.w[at]) = (x, y, w);
            (packet.id[at], packet.slot[at]) = (i as u32, slot as u8);
            packet.scale = packet.scale.max(x.abs() + y.abs() + w.abs());
            packet.count += 1;
        });
        if packet.count == 0 {
            return;
        }
        let last = packet.count - 1;
        for at in packet.count..PACKET {
            (packet.x[at], packet.y[at], packet.w[at]) = (packet.x[last], packet.y[last], packet.w[last]);
        }
    }

    /// Puts the samples of a bare list into Morton order, background left out.
    fn sort_list(&mut self, positions: &[[f32; 3]]) {
        let valid = |p: &[f32; 3]| !p.iter().any(|v| v.is_nan());
        let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in positions.iter().filter(|p| valid(p)) {
            for k in 0..3 {
                (lo[k], hi[k]) = (lo[k].min(p[k]), hi[k].max(p[k]));
            }
        }
        let scale = [0, 1, 2].map(|k| {
            let s = 1024.0 / (hi[k] - lo[k]);
            if s.is_finite() { s } else { 0.0 }
        });
        let key = |(i, p): (usize, &[f32; 3])| {
            let code = morton([0, 1, 2].map(|k| (p[k] - lo[k]) * scale[k]));
            u64::from(code) << 32 | i as u64
        };
        self.order.clear();
        self.order.par_extend(positions.par_iter().enumerate().filter(|(_, p)| valid(p)).map(key));
        self.order.par_sort_unstable();
    }

    /// Calls `each` for every sample of a picture or list, in parallel where possible, with its packet and place there.
    pub(super) fn scatter<T: Send>(&self, out: &mut [T], each: impl Fn(&mut T, usize, usize) + Sync) {
        match self.layout {
            Layout::Image { width, tiles } => {
                out.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
                    let (tile_y, packet_y) = (y / TILE_SIDE, y % TILE_SIDE / PACKET_SIDE);
                    for (x, out) in row.iter_mut().enumerate() {
                        let (tile_x, packet_x) = (x / TILE_SIDE, x % TILE_SIDE / PACKET_SIDE);
                        let tile = tile_y * tiles + tile_x;
                        let inner = spread_even(packet_x) | spread_even(packet_y) << 1;
                        let slot = y % PACKET_SIDE * PACKET_SIDE + x % PACKET_SIDE;
                        each(out, tile * TILE_PACKETS * TILE_PACKETS + inner, slot);
                    }
                });
            }
            Layout::List => {
                for (at, key) in self.order.iter().enumerate() {
                    each(&mut out[(key & 0xffff_ffff) as usize], at / PACKET, at % PACKET);
                }
            }
        }
    }

    /// Bytes of the tree.
    pub(super) fn bytes(&self) -> usize {
        self.order.len() * 8 + self.levels.iter().map(|l| l.len() * size_of::<Bounds>()).sum::<usize>()
    }

    /// Packets in use.
    pub(super) fn packets(&self) -> usize {
        self.packets
    }
}

/// Every second bit of a six-bit number.
fn gather_even(v: usize) -> usize {
    v & 1 | v >> 1 & 2 | v >> 2 & 4
}

/// The inverse of [`gather_even`].
fn spread_even(v: usize) -> usize {
    v & 1 | (v & 2) << 1 | (v & 4) << 2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference() -> Reference {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Reference { point: [0.25, 0.5, -2.0], axes, tries: 1 }
    }

    /// Every sample is in one packet, where [`Tree::scatter`] says, and within the bounds of all nodes above it.
    fn check(positions: &[[f32; 3]], width: usize) {
        let reference = reference();
        let mut tree = Tree::default();
        tree.build(Samples::image(positions, width), &reference);
        let mut place = vec![(usize::MAX, 0); positions.len()];
        tree.scatter(&mut place, |out, packet, slot| *out = (packet, slot));
        let mut seen = vec![0; positions.len()];
        let mut packet = Packet::EMPTY;
        for index in 0..tree.packets() {
            tree.load(positions, &reference, index, &mut packet);
            for at in 0..packet.count {
                let i = packet.id[at] as usize;
                seen[i] += 1;
                assert_eq!(place[i], (index, packet.slot[at] as usize));
                let v = [packet.x[at], packet.y[at]].map(|v| v / packet.w[at]);
                let mut node = index;
                for level in 0..=tree.top() {
                    if let Some(region) = tree.bounds(level, node).region() {
                        for k in 0..2 {
                            assert!((v[k] - region.middle[k]).abs() <= region.half[k]);
                        }
                        let inverse = 1.0 / packet.w[at];
                        assert!(region.inverse[0] <= inverse && inverse <= region.inverse[1]);
                        let size = packet.x[at].abs() + packet.y[at].abs() + packet.w[at].abs();
                        assert!(size / packet.w[at] <= region.scale * (1.0 + 1e-15));
                    } else {
                        assert!(positions.iter().any(|p| p[2] <= -2.0));
                    }
                    node /= CHILDREN;
                }
            }
        }
        for (p, seen) in positions.iter().zip(seen) {
            assert_eq!(seen, i32::from(!p[0].is_nan()));
        }
    }

    #[test]
    fn every_sample_is_in_one_packet_and_within_its_bounds() {
        for (count, width) in
            [(1, 1), (7, 7), (700, 100), (130 * 71, 130), (64 * 64, 64), (999, 64), (300, 300)]
        {
            let mut state = 1u64;
            let mut positions: Vec<[f32; 3]> = (0..count)
                .map(|i| {
                    let mut number = || {
                        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                        (state >> 40) as f32 / (1u64 << 24) as f32
                    };
                    if i % 17 == 5 { [f32::NAN; 3] } else { [number(), number(), number()] }
                })
                .collect();
            check(&positions, width);
            positions[0] = [0.0, 0.0, -3.0];
            check(&positions, width);
        }
    }
}
