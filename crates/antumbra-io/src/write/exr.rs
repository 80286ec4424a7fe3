//! OpenEXR pictures: linear 32-bit floats, any number of named channels.

use std::io::{Cursor, Write};
use std::path::Path;

use ::exr::prelude::*;
// The prelude's `Result` has a fixed error; ours differ.
use std::result::Result;

use super::{atomically, check_len, invalid};
use crate::Error;

/// Writes linear pixels as channels `R`, `G`, `B`, and each of `extra` (e.g. `mask`, `Z`, `light`) as a channel of its
/// name; all row by row, top row first.
///
/// # Errors
/// [`Error`] names the file that cannot be written, the channel whose length does not fit, or whose name is empty, too
/// long (over 255 bytes), or there twice.
pub fn color(
    path: &Path,
    width: usize,
    height: usize,
    pixels: &[[f32; 3]],
    extra: &[(&str, &[f32])],
) -> Result<(), Error> {
    check_len(path, "picture", pixels.len(), &[height, width])?;
    let mut channels = SmallVec::new();
    for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
        let values = pixels.iter().map(|p| p[k]).collect();
        channels.push(AnyChannel::new(name, FlatSamples::F32(values)));
    }
    for (i, (name, values)) in extra.iter().enumerate() {
        check_len(path, &format!("channel {name:?}"), values.len(), &[height, width])?;
        let known = ["R", "G", "B"].contains(name) || extra[..i].iter().any(|(n, _)| n == name);
        if known || !(1..=255).contains(&name.len()) || name.contains('\0') {
            return Err(Error::content(path, format!("channel name {name:?} is empty, too long or taken")));
        }
        let name = Text::new_or_none(name)
            .ok_or_else(|| Error::content(path, format!("channel name {name:?} has letters EXR lacks")))?;
        channels.push(AnyChannel::new(name, FlatSamples::F32(values.to_vec())));
    }
    write(path, width, height, channels)
}

/// Writes one number a pixel, NaN and all, as the channel `Y`, which viewers show as grey.
///
/// # Errors
/// [`Error`] names the file that cannot be written, or the size that does not fit.
pub fn numbers(path: &Path, width: usize, height: usize, values: &[f32]) -> Result<(), Error> {
    check_len(path, "picture", values.len(), &[height, width])?;
    let channel = AnyChannel::new("Y", FlatSamples::F32(values.to_vec()));
    write(path, width, height, std::iter::once(channel).collect())
}

fn write(
    path: &Path,
    width: usize,
    height: usize,
    channels: SmallVec<[AnyChannel<FlatSamples>; 4]>,
) -> Result<(), Error> {
    if ![width, height].iter().all(|s| (1..=1 << 24).contains(s)) {
        return Err(Error::content(path, format!("a picture of {width} x {height} pixels is not possible")));
    }
    // ZIP and PIZ take five times as long for a fifth less; run lengths shrink what is flat: masks and backgrounds.
    let encoding = Encoding { compression: Compression::RLE, ..Encoding::SMALL_LOSSLESS };
    let image = Image::from_encoded_channels((width, height), encoding, AnyChannels::sort(channels));
    // The encoder seeks: a device or a pipe cannot, memory can.
    let mut encoded = Cursor::new(Vec::new());
    image.write().to_buffered(&mut encoded).map_err(|e| Error::io(path, invalid(e)))?;
    atomically(path, |file| file.write_all(encoded.get_ref()))
}
