//! Scene files in, pictures and data out.
//!
//! [`open`] reads a scene file once; [`SceneFile::at`] gives the scene at a time. [`read::npy`] reads arrays,
//! [`mod@write`] writes them, and pictures. Files are untrusted: every error names file, object and index; nothing panics.
#![forbid(unsafe_code)]

mod error;
pub mod read;
pub mod write;

pub use error::Error;
pub use read::{SceneFile, open};
