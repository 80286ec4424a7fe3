//! NPY arrays: triangles, samples and masks, as NumPy and this library's writers make them.
//!
//! Numbers are `f4` or `f8` in either byte order; doubles are rounded to the nearest float. Rows may be in C or
//! Fortran order.

mod header;

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use antumbra::mask::{LIT, NONE, SHADOWED};
use antumbra::scene::{Scene, Triangle, check_triangles};

use super::mesh::{Budget, plain_scene};
use crate::Error;
use header::Header;

/// Bytes read at once: stays in the cache on its way from the system's buffer to the array.
const CHUNK: usize = 1 << 18;

pub(super) fn open_scene(path: &Path) -> Result<Scene, Error> {
    let triangles = read_triangles(path)?;
    if triangles.is_empty() {
        return Err(Error::content(path, "no triangles"));
    }
    Ok(plain_scene(path, triangles))
}

/// Reads triangles `[T, 3, 3]` (triangle, corner, coordinate), in scene units.
///
/// # Errors
/// [`Error`] names the file and its shape or type if they do not fit, and the first triangle with a coordinate that is
/// not finite (or too large for `f32`).
pub fn read_triangles(path: &Path) -> Result<Vec<Triangle>, Error> {
    let mut array = Array::open(path)?;
    let &[_, 3, 3] = array.shape() else {
        return Err(array.misfit("triangles [T,3,3]"));
    };
    let (triangles, all_finite) = array.floats::<Triangle>()?;
    if !all_finite {
        check_triangles(&triangles).map_err(|e| Error::content(path, e))?;
    }
    Ok(triangles)
}

/// Reads samples `[H, W, 3]` or `[N, 3]`, in scene units: the positions row by row, and the leading shape (`[H, W]` or
/// `[N]`). A sample with a NaN is "no sample here".
///
/// # Errors
/// [`Error`] names the file and its shape or type if they do not fit, and the first sample with an infinite coordinate
/// (or one too large for `f32`).
pub fn read_samples(path: &Path) -> Result<(Vec<[f32; 3]>, Vec<usize>), Error> {
    let mut array = Array::open(path)?;
    let leading = match array.shape() {
        [leading @ .., 3] if matches!(leading.len(), 1 | 2) => leading.to_vec(),
        _ => return Err(array.misfit("samples [H,W,3] or [N,3]")),
    };
    let (samples, all_finite) = array.floats::<[f32; 3]>()?;
    if !all_finite && let Some(i) = samples.iter().position(|s| s.iter().any(|v| v.is_infinite())) {
        return Err(Error::content(path, format!("sample {i}: {:?} is infinite", samples[i])));
    }
    Ok((samples, leading))
}

/// Reads a mask of any shape (0 lit, 1 shadowed, 255 none; booleans do, too): the bytes row by row, and the shape.
///
/// # Errors
/// [`Error`] names the file and its type if that does not fit, and the first byte that is none of the three.
pub fn read_mask(path: &Path) -> Result<(Vec<u8>, Vec<usize>), Error> {
    let mut array = Array::open(path)?;
    if !matches!(array.header.descr.trim_start_matches(['|', '<', '>', '=']), "u1" | "b1") {
        return Err(array.misfit("a mask of type |u1"));
    }
    let len = array.check_len(1)?;
    let mut mask = vec![0; len];
    array.file.read_exact(&mut mask).map_err(|e| array.broken(e))?;
    array.check_end()?;
    if let Some(i) = mask.iter().position(|m| !matches!(*m, LIT | SHADOWED | NONE)) {
        return Err(Error::content(path, format!("mask entry {i} is {}, not 0, 1 or 255", mask[i])));
    }
    let shape = array.header.shape.clone();
    if array.header.fortran {
        array.charge(len, 1)?;
        mask = c_order(&mask, &shape);
    }
    Ok((mask, shape))
}

/// An open file, behind its header.
struct Array<'a> {
    path: &'a Path,
    file: File,
    header: Header,
    /// Bytes that follow.
    left: u64,
    budget: Budget,
}

impl<'a> Array<'a> {
    fn open(path: &'a Path) -> Result<Array<'a>, Error> {
        let mut file = File::open(path).map_err(|e| Error::io(path, e))?;
        let left = file.metadata().map_err(|e| Error::io(path, e))?.len();
        let mut array = Array { path, file, header: Header::default(), left, budget: Budget::new() };
        let [magic @ .., major, _minor] = array.read::<8>()?;
        if magic != *b"\x93NUMPY" {
            return Err(array.content("not an NPY file"));
        }
        let len = match major {
            1 => usize::from(u16::from_le_bytes(array.read()?)),
            2 | 3 => u32::from_le_bytes(array.read()?) as usize,
            _ => return Err(array.content(format!("unknown NPY version {major}"))),
        };
        if len > header::LONGEST {
            return Err(array.content(format!("bad header: {len} bytes long")));
        }
        let mut text = vec![0; len];
        file = array.file;
        file.read_exact(&mut text).map_err(|e| broken(path, e))?;
        let header = header::parse(&text).map_err(|e| Error::content(path, e))?;
        let left = array.left.saturating_sub(len as u64);
        Ok(Array { file, header, left, ..array })
    }

    fn read<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut bytes = [0; N];
        self.file.read_exact(&mut bytes).map_err(|e| self.broken(e))?;
        self.left = self.left.saturating_sub(N as u64);
        Ok(bytes)
    }

