//! Which rays need not be asked any more, and which nodes are dead because all of their rays are: one bit a ray, and one
//! bit for each 64 below it, up to the root.
//!
//! The tree is 4-ary, so three of its levels are one level of words: set 0 holds the rays (level 0), set 1 the nodes of
//! level 3, set 2 those of level 6. A node of a level between is dead if its 4 or 16 bits in the set below are set. The
//! invalidation of section 3.3 thus costs one word for any level, and a node dies too when several triangles
//! shadow its rays together, one by one.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Bits of a frame, shared by all threads. A bit is only ever set; a thread that sees it late does work in vain.
#[derive(Debug, Default)]
pub(super) struct Done {
    sets: Vec<Vec<AtomicU64>>,
}

/// Levels of the tree that one set of bits spans.
const SPAN: usize = 3;

impl Done {
    /// Starts with the rays of `valid` (one bit a ray) to be asked, and everything else done.
    pub(super) fn reset(&mut self, valid: &[u64]) {
        let mut set = 0;
        let mut words = valid.len();
        loop {
            if self.sets.len() == set {
                self.sets.push(Vec::new());
            }
            self.sets[set].resize_with(words, AtomicU64::default);
            for word in 0..words {
                let bits = if set == 0 { !valid[word] } else { self.full_below(set, word) };
                *self.sets[set][word].get_mut() = bits;
            }
            set += 1;
            if words <= 1 {
                break;
            }
            words = words.div_ceil(64);
        }
        self.sets.truncate(set);
    }

    /// One bit for each of 64 words below: full, or not there.
    fn full_below(&self, set: usize, word: usize) -> u64 {
        let below = &self.sets[set - 1];
        (0..64).fold(0, |bits, i| {
            let full = below.get(word * 64 + i).is_none_or(|w| w.load(Relaxed) == !0);
            bits | u64::from(full) << i
        })
    }

    /// Bits of rays `64 word ..`.
    #[inline(always)]
    pub(super) fn rays(&self, word: usize) -> u64 {
        self.sets[0][word].load(Relaxed)
    }

    /// Sets bits of one word, and those above that become full.
    #[inline(always)]
    pub(super) fn set(&self, mut set: usize, mut word: usize, mut bits: u64) {
        while let Some(cell) = self.sets.get(set).map(|s| &s[word]) {
            if cell.load(Relaxed) & bits == bits {
                return;
            }
            if cell.fetch_or(bits, Relaxed) | bits != !0 {
                return;
            }
            bits = 1 << (word % 64);
            word /= 64;
            set += 1;
        }
    }

    /// Kills a node.
    pub(super) fn kill(&self, level: usize, node: usize) {
        let within = level % SPAN;
        // 1, 4 or 16 bits.
        let first = node << (2 * within);
        let bits = (1u64 << (1 << (2 * within))) - 1;
        self.set(level / SPAN, first / 64, bits << (first % 64));
    }

    /// Which nodes of a group of four siblings are dead: by their own bits, or by the bit of the next set above. (Bits
    /// farther above are not looked at: whoever set them also stopped those that come after at that level.)
    #[inline(always)]
    pub(super) fn dead(&self, level: usize, group: usize) -> u8 {
        let set = level / SPAN;
        let within = level % SPAN;
        let first = (group << 2) << (2 * within);
        let word = first / 64;
        if self.sets.get(set + 1).is_some_and(|s| s[word / 64].load(Relaxed) >> (word % 64) & 1 == 1) {
            return 0b1111;
        }
        let bits = self.sets[set][word].load(Relaxed) >> (first % 64);
        match within {
            0 => bits as u8 & 0b1111,
            1 => {
                let pairs = bits & bits >> 1;
                let full = pairs & pairs >> 2;
                (full & 1 | full >> 3 & 2 | full >> 6 & 4 | full >> 9 & 8) as u8
            }
            _ => (0..4).fold(0, |dead, i| dead | u8::from((bits >> (16 * i)) as u16 == u16::MAX) << i),
        }
    }

    /// Hands the bits of all sets down to the rays.
    pub(super) fn hand_down(&mut self) {
        for set in (1..self.sets.len()).rev() {
            let (below, above) = self.sets.split_at_mut(set);
            for (i, cell) in below[set - 1].iter_mut().enumerate() {
                if *above[0][i / 64].get_mut() >> (i % 64) & 1 == 1 {
                    *cell.get_mut() = !0;
                }
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.sets.iter().map(|s| s.len() * 8).sum()
    }
}
