//! The program `antumbra`.
fn main() {}
