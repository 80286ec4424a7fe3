//! What can go wrong with a file.

use std::path::{Path, PathBuf};

/// A file that cannot be read, written or meant.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system said no.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The content cannot be meant; `what` names object and index, and the remedy if there is one. One or two lines.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, where.
        what: String,
    },
    /// No reader or writer knows this file name ending.
    #[error("{}: unknown file type '{extension}'; known are {known}", path.display())]
    Type {
        /// The file.
        path: PathBuf,
        /// Its ending.
        extension: String,
        /// The endings that would do.
        known: &'static str,
    },
}

impl Error {
    /// [`Error::Content`] from anything printable. Line breaks and over-long texts of libraries are cut to one line.
    pub fn content(path: &Path, what: impl std::fmt::Display) -> Error {
        let text = what.to_string();
        let line: String =
            text.lines().map(str::trim).collect::<Vec<_>>().join("; ").chars().take(300).collect();
        Error::Content { path: path.to_owned(), what: line }
    }

    /// [`Error::Io`].
    pub fn io(path: &Path, source: std::io::Error) -> Error {
        Error::Io { path: path.to_owned(), source }
    }
}
