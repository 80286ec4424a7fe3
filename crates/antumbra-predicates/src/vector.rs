//! Three vectors of eight lanes as coordinates. Spelled out: closures and `array::map` over vectors are compiled without the
//! instruction set of their caller.

use fearless_simd::{Simd, SimdBase, SimdFloat, f32x8};

/// Eight points or vectors: coordinates.
pub type V3<S> = [f32x8<S>; 3];

/// From memory, coordinate by coordinate.
#[inline(always)]
pub fn load3<S: Simd>(s: S, v: &[[f32; 8]; 3]) -> V3<S> {
    [f32x8::load_array_ref(s, &v[0]), f32x8::load_array_ref(s, &v[1]), f32x8::load_array_ref(s, &v[2])]
}

/// One point in all lanes.
#[inline(always)]
pub fn splat3<S: Simd>(s: S, v: [f32; 3]) -> V3<S> {
    [f32x8::splat(s, v[0]), f32x8::splat(s, v[1]), f32x8::splat(s, v[2])]
}

/// To memory, coordinate by coordinate.
#[inline(always)]
pub fn store3<S: Simd>(v: V3<S>, out: &mut [[f32; 8]; 3]) {
    v[0].store_array(&mut out[0]);
    v[1].store_array(&mut out[1]);
    v[2].store_array(&mut out[2]);
}

/// Differences.
#[inline(always)]
pub fn sub<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Absolute values of the coordinates.
#[inline(always)]
pub fn abs<S: Simd>(a: V3<S>) -> V3<S> {
    [a[0].abs(), a[1].abs(), a[2].abs()]
}

/// Dot products.
#[inline(always)]
pub fn dot<S: Simd>(a: V3<S>, b: V3<S>) -> f32x8<S> {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// Products with a number for each lane.
#[inline(always)]
pub fn scale<S: Simd>(a: V3<S>, by: f32x8<S>) -> V3<S> {
    [a[0] * by, a[1] * by, a[2] * by]
}

/// Cross products; one product of each coordinate is fused.
#[inline(always)]
pub fn cross<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[1].mul_sub(b[2], a[2] * b[1]), a[2].mul_sub(b[0], a[0] * b[2]), a[0].mul_sub(b[1], a[1] * b[0])]
}

/// The cross product of absolute values with all signs positive, plus `tiny`.
#[inline(always)]
pub fn cross_abs<S: Simd>(a: V3<S>, b: V3<S>, tiny: f32x8<S>) -> V3<S> {
    [
        a[1].mul_add(b[2], a[2].mul_add(b[1], tiny)),
        a[2].mul_add(b[0], a[0].mul_add(b[2], tiny)),
        a[0].mul_add(b[1], a[1].mul_add(b[0], tiny)),
    ]
}

/// The largest coordinate of each lane.
#[inline(always)]
pub fn max3<S: Simd>(a: V3<S>) -> f32x8<S> {
    a[0].max(a[1]).max(a[2])
}
