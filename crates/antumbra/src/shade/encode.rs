//! From linear light to the 8 bits of a screen.

use rayon::prelude::*;

/// Where the shoulder begins: below it the picture is linear, above it highlights are rolled off towards white instead
/// of being cut. Lower keeps more detail in highlights and takes contrast from the middle.
const SHOULDER: f32 = 0.5;

/// Linear light to sRGB pixels: a soft shoulder for what is brighter than white, then the transfer curve of IEC 61966-2-1.
pub fn picture(linear: &[[f32; 3]]) -> Vec<[u8; 3]> {
    let table = EncodeTable::new();
    linear.par_iter().with_min_len(4096).map(|c| c.map(|v| table.byte(shoulder(v)))).collect()
}

/// The identity up to 0.5, then bent (with a continuous slope) so that it nears 1 but never reaches it.
pub fn shoulder(v: f32) -> f32 {
    if v <= SHOULDER {
        // NaN fails the comparison and falls through to 1, white: visible, and no panic.
        return v.max(0.0);
    }
    let over = (v - SHOULDER) / (1.0 - SHOULDER);
    if over < 1e6 { SHOULDER + (1.0 - SHOULDER) * over / (1.0 + over) } else { 1.0 }
}

/// One channel, 0..=1, to its sRGB value, 0..=1.
pub fn srgb_from_linear(v: f32) -> f32 {
    let v = v.clamp(0.0, 1.0);
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// One channel, 0..=1, of sRGB to linear light, 0..=1.
pub fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// The 256 values of a byte of sRGB as linear light.
pub(super) fn decode_table() -> [f32; 256] {
    std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0))
}

/// Linear light to a byte without a power for every pixel: the steps of a table of 4096 are finer than those of the
/// bytes everywhere but in the darkest 0.3 %, where the curve is a straight line and is computed.
struct EncodeTable(Vec<u8>);

impl EncodeTable {
    const STEPS: f32 = 4096.0;

    fn new() -> EncodeTable {
        let steps = Self::STEPS as usize;
        let byte = |i| (srgb_from_linear(i as f32 / Self::STEPS) * 255.0 + 0.5) as u8;
        EncodeTable((0..=steps).map(byte).collect())
    }

    fn byte(&self, v: f32) -> u8 {
        if v <= 0.003_130_8 {
            return (v * (12.92 * 255.0) + 0.5) as u8;
        }
        self.0[(v.min(1.0) * Self::STEPS + 0.5) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_the_round_trip() {
        let (decode, encode) = (decode_table(), EncodeTable::new());
        for i in 0..=255u8 {
            assert_eq!((srgb_from_linear(decode[usize::from(i)]) * 255.0).round() as u8, i);
            let by_table = encode.byte(decode[usize::from(i)]);
            assert!(by_table.abs_diff(i) <= 1, "{i} became {by_table}");
        }
    }

    #[test]
    fn the_shoulder_is_monotone_and_bounded() {
        let mut last = -1.0;
        for i in 0..10_000 {
            let v = shoulder(i as f32 * 0.01);
            assert!(v > last && v < 1.0);
            last = v;
        }
        assert_eq!(shoulder(0.25), 0.25);
        assert_eq!(picture(&[[f32::NAN, f32::INFINITY, -1.0]]), [[255, 255, 0]]);
    }
}
