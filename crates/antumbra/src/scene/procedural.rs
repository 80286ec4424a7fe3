//! Seeded scenes made in code.
