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
#![forbid(unsafe_code)]
#![no_std]

#[cfg(test)]
extern crate std;

pub mod exact;
pub mod filter;
pub mod resolve;
pub mod single;

pub use filter::{BlockVerdict, Coefficients, Lanes, SampleGroup, TriangleBlock};
pub use resolve::{Decided, Resolver};

/// Three corners, in any order.
pub type Triangle = [[f32; 3]; 3];
