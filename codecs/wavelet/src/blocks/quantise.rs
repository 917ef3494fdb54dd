//! Samples as integers of the transform, and coefficients as multiples of steps.

use cvr_core::volume::{SampleType, ValueRange};
use serde::{Deserialize, Serialize};

use super::lift::norms;
use super::shape::{Coefficients, KIND, for_places, levels};
use super::{Filter, Options};

/// Bits of a float's range. With them, no coefficient of either filter reaches 2^29.
const FLOAT_BITS: i32 = 22;
/// A coefficient counts from this fraction of a step on, in 256ths: dead zone. Tuned on bonsai.
const ROUNDING: i64 = 104;
/// Squared error, in squares of a step, that a bit must save. Tuned on bonsai.
pub const BIT_PRICE: f64 = 0.13;

/// How integers of the transform become values: rounded to `x / 2^fraction`, kept from `low` to `high`, then
/// `offset + unit · x`. The product is exact and so is the integer as a single, so every device rounds alike.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// Bits behind the point: none for floats and if all is kept.
    pub fraction: u32,
    /// Lowest integer.
    pub low: i32,
    /// Highest integer.
    pub high: i32,
    /// Value of integer 0.
    pub offset: f32,
    /// A power of two. Or a whole number, if integers may err.
    pub unit: f32,
}

impl Scale {
    /// For samples of this type and range. `exact` if integers shall be kept as they are.
    pub fn of(sample: SampleType, range: ValueRange, exact: bool) -> Self {
        if sample.is_integer() {
            let fraction = match (exact, sample.bits()) {
                (true, _) => 0,
                (false, 8) => 8,
                (false, _) => 6,
            };
            return Self { fraction, low: range.min as i32, high: range.max as i32, offset: 0.0, unit: 1.0 };
        }
        // A power of two of which the range holds at most 2^22; a normal number, so that no device flushes it.
        let bits = range.span().max(f64::MIN_POSITIVE).log2().ceil() as i32 - FLOAT_BITS;
        let unit = 2_f64.powi(bits.max(-126));
        // A multiple of the unit: values are 0 or at least a unit.
        let middle = 0.5 * (f64::from(range.min) + f64::from(range.max));
        let offset = if range.span() == 0.0 { range.min } else { ((middle / unit).round() * unit) as f32 };
        let of = |v: f32| (f64::from(v) - f64::from(offset)) / unit;
        // Both ends lie inside the range, so no value overflows.
        let (low, high) = (of(range.min).ceil() as i32, of(range.max).floor() as i32);
        Self { fraction: 0, low: low.min(high), high, offset, unit: unit as f32 }
    }

    /// For integers of this range that may err by so much: every `2 · error + 1`th integer is kept. The kept ones lie in
    /// the range.
    pub fn apart(range: ValueRange, error: i32) -> Self {
        let (span, unit) = ((range.max - range.min) as i32, 2 * error.min(1 << 16) + 1);
        let count = span / unit + 1;
        let first = range.min as i32 + unit / 2 - (count * unit - span - 1) / 2;
        Self { fraction: 0, low: 0, high: count - 1, offset: first as f32, unit: unit as f32 }
    }

    /// Whether values are finite and equal on every device.
    pub fn is_sound(&self) -> bool {
        let ends = [self.low, self.high];
        let power = self.unit.is_normal() && self.unit > 0.0 && self.unit.to_bits() & 0x7f_ffff == 0;
        let whole =
            self.unit >= 1.0 && self.unit.fract() == 0.0 && self.high as f32 * self.unit <= 16_777_216.0;
        self.fraction <= 8
            && self.low <= self.high
            && ends.iter().all(|end| end.unsigned_abs() <= 1 << 23)
            && (power || whole && self.low >= 0)
            && self.offset.is_finite()
            && ends.iter().all(|end| (*end as f32 * self.unit).is_finite() && self.value_of(*end).is_finite())
    }

