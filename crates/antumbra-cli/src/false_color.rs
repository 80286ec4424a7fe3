//! Numbers to colours: the pictures of `--debug`.
//!
//! The ramp is viridis (Smith and van der Walt 2015): equal steps of a number look equally large, it grows lighter from
//! end to end, so it survives grey printers, and it can be told apart by the colour-blind.

use antumbra::methods::Scale;
use serde::Serialize;

/// Amounts are cut off above this percentile: a handful of samples with a hundred times the work of all others would
/// leave the rest of the picture dark.
pub(crate) const PERCENTILE: f64 = 99.9;

/// How much of a pixel is the shaded picture: enough to recognise the scene, too little to be taken for a number.
const SHINE: f32 = 0.2;

/// Steps of the ramp and of the greys that shine through: together with the background they fit a palette of 256, which
/// makes files a third as large.
const STEPS: usize = 42;
const GREYS: usize = 6;

/// Where there is no sample. Not a colour of the ramp.
const BACKGROUND: [u8; 3] = [56, 56, 56];

/// A picture with a palette.
pub(crate) struct Painting {
    pub(crate) palette: Vec<[u8; 3]>,
    pub(crate) pixels: Vec<u8>,
}

/// What the colours of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Legend {
    /// The number of the first colour and of the last.
    pub(crate) range: [f32; 2],
    pub(crate) max: f32,
    pub(crate) mean: f64,
    /// Samples above the range.
    pub(crate) above: usize,
}

impl Legend {
    /// From 0 to the percentile, or to the largest number of labels. Where that is 0 although there are larger numbers, the
    /// few that are there are what the picture is about: the largest then.
    /// `told` overrules all that.
    pub(crate) fn new(numbers: &[f32], scale: Scale, told: Option<f32>) -> Legend {
        let mut known: Vec<f32> = numbers.iter().copied().filter(|v| !v.is_nan()).collect();
        let max = known.iter().copied().fold(0.0, f32::max);
        let mean = known.iter().map(|v| f64::from(*v)).sum::<f64>() / known.len().max(1) as f64;
        let mut end = max;
        if scale == Scale::Amount && !known.is_empty() {
            // The smallest number that at least so many do not exceed.
            let rank = (known.len() as f64 * PERCENTILE / 100.0).ceil() as usize;
            let rank = rank.clamp(1, known.len()) - 1;
            let (_, value, _) = known.select_nth_unstable_by(rank, f32::total_cmp);
            end = if *value > 0.0 { *value } else { max };
        }
        let end = told.unwrap_or(end);
        let above = known.iter().filter(|v| **v > end).count();
        Legend { range: [0.0, end], max, mean, above }
    }

    /// The step of the ramp for a number that is not NaN.
    fn step(&self, number: f32) -> usize {
        let [from, to] = self.range;
        let share = if to > from { ((number - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        (share * (STEPS - 1) as f32).round() as usize
    }

    /// The colours of the numbers, the greys of `picture` (sRGB) shining through.
    pub(crate) fn paint(&self, numbers: &[f32], picture: &[[u8; 3]]) -> Painting {
        let place = |(number, [r, g, b]): (&f32, &[u8; 3])| {
            if number.is_nan() {
                return (STEPS * GREYS) as u8;
            }
            let grey = 0.299 * f32::from(*r) + 0.587 * f32::from(*g) + 0.114 * f32::from(*b);
            let grey = (grey / 255.0 * (GREYS - 1) as f32).round() as usize;
            (self.step(*number) * GREYS + grey.min(GREYS - 1)) as u8
        };
        Painting { palette: palette(), pixels: numbers.iter().zip(picture).map(place).collect() }
    }
}

/// By step of the ramp, then by grey; the background at the end.
fn palette() -> Vec<[u8; 3]> {
    let mut colors = Vec::with_capacity(STEPS * GREYS + 1);
    for step in 0..STEPS {
        let c = colorous::VIRIDIS.eval_continuous(step as f64 / (STEPS - 1) as f64);
        for grey in 0..GREYS {
            let grey = grey as f32 / (GREYS - 1) as f32 * 255.0;
            colors
                .push([c.r, c.g, c.b].map(|v| (f32::from(v) + SHINE * (grey - f32::from(v))).round() as u8));
        }
    }
    colors.push(BACKGROUND);
    colors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_cut_off_and_labels_are_not() {
        let mut numbers = vec![1.0; 10_000];
        numbers[..5].fill(700.0);
        numbers[5..20].fill(9.0);
        numbers[20] = f32::NAN;
        let amount = Legend::new(&numbers, Scale::Amount, None);
        assert_eq!((amount.range, amount.max, amount.above), ([0.0, 9.0], 700.0, 5));
        let label = Legend::new(&numbers, Scale::Label, None);
        assert_eq!((label.range, label.above), ([0.0, 700.0], 0));
        assert!((label.mean - (9979.0 + 15.0 * 9.0 - 15.0 + 5.0 * 700.0 - 5.0 + 20.0) / 9999.0).abs() < 0.01);
        // Rare numbers among zeros are what there is to see.
        let mut rare = vec![0.0; 10_000];
        rare[7] = 3.0;
        assert_eq!(Legend::new(&rare, Scale::Amount, None).range, [0.0, 3.0]);
        for nothing in [&[][..], &[f32::NAN], &[0.0, 0.0]] {
            let legend = Legend::new(nothing, Scale::Amount, None);
            assert_eq!((legend.range, legend.mean, legend.above), ([0.0, 0.0], 0.0, 0));
        }
    }

    #[test]
    fn colours_run_from_dark_to_light_and_the_background_is_grey() {
        let legend = Legend { range: [0.0, 8.0], max: 90.0, mean: 1.0, above: 1 };
        let numbers: Vec<f32> = (0..=8).map(|i| i as f32).chain([90.0, f32::NAN]).collect();
        let paint = |grey: u8| {
            let Painting { palette, pixels } = legend.paint(&numbers, &[[grey; 3]; 11]);
            assert!(palette.len() <= 256);
            pixels.iter().map(|p| palette[usize::from(*p)]).collect::<Vec<_>>()
        };
        let light = |c: [u8; 3]| c.iter().map(|v| u32::from(*v)).sum::<u32>();
        let (dark, bright) = (paint(0), paint(255));
        for colors in [&dark, &bright] {
            assert!(colors[..9].windows(2).all(|pair| light(pair[0]) < light(pair[1])), "{colors:?}");
            assert_eq!((colors[9], colors[10]), (colors[8], BACKGROUND));
        }
        assert!((0..10).all(|i| light(dark[i]) < light(bright[i])));
        // Four fifths of the ends of viridis, (68, 1, 84) and (253, 231, 37).
        assert_eq!((dark[0], dark[8]), ([54, 1, 67], [202, 185, 30]));
    }

    #[test]
    fn a_range_that_is_told_is_kept() {
        let legend = Legend::new(&[1.0, 5.0, 9.0, f32::NAN], Scale::Amount, Some(4.0));
        assert_eq!((legend.range, legend.max, legend.above), ([0.0, 4.0], 9.0, 2));
    }
}
