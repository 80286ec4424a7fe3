//! The pyramid: a tree with up to 32 children a node, boxes of siblings side by side, one shadow bit a node.
//!
//! It has the nodes of the paper's pyramid that hold samples, and no others: children are numbered without gaps, so empty
//! tiles cost nothing, and the same tree serves clusters in depth (methods.md 4.4).

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::boxes::{Aabb, Box8, LANES};
use super::tiles::{Band, Item, Tiling};

/// An inner node: its children are `first_child ..` of the level below (of the leaves, on the lowest level).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    pub(crate) first_child: u32,
    pub(crate) count: u32,
    first_box: u32,
    /// The group on the level above that this one is a child of.
    pub(crate) parent: u32,
    /// Bounds the absolute coordinates of all boxes.
    pub(crate) reach: [f32; 3],
}

/// A tile or a cluster: up to 64 samples in vectors of eight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafNode {
    pub(crate) first_block: u32,
    pub(crate) count: u32,
    pub(crate) parent: u32,
}

/// Eight sample positions, world space.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Block {
    pub(crate) at: [[f32; LANES]; 3],
}

/// All inner nodes of one height.
#[derive(Debug, Default)]
pub(crate) struct Level {
    pub(crate) groups: Vec<Group>,
    boxes: Vec<Box8>,
    /// One word a group, one bit a child: shadowed as a whole. Bits of children that are not there are set, so a complete
    /// word is all ones.
    pub(crate) words: Vec<AtomicU32>,
}

/// The tree over all samples of a frame. Memory is kept between frames.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    /// Lowest first; the last one has one group, the root. Empty without samples.
    pub(crate) levels: Vec<Level>,
    spare: Vec<Level>,
    pub(crate) leaves: Vec<LeafNode>,
    /// One word a leaf, one bit a sample (set where there is none).
    pub(crate) leaf_words: Vec<AtomicU64>,
    pub(crate) blocks: Vec<Block>,
    keys: Vec<u64>,
    bounds: Vec<Aabb>,
}

/// Leaves whose samples one task copies.
const COPY_TASK: usize = 1024;

/// Levels at most: 64 key bits, five a level.
pub(crate) const MAX_LEVELS: usize = 13;

impl Level {
    pub(crate) fn boxes(&self, group: &Group) -> &[Box8] {
        let first = group.first_box as usize;
        &self.boxes[first..first + (group.count as usize).div_ceil(LANES)]
    }
}

impl Tree {
    /// Builds the tree over the records that `items` lists in the order of their keys.
    pub(crate) fn build(
        &mut self,
        items: &[Item],
        bands: &mut [Band],
        positions: &[[f32; 3]],
        tiling: Tiling,
    ) {
        self.make_leaves(items, bands);
        self.copy_positions(items, bands, positions, tiling);
        self.spare.append(&mut self.levels);
        self.keys.clear();
        self.keys.extend(items.iter().map(|i| i.key));
        while self.keys.len() > 1 || (self.levels.is_empty() && !self.keys.is_empty()) {
            self.add_level();
        }
    }

    fn make_leaves(&mut self, items: &[Item], bands: &mut [Band]) {
        self.leaves.clear();
        self.leaf_words.clear();
        self.bounds.clear();
        let mut first_block = 0;
        for (leaf, item) in items.iter().enumerate() {
            let record = &mut bands[item.band as usize].records[item.record as usize];
            record.leaf = leaf as u32;
            let count = record.mask.count_ones();
            self.leaves.push(LeafNode { first_block, count, parent: 0 });
            self.leaf_words.push(AtomicU64::new(if count == 64 { 0 } else { u64::MAX << count }));
            self.bounds.push(record.bounds);
            first_block += count.div_ceil(LANES as u32);
        }
        self.blocks.resize(first_block as usize, Block { at: [[0.0; LANES]; 3] });
    }

    fn copy_positions(&mut self, items: &[Item], bands: &[Band], positions: &[[f32; 3]], tiling: Tiling) {
        let mut rest = &mut self.blocks[..];
        let mut jobs = Vec::with_capacity(items.len().div_ceil(COPY_TASK));
        for (items, leaves) in items.chunks(COPY_TASK).zip(self.leaves.chunks(COPY_TASK)) {
            let size = leaves.iter().map(|l| l.count.div_ceil(LANES as u32) as usize).sum();
            let (mine, others) = rest.split_at_mut(size);
            rest = others;
            jobs.push((items, mine));
        }
        jobs.into_par_iter().for_each(|(items, blocks)| {
            let mut first = 0;
            for item in items {
                let record = &bands[item.band as usize].records[item.record as usize];
                let start = item.band as usize * tiling.band();
                let len = tiling.band().min(positions.len() - start);
                let mut slot = 0;
                tiling.for_each(len, item.tile as usize, |bit, index| {
                    if record.mask >> bit & 1 == 1 {
                        for k in 0..3 {
                            blocks[first + slot / LANES].at[k][slot % LANES] = positions[start + index][k];
                        }
                        slot += 1;
                    }
                });
                first += slot.div_ceil(LANES);
            }
        });
    }

