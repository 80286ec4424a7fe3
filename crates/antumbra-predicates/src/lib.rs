//! Does this triangle block this sample from this light? The one leaf test of antumbra.
#![forbid(unsafe_code)]

pub mod exact;
