//! What lowering reads from: the parsed JSON, the buffers, and an account of the memory taken so far.

use std::borrow::Cow;
use std::cell::Cell;
use std::fmt::Display;
use std::path::Path;

use gltf::json::Root;
use gltf::json::validation::Checked;

use super::container::{Container, read_file};
use super::uri::{self, Target};
use crate::Error;

/// Bytes that a file may make us hold, all in all. Files are untrusted: a few bytes can ask for any amount.
pub(super) const MEMORY_LIMIT: u64 = 2 << 30;

/// A scene file during `open`.
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) root: &'a Root,
    buffers: Vec<Cow<'a, [u8]>>,
    used: Cell<u64>,
}

impl<'a> Source<'a> {
    /// Loads all buffers: the binary chunk, `data:` URIs, files.
    pub(super) fn load(path: &'a Path, container: &'a Container) -> Result<Source<'a>, Error> {
        let mut source =
            Source { path, root: &container.root, buffers: Vec::new(), used: Cell::new(container.size) };
        for (index, buffer) in container.root.buffers.iter().enumerate() {
            let what = label("buffer", index, buffer.name.as_deref());
            let bytes = match (&buffer.uri, container.binary()) {
                (Some(uri), _) => Cow::Owned(source.fetch(uri, &what)?),
                (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
                (None, _) => return Err(source.error(format!("{what} has neither a URI nor a binary chunk"))),
            };
            if (bytes.len() as u64) < buffer.byte_length.0 {
                let (got, expected) = (bytes.len(), buffer.byte_length.0);
                return Err(source.error(format!("{what} has {got} bytes where {expected} were promised")));
            }
            source.buffers.push(bytes);
        }
        Ok(source)
    }

    /// An error of this file.
    pub(super) fn error(&self, what: impl Display) -> Error {
        Error::content(self.path, what)
    }

    /// Books `count` items of `size` bytes before they are allocated.
    pub(super) fn charge(&self, count: u64, size: usize, what: impl Display) -> Result<(), Error> {
        let total = self.used.get().saturating_add(count.saturating_mul(size as u64));
        if total > MEMORY_LIMIT {
            let limit = MEMORY_LIMIT >> 20;
            return Err(self.error(format!(
                "{what}: {count} items would take the file over the limit of {limit} MiB of memory"
            )));
        }
        self.used.set(total);
        Ok(())
    }

    /// Takes back what was booked and is freed again.
    pub(super) fn release(&self, bytes: u64) {
        self.used.set(self.used.get().saturating_sub(bytes));
    }

    /// The content behind a URI.
    pub(super) fn fetch(&self, uri: &str, what: &str) -> Result<Vec<u8>, Error> {
        if uri.starts_with("data:") {
            self.charge(uri.len() as u64, 1, what)?;
        }
        match uri::resolve(uri).map_err(|e| self.error(format!("{what}: {e}")))? {
            Target::Data(bytes) => Ok(bytes),
            Target::File(relative) => {
                let file = self.path.parent().unwrap_or(Path::new("")).join(relative);
                let rest = MEMORY_LIMIT - self.used.get().min(MEMORY_LIMIT);
                let bytes = read_file(&file, rest).map_err(|e| self.error(format!("{what}: {e}")))?;
                self.charge(bytes.len() as u64, 1, what)?;
                Ok(bytes)
            }
        }
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, index: usize, what: &str) -> Result<&[u8], Error> {
        let view = self.item(&self.root.buffer_views, index, "buffer view", what)?;
        let buffer =
            self.item(&self.buffers, view.buffer.value(), "buffer", &format!("buffer view {index}"))?;
        let offset = view.byte_offset.unwrap_or_default().0;
        usize::try_from(offset)
            .ok()
            .zip(offset.checked_add(view.byte_length.0).and_then(|end| usize::try_from(end).ok()))
            .and_then(|(start, end)| buffer.get(start..end))
            .ok_or_else(|| {
                let (length, number, size) = (view.byte_length.0, view.buffer.value(), buffer.len());
                self.error(format!(
                    "buffer view {index}: {length} bytes at {offset} do not fit in buffer {number} of {size} bytes"
                ))
            })
    }

    /// `list[index]`, or an error such as "mesh 3 'wall': accessor 12 out of range (there are 7)".
    pub(super) fn item<'l, T>(
        &self,
        list: &'l [T],
        index: usize,
        kind: &str,
        user: &str,
    ) -> Result<&'l T, Error> {
        list.get(index).ok_or_else(|| {
            self.error(format!("{user}: {kind} {index} out of range (there are {})", list.len()))
        })
    }

    /// The value of an enumeration of the JSON, or an error.
    pub(super) fn known<T: Copy>(&self, value: &Checked<T>, field: &str, user: &str) -> Result<T, Error> {
        match value {
            Checked::Valid(value) => Ok(*value),
            Checked::Invalid => {
                Err(self.error(format!("{user}: the value of '{field}' is not known to glTF")))
            }
        }
    }

    /// Memory booked for what stays when the file and its buffers are gone.
    pub(super) fn kept(&self, container: &Container) -> u64 {
        let owned = |b: &Cow<'_, [u8]>| if matches!(b, Cow::Owned(_)) { b.len() as u64 } else { 0 };
        let gone = container.size + self.buffers.iter().map(owned).sum::<u64>();
        self.used.get().saturating_sub(gone)
    }
}

/// `mesh 3 'wall'`, or `mesh 3` if it has no name. Names are cut and cleaned: they end up in one-line messages.
pub(super) fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => {
            let short: String = name.chars().filter(|c| !c.is_control()).take(40).collect();
            format!("{kind} {index} '{short}'")
        }
        _ => format!("{kind} {index}"),
    }
}
