//! Does this triangle block this sample from this light? The one leaf test of antumbra.
//!
//! The definition, in real arithmetic, with the light at the origin (`A = a - l`, `B = b - l`, `C = c - l`, `P = p - l`):
//!
//! 1. `D = sign det[A, B, C]`; a triangle with `D = 0` (degenerate, or edge-on from the light) does not block.
//! 2. The sides `det[A, B, P]`, `det[B, C, P]`, `det[C, A, P]` must all have the sign `D`; a zero is broken as if the
//!    sample were moved by `(ε, ε², ε³)` with ε → 0+.
//! 3. `(B - A) × (C - A) · (P - A)` must have the sign `D`: the sample lies strictly beyond the plane. Touching is not
//!    blocking.
//!
//! Two triangles that share an edge therefore claim a sample on that edge exactly once, and the answer depends neither
//! on the order of triangles nor on the order of vertices.
//!
//! Three stages give that answer, each leaving to the next what it cannot decide for certain:
//! [`filter`] (f32, eight lanes, with the error bound that `bounds.md` derives), [`resolve`] (f64, same bound), [`exact`]
//! (expansions). Every method of antumbra ends here; nobody writes a second epsilon.
//!
//! # One pair
//!
//! ```
//! use antumbra_predicates::resolve::blocks;
//!
//! let light = [0.0, 0.0, 4.0];
//! let triangle = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, 1.0, 2.0]];
//! assert!(blocks(&triangle, light, [0.0, 0.0, 0.0]));
//! // In front of it, and on it: not blocked.
//! assert!(!blocks(&triangle, light, [0.0, 0.0, 3.0]));
//! assert!(!blocks(&triangle, light, [0.0, 0.0, 2.0]));
//! // Exactly behind an edge that two triangles share: one of them blocks, not none and not both.
//! let neighbour = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, -3.0, 2.0]];
//! let behind_edge = [0.5, -2.0, 0.0];
//! assert!(blocks(&triangle, light, behind_edge) != blocks(&neighbour, light, behind_edge));
//! ```
//!
//! # Many: eight triangles against eight samples
//!
//! ```
//! use antumbra_predicates::{Coefficients, Resolver, SampleGroup, TriangleBlock, exact};
//! use fearless_simd::{Level, Simd, SimdBase, dispatch, f32x8};
//!
//! /// The mask of the samples that some triangle blocks; bits are samples.
//! #[inline(always)]
//! fn shadowed<S: Simd>(s: S, triangles: &[[[f32; 3]; 3]; 8], light: [f32; 3], samples: &[[f32; 3]; 8]) -> u8 {
//!     let bound = |f: fn(f32, f32) -> f32| [0, 1, 2].map(|k| samples.iter().map(|p| p[k]).reduce(f).unwrap());
//!     let group = SampleGroup::from_bounds(bound(f32::min), bound(f32::max));
//!     let block = TriangleBlock {
//!         corner: [0, 1, 2].map(|i| [0, 1, 2].map(|k| triangles.map(|t| t[i][k]))),
//!     };
//!     let mut tests = Coefficients::ZERO;
//!     let verdict = block.against(s, 0xff, light, &group, &mut tests);
//!     if verdict.covers != 0 {
//!         return 0xff;
//!     }
//!     let p = [0, 1, 2].map(|k| f32x8::from_fn(s, |i| samples[i][k]));
//!     let (mut blocked, mut open) = (0, Vec::new());
//!     for lane in (0..8).filter(|lane| verdict.maybe >> lane & 1 == 1) {
//!         if verdict.edge_on >> lane & 1 == 1 {
//!             match exact::facing(&triangles[lane], light) {
//!                 0 => continue,
//!                 -1 => tests.flip(lane),
//!                 _ => {}
//!             }
//!         }
//!         let lanes = tests.test(s, lane, p);
//!         blocked |= lanes.blocked;
//!         open.push((lane, lanes.unsure));
//!     }
//!     // Last, and only for samples that no other triangle blocks for certain.
//!     for (lane, unsure) in open {
//!         let Some(resolver) = Resolver::new(&triangles[lane], light) else { continue };
//!         let ask = unsure & !blocked;
//!         for i in (0..8).filter(|i| ask >> i & 1 == 1) {
//!             blocked |= u8::from(resolver.blocks(samples[i]).0) << i;
//!         }
//!     }
//!     blocked
//! }
//!
//! let triangles = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
//!     let x = i as f32;
//!     [[x, 0.0, 1.0], [x + 1.0, 0.0, 1.0], [x, 1.0, 1.0]]
//! });
//! // Under a light far above, the row of triangles shades x in 0..8 where y is small; 8.5 is beyond the row.
//! let samples = [0.25, 1.25, 2.25, 3.25, 4.25, 5.25, 8.5, 9.5].map(|x| [x, 0.25, 0.0]);
//! let mask = dispatch!(Level::new(), s => shadowed(s, &triangles, [4.0, 0.0, 1000.0], &samples));
//! assert_eq!(mask, 0b0011_1111);
//! ```
#![forbid(unsafe_code)]
#![no_std]

#[cfg(test)]
extern crate std;

pub mod aim;
pub mod exact;
pub mod filter;
pub mod plane;
pub mod resolve;
mod shares;
pub mod single;
pub mod tile;
pub mod vector;

pub use filter::{BlockVerdict, Coefficients, Lanes, SampleGroup, TriangleBlock};
pub use resolve::{Decided, Resolver};
pub use shares::Shares;

/// Three corners, in any order.
pub type Triangle = [[f32; 3]; 3];
