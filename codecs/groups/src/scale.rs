//! What a code counts: an integer of four significant bits, so that the largest code comes near the largest value whatever
//! that is.

/// Bits of a sum's value, before it is scaled to data units.
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

    /// The least scale at which codes of so many bits reach up to `largest`, in units of the sums, or else the greatest.
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

    /// The scale nearest to so many units; `most` is the greatest exponent.
    #[must_use]
    pub fn nearest(units: f64, most: u32) -> Self {
        // Above 8 units exponents are those of the number; below, fractions give every integer.
        let exponent = units.max(1.0).log2().floor().min(f64::from(most)) as u32;
        let of = |exponent: u32| (0..FRACTIONS).map(move |fraction| Self { exponent, fraction });
        let all = of(exponent).chain(of((exponent + 1).min(most)));
        let far = |scale: &Self| (f64::from(scale.units()) - units).abs();
        all.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(Self::ONE)
    }

    /// The greatest scale of at most so many units, at least one.
    #[must_use]
    pub fn at_most(units: f64) -> Self {
        let exponent = units.clamp(1.0, 65536.0).log2().floor() as u32;
        let mut all = (0..FRACTIONS).rev().map(|fraction| Self { exponent, fraction });
        all.find(|scale| f64::from(scale.units()) <= units).unwrap_or(Self::ONE)
    }

    /// In eight bits: the exponent in the lower five, the fraction above it.
    #[must_use]
    pub const fn byte(self) -> u32 {
        self.exponent | self.fraction << EXPONENT_BITS
    }

    /// The scale of eight bits, the lowest of `byte`.
    #[must_use]
    #[inline]
    pub const fn of_byte(byte: u32) -> Self {
        Self {
            exponent: byte & ((1 << EXPONENT_BITS) - 1),
            fraction: byte >> EXPONENT_BITS & (FRACTIONS - 1),
        }
    }

    /// The exponent of its power of two.
    #[must_use]
    pub const fn exponent(self) -> u32 {
        self.exponent
    }

    /// Most that an exponent may be: sums of all codebooks stay within 32 bits.
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
        self.byte() << AT
    }

    /// The scale in the form of a codebook.
    #[must_use]
    #[inline]
    pub const fn of_form(form: u32) -> Self {
        Self::of_byte(form >> AT)
    }

    /// Whether entries of so many bits may have it.
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

    #[test]
    fn the_nearest_scale_is_found() {
        for (units, nearest) in
            [(0.0, 1), (1.4, 1), (1.6, 2), (15.4, 15), (255.0, 256), (247.0, 240), (1e9, 30720)]
        {
            assert_eq!(Scale::nearest(units, 14).units(), nearest, "{units}");
        }
        for (units, most) in [(0.3, 1), (256.0, 256), (255.0, 240), (9.0, 9), (1.0, 1)] {
            assert_eq!(Scale::at_most(units).units(), most, "{units}");
        }
    }

    /// Forms of version 1 have no fraction: their scales are powers of two.
    #[test]
    fn a_form_holds_a_scale() {
        for exponent in 0..=10 {
            assert_eq!(Scale::of_form(exponent << 8 | 3 | 2 << 16).units(), 1 << exponent);
            for fraction in 0..8 {
                let scale = Scale { exponent, fraction };
                assert_eq!(Scale::of_form(scale.form() | 31 | 3 << 16), scale);
            }
        }
        assert!(Scale::of_form(10 << 8).fits(8) && !Scale::of_form(11 << 8).fits(8));
        assert!(Scale::of_form(3 << 8).fits(16) && !Scale::of_form(4 << 8).fits(16));
    }
}
