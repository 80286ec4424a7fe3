//! Textures looked up without aliasing: pyramids of halved images, made when a pixel first needs one.

use std::sync::OnceLock;

use crate::scene::{Texture, Wrap};
use crate::vec3::mix;

/// A texture with its halved images.
pub(super) struct Pyramid<'a> {
    texture: &'a Texture,
    /// Weigh colours by alpha: the texels around a cut-out leaf are often black or garbage.
    cutout: bool,
    /// Half size, quarter size, … down to one texel. Built on first use, by one thread (a parallel build inside the
    /// cell could be stolen by a thread that waits for the cell).
    halves: OnceLock<Vec<Half>>,
}

/// A reduced image: linear colour and alpha in 16 bits, fine enough for the dark end of 8-bit sRGB (20 steps each).
struct Half {
    width: u32,
    height: u32,
    texels: Vec<[u16; 4]>,
}

impl<'a> Pyramid<'a> {
    pub(super) fn new(texture: &'a Texture, cutout: bool) -> Pyramid<'a> {
        Pyramid { texture, cutout, halves: OnceLock::new() }
    }

    /// Makes the reduced images now.
    pub(super) fn prepare(&self, decode: &[f32; 256]) {
        self.halves.get_or_init(|| self.build(decode));
    }

    /// Texels of the full image.
    pub(super) fn area(&self) -> f32 {
        self.texture.width as f32 * self.texture.height as f32
    }

    /// Linear colour at `uv`; `level` is the base-2 logarithm of the width in texels of what one pixel sees.
    /// Bilinear in a level, linear between two.
    pub(super) fn color(&self, decode: &[f32; 256], uv: [f32; 2], level: f32) -> [f32; 3] {
        let texture = self.texture;
        let (width, height) = (texture.width, texture.height);
        if width == 0 || height == 0 || texture.pixels.len() < width as usize * height as usize {
            return [1.0; 3];
        }
        // NaN and negative levels (a magnified texture) both mean the full image.
        let level = if level.is_nan() { 0.0 } else { level.clamp(0.0, 31.0) };
        let full = || {
            self.bilinear(width, height, uv, |i| {
                let p = texture.pixels[i];
                [0, 1, 2, 3].map(|k| if k < 3 { decode[usize::from(p[k])] } else { f32::from(p[3]) / 255.0 })
            })
        };
        if level <= 0.0 {
            return full();
        }
        let halves = self.halves.get_or_init(|| self.build(decode));
        let half = |level: usize| {
            let Some(h) = halves.get(level - 1).or(halves.last()) else { return full() };
            self.bilinear(h.width, h.height, uv, |i| h.texels[i].map(|v| f32::from(v) / 65535.0))
        };
        let below = level as usize;
        let part = level - below as f32;
        let at = |level: usize| if level == 0 { full() } else { half(level) };
        // A level that is nearly whole needs no second look-up.
        match part {
            p if p < 0.1 => at(below),
            p if p > 0.9 => at(below + 1),
            p => mix(at(below), at(below + 1), p),
        }
    }

    fn bilinear(&self, width: u32, height: u32, uv: [f32; 2], texel: impl Fn(usize) -> [f32; 4]) -> [f32; 3] {
        let (x0, x1, fx) = neighbours(uv[0], width, self.texture.wrap[0]);
        let (y0, y1, fy) = neighbours(uv[1], height, self.texture.wrap[1]);
        let (row0, row1) = (y0 as usize * width as usize, y1 as usize * width as usize);
        let corners = [
            (row0 + x0 as usize, (1.0 - fx) * (1.0 - fy)),
            (row0 + x1 as usize, fx * (1.0 - fy)),
            (row1 + x0 as usize, (1.0 - fx) * fy),
            (row1 + x1 as usize, fx * fy),
        ];
        let (mut sum, mut weights) = ([0.0f32; 3], 0.0f32);
        for (index, share) in corners {
            let [r, g, b, alpha] = texel(index);
            let weight = if self.cutout { share * (alpha + 1e-3) } else { share };
            sum = [sum[0] + r * weight, sum[1] + g * weight, sum[2] + b * weight];
            weights += weight;
        }
        sum.map(|v| v / weights)
    }

    fn build(&self, decode: &[f32; 256]) -> Vec<Half> {
        let linear = decode.map(|v| (v * 65535.0 + 0.5) as u16);
        let Texture { width, height, pixels, .. } = self.texture;
        let mut halves = Vec::new();
        let complete = pixels.len() >= *width as usize * *height as usize;
        if complete && width.min(height) > &0 && width.max(height) > &1 {
            halves.push(self.halve(*width, *height, |i| {
                let p = pixels[i];
                [
                    linear[usize::from(p[0])],
                    linear[usize::from(p[1])],
                    linear[usize::from(p[2])],
                    u16::from(p[3]) * 257,
                ]
            }));
        }
        while let Some(last) = halves.last()
            && (last.width > 1 || last.height > 1)
        {
            let next = self.halve(last.width, last.height, |i| last.texels[i]);
            halves.push(next);
        }
        halves
    }

    /// Means of 2 x 2 texels. The last row or column of an odd size is left out: half a texel at a border that is
    /// seen from far away.
    fn halve(&self, width: u32, height: u32, texel: impl Fn(usize) -> [u16; 4]) -> Half {
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let (dx, dy) = (usize::from(width > 1), usize::from(height > 1) * width as usize);
        let mut texels = Vec::with_capacity(w as usize * h as usize);
        for y in 0..h as usize {
            for x in 0..w as usize {
                let i = 2 * y * width as usize + 2 * x;
                let four = [texel(i), texel(i + dx), texel(i + dy), texel(i + dx + dy)];
                let mean = |k: usize| {
                    if !self.cutout {
                        return (four.iter().map(|t| u32::from(t[k])).sum::<u32>() / 4) as u16;
                    }
                    let weight = four.map(|t| f32::from(t[3]) + 1.0);
                    let sum: f32 = (0..4).map(|j| f32::from(four[j][k]) * weight[j]).sum();
                    (sum / weight.iter().sum::<f32>()) as u16
                };
                let alpha = four.iter().map(|t| u32::from(t[3])).sum::<u32>() / 4;
                texels.push([mean(0), mean(1), mean(2), alpha as u16]);
            }
        }
        Half { width: w, height: h, texels }
    }
}

/// The two texels around coordinate `u` (0..=1 is the image), and how far it is from the first to the second.
fn neighbours(u: f32, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    let unit = match wrap {
        _ if u.is_nan() => 0.0,
        Wrap::Repeat => fraction(u),
        Wrap::Mirror => 1.0 - (fraction(u * 0.5) * 2.0 - 1.0).abs(),
        Wrap::Clamp => u.clamp(0.0, 1.0),
    };
    // One more, so that the cast rounds down: it is at least 0.5 now.
    let x = unit * size as f32 + 0.5;
    let above = x as u32;
    let last = size - 1;
    let (low, high) = match wrap {
        Wrap::Repeat => {
            (if above == 0 { last } else { (above - 1).min(last) }, if above > last { 0 } else { above })
        }
        _ => (above.saturating_sub(1).min(last), above.min(last)),
    };
    (low, high, x - above as f32)
}

/// `u - u.floor()` without a call into the mathematics library, which baseline x86-64 would make of `floor`. Of numbers
/// that are too large to have a fraction, 0.
fn fraction(u: f32) -> f32 {
    let f = u - (u as i32) as f32;
    match f < 0.0 {
        _ if !(-1.0..1.0).contains(&f) => 0.0,
        true => f + 1.0,
        false => f,
    }
}

#[cfg(test)]
mod tests {
    use super::super::encode::decode_table;
    use super::*;