    fn shape(&self) -> &[usize] {
        &self.header.shape
    }

    fn content(&self, what: impl std::fmt::Display) -> Error {
        Error::content(self.path, what)
    }

    fn broken(&self, e: std::io::Error) -> Error {
        broken(self.path, e)
    }

    fn misfit(&self, wanted: &str) -> Error {
        self.content(format!(
            "the array is {:?} of type {:?}, but {wanted} are wanted",
            self.header.shape, self.header.descr
        ))
    }

    fn charge(&mut self, count: usize, size: usize) -> Result<(), Error> {
        self.budget.take(count, size).map_err(|e| Error::content(self.path, e))
    }

    /// The number of entries, after a check against the size of the file and the memory allowed.
    fn check_len(&mut self, size: usize) -> Result<usize, Error> {
        let len = self.header.shape.iter().try_fold(1usize, |n, s| n.checked_mul(*s));
        let bytes = len.and_then(|n| n.checked_mul(size));
        let (Some(len), Some(bytes)) = (len, bytes) else {
            return Err(self.content(format!("the shape {:?} is impossible", self.header.shape)));
        };
        if bytes as u64 != self.left {
            return Err(self.content(format!(
                "the shape {:?} of {} takes {bytes} bytes, but {} follow the header: truncated?",
                self.header.shape, self.header.descr, self.left
            )));
        }
        self.charge(len, size)?;
        Ok(len)
    }

    fn check_end(&mut self) -> Result<(), Error> {
        match self.file.read(&mut [0]).map_err(|e| self.broken(e))? {
            0 => Ok(()),
            _ => Err(self.content("more bytes follow than the shape says")),
        }
    }

    /// All numbers, in rows made of `f32`, and whether all of them are finite.
    fn floats<Row: bytemuck::Pod>(&mut self) -> Result<(Vec<Row>, bool), Error> {
        let (big, double) = match self.header.descr.as_str() {
            "<f4" | "=f4" => (false, false),
            ">f4" => (true, false),
            "<f8" | "=f8" => (false, true),
            ">f8" => (true, true),
            _ => return Err(self.misfit("numbers of type <f4, >f4, <f8 or >f8")),
        };
        let len = self.check_len(if double { 8 } else { 4 })?;
        let mut rows = vec![Row::zeroed(); len * 4 / size_of::<Row>()];
        let flat: &mut [f32] = bytemuck::cast_slice_mut(&mut rows);
        let mut chunk = vec![0; CHUNK];
        // Looked at while it is in the cache: most files need no second look.
        let mut all_finite = true;
        for to in flat.chunks_mut(CHUNK / 8) {
            let size = if double { 8 } else { 4 };
            let from = &mut chunk[..to.len() * size];
            self.file.read_exact(from).map_err(|e| broken(self.path, e))?;
            match (double, big) {
                (false, false) => convert(from, to, f32::from_le_bytes),
                (false, true) => convert(from, to, f32::from_be_bytes),
                (true, false) => convert(from, to, |b| f64::from_le_bytes(b) as f32),
                (true, true) => convert(from, to, |b| f64::from_be_bytes(b) as f32),
            }
            all_finite &= to.iter().fold(true, |all, v| all & v.is_finite());
        }
        self.check_end()?;
        if self.header.fortran {
            self.charge(len, 4)?;
            let ordered = c_order(flat, &self.header.shape);
            flat.copy_from_slice(&ordered);
        }
        Ok((rows, all_finite))
    }
}

fn broken(path: &Path, e: std::io::Error) -> Error {
    if e.kind() == ErrorKind::UnexpectedEof {
        return Error::content(path, "the file ends early: truncated?");
    }
    Error::io(path, e)
}

fn convert<const S: usize>(from: &[u8], to: &mut [f32], number: impl Fn([u8; S]) -> f32) {
    for (to, from) in to.iter_mut().zip(from.as_chunks::<S>().0) {
        *to = number(*from);
    }
}

/// From "first index fastest" to "last index fastest".
fn c_order<T: Copy>(from: &[T], shape: &[usize]) -> Vec<T> {
    // `index` is the next entry's, `at` its place in `from`; both count up like a mileage meter.
    let mut index = vec![0; shape.len()];
    let mut at = 0;
    let mut to = Vec::with_capacity(from.len());
    let mut strides = Vec::with_capacity(shape.len());
    let mut stride = 1;
    for size in shape {
        strides.push(stride);
        stride *= size;
    }
    while to.len() < from.len() {
        to.push(from[at]);
        for k in (0..shape.len()).rev() {
            index[k] += 1;
            at += strides[k];
            if index[k] < shape[k] {
                break;
            }
            at -= strides[k] * shape[k];
            index[k] = 0;
        }
    }
    to
}
