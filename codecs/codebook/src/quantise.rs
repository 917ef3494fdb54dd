//! Storage of codewords: a code of 8 or 16 bits per component, with one offset and step per codebook.

use cvr_core::codec::{Agreement, DecodedForm, TexelFormat};
use cvr_core::volume::ValueRange;
use cvr_groups::Scale;

/// Smallest step: 2^-100. With a smaller one, values come near the subnormals, which a device may flush.
const SMALLEST_STEP: f64 = 1.0 / (1_u128 << 100) as f64;

/// `value = offset + step · code`.
///
/// The step has at most 24 − `bits` significant bits. So the product is exact in single precision, and the sum is
/// rounded once. A fused multiply-add gives the same number.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Quantiser {
    bits: u32,
    offset: f32,
    step: f32,
    top: u32,
}

impl Quantiser {
    /// Codes of `bits` (8 or 16) bits over `range`. For `integers` the step is a power of two if the range allows it
    /// without loss, so every integer of the range has its own code.
    ///
    /// # Errors
    /// A sentence, when the range overflows single precision or its steps would lie below 2^-100.
    ///
    /// # Panics
    /// When `bits` is neither 8 nor 16, or the range is not finite and ordered.
    pub fn over(range: ValueRange, bits: u32, integers: bool) -> Result<Self, String> {
        let ValueRange { min, max } = range;
        assert!(matches!(bits, 8 | 16), "codewords of {bits} bits");
        assert!(min.is_finite() && max.is_finite() && min <= max, "{min} to {max} is no range");
        let (span, levels) = (range.span(), f64::from((1_u32 << bits) - 1));
        let step = if span == 0.0 {
            1.0
        } else if integers && span <= levels {
            power_of_two(exponent(levels / span)).recip()
        } else {
            let ideal = span / levels;
            let unit = power_of_two(exponent(ideal) - (24 - bits as i32 - 1));
            (ideal / unit).ceil() * unit
        };
        if !((step * levels) as f32).is_finite() {
            return Err(format!("the range {min} to {max} overflows single precision; scale the volume"));
        }
        if step < SMALLEST_STEP {
            let levels = levels as u32;
            return Err(format!(
                "a {levels}th of the range {min} to {max} is too small for single precision on a device (less than \
                 2^-100); scale the volume"
            ));
        }
        let mut quantiser = Self { bits, offset: min, step: step as f32, top: (span / step).ceil() as u32 };
        if !quantiser.value(quantiser.top).is_finite() {
            quantiser.top -= 1;
        }
        Ok(quantiser)
    }

    /// Of entries that are added up as integers: codes of `bits` bits that reach up to `largest`, in units of the sums, and
    /// whose middle code is 0. With it comes the scale that they count in.
    ///
    /// # Panics
    /// When `bits` is neither 8 nor 16.
    #[must_use]
    #[allow(clippy::unwrap_used, reason = "an integer below 2^11 is a step")]
    pub fn of_entries(bits: u32, largest: f64) -> (Self, Scale) {
        let scale = Scale::reaching(bits, largest);
        let unit = scale.units() as f32;
        (Self::of_stream(bits, -unit * (1_u32 << (bits - 1)) as f32, unit).unwrap(), scale)
    }

    /// From the parameters of a stream. `None` if offset, step or width are invalid.
    #[must_use]
    pub fn of_stream(bits: u32, offset: f32, step: f32) -> Option<Self> {
        let normal = offset.is_finite() && !offset.is_subnormal() && step.is_normal() && step > 0.0;
        if !matches!(bits, 8 | 16) || !normal {
            return None;
        }
        let quantiser = Self { bits, offset, step, top: (1 << bits) - 1 };
        (step * quantiser.top as f32).is_finite().then_some(quantiser)
    }

