//! A histogram in one line of text.

use cvr_core::volume::{Samples, ValueRange};
use rayon::prelude::*;

/// Bars of the line.
const BARS: usize = 48;
const HEIGHTS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Frequencies of the values in each part of `range`, as bars. Heights are logarithmic, so rare values are visible. A
/// part without a value is a space.
pub fn bars(samples: &Samples, range: ValueRange) -> String {
    let span = range.span().max(f64::MIN_POSITIVE);
    let bar = |v: f32| {
        let at = (f64::from(v) - f64::from(range.min)) / span * BARS as f64;
        (at as usize).min(BARS - 1)
    };
    let counts = (0..samples.len())
        .into_par_iter()
        .with_min_len(1 << 16)
        .fold(
            || [0_u64; BARS],
            |mut counts, i| {
                counts[bar(samples.get(i))] += 1;
                counts
            },
        )
        .reduce(
            || [0; BARS],
            |mut a, b| {
                a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                a
            },
        );
    let height = |n: u64| ((n as f64) + 1.0).ln();
    let highest = height(counts.into_iter().max().unwrap_or(0)).max(f64::MIN_POSITIVE);
    let bar = |n: u64| match n {
        0 => ' ',
        n => HEIGHTS[((height(n) / highest * HEIGHTS.len() as f64).ceil() as usize).clamp(1, 8) - 1],
    };
    counts.into_iter().map(bar).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(values: &[f32]) -> String {
        let range = ValueRange::of(values.iter().copied()).unwrap();
        bars(&Samples::F32(values.to_vec()), range)
    }

    #[test]
    fn bars_stand_where_values_are() {
        let text = drawn(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 48.0, 24.5]);
        let bars: Vec<char> = text.chars().collect();
        assert_eq!((bars.len(), bars[0], bars[47], bars[24]), (48, '█', '▃', '▃'));
        assert_eq!(bars.iter().filter(|c| **c == ' ').count(), 45);
        assert_eq!(drawn(&[7.0, 7.0]).trim_end(), "█", "a volume of one value");
        assert_eq!(drawn(&[f32::MIN, f32::MAX]).chars().filter(|c| *c == '█').count(), 2);
    }
}
