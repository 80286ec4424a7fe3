//! Rows of numbers to columns.
//!
//! All of it works in each half of a vector alone, as the hardware does: written as halves put together, which compilers see through.

use antumbra_predicates::Triangle;
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Avx2, SimdInto};
use fearless_simd::{Simd, SimdBase, f32x4, f32x8};

/// `a0 b0 a1 b1`, in each half of the vectors.
#[inline(always)]
pub(super) fn zip_low<S: Simd>(s: S, a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = s.level().as_avx2() {
        let (a, b) = (f32x8::load_array(avx2, a.to_array()), f32x8::load_array(avx2, b.to_array()));
        return f32x8::load_array(s, unpack_low(avx2, a, b).to_array());
    }
    let ((a, c), (b, d)) = (s.split_f32x8(a), s.split_f32x8(b));
    s.combine_f32x4(s.zip_low_f32x4(a, b), s.zip_low_f32x4(c, d))
}

/// `a2 b2 a3 b3`, in each half of the vectors.
#[inline(always)]
pub(super) fn zip_high<S: Simd>(s: S, a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = s.level().as_avx2() {
        let (a, b) = (f32x8::load_array(avx2, a.to_array()), f32x8::load_array(avx2, b.to_array()));
        return f32x8::load_array(s, unpack_high(avx2, a, b).to_array());
    }
    let ((a, c), (b, d)) = (s.split_f32x8(a), s.split_f32x8(b));
    s.combine_f32x4(s.zip_high_f32x4(a, b), s.zip_high_f32x4(c, d))
}

fearless_simd::kernel!(
    #[inline(always)]
    fn unpack_low(avx2: Avx2, a: f32x8<Avx2>, b: f32x8<Avx2>) -> f32x8<Avx2> {
        std::arch::x86_64::_mm256_unpacklo_ps(a.into(), b.into()).simd_into(avx2)
    }
);

fearless_simd::kernel!(
    #[inline(always)]
    fn unpack_high(avx2: Avx2, a: f32x8<Avx2>, b: f32x8<Avx2>) -> f32x8<Avx2> {
        std::arch::x86_64::_mm256_unpackhi_ps(a.into(), b.into()).simd_into(avx2)
    }
);

/// The first three columns of four rows, in each half of the vectors.
#[inline(always)]
pub(super) fn three_columns<S: Simd>(s: S, [a, b, c, d]: [f32x8<S>; 4]) -> [f32x8<S>; 3] {
    let (ac, bd) = (zip_low(s, a, c), zip_low(s, b, d));
    let z = zip_low(s, zip_high(s, a, c), zip_high(s, b, d));
    [zip_low(s, ac, bd), zip_high(s, ac, bd), z]
}

/// The last column of four rows, in each half of the vectors.
#[inline(always)]
fn last_column<S: Simd>(s: S, [a, b, c, d]: [f32x8<S>; 4]) -> f32x8<S> {
    zip_high(s, zip_high(s, a, c), zip_high(s, b, d))
}

/// Four numbers of each of two rows.
#[inline(always)]
pub(super) fn two<S: Simd>(s: S, low: &[f32], high: &[f32]) -> f32x8<S> {
    s.combine_f32x4(f32x4::from_slice(s, &low[..4]), f32x4::from_slice(s, &high[..4]))
}

/// Corners of eight triangles, coordinates apart: corner, axis.
#[inline(always)]
pub(super) fn corners<S: Simd>(s: S, t: [&Triangle; 8]) -> [[f32x8<S>; 3]; 3] {
    // Nine numbers a triangle: 0 to 3, 4 to 7, and 5 to 8 for the last.
    let first = rows::<S, 0>(s, t);
    let second = rows::<S, 4>(s, t);
    let [ax, ay, az] = three_columns(s, first);
    let [by, bz, cx] = three_columns(s, second);
    [
        [ax, ay, az],
        [last_column(s, first), by, bz],
        [cx, last_column(s, second), last_column(s, rows::<S, 5>(s, t))],
    ]
}

#[inline(always)]
fn rows<S: Simd, const AT: usize>(s: S, t: [&Triangle; 8]) -> [f32x8<S>; 4] {
    [
        two(s, &t[0].as_flattened()[AT..], &t[4].as_flattened()[AT..]),
        two(s, &t[1].as_flattened()[AT..], &t[5].as_flattened()[AT..]),
        two(s, &t[2].as_flattened()[AT..], &t[6].as_flattened()[AT..]),
        two(s, &t[3].as_flattened()[AT..], &t[7].as_flattened()[AT..]),
    ]
}