    /// Bits of a code: 8 or 16.
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.bits
    }

    /// Value of code 0.
    #[must_use]
    pub const fn offset(self) -> f32 {
        self.offset
    }

    /// Data units per code.
    #[must_use]
    pub const fn step(self) -> f32 {
        self.step
    }

    /// Distance from the value of code 0 to that of the largest code, in data units.
    #[must_use]
    pub fn span(self) -> f32 {
        self.step * ((1_u32 << self.bits) - 1) as f32
    }

    /// The code whose value is nearest.
    #[must_use]
    pub fn code(self, value: f64) -> u16 {
        let code = ((value - f64::from(self.offset)) / f64::from(self.step)).round();
        code.clamp(0.0, f64::from(self.top)) as u16
    }

    /// Value of a code: the only floating-point expression of decoding.
    #[must_use]
    #[inline]
    pub fn value(self, code: u32) -> f32 {
        self.offset + self.step * code as f32
    }

    /// Whether single precision holds every value without rounding, as for integers.
    #[must_use]
    pub fn is_exact(self) -> bool {
        let exact = |code| f64::from(self.offset) + f64::from(self.step) * f64::from(code);
        (0..1 << self.bits).all(|code: u32| f64::from(self.value(code)) == exact(code))
    }

    /// The texel format for decoded values that are values of codes. The texel is the code.
    #[must_use]
    pub fn decoded_form(self) -> DecodedForm {
        let format = if self.bits == 8 { TexelFormat::Unorm8 } else { TexelFormat::Unorm16 };
        DecodedForm { format, scale: self.span(), offset: self.offset }
    }

    /// How closely a shader follows [`Quantiser::value`]. The product is exact and the sum rounded once, so a fused
    /// multiply-add changes nothing. If values are rounded, a texel with the code is decoded by another sum and may
    /// give the neighbouring number.
    #[must_use]
    pub fn agreement(self) -> Agreement {
        if self.is_exact() { Agreement::Exact } else { Agreement::Ulp(1) }
    }
}

/// Exponent of a positive, normal number: the largest `e` with 2^e ≤ `x`.
fn exponent(x: f64) -> i32 {
    ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// 2^`e`, for the exponents of singles and their fractions.
fn power_of_two(e: i32) -> f64 {
    2_f64.powi(e)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over(min: f32, max: f32, bits: u32, integers: bool) -> Quantiser {
        Quantiser::over(ValueRange { min, max }, bits, integers).unwrap()
    }

    #[test]
    fn integers_have_codes_of_their_own() {
        for (min, max, bits, step) in [
            (0.0, 255.0, 8, 1.0),
            (-128.0, 127.0, 8, 1.0),
            (10.0, 110.0, 8, 0.5),
            (0.0, 255.0, 16, 1.0 / 256.0),
        ] {
            let q = over(min, max, bits, true);
            assert_eq!(q.step(), step, "{min} to {max} in {bits} bits");
            assert!(q.is_exact());
            for v in min as i32..=max as i32 {
                assert_eq!(q.value(q.code(f64::from(v)).into()), v as f32);
            }
        }
        assert_eq!(over(-32768.0, 32767.0, 16, true).step(), 1.0);
    }

    #[test]
    fn products_are_exact_and_the_range_is_covered() {
        for (min, max) in
            [(-0.37_f32, 19.3), (1e-20, 3e-20), (-5e37, 9e37), (0.0, 65535.0), (1e6, 1_000_001.0)]
        {
            for bits in [8, 16] {
                let q = over(min, max, bits, false);
                for code in 0..1_u32 << bits {
                    assert_eq!(f64::from(q.step() * code as f32), f64::from(q.step()) * f64::from(code));
                    let fused = q.step().mul_add(code as f32, q.offset());
                    assert_eq!(q.value(code), fused);
                }
                let last = f64::from(q.value(q.code(f64::from(max)).into()));
                assert!((last - f64::from(max)).abs() <= f64::from(q.step()));
                let ideal = ValueRange { min, max }.span() / f64::from((1 << bits) - 1);
                assert!(f64::from(q.step()) < ideal * 1.01, "{} for {ideal}", q.step());
            }
        }
    }

    #[test]
    fn one_value_is_kept_as_it_is() {
        for v in [0.0, 7.25, -3e38, 1e-38] {
            let q = over(v, v, 8, false);
            assert_eq!(q.value(q.code(f64::from(v)).into()), v);
        }
    }

    #[test]
    fn no_code_decodes_to_infinity() {
        let q = over(0.0, f32::MAX * 0.99, 8, false);
        assert!(q.value(q.code(f64::from(f32::MAX)).into()).is_finite());
        assert!(Quantiser::over(ValueRange { min: f32::MIN, max: f32::MAX }, 8, false).is_err());
    }

    #[test]
    fn steps_near_the_subnormals_are_refused() {
        let problem = Quantiser::over(ValueRange { min: 1e-37, max: 2e-37 }, 8, false).unwrap_err();
        assert!(problem.contains("2^-100"), "{problem}");
    }

    #[test]
    fn what_is_no_quantiser_is_not_read_from_a_stream() {
        assert!(Quantiser::of_stream(8, 1.0, 0.5).is_some());
        for (bits, offset, step) in [
            (7, 0.0, 1.0),
            (8, f32::NAN, 1.0),
            (8, 0.0, 0.0),
            (8, 0.0, -1.0),
            (16, 0.0, f32::MAX),
            (8, 1e-40, 1.0),
        ] {
            assert_eq!(Quantiser::of_stream(bits, offset, step), None, "{bits} {offset} {step}");
        }
    }
}
