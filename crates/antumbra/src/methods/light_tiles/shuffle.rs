//! Rows of numbers to columns.
//!
//! All of it works in each half of a vector alone, as the hardware does. AVX2 has names for that which the portable interface lacks; compilers
//! do not find them in halves that are put together.

use antumbra_predicates::Triangle;
use fearless_simd::{Simd, SimdBase, f32x4, f32x8};

#[inline(always)]
fn halves<S: Simd>(s: S, [a, b, c, d]: [f32x8<S>; 4]) -> [[f32x4<S>; 4]; 2] {
    let ((a, e), (b, f), (c, g), (d, h)) =
        (s.split_f32x8(a), s.split_f32x8(b), s.split_f32x8(c), s.split_f32x8(d));
    [[a, b, c, d], [e, f, g, h]]
}

#[inline(always)]
fn four_columns<S: Simd>(s: S, [a, b, c, d]: [f32x4<S>; 4]) -> [f32x4<S>; 4] {
    let (ac, bd) = (s.zip_low_f32x4(a, c), s.zip_low_f32x4(b, d));
    let (ac2, bd2) = (s.zip_high_f32x4(a, c), s.zip_high_f32x4(b, d));
    [s.zip_low_f32x4(ac, bd), s.zip_high_f32x4(ac, bd), s.zip_low_f32x4(ac2, bd2), s.zip_high_f32x4(ac2, bd2)]
}

/// The least of the four numbers in each half of x, y and r: as numbers 0, 1, 2 of the half.
#[inline(always)]
pub(super) fn least_of_halves<S: Simd>(s: S, [x, y, r]: [f32x8<S>; 3]) -> f32x8<S> {
    let [a, b, c, d] = columns(s, [x, y, r, r]);
    a.min(b).min(c.min(d))
}

/// Columns of four rows, in each half of the vectors.
#[inline(always)]
pub(super) fn columns<S: Simd>(s: S, rows: [f32x8<S>; 4]) -> [f32x8<S>; 4] {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = s.level().as_avx2() {
        let [a, b, c, d] = rows;
        let [a, b, c, d] = avx2::columns(avx2, a.to_array(), b.to_array(), c.to_array(), d.to_array());
        return [
            f32x8::load_array(s, a),
            f32x8::load_array(s, b),
            f32x8::load_array(s, c),
            f32x8::load_array(s, d),
        ];
    }
    let [low, high] = halves(s, rows);
    let ([a, b, c, d], [e, f, g, h]) = (four_columns(s, low), four_columns(s, high));
    [s.combine_f32x4(a, e), s.combine_f32x4(b, f), s.combine_f32x4(c, g), s.combine_f32x4(d, h)]
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{_mm256_unpackhi_ps, _mm256_unpacklo_ps};

    use fearless_simd::{SimdBase, SimdFrom, f32x8};

    fearless_simd::kernel!(
        /// Columns of four rows, in each half of the vectors.
        #[inline(always)]
        pub(super) fn columns(
            avx2: Avx2,
            a: [f32; 8],
            b: [f32; 8],
            c: [f32; 8],
            d: [f32; 8],
        ) -> [[f32; 8]; 4] {
            let a = f32x8::load_array(avx2, a).into();
            let b = f32x8::load_array(avx2, b).into();
            let c = f32x8::load_array(avx2, c).into();
            let d = f32x8::load_array(avx2, d).into();
            let (ac, bd) = (_mm256_unpacklo_ps(a, c), _mm256_unpacklo_ps(b, d));
            let (ac2, bd2) = (_mm256_unpackhi_ps(a, c), _mm256_unpackhi_ps(b, d));
            let columns = [
                _mm256_unpacklo_ps(ac, bd),
                _mm256_unpackhi_ps(ac, bd),
                _mm256_unpacklo_ps(ac2, bd2),
                _mm256_unpackhi_ps(ac2, bd2),
            ];
            [
                f32x8::simd_from(avx2, columns[0]).to_array(),
                f32x8::simd_from(avx2, columns[1]).to_array(),
                f32x8::simd_from(avx2, columns[2]).to_array(),
                f32x8::simd_from(avx2, columns[3]).to_array(),
            ]
        }
    );
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
    let [ax, ay, az, bx] = columns(s, first);
    let [by, bz, cx, cy] = columns(s, second);
    let [.., cz] = columns(s, rows::<S, 5>(s, t));
    [[ax, ay, az], [bx, by, bz], [cx, cy, cz]]
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
