//! The three stages against exact integers, on inputs made to break them.
//!
//! `oracle` is the definition, literally, in big integers; `cases` makes the inputs; every other module asks one stage
//! (or one consequence of the definition) the same questions. A failure prints a line that can be pasted into
//! `fixtures/regressions.txt`.

mod cases;
mod consequences;
mod cube;
mod exact;
mod filter;
mod fixtures;
mod oracle;
mod resolve;
mod shares;
mod tile;
