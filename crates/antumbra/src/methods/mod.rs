//! Who finds the blocking triangle.
