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

/// Where there is no sample. Not a colour of the ramp.
const BACKGROUND: [u8; 3] = [56, 56, 56];

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
    pub(crate) fn new(numbers: &[f32], scale: Scale) -> Legend {
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
        let above = known.iter().filter(|v| **v > end).count();
        Legend { range: [0.0, end], max, mean, above }
    }

    /// The colour of a number that is not NaN.
    pub(crate) fn color(&self, number: f32) -> [u8; 3] {
        let [from, to] = self.range;
        let share = if to > from { ((number - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        let color = colorous::VIRIDIS.eval_continuous(f64::from(share));
        [color.r, color.g, color.b]
    }

    /// sRGB pixels, the greys of `picture` shining through.
    pub(crate) fn paint(&self, numbers: &[f32], picture: &[[u8; 3]]) -> Vec<[u8; 3]> {
        let paint = |(number, [r, g, b]): (&f32, &[u8; 3])| {
            if number.is_nan() {
                return BACKGROUND;
            }
            let grey = 0.299 * f32::from(*r) + 0.587 * f32::from(*g) + 0.114 * f32::from(*b);
            self.color(*number).map(|c| (f32::from(c) + SHINE * (grey - f32::from(c))).round() as u8)
        };
        numbers.iter().zip(picture).map(paint).collect()
    }
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
        let amount = Legend::new(&numbers, Scale::Amount);
        assert_eq!((amount.range, amount.max, amount.above), ([0.0, 9.0], 700.0, 5));
        let label = Legend::new(&numbers, Scale::Label);
        assert_eq!((label.range, label.above), ([0.0, 700.0], 0));
        assert!((label.mean - (9979.0 + 15.0 * 9.0 - 15.0 + 5.0 * 700.0 - 5.0 + 20.0) / 9999.0).abs() < 0.01);
        // Rare numbers among zeros are what there is to see.
        let mut rare = vec![0.0; 10_000];
        rare[7] = 3.0;
        assert_eq!(Legend::new(&rare, Scale::Amount).range, [0.0, 3.0]);
        for nothing in [&[][..], &[f32::NAN], &[0.0, 0.0]] {
            let legend = Legend::new(nothing, Scale::Amount);
            assert_eq!((legend.range, legend.mean, legend.above), ([0.0, 0.0], 0.0, 0));
        }
    }

    #[test]
    fn colours_run_from_dark_to_light_and_the_background_is_grey() {
        let legend = Legend { range: [0.0, 8.0], max: 90.0, mean: 1.0, above: 1 };
        let light = |c: [u8; 3]| c.iter().map(|v| u32::from(*v)).sum::<u32>();
        let colors: Vec<_> = (0..=8).map(|i| legend.color(i as f32)).collect();
        assert!(colors.windows(2).all(|pair| light(pair[0]) < light(pair[1])), "{colors:?}");
        assert_eq!(legend.color(90.0), legend.color(8.0));
        assert_eq!((colors[0], colors[8]), ([68, 1, 84], [253, 231, 37]));
        let painted = legend.paint(&[f32::NAN, 0.0, 0.0], &[[9; 3], [0; 3], [255; 3]]);
        assert_eq!(painted[0], BACKGROUND);
        assert!(light(painted[1]) < light(painted[2]));
    }
}