    fn checker(wrap: Wrap) -> Texture {
        let pixels = (0..64).map(|i| if (i % 8 + i / 8) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] });
        Texture { name: String::new(), width: 8, height: 8, pixels: pixels.collect(), wrap: [wrap; 2] }
    }

    #[test]
    fn texel_centres_are_exact_and_far_views_are_the_mean() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let (texture, decode) = (checker(wrap), decode_table());
            let pyramid = Pyramid::new(&texture, false);
            assert_eq!(pyramid.color(&decode, [0.5 / 8.0, 0.5 / 8.0], 0.0), [1.0; 3]);
            assert_eq!(pyramid.color(&decode, [1.5 / 8.0, 0.5 / 8.0], f32::NAN), [0.0; 3]);
            for level in [1.0, 2.5, 9.0, f32::INFINITY] {
                let [r, ..] = pyramid.color(&decode, [0.3, 0.9], level);
                assert!((r - 0.5).abs() < 1e-3, "level {level}: {r}");
            }
        }
    }

    #[test]
    fn borders_wrap_as_told() {
        assert_eq!(neighbours(0.0, 8, Wrap::Repeat), (7, 0, 0.5));
        assert_eq!(neighbours(-0.25, 8, Wrap::Repeat).0, 5);
        assert_eq!(neighbours(-0.25, 8, Wrap::Mirror).0, 1);
        assert_eq!(neighbours(1.25, 8, Wrap::Mirror).0, 5);
        assert_eq!(neighbours(-3.0, 8, Wrap::Clamp), (0, 0, 0.5));
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for u in [f32::NAN, f32::INFINITY, -1e30, 3e38, 1.0, -1e-9] {
                let (a, b, _) = neighbours(u, 5, wrap);
                assert!(a < 5 && b < 5, "{u} {wrap:?}");
            }
        }
    }

    #[test]
    fn colours_of_holes_do_not_bleed() {
        let mut texture = checker(Wrap::Repeat);
        for p in &mut texture.pixels {
            p[3] = p[0];
        }
        let decode = decode_table();
        assert!(Pyramid::new(&texture, true).color(&decode, [0.5, 0.5], 3.0)[0] > 0.99);
        assert!(Pyramid::new(&texture, true).color(&decode, [0.5, 0.5], 0.0)[0] > 0.99);
    }
}
