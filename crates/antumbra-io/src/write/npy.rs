//! NPY arrays, little-endian, C order: what NumPy's `load` and [`crate::read::npy`] read.

use std::io::{BufWriter, Write};
use std::path::Path;

use antumbra::scene::Triangle;

use super::{atomically, check_len};
use crate::Error;

/// Writes triangles as `f4 [T, 3, 3]` (triangle, corner, coordinate).
///
/// # Errors
/// [`Error`] names the file that cannot be written.
pub fn triangles(path: &Path, triangles: &[Triangle]) -> Result<(), Error> {
    f32_array(path, triangles.as_flattened().as_flattened(), &[triangles.len(), 3, 3])
}

/// Writes sample positions as `f4 [H, W, 3]` or `[N, 3]`; `leading` is `[H, W]` or `[N]`. NaN is "no sample".
///
/// # Errors
/// [`Error`] names the file that cannot be written, or the shape that does not fit.
pub fn samples(path: &Path, positions: &[[f32; 3]], leading: &[usize]) -> Result<(), Error> {
    f32_array(path, positions.as_flattened(), &[leading, &[3]].concat())
}

/// Writes a mask (0 lit, 1 shadowed, 255 none) as `u1` of the samples' leading shape.
///
/// # Errors
/// [`Error`] names the file that cannot be written, or the shape that does not fit.
pub fn mask(path: &Path, mask: &[u8], shape: &[usize]) -> Result<(), Error> {
    check_len(path, "mask", mask.len(), shape)?;
    atomically(path, |file| {
        file.write_all(&header("|u1", shape))?;
        file.write_all(mask)
    })
}

/// Writes any floats, row by row, as `f4` of the given shape.
///
/// # Errors
/// [`Error`] names the file that cannot be written, or the shape that does not fit.
pub fn f32_array(path: &Path, values: &[f32], shape: &[usize]) -> Result<(), Error> {
    check_len(path, "array", values.len(), shape)?;
    atomically(path, |file| {
        file.write_all(&header("<f4", shape))?;
        write_floats(file, values)
    })
}

fn write_floats(file: &mut BufWriter<impl Write>, values: &[f32]) -> std::io::Result<()> {
    if cfg!(target_endian = "little") {
        return file.write_all(bytemuck::cast_slice(values));
    }
    values.iter().try_for_each(|v| file.write_all(&v.to_le_bytes()))
}

/// Magic, version 1.0, length, dictionary; padded so that the data begin at a multiple of 64 bytes.
fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|s| format!("{s}, ")).collect();
    // One size needs its comma, `(5,)`; of several the last may not have one to look as NumPy's.
    let sizes = if shape.len() == 1 { sizes.trim_end() } else { sizes.trim_end_matches(", ") };
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({sizes}), }}");
    let len = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((len as u16).to_le_bytes());
    header.extend(text.as_bytes());
    header.resize(10 + len - 1, b' ');
    header.push(b'\n');
    header
}

#[cfg(test)]
mod tests {
    use super::header;

    #[test]
    fn the_header_is_what_numpy_writes() {
        let text = |shape: &[usize]| {
            let bytes = header("<f4", shape);
            assert_eq!(bytes.len() % 64, 0);
            String::from_utf8_lossy(&bytes[10..]).trim_end().to_owned()
        };
        assert_eq!(text(&[2, 3, 3]), "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 3), }");
        assert_eq!(text(&[5]), "{'descr': '<f4', 'fortran_order': False, 'shape': (5,), }");
        assert_eq!(text(&[]), "{'descr': '<f4', 'fortran_order': False, 'shape': (), }");
    }
}
