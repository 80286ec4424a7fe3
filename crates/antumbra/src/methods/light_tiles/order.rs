//! The order in a tile: what the light sees close together is tested together.

use antumbra_predicates::tile::Region;
use fearless_simd::{Bytes, Select, Simd, SimdBase, f32x8, u32x8};

use super::bin::{Eight, Entry, LARGE};
use super::grid::{MAGIC, PLACES, Tiles};
use super::layout::HALF;
use super::leaves::directions;
use super::sight::Sight;

/// Keys of samples and leaves within a tile. Depth first: what mixes near and far is tested most.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafPlace {
    lo: [f32; 3],
    /// What makes 1 of the tile's extent.
    scale: [f32; 3],
}

impl LeafPlace {
    pub(super) fn new(region: &Region) -> LeafPlace {
        let scale = [0, 1, 2].map(|k| 1.0 / (region.hi[k] - region.lo[k]).max(f32::MIN_POSITIVE));
        LeafPlace { lo: region.lo, scale }
    }

    #[inline(always)]
    fn step<S: Simd>(&self, k: usize, at: f32x8<S>, steps: f32) -> u32x8<S> {
        ((at - self.lo[k]) * (self.scale[k] * steps) + MAGIC).bitcast()
    }

    /// Two bits of depth over four bits each of a curve through the directions, of sixteen samples.
    #[inline(always)]
    pub(super) fn sixteen<S: Simd>(&self, s: S, sight: &Sight, p: &[[f32x8<S>; 2]; 3]) -> [u32; HALF] {
        let [x, y, r] = directions(s, sight, p);
        let mut keys = [0; HALF];
        for h in 0..2 {
            let (x, y, r) = (self.step(0, x[h], 15.0), self.step(1, y[h], 15.0), self.step(2, r[h], 3.0));
            let key = ((r & 3) << 8) | (spread(y) << 1) | spread(x);
            keys[8 * h..8 * h + 8].copy_from_slice(&key.to_array());
        }
        keys
    }
}

/// The four low bits of each lane, a zero after each.
#[inline(always)]
fn spread<S: Simd>(v: u32x8<S>) -> u32x8<S> {
    (v & 1) | ((v & 2) << 1) | ((v & 4) << 2) | ((v & 8) << 3)
}

/// Puts what `get` gives of `from` into `to`, sorted by small keys, one an item.
#[inline(always)]
pub(super) fn counting_sort<T, U: Copy, const KEYS: usize>(
    from: &[T],
    to: &mut Vec<U>,
    key: impl Fn(usize) -> u32,
    get: impl Fn(&T) -> U,
) {
    to.clear();
    let Some(any) = from.first() else { return };
    if from.len() <= 8 {
        // Few: nothing to part.
        to.extend(from.iter().map(get));
        return;
    }
    to.resize(from.len(), get(any));
    let mut start = [0u32; KEYS];
    for i in 0..from.len() {
        start[key(i) as usize % KEYS] += 1;
    }
    let mut sum = 0;
    for s in &mut start {
        (*s, sum) = (sum, sum + *s);
    }
    for (i, item) in from.iter().enumerate() {
        let at = &mut start[key(i) as usize % KEYS];
        to[*at as usize] = get(item);
        *at += 1;
    }
}

/// Parts of the range of nearness by which triangles that came together are sorted. 6 to 64 cost the same.
const PARTS: usize = 16;

/// Triangles that came together, nearest to the light first: the front of a mesh puts samples in shadow, and what is behind it need not be prepared any
/// more. Those that are about as near stay in the order of the list, where neighbours are together.
pub(super) fn front_first(mixed: &[Eight], eights: &mut Vec<Eight>) {
    // Bits of positive numbers are in their order, and parts of their range are about logarithmic.
    let r = |eight: &Eight| u32::from(eight.near);
    let (mut lo, mut hi) = (u32::MAX, 0);
    for eight in mixed {
        (lo, hi) = (lo.min(r(eight)), hi.max(r(eight)));
    }
    // A little less than whole parts, as numbers are rounded.
    let scale = (PARTS as f32 - 0.5) / (hi.saturating_sub(lo) + 1) as f32;
    counting_sort::<_, _, PARTS>(
        mixed,
        eights,
        |i| ((hi - r(&mixed[i])) as f32 * scale) as u32,
        |eight| *eight,
    );
}

/// Keys of triangles within a tile: large triangles first, they may cover all; then neighbours together, so that blocks of eight
/// have narrow bounds.
#[inline(always)]
pub(super) fn entry_keys<S: Simd>(s: S, tiles: &Tiles, tile: usize, entries: &[Entry], keys: &mut Vec<u32>) {
    keys.clear();
    let [x, _, y, _] = tiles.cells[tile].map(|cell| u32::from(cell) * PLACES);
    // Eight parts of the tile each way.
    let place = (x, y, tiles.shift(tile) + 1);
    let (eights, rest) = entries.as_chunks();
    for [a, b, c, d, e, f, g, h] in eights {
        keys.extend_from_slice(&eight_keys(s, place, [a.at, b.at, c.at, d.at, e.at, f.at, g.at, h.at]));
    }
    let mut at = [0; 8];
    for (at, entry) in at.iter_mut().zip(rest) {
        *at = entry.at;
    }
    keys.extend_from_slice(&eight_keys(s, place, at));
}

#[inline(always)]
fn eight_keys<S: Simd>(s: S, (x, y, shift): (u32, u32, u32), at: [u32; 8]) -> [u32; 8] {
    let at = u32x8::load_array(s, at);
    // Less than the tile's first is its first.
    let (x, y) = ((at & 0xffff).max(x) - x, (at >> 16).max(y) - y);
    let curve = spread((x >> shift).min(7)) | (spread((y >> shift).min(7)) << 1);
    at.simd_eq(LARGE).select(u32x8::splat(s, 0), curve + 1).to_array()
}
