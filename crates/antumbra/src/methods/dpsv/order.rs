//! The order of insertion: a seeded permutation of the triangles, computed and never stored.
//!
//! A bijection on the numbers of k bits (odd multiplications, additions and shifts, each invertible), walked until the result
//! is below the length ("cycle walking": Black, Rogaway 2002, "Ciphers with Arbitrary Finite Domains"). The length is
//! over half of 2^k, so that takes fewer than two steps on average.

use super::tuning::SEED;

const ROUNDS: usize = 3;

/// A permutation of `0..len`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    len: u32,
    mask: u64,
    half: u32,
    multiply: [u64; ROUNDS],
    /// Inverses of `multiply` modulo 2^64.
    divide: [u64; ROUNDS],
    add: [u64; ROUNDS],
}

impl Order {
    pub(super) fn new(len: u32) -> Order {
        let bits = 32 - len.saturating_sub(1).leading_zeros().min(31);
        let mut state = SEED;
        let mut next = || {
            // SplitMix64 (Steele, Lea, Flood 2014).
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ (z >> 31)
        };
        let multiply = [0; ROUNDS].map(|_: u64| next() | 1);
        let add = [0; ROUNDS].map(|_: u64| next());
        // Newton: each step doubles the right bits, an odd number is its own inverse modulo 8.
        let divide =
            multiply.map(|m| (0..5).fold(m, |x, _| x.wrapping_mul(2u64.wrapping_sub(m.wrapping_mul(x)))));
        Order { len, mask: (1 << bits) - 1, half: bits.div_ceil(2), multiply, divide, add }
    }

    /// The triangle of this rank.
    pub(super) fn at(&self, rank: u32) -> u32 {
        let mut x = u64::from(rank);
        loop {
            for i in 0..ROUNDS {
                x = x.wrapping_mul(self.multiply[i]).wrapping_add(self.add[i]) & self.mask;
                // With a shift of at least half the bits this undoes itself.
                x ^= x >> self.half;
            }
            if x < u64::from(self.len) {
                return x as u32;
            }
        }
    }

    /// The rank of this triangle.
    pub(super) fn rank(&self, index: u32) -> u32 {
        let mut x = u64::from(index);
        loop {
            for i in (0..ROUNDS).rev() {
                x ^= x >> self.half;
                x = x.wrapping_sub(self.add[i]).wrapping_mul(self.divide[i]) & self.mask;
            }
            if x < u64::from(self.len) {
                return x as u32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_is_permuted_and_inverted() {
        for len in (1..70).chain([1000, 1024, 1025, 65_537]) {
            let order = Order::new(len);
            let mut seen = vec![false; len as usize];
            for rank in 0..len {
                let index = order.at(rank);
                assert!(!std::mem::replace(&mut seen[index as usize], true));
                assert_eq!(order.rank(index), rank, "length {len}");
            }
        }
    }
}
