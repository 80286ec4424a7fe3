//! Many growing lists in one array: a list is a chain of chunks.

use super::prefetch::prefetch;

/// Items of a chunk: with link and count one cache line of 4-byte items, two of 8-byte items, thirteen of leaves.
const ITEMS: usize = 14;
const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Chunk<T> {
    next: u32,
    count: u32,
    items: [T; ITEMS],
}

/// Lists by number.
#[derive(Debug, Default)]
pub(super) struct Lists<T> {
    head: Vec<u32>,
    chunks: Vec<Chunk<T>>,
    items: usize,
}

impl<T: Copy + Default> Lists<T> {
    /// `count` empty lists. Memory is kept.
    pub(super) fn reset(&mut self, count: usize) {
        self.head.clear();
        self.head.resize(count, NONE);
        self.chunks.clear();
        self.items = 0;
    }

    /// Adds to a list.
    #[inline(always)]
    pub(super) fn push(&mut self, list: u32, item: T) {
        self.items += 1;
        let head = self.head[list as usize];
        if let Some(chunk) = self.chunks.get_mut(head as usize)
            && let Some(slot) = chunk.items.get_mut(chunk.count as usize)
        {
            *slot = item;
            chunk.count += 1;
        } else {
            self.head[list as usize] = self.chunks.len() as u32;
            let mut items = [T::default(); ITEMS];
            items[0] = item;
            self.chunks.push(Chunk { next: head, count: 1, items });
        }
    }

    /// All items of all lists.
    pub(super) fn items(&self) -> usize {
        self.items
    }

    /// Calls `visit` with the pieces of a list.
    #[inline(always)]
    pub(super) fn each(&self, list: usize, mut visit: impl FnMut(&[T])) {
        let mut at = self.head.get(list).copied().unwrap_or(NONE);
        while let Some(chunk) = self.chunks.get(at as usize) {
            visit(&chunk.items[..chunk.count as usize]);
            at = chunk.next;
        }
    }

    /// The list will be read soon.
    #[inline(always)]
    pub(super) fn ask_for(&self, list: usize) {
        if let Some(&head) = self.head.get(list) {
            prefetch(&self.chunks, head as usize);
        }
    }

    /// Bytes in use.
    pub(super) fn bytes(&self) -> usize {
        self.head.len() * 4 + self.chunks.len() * size_of::<Chunk<T>>()
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
