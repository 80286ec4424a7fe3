//! Exact shadows of a point light, for any triangles.
//!
//! The pipeline, each word a module: [`scene`] (triangles, lights, camera) → [`samples`] (the points that are
//! asked) → [`methods`] (who finds the blocking triangle) → [`mask`] (the answer) → [`shade`] (a picture).

pub mod mask;
pub mod methods;
pub mod samples;
pub mod scene;
pub mod shade;

mod bvh;
mod isa;
mod vec3;

pub use isa::{Isa, UnknownIsa};
