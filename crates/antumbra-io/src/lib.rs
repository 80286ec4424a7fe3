//! Scene files in, pictures and data out.
#![forbid(unsafe_code)]
