//! Low end, step and numbers of an escape that leave the least squared error of what is left of a block.

use crate::escape::{Escape, most_exponent};
use crate::scale::Scale;
use crate::{MOST_BITS, VOXELS};

/// Rounds of least squares, each with the numbers of the round before.
const ROUNDS: usize = 3;

/// What is left of a block, in units of sums, and the voxels that count.
#[derive(Copy, Clone, Debug)]
pub struct Rest<'a> {
    /// One value for each voxel.
    pub values: &'a [f32],
    /// Voxels inside the volume.
    pub inside: &'a [bool],
    range: [f64; 2],
}

impl<'a> Rest<'a> {
    /// What is left of a block.
    #[must_use]
    pub fn of(values: &'a [f32], inside: &'a [bool]) -> Self {
        let range = values.iter().zip(inside).filter(|(_, inside)| **inside);
        let range = range.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (v, _)| {
            [low.min(f64::from(*v)), high.max(f64::from(*v))]
        });
        Self { values, inside, range }
    }

    /// Distance of the least value and the greatest.
    #[must_use]
    pub fn span(&self) -> f64 {
        (self.range[1] - self.range[0]).max(0.0)
    }

    /// The escape in so many bits that leaves about the least squared error: a uniform quantiser whose low end and step fit by
    /// least squares (Lloyd 1982, with uniform levels).
    #[must_use]
    pub fn fit(&self, bits: u32) -> Escape {
        debug_assert!((1..=MOST_BITS).contains(&bits));
        let levels = f64::from(1_u32 << bits);
        let mut step = self.span() / levels;
        let mut low = self.range[0] + 0.5 * step;
        let mut numbers = [0.0; VOXELS];
        // With more levels there is nothing to gain: they are about as dense as the values.
        for _ in 0..if bits <= 6 { ROUNDS } else { 0 } {
            self.number(low, step, levels, &mut numbers);
            let Some(fitted) = self.least_squares(&numbers) else { break };
            (low, step) = fitted;
        }
        self.of_step(bits, Scale::nearest(step, most_exponent(bits)), low)
    }

    /// The escape in so many bits of a given step, with a low end near `low`.
    #[must_use]
    pub fn of_step(&self, bits: u32, step: Scale, low: f64) -> Escape {
        let (levels, units) = (f64::from(1_u32 << bits), f64::from(step.units()));
        let mut numbers = [0.0; VOXELS];
        self.number(low, units, levels, &mut numbers);
        let (mut sum, mut count) = (0.0, 0.0);
        for (v, n) in self.counted(&numbers) {
            sum += v - units * n;
            count += 1.0;
        }
        let [least, most] = Escape::LOWS.map(f64::from);
        let low = (sum / f64::max(count, 1.0)).round().clamp(least, most);
        self.number(low, units, levels, &mut numbers);
        Escape { bits, low: low as i32, step, numbers: numbers.map(|n| n as u16) }
    }

    /// The escape whose step is `step` and whose numbers begin at the least value, where so many bits reach the greatest.
    #[must_use]
    pub fn covering(&self, bits: u32, step: Scale) -> Option<Escape> {
        let units = f64::from(step.units());
        let levels = f64::from(1_u32 << bits);
        let reaches = (self.span() / units).round() < levels && step.exponent() <= most_exponent(bits);
        reaches.then(|| {
            let low = self.range[0].round();
            let mut numbers = [0.0; VOXELS];
            self.number(low, units, levels, &mut numbers);
            Escape { bits, low: low as i32, step, numbers: numbers.map(|n| n as u16) }
        })
    }

    /// The better of the escape that fits, and of the one whose step is `exact`, by the squared error that `error` finds.
    #[must_use]
    pub fn nearest(&self, bits: u32, exact: Option<Scale>, error: impl Fn(&Escape) -> f32) -> (Escape, f32) {
        let measured = |escape: Escape| {
            let error = error(&escape);
            (escape, error)
        };
        let fitted = measured(self.fit(bits));
        match exact.and_then(|exact| self.covering(bits, exact)).map(measured) {
            Some(covering) if covering.1 < fitted.1 => covering,
            _ => fitted,
        }
    }

    fn counted<'n>(&'n self, numbers: &'n [f64; VOXELS]) -> impl Iterator<Item = (f64, f64)> {
        let all = self.values.iter().zip(self.inside).zip(numbers);
        all.filter(|((_, inside), _)| **inside).map(|((v, _), n)| (f64::from(*v), *n))
    }

    /// The nearest number of each voxel; 0 outside the volume.
    fn number(&self, low: f64, step: f64, levels: f64, numbers: &mut [f64; VOXELS]) {
        let scale = if step > 0.0 { 1.0 / step } else { 0.0 };
        for ((v, inside), n) in self.values.iter().zip(self.inside).zip(numbers) {
            let near = ((f64::from(*v) - low) * scale).round().clamp(0.0, levels - 1.0);
            *n = if *inside { near } else { 0.0 };
        }
    }

    /// Low end and step of least squared error for given numbers; none where all are equal.
    fn least_squares(&self, numbers: &[f64; VOXELS]) -> Option<(f64, f64)> {
        let mut sums = [0.0; 5];
        for (v, n) in self.counted(numbers) {
            let terms = [1.0, v, n, v * n, n * n];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let [count, values, numbers, products, squares] = sums;
        let spread = count * squares - numbers * numbers;
        if spread <= 0.0 {
            return None;
        }
        let step = (count * products - values * numbers) / spread;
        (step > 0.0).then(|| ((values - step * numbers) / count, step))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(escape: &Escape, values: &[f32]) -> f64 {
        let shown = |n: u16| f64::from(escape.low) + f64::from(escape.step.units()) * f64::from(n);
        values.iter().zip(escape.numbers).map(|(v, n)| (f64::from(*v) - shown(n)).powi(2)).sum()
    }

    /// Values as of a normal distribution: sums of hashes.
    fn normal() -> Vec<f32> {
        let hash = |i: u32| i.wrapping_mul(0x9e37_79b9).rotate_left(15).wrapping_mul(0x85eb_ca6b) >> 16;
        (0..64).map(|i| (0..12).map(|j| hash(i * 12 + j + 1) as f32).sum::<f32>() - 6.0 * 65536.0).collect()
    }

    /// One bit leaves about 0.36 of a normal distribution's variance, two 0.12 (Max 1960).
    #[test]
    fn few_bits_leave_what_the_best_uniform_quantiser_does() {
        let values = normal();
        let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / 64.0;
        let variance: f64 = values.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum();
        let rest = Rest::of(&values, &[true; 64]);
        let mut before = variance;
        for (bits, most) in [(1, 0.42), (2, 0.14), (3, 0.05), (4, 0.015), (8, 1e-4)] {
            let left = error(&rest.fit(bits), &values);
            assert!(left < most * variance && left < before, "{bits} bits: {}", left / variance);
            before = left;
        }
    }

    #[test]
    fn multiples_of_a_step_come_back_in_as_many_bits_as_they_need() {
        let values: Vec<f32> = (0..64).map(|i| (i * i % 13) as f32 * 256.0 - 700.0).collect();
        let rest = Rest::of(&values, &[true; 64]);
        let step = Scale::of_byte(8);
        assert_eq!(step.units(), 256);
        assert_eq!(rest.covering(3, step), None);
        assert_eq!(error(&rest.covering(4, step).unwrap(), &values), 0.0);
    }

    #[test]
    fn voxels_outside_do_not_count() {
        let mut values = vec![5.0_f32; 64];
        values[9] = 1e6;
        let inside = std::array::from_fn::<bool, 64, _>(|i| i != 9);
        let escape = Rest::of(&values, &inside).fit(1);
        assert_eq!((escape.low, escape.numbers[9], escape.numbers[8]), (5, 0, 0));
    }
}
