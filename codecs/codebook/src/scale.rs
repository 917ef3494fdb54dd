//! Codewords whose components are sums of integers: what an entry of a codebook counts.
//!
//! A decoder of several stages adds entries of several codebooks. Each codebook has a scale of its own, an integer of four
//! significant bits, so that its largest entry comes near the largest code. Sums are exact in 32 bits.

use crate::Quantiser;

/// Bits of a value before it is scaled to data units.
pub const VALUE_BITS: u32 = 16;

/// The lowest bit of a scale in the form of a codebook.
const AT: u32 = 8;
/// Bits of the exponent, and of the fraction above it.
const EXPONENT_BITS: u32 = 5;
const FRACTION_BITS: u32 = 3;
/// Fractions of each exponent.
const FRACTIONS: u32 = 1 << FRACTION_BITS;

/// The scale of a codebook's entries: `(8 + fraction) · 2^exponent / 8`, rounded down.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Scale {
    exponent: u32,
    fraction: u32,
}

impl Scale {
    /// One unit of the sums.
    pub const ONE: Self = Self { exponent: 0, fraction: 0 };

    /// The least scale at which codes of `bits` bits reach `largest`, in units of the sums. Else the greatest scale.
    #[must_use]
    pub fn reaching(bits: u32, largest: f64) -> Self {
        let top = f64::from((1_u32 << (bits - 1)) - 1);
        let exponents = 0..=Self::most_exponent(bits);
        let mut all =
            exponents.flat_map(|exponent| (0..FRACTIONS).map(move |fraction| Self { exponent, fraction }));
        let reaches = |scale: &Self| top * f64::from(scale.units()) >= largest;
        let greatest = Self { exponent: Self::most_exponent(bits), fraction: FRACTIONS - 1 };
        all.find(reaches).unwrap_or(greatest)
    }

    /// The scale that reaches up to `largest`, and its entries as a quantiser: codes of so many bits, the middle one is 0.
    ///
    /// # Panics
    /// When `bits` is neither 8 nor 16.
    #[must_use]
    #[allow(clippy::unwrap_used, reason = "an integer below 2^11 is a step")]
    pub fn entries(bits: u32, largest: f64) -> (Quantiser, Self) {
        let scale = Self::reaching(bits, largest);
        let unit = scale.units() as f32;
        (Quantiser::of_stream(bits, -unit * (1_u32 << (bits - 1)) as f32, unit).unwrap(), scale)
    }

    /// Largest exponent. With it, sums of all codebooks stay within 32 bits.
    const fn most_exponent(entry_bits: u32) -> u32 {
        26 - VALUE_BITS - if entry_bits == 16 { 7 } else { 0 }
    }

    /// Units of the sums that one step of an entry counts.
    #[must_use]
    pub const fn units(self) -> u32 {
        ((FRACTIONS + self.fraction) << self.exponent) >> FRACTION_BITS
    }

    /// Its bits in the form of a codebook.
    #[must_use]
    pub const fn form(self) -> u32 {
        (self.exponent | self.fraction << EXPONENT_BITS) << AT
    }

    /// The scale in the form of a codebook.
    #[must_use]
    #[inline]
    pub const fn of_form(form: u32) -> Self {
        let bits = form >> AT;
        Self {
            exponent: bits & ((1 << EXPONENT_BITS) - 1),
            fraction: bits >> EXPONENT_BITS & (FRACTIONS - 1),
        }
    }

    /// Its bits as a byte: the exponent, and the fraction above it.
    #[must_use]
    pub const fn byte(self) -> u8 {
        (self.form() >> AT) as u8
    }

    /// The scale of a byte.
    #[must_use]
    pub const fn of_byte(byte: u8) -> Self {
        Self::of_form((byte as u32) << AT)
    }

    /// Whether entries of `entry_bits` bits may have it.
    #[must_use]
    pub const fn fits(self, entry_bits: u32) -> bool {
        self.exponent <= Self::most_exponent(entry_bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_scale_that_reaches_is_found() {
        for (largest, units) in
            [(0.0, 1), (127.0, 1), (128.0, 2), (254.5, 3), (1017.0, 9), (2033.0, 18), (65535.0, 576)]
        {
            assert_eq!(Scale::reaching(8, largest).units(), units, "{largest}");
        }
        assert_eq!(Scale::reaching(16, 65535.0).units(), 3);
        assert_eq!(Scale::reaching(8, 1e9).units(), 1920);
        assert_eq!(Scale::reaching(16, 1e9).units(), 15);
    }

    /// Forms of version 1 have no fraction. Their scales are powers of two.
    #[test]
    fn a_form_holds_a_scale() {
        for exponent in 0..=10 {
            assert_eq!(Scale::of_form(exponent << 8 | 3 | 2 << 16).units(), 1 << exponent);
            for fraction in 0..8 {
                let scale = Scale { exponent, fraction };
                assert_eq!(Scale::of_form(scale.form() | 31 | 3 << 16), scale);
                assert_eq!(Scale::of_byte(scale.byte()), scale);
            }
        }
        assert!(Scale::of_form(10 << 8).fits(8) && !Scale::of_form(11 << 8).fits(8));
        assert!(Scale::of_form(3 << 8).fits(16) && !Scale::of_form(4 << 8).fits(16));
    }
}
