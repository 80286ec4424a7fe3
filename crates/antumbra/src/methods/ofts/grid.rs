//! Cells of a rectangle of directions.

/// One axis of a grid: `n` cells between two values.
///
/// [`Axis::index`] is made of operations whose rounding is monotone (difference, product with a positive number, floor,
/// clamp), so the indices of an interval's ends bound the indices of everything inside, exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Axis {
    pub(super) lo: f64,
    pub(super) hi: f64,
    scale: f64,
    step: f64,
    pub(super) n: u32,
}

impl Axis {
    /// `n > 0` cells between `lo <= hi`; one if the ends are equal.
    pub(super) fn new(lo: f64, hi: f64, n: u32) -> Axis {
        let size = hi - lo;
        if n > 1 && size > 0.0 {
            Axis { lo, hi, scale: f64::from(n) / size, step: size / f64::from(n), n }
        } else {
            Axis { lo, hi, scale: 0.0, step: size, n: 1 }
        }
    }

    /// The cell that a value is counted in.
    #[inline(always)]
    pub(super) fn index(&self, x: f64) -> u32 {
        // The cast saturates: below the first cell (and NaN, from 0 times infinity) is 0.
        (((x - self.lo) * self.scale) as u32).min(self.n - 1)
    }

    /// The first and last cell that values between `x[0]` and `x[1]` can be counted in; `None` if those miss the axis by
    /// more than `pad`.
    #[inline(always)]
    pub(super) fn range(&self, x: [f64; 2], pad: f64) -> Option<[u32; 2]> {
        (x[0] <= self.hi + pad && x[1] >= self.lo - pad).then(|| [self.index(x[0]), self.index(x[1])])
    }

    /// Where cells `first` to `last` begin and end, to within 32 U (U = 2^-53) for ends in [-1, 1]: with `s` and `w` the rounded
    /// scale and step, a value in cell `k` has `k <= (x - lo) s (1 ± 2 U) < k + 1` and `s = (1 ± 3 U) / w`, so it lies
    /// between `lo + k w` and `lo + (k + 1) w` to within 6 U times `hi - lo <= 2`; evaluating that adds 6 U.
    #[inline(always)]
    pub(super) fn ends(&self, first: u32, last: u32) -> [f64; 2] {
        [self.lo + f64::from(first) * self.step, self.lo + f64::from(last + 1) * self.step]
    }
}

/// Two axes; cell `[column, row]` has number `row * columns + column`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Grid {
    pub(super) u: Axis,
    pub(super) v: Axis,
}

impl Grid {
    pub(super) fn cells(&self) -> usize {
        self.u.n as usize * self.v.n as usize
    }

    #[inline(always)]
    pub(super) fn cell(&self, uv: [f64; 2]) -> usize {
        self.v.index(uv[1]) as usize * self.u.n as usize + self.u.index(uv[0]) as usize
    }

    /// Least and largest u, least and largest v.
    pub(super) fn window(&self) -> [[f64; 2]; 2] {
        [[self.u.lo, self.u.hi], [self.v.lo, self.v.hi]]
    }
}