    /// The integer of a sample.
    #[inline]
    pub fn integer(&self, sample: f32) -> i32 {
        let x = (f64::from(sample) - f64::from(self.offset)) / f64::from(self.unit);
        (x.round() as i32).clamp(self.low, self.high) << self.fraction
    }

    /// The value of an integer of the transform.
    #[inline]
    pub fn value(&self, x: i32) -> f32 {
        let half = (1 << self.fraction) >> 1;
        self.value_of((x.wrapping_add(half) >> self.fraction).clamp(self.low, self.high))
    }

    #[inline]
    fn value_of(&self, integer: i32) -> f32 {
        self.offset + self.unit * integer as f32
    }

    /// All values lie here.
    pub fn range(&self) -> ValueRange {
        ValueRange { min: self.value_of(self.low), max: self.value_of(self.high) }
    }
}

/// Steps of all coefficients, and how they are chosen from.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantiser {
    pub edge: usize,
    pub filter: Filter,
    pub scale: Scale,
    pub low_step: i32,
    /// Steps of each level and kind, the coarsest level first.
    pub steps: Vec<[i32; 3]>,
    /// Squared error, in squares of a step, that a bit must save. A place of coefficients of −1, 0 and 1 that are not worth
    /// their bits loses them.
    pub price: f64,
}

impl Quantiser {
    /// Steps that keep everything.
    pub fn exact(options: &Options, scale: Scale) -> Self {
        let edge = options.block as usize;
        let steps = vec![[1; 3]; levels(edge)];
        Self { edge, filter: options.filter, scale, low_step: 1, steps, price: 0.0 }
    }

    /// The steps of one error: each coefficient's is `step`, in integers of the transform, over how strongly it shows.
    /// So an error of a step is the same in all, if the transform were orthonormal.
    pub fn of_step(options: &Options, scale: Scale, step: f64, price: f64) -> Self {
        let edge = options.block as usize;
        let of = |norm: f64| (step / norm).round().clamp(1.0, f64::from(1 << 28)) as i32;
        let steps = (0..levels(edge)).map(|level| {
            let [low, high] = norms(options.filter, edge, levels(edge) - level);
            [1, 2, 3].map(|kind| of(low.powi(3 - kind) * high.powi(kind)))
        });
        let steps = steps.collect();
        let [low, _] = norms(options.filter, edge, levels(edge));
        Self { edge, filter: options.filter, scale, low_step: of(low.powi(3)), steps, price }
    }

    /// Quantises a transformed block.
    pub fn quantise(&self, block: &[i32], out: &mut Coefficients) {
        out.high.clear();
        out.high.resize(Coefficients::places(self.edge), [0; 7]);
        // The mean shows over the whole block: it is rounded to nearest.
        out.low = rounded(block[0], self.low_step, 128);
        for_places(self.edge, |number, level, at| {
            let place = &mut out.high[number];
            let steps = &self.steps[level];
            let mut most = 0;
            for ((q, at), kind) in place.iter_mut().zip(at).zip(KIND) {
                *q = rounded(block[at], steps[kind], ROUNDING);
                most = most.max(q.unsigned_abs());
            }
            if most == 1
                && self.price > 0.0
                && value_of_bits(place, |slot| block[at[slot]], steps) <= self.price
            {
                *place = [0; 7];
            }
        });
    }

    /// The transformed block of quantised coefficients.
    pub fn restore(&self, coefficients: &Coefficients, block: &mut [i32]) {
        block[0] = coefficients.low.wrapping_mul(self.low_step);
        for_places(self.edge, |number, level, at| {
            for ((at, q), kind) in at.into_iter().zip(coefficients.high[number]).zip(KIND) {
                block[at] = q.wrapping_mul(self.steps[level][kind]);
            }
        });
    }
}