    /// Puts nodes whose keys differ in the last five bits only under one parent.
    fn add_level(&mut self) {
        let mut level = self.spare.pop().unwrap_or_default();
        level.groups.clear();
        level.boxes.clear();
        level.words.clear();
        let (mut first, mut parents) = (0, 0);
        while first < self.keys.len() {
            let path = self.keys[first] >> 5;
            let mut all = Aabb::EMPTY;
            let first_box = level.boxes.len();
            let mut count = 0;
            while first + count < self.keys.len() && self.keys[first + count] >> 5 == path {
                let child = self.bounds[first + count];
                if count % LANES == 0 {
                    level.boxes.push(Box8::ZERO);
                }
                level.boxes[first_box + count / LANES].set(count % LANES, &child);
                all = all.union(child);
                match self.levels.last_mut() {
                    None => self.leaves[first + count].parent = parents as u32,
                    Some(below) => below.groups[first + count].parent = parents as u32,
                }
                count += 1;
            }
            level.groups.push(Group {
                first_child: first as u32,
                count: count as u32,
                first_box: first_box as u32,
                parent: 0,
                reach: all.reach(),
            });
            level.words.push(AtomicU32::new(u32::MAX.checked_shl(count as u32).unwrap_or(0)));
            // Parents are fewer than children: they take the places of children that are done with.
            self.keys[parents] = path;
            self.bounds[parents] = all;
            parents += 1;
            first += count;
        }
        self.keys.truncate(parents);
        self.bounds.truncate(parents);
        self.levels.push(level);
    }

    /// Sets shadow bits of the children of a group; a word that becomes complete sets its parent's bit, and so on up
    /// (methods.md 3.6). Returns how many atomic operations that took.
    #[inline]
    pub(crate) fn cover(&self, mut level: usize, mut group: usize, mut bits: u32) -> u64 {
        let mut atomics = 0;
        loop {
            let word = &self.levels[level].words[group];
            if bits & !word.load(Relaxed) == 0 {
                return atomics;
            }
            let before = word.fetch_or(bits, Relaxed);
            atomics += 1;
            if before == u32::MAX || before | bits != u32::MAX || level + 1 == self.levels.len() {
                return atomics;
            }
            let parent = self.levels[level].groups[group].parent as usize;
            bits = 1 << (group - self.levels[level + 1].groups[parent].first_child as usize);
            (level, group) = (level + 1, parent);
        }
    }

    /// Sets shadow bits of samples of a leaf, and of all nodes that this completes.
    #[inline]
    pub(crate) fn cover_samples(&self, leaf: usize, bits: u64) -> u64 {
        let word = &self.leaf_words[leaf];
        if bits & !word.load(Relaxed) == 0 {
            return 0;
        }
        let before = word.fetch_or(bits, Relaxed);
        if before == u64::MAX || before | bits != u64::MAX {
            return 1;
        }
        let parent = self.leaves[leaf].parent as usize;
        let bit = 1 << (leaf - self.levels[0].groups[parent].first_child as usize);
        1 + self.cover(0, parent, bit)
    }

    /// Carries the bits of nodes down to the samples below them (methods.md 3.7).
    pub(crate) fn merge(&self) {
        for (height, level) in self.levels.iter().enumerate().rev() {
            level.groups.par_iter().zip(&level.words).with_min_len(256).for_each(|(group, word)| {
                let mut bits = word.load(Relaxed);
                if group.count < 32 {
                    bits &= (1 << group.count) - 1;
                }
                while bits != 0 {
                    let child = group.first_child as usize + bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    match height {
                        0 => self.leaf_words[child].store(u64::MAX, Relaxed),
                        _ => self.levels[height - 1].words[child].store(u32::MAX, Relaxed),
                    }
                }
            });
        }
    }

    /// Inner nodes and leaves.
    pub(crate) fn nodes(&self) -> usize {
        self.leaves.len() + self.levels.iter().map(|l| l.groups.len()).sum::<usize>()
    }

    /// Bytes of nodes with their boxes, of shadow bits, of sample positions.
    pub(crate) fn bytes(&self) -> [usize; 3] {
        let level = |l: &Level| size_of_val(&l.groups[..]) + size_of_val(&l.boxes[..]);
        let nodes = self.levels.iter().map(level).sum::<usize>() + size_of_val(&self.leaves[..]);
        let words: usize = self.levels.iter().map(|l| size_of_val(&l.words[..])).sum();
        [nodes, words + size_of_val(&self.leaf_words[..]), size_of_val(&self.blocks[..])]
    }
}
