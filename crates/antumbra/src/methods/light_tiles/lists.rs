//! Many growing lists in one array: a list is a chain of chunks.

use super::prefetch::prefetch;

const NONE: u32 = u32::MAX;

/// A chunk is asked for when the one so many before it is read.
const AHEAD: usize = 8;

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Chunk<T, const ITEMS: usize> {
    /// The chunk before; it is full.
    next: u32,
    /// The one [`AHEAD`] before.
    far: u32,
    items: [T; ITEMS],
}

/// The last chunk of a list. How full it is stands here, so that adding to a list touches one line of the chunk.
#[derive(Clone, Copy, Debug)]
struct Tail {
    chunk: u32,
    /// Items of the chunk, and [`FULL`] times the chunks of the list.
    count: u32,
}

/// A power of two over the items of a chunk.
const FULL: u32 = 16;

/// Lists by number, in chunks of `ITEMS` items.
#[derive(Debug, Default)]
pub(super) struct Lists<T, const ITEMS: usize> {
    tails: Vec<Tail>,
    /// The last chunks of each list, in a ring.
    recent: Vec<[u32; AHEAD]>,
    chunks: Vec<Chunk<T, ITEMS>>,
    items: usize,
}

impl<T: Copy + Default, const ITEMS: usize> Lists<T, ITEMS> {
    /// `count` empty lists. Memory is kept.
    pub(super) fn reset(&mut self, count: usize) {
        self.tails.clear();
        self.tails.resize(count, Tail { chunk: NONE, count: 0 });
        self.recent.clear();
        self.recent.resize(count, [NONE; AHEAD]);
        self.chunks.clear();
        self.items = 0;
    }

    /// Adds to a list.
    #[inline(always)]
    pub(super) fn push(&mut self, list: u32, item: T) {
        self.push_each(list, 1, |_| item);
    }

    /// Adds an item for each bit that is set.
    #[inline(always)]
    pub(super) fn push_each(&mut self, list: u32, mut bits: u32, item: impl Fn(usize) -> T) {
        const { assert!(ITEMS < FULL as usize) };
        self.items += bits.count_ones() as usize;
        let tail = &mut self.tails[list as usize];
        while bits != 0 {
            let full = (tail.count % FULL) as usize;
            if let Some(chunk) = self.chunks.get_mut(tail.chunk as usize)
                && full < ITEMS
            {
                for slot in &mut chunk.items[full..] {
                    *slot = item(bits.trailing_zeros() as usize);
                    tail.count += 1;
                    bits &= bits - 1;
                    if bits == 0 {
                        return;
                    }
                }
            } else {
                let chunk = self.chunks.len() as u32;
                let chunks = tail.count / FULL + 1;
                let recent = &mut self.recent[list as usize][chunks as usize % AHEAD];
                let (next, far) = (tail.chunk, *recent);
                *recent = chunk;
                *tail = Tail { chunk, count: chunks * FULL };
                self.chunks.push(Chunk { next, far, items: [T::default(); ITEMS] });
            }
        }
    }

    /// Something will be added to the list soon.
    #[inline(always)]
    pub(super) fn ask_for_end(&self, list: u32) {
        let tail = self.tails[list as usize];
        if let Some(chunk) = self.chunks.get(tail.chunk as usize) {
            prefetch(&chunk.items, (tail.count % FULL) as usize);
        }
    }

    /// All items of all lists.
    pub(super) fn items(&self) -> usize {
        self.items
    }

    /// Calls `visit` with the pieces of a list.
    #[inline(always)]
    pub(super) fn each(&self, list: usize, mut visit: impl FnMut(&[T])) {
        let Some(&Tail { chunk: mut at, mut count }) = self.tails.get(list) else { return };
        count %= FULL;
        while let Some(chunk) = self.chunks.get(at as usize) {
            self.ask_for_chunk(chunk.far);
            visit(&chunk.items[..count as usize]);
            (at, count) = (chunk.next, ITEMS as u32);
        }
    }

    /// The list will be read soon: its end.
    #[inline(always)]
    pub(super) fn ask_for(&self, list: usize) {
        if let Some(tail) = self.tails.get(list) {
            prefetch(&self.chunks, tail.chunk as usize);
        }
    }

    /// The list will be read soon: several chunks.
    #[inline(always)]
    pub(super) fn ask_for_more(&self, list: usize) {
        for &chunk in self.recent.get(list).into_iter().flatten() {
            self.ask_for_chunk(chunk);
        }
    }

    #[inline(always)]
    fn ask_for_chunk(&self, chunk: u32) {
        if let Some(chunk) = self.chunks.get(chunk as usize) {
            prefetch(std::slice::from_ref(chunk), 0);
            prefetch(&chunk.items, ITEMS - 1);
        }
    }

    /// Bytes in use.
    pub(super) fn bytes(&self) -> usize {
        self.tails.len() * (size_of::<Tail>() + size_of::<[u32; AHEAD]>())
            + self.chunks.len() * size_of::<Chunk<T, ITEMS>>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_hold_what_was_pushed_and_forget_it() {
        let mut lists = Lists::<u32, 14>::default();
        lists.reset(3);
        (0..100).for_each(|i| lists.push(i % 2, i));
        let mut got = Vec::new();
        lists.each(1, |items| got.extend_from_slice(items));
        got.sort_unstable();
        assert_eq!(got, (0..100).filter(|i| i % 2 == 1).collect::<Vec<_>>());
        lists.each(2, |_| panic!("empty"));
        assert_eq!(lists.items(), 100);
        // 32 and 3 more, over the ends of chunks.
        lists.push_each(2, u32::MAX, |i| i as u32);
        lists.push_each(2, 0x8000_0101, |i| 100 + i as u32);
        lists.push_each(2, 0, |_| 0);
        let mut got = Vec::new();
        lists.each(2, |items| got.extend_from_slice(items));
        got.sort_unstable();
        assert_eq!(got, (0..32).chain([100, 108, 131]).collect::<Vec<_>>());
        assert_eq!(lists.items(), 135);
        lists.reset(3);
        lists.each(1, |_| panic!("empty"));
    }
}
