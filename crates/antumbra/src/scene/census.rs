//! Triangles that a modeller would call faulty. They are allowed, and counted for those who want to know.

use antumbra_predicates::exact::tie_break;
use rayon::prelude::*;

use super::{Soup, Triangle};

/// What [`Soup::census`] counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Without area: corners on one line, in exact arithmetic. They never block.
    pub degenerate: usize,
    /// Triangles with area whose three corners, in any order, an earlier one has too. They change no mask.
    pub duplicate: usize,
}

impl Soup {
    /// Counts degenerate and duplicate triangles.
    pub fn census(&self) -> Census {
        // The cross product of two edges, each component's sign exact: all zero means collinear.
        let flat = |t: &Triangle| tie_break(t[0], t[1], t[2]) == 0;
        let mut keys: Vec<[[u32; 3]; 3]> = self.positions.par_iter().filter(|t| !flat(t)).map(key).collect();
        let degenerate = self.len() - keys.len();
        keys.par_sort_unstable();
        let duplicate = keys.windows(2).filter(|pair| pair[0] == pair[1]).count();
        Census { degenerate, duplicate }
    }
}

/// The same for the same three corners in any order, and for both zeros.
fn key(t: &Triangle) -> [[u32; 3]; 3] {
    let mut key = t.map(|corner| corner.map(|v| (v + 0.0).to_bits()));
    key.sort_unstable();
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_what_is_there() {
        let (a, b, c) = ([0.0, -0.0, 1.0], [0.1, 0.2, 0.3], [5.0, 6.0, -7.0]);
        let line = [[0.0; 3], [0.1, 0.2, 0.3], [0.2, 0.4, 0.6]];
        let positions = vec![
            [a, b, c],
            [c, a, b],
            [b, [0.0, 0.0, 1.0], c],
            [a, a, b],
            line,
            [a, b, [5.0, 6.0, 7.0]],
            [a, a, b],
        ];
        let soup = Soup { positions, ..Soup::default() };
        assert_eq!(soup.census(), Census { degenerate: 3, duplicate: 2 });
        assert_eq!(Soup::default().census(), Census::default());
    }
}