/// A coefficient in steps. It counts upwards from `256 − rounding` 256ths of a step.
#[inline]
const fn rounded(c: i32, step: i32, rounding: i64) -> i32 {
    if step == 1 {
        return c;
    }
    let bias = ((step as i64 * rounding) >> 8) as u32;
    let q = ((c.unsigned_abs() + bias) / step as u32) as i32;
    if c < 0 { -q } else { q }
}

/// Squared error that each bit of coefficients of −1, 0 and 1 saves, in squares of a step.
fn value_of_bits(place: &[i32; 7], coefficient: impl Fn(usize) -> i32, steps: &[i32; 3]) -> f64 {
    let (mut saved, mut bits) = (0.0, 7.0);
    for (slot, _) in place.iter().enumerate().filter(|(_, q)| **q != 0) {
        let size = f64::from(coefficient(slot).unsigned_abs()) / f64::from(steps[KIND[slot]]);
        saved += 2.0 * size - 1.0;
        bits += 1.0;
    }
    saved / bits
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(min: f32, max: f32) -> Scale {
        Scale::of(SampleType::F32, ValueRange { min, max }, false)
    }

    #[test]
    fn every_range_of_floats_has_a_sound_scale() {
        let tiny = f32::MIN_POSITIVE;
        for (min, max) in [
            (f32::MIN, f32::MAX),
            (0.0, f32::MAX),
            (0.0, 0.0),
            (tiny, tiny),
            (tiny, 64.0 * tiny),
            (-tiny, 3.0 * tiny),
            (f32::MAX, f32::MAX),
            (16_777_214.0, 16_777_218.0),
            (-1000.0, 1000.0),
            (1e-30, 2.5),
        ] {
            let scale = of(min, max);
            assert!(scale.is_sound(), "{min} {max}: {scale:?}");
            let (range, unit) = (scale.range(), f64::from(scale.unit));
            let inside = f64::from(range.min) >= f64::from(min) - unit
                && f64::from(range.max) <= f64::from(max) + unit;
            assert!(inside, "{min} {max}: {range:?}");
            for sample in [min, max, 0.5 * min + 0.5 * max] {
                let error = (f64::from(scale.value(scale.integer(sample))) - f64::from(sample)).abs();
                let rounding = f64::from(sample.abs() * f32::EPSILON);
                assert!(error <= f64::from(scale.unit) + rounding, "{min} {max} {sample}: {error}");
            }
        }
        assert_eq!(of(7.25, 7.25).value(0), 7.25);
    }

    #[test]
    fn integers_are_kept_with_and_without_a_fraction() {
        for exact in [true, false] {
            let scale = Scale::of(SampleType::I16, ValueRange { min: -32768.0, max: 32767.0 }, exact);
            for sample in [-32768.0, -1.0, 0.0, 32767.0] {
                assert_eq!(scale.value(scale.integer(sample)), sample);
            }
            assert!(scale.is_sound());
        }
    }

    #[test]
    fn integers_that_may_err_are_kept_inside_their_range() {
        for (min, max) in [(0.0, 255.0), (-32768.0, 32767.0), (3.0, 3.0), (0.0, 1.0), (-5.0, 6.0)] {
            for error in [1, 2, 7, 127, 1 << 20] {
                let range = ValueRange { min, max };
                let scale = Scale::apart(range, error);
                assert!(scale.is_sound(), "{scale:?}");
                assert!(range.contains(scale.range().min) && range.contains(scale.range().max), "{scale:?}");
                for sample in min as i32..=max as i32 {
                    let decoded = scale.value(scale.integer(sample as f32)) as i32;
                    assert!((decoded - sample).abs() <= error, "{sample} {decoded} {scale:?}");
                }
            }
        }
    }

    #[test]
    fn a_coefficient_counts_from_the_dead_zone_on() {
        assert_eq!([59, 60, 61, 159, 160, -61, -59].map(|c| rounded(c, 100, 104)), [0, 1, 1, 1, 2, -1, 0]);
        assert_eq!(rounded(i32::MIN / 4, 1, 104), i32::MIN / 4);
    }
}
