//! Asks memory for what is needed soon.
//!
//! The tile pass reads samples, triangles and lists in the order of tiles, which is no order in memory: a profile showed an eighth of
//! its time at the first touch of each sample. The compiler has no safe way to say "soon".
#![allow(unsafe_code, reason = "prefetching takes a pointer; it reads nothing and cannot fault")]

use antumbra_predicates::Triangle;

/// Asks for the cache line that holds item `index`, or would. Never changes a result.
#[inline(always)]
pub(super) fn prefetch<T>(items: &[T], index: usize) {
    ask_for::<T, true>(items, index);
}

/// The same, as far as the second cache, which keeps three times as many requests going at once as the first one (48 and 16 on recent Intel
/// processors).
#[inline(always)]
pub(super) fn prefetch_second<T>(items: &[T], index: usize) {
    ask_for::<T, false>(items, index);
}

#[inline(always)]
fn ask_for<T, const FIRST: bool>(items: &[T], index: usize) {
    let item = items.as_ptr().wrapping_add(index);
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _MM_HINT_T1, _mm_prefetch};
        // SAFETY: the instruction is part of SSE, which every x86-64 has; it has no effect but on caches, for any address.
        unsafe {
            if FIRST {
                _mm_prefetch::<_MM_HINT_T0>(item.cast());
            } else {
                _mm_prefetch::<_MM_HINT_T1>(item.cast());
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = item;
}

/// Asks for the eight triangles from `first` on.
#[inline(always)]
pub(super) fn prefetch_eight(triangles: &[Triangle], first: usize) {
    // 288 bytes lie in five cache lines, or six, of which the last is that of the next.
    for line in 0..5 {
        prefetch(triangles.as_flattened().as_flattened(), 9 * first + 16 * line);
    }
}
