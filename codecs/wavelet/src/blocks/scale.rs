//! Samples as integers of the transform, and back.

use cvr_core::volume::{SampleType, ValueRange};
use serde::{Deserialize, Serialize};

/// Bits of a float's range. With them, no coefficient of either filter reaches 2^29.
const FLOAT_BITS: i32 = 22;

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
        // A power of two. The range holds at most 2^22 of it. It is a normal number, so no device flushes it.
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
}
