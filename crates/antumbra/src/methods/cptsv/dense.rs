//! What the dense layout would take: every node that the key's bits can name, whether it holds samples or not.
//!
//! Source: the comparison framework of Kobrtek et al. 2021 (section 4.1 discusses its memory). Ours is sparse;
//! these numbers are for tables only.

/// Sizes of a dense 32-ary tree over clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DenseLayout {
    /// Nodes of all levels.
    pub nodes: u64,
    /// Tiles of the picture.
    pub tiles: u64,
}

/// Bytes of a node's box: six f32.
const BOX: u64 = 24;

/// Boxes a tile that the framework's reduced layout sets aside (its `memoryFactor`). More clusters than that do not fit.
const BOXES_PER_TILE: u64 = 10;

impl DenseLayout {
    /// For keys with `bits` of tile column, tile row and slice.
    pub fn new(bits: [u32; 3], tiles: u64) -> DenseLayout {
        let mut left: u32 = bits.iter().sum();
        let mut nodes = 0u64;
        while left > 0 {
            nodes = nodes.saturating_add(1u64.checked_shl(left).unwrap_or(u64::MAX));
            left = left.saturating_sub(5);
        }
        DenseLayout { nodes, tiles }
    }

    /// A bit, a box and a work list entry (4 bytes) a node.
    pub fn bytes(&self) -> u64 {
        self.nodes.div_ceil(8).saturating_add(self.nodes.saturating_mul(BOX + 4))
    }

    /// A bit, a pointer to a box and a work list entry a node, and boxes for ten clusters a tile.
    pub fn reduced_bytes(&self) -> u64 {
        let nodes = self.nodes.div_ceil(8).saturating_add(self.nodes.saturating_mul(4 + 4));
        nodes.saturating_add(self.tiles * BOXES_PER_TILE * BOX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_the_framework() {
        // 1920 x 1080 in 8 x 8 tiles, ten bits of slices: 8 + 8 + 10 bits, 69 million nodes, 1.55 GiB of boxes.
        let hd = DenseLayout::new([8, 8, 10], 240 * 135);
        assert_eq!(hd.nodes, (1 << 26) + (1 << 21) + (1 << 16) + (1 << 11) + (1 << 6) + 2);
        assert!((hd.nodes * BOX) >> 20 == 1585);
        // 3840 x 2160: 6.2 GiB.
        let uhd = DenseLayout::new([9, 9, 10], 480 * 270);
        assert!((6.1..6.3).contains(&((uhd.nodes * BOX) as f64 / (1u64 << 30) as f64)));
        assert!(uhd.reduced_bytes() < uhd.bytes() / 3);
        assert_eq!(DenseLayout::new([40, 40, 40], 1).nodes, u64::MAX);
    }
}
