//! Conversion between data and codes.

use cvr_core::volume::{SampleType, ValueRange};
use serde::{Deserialize, Serialize};

use crate::block::{PARTS, TOP};

/// The decode parameters in the container.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Values of the codes 0 and 255.
    pub range: ValueRange,
}

/// Smallest step between two codes of wide samples: 2^-100. With a smaller one, a device that flushes subnormals would
/// lose whole steps.
const SMALLEST_STEP: f64 = 1.0 / (1_u128 << 100) as f64;

/// A range over which codes can be spread.
///
/// # Errors
/// A sentence, when it overflows single precision or its steps are too small.
pub fn checked(range: ValueRange) -> Result<ValueRange, String> {
    let ValueRange { min, max } = range;
    if !(max - min).is_finite() {
        return Err(format!("the range {min} to {max} overflows single precision; scale the volume"));
    }
    if max > min && range.span() / 255.0 < SMALLEST_STEP {
        return Err(format!(
            "a 255th of the range {min} to {max} is too small for single precision on a device (less than 2^-100); \
             scale the volume"
        ));
    }
    Ok(range)
}

/// Conversion of codes to values: `min(offset + step · code, high)`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Scale {
    /// Value of code 0, in data units.
    pub offset: f32,
    /// Data units per code. 0 if the volume has a single value.
    pub step: f32,
    /// No value exceeds this.
    pub high: f32,
}

impl Scale {
    /// The scale that maps codes 0 and 255 to the ends of a range.
    #[must_use]
    pub fn over(range: ValueRange) -> Self {
        Self { offset: range.min, step: (range.span() / 255.0) as f32, high: range.max }
    }

    /// The range in which samples of 8 bits are their own codes. `None` for other types, which use the volume's range.
    #[must_use]
    pub fn native(sample: SampleType) -> Option<ValueRange> {
        let (low, high) = sample.integer_range().filter(|(low, high)| high - low == 255)?;
        Some(ValueRange { min: low as f32, max: high as f32 })
    }

    /// The level nearest to a value, in parts of a code.
    #[must_use]
    pub fn level(&self, value: f32) -> i16 {
        let span = f64::from(self.high) - f64::from(self.offset);
        if span <= 0.0 {
            return 0;
        }
        let share = (f64::from(value) - f64::from(self.offset)) / span;
        (share * 255.0 * f64::from(PARTS)).round().clamp(0.0, f64::from(TOP)) as i16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_8_bits_are_their_own_codes() {
        for (sample, offset) in [(SampleType::U8, 0.0), (SampleType::I8, -128.0)] {
            let scale = Scale::over(Scale::native(sample).unwrap());
            assert_eq!((scale.offset, scale.step, scale.high), (offset, 1.0, offset + 255.0));
            for code in 0..=255_i16 {
                assert_eq!(scale.level(f32::from(code) + offset), code * PARTS as i16);
            }
        }
        for sample in [SampleType::U16, SampleType::I16, SampleType::F32] {
            assert_eq!(Scale::native(sample), None);
        }
    }

    #[test]
    fn a_volume_of_one_value_has_one_level() {
        let scale = Scale::over(ValueRange { min: 3.5, max: 3.5 });
        assert_eq!((scale.level(3.5), scale.step), (0, 0.0));
    }
}
