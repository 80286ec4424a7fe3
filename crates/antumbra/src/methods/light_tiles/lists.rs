//! Many growing lists in one array: a list is a chain of chunks.

use super::prefetch::prefetch;

/// Items of a chunk.
const ITEMS: usize = 14;
const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Chunk<T> {
    /// The chunks before, last first; they are full.
    before: [u32; 3],
    items: [T; ITEMS],
}

/// The last chunk of a list. How full it is stands here, so that adding to a list touches one line of the chunk.
#[derive(Clone, Copy, Debug)]
struct Tail {
    chunk: u32,
    count: u32,
}

/// Lists by number.
#[derive(Debug, Default)]
pub(super) struct Lists<T> {
    tails: Vec<Tail>,
    chunks: Vec<Chunk<T>>,
    items: usize,
}

impl<T: Copy + Default> Lists<T> {
    /// `count` empty lists. Memory is kept.
    pub(super) fn reset(&mut self, count: usize) {
        self.tails.clear();
        self.tails.resize(count, Tail { chunk: NONE, count: 0 });
        self.chunks.clear();
        self.items = 0;
    }

    /// Adds to a list.
    #[inline(always)]
    pub(super) fn push(&mut self, list: u32, item: T) {
        self.items += 1;
        let tail = &mut self.tails[list as usize];
        if let Some(chunk) = self.chunks.get_mut(tail.chunk as usize)
            && let Some(slot) = chunk.items.get_mut(tail.count as usize)
        {
            *slot = item;
            tail.count += 1;
        } else {
            let mut items = [T::default(); ITEMS];
            items[0] = item;
            let [a, b, _] = self.chunks.get(tail.chunk as usize).map_or([NONE; 3], |c| c.before);
            let before = [tail.chunk, a, b];
            *tail = Tail { chunk: self.chunks.len() as u32, count: 1 };
            self.chunks.push(Chunk { before, items });
        }
    }

    /// Something will be added to the list soon.
    #[inline(always)]
    pub(super) fn ask_for_end(&self, list: u32) {
        let tail = self.tails[list as usize];
        if let Some(chunk) = self.chunks.get(tail.chunk as usize) {
            prefetch(&chunk.items, tail.count as usize);
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
        while let Some(chunk) = self.chunks.get(at as usize) {
            let [next, _, last] = chunk.before;
            prefetch(&self.chunks, last as usize);
            visit(&chunk.items[..count as usize]);
            (at, count) = (next, ITEMS as u32);
        }
    }

    /// The list will be read soon.
    #[inline(always)]
    pub(super) fn ask_for(&self, list: usize) {
        if let Some(tail) = self.tails.get(list) {
            prefetch(&self.chunks, tail.chunk as usize);
        }
    }

    /// Bytes in use.
    pub(super) fn bytes(&self) -> usize {
        self.tails.len() * size_of::<Tail>() + self.chunks.len() * size_of::<Chunk<T>>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_hold_what_was_pushed_and_forget_it() {
        let mut lists = Lists::default();
        lists.reset(3);
        (0..100).for_each(|i| lists.push(i % 2, i));
        let mut got = Vec::new();
        lists.each(1, |items| got.extend_from_slice(items));
        got.sort_unstable();
        assert_eq!(got, (0..100).filter(|i| i % 2 == 1).collect::<Vec<_>>());
        lists.each(2, |_| panic!("empty"));
        assert_eq!(lists.items(), 100);
        lists.reset(3);
        lists.each(1, |_| panic!("empty"));
    }
}
