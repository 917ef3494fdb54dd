//! Values as symbols, and the header that gives the alphabet of a region.

use super::fault::Fault;

/// The largest magnitude of a region, from which its alphabet follows. It is 0 if all coefficients are.
#[must_use]
pub fn largest(coefficients: &[i32]) -> u32 {
    coefficients.iter().map(|value| value.unsigned_abs()).max().unwrap_or(0)
}

/// Appends the header of a region: seven bits per byte, the low ones first, and bit 7 where a byte follows.
pub fn write_largest(mut largest: u32, chunk: &mut Vec<u8>) {
    while largest >= 0x80 {
        chunk.push(largest as u8 | 0x80);
        largest >>= 7;
    }
    chunk.push(largest as u8);
}

/// Reads the header of a region, and takes it off `chunk`.
///
/// # Errors
/// The header has no end, or no coefficient has this magnitude.
pub fn read_largest(chunk: &mut &[u8]) -> Result<u32, Fault> {
    let mut largest = 0_u64;
    for place in 0..5 {
        let (byte, rest) = chunk.split_first().ok_or(Fault("the header of a region is cut off"))?;
        *chunk = rest;
        largest |= u64::from(byte & 0x7f) << (7 * place);
        if *byte < 0x80 {
            return u32::try_from(largest).ok().filter(|largest| *largest <= i32::MAX as u32).ok_or(LARGEST);
        }
    }
    Err(LARGEST)
}

const LARGEST: Fault = Fault("the largest magnitude of a region does not fit in a coefficient");

/// The symbol of a value other than 0: 1, −1, 2, −2 and so on become 1, 2, 3, 4. Symbol 0 is zero.
#[inline]
#[must_use]
pub const fn fold(magnitude: u32, negative: bool) -> u32 {
    2 * magnitude - !negative as u32
}

/// Magnitude of a symbol, and whether it is negative.
#[inline]
#[must_use]
pub const fn unfold(symbol: u32) -> (u32, bool) {
    (symbol.div_ceil(2), symbol.is_multiple_of(2))
}

/// The value of this magnitude in a region.
///
/// # Errors
/// The magnitude is beyond the largest of its region, which [`read_largest`] has read.
#[inline]
pub fn signed(magnitude: u32, negative: bool, largest: u32) -> Result<i32, Fault> {
    if magnitude > largest {
        return Err(Fault("a value is beyond the largest magnitude of its region"));
    }
    let value = magnitude as i32;
    Ok(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_values_have_small_symbols() {
        assert_eq!([1, -1, 2, -2].map(|v: i32| fold(v.unsigned_abs(), v < 0)), [1, 2, 3, 4]);
        for value in [1, -1, 77, i32::MAX, -i32::MAX] {
            let (magnitude, negative) = unfold(fold(value.unsigned_abs(), value < 0));
            assert_eq!(signed(magnitude, negative, i32::MAX as u32), Ok(value));
            assert!(signed(magnitude, negative, magnitude - 1).is_err());
        }
        assert_eq!(unfold(u32::MAX).0, 1 << 31);
    }

    #[test]
    fn a_header_is_checked() {
        for (largest, bytes) in [
            (0, vec![0]),
            (127, vec![127]),
            (300, vec![0xac, 2]),
            (i32::MAX as u32, vec![255, 255, 255, 255, 7]),
        ] {
            let mut chunk = Vec::new();
            write_largest(largest, &mut chunk);
            assert_eq!(chunk, bytes);
            assert_eq!(read_largest(&mut &chunk[..]), Ok(largest));
            assert!(read_largest(&mut &chunk[..chunk.len() - 1]).is_err());
        }
        assert!(read_largest(&mut &[255, 255, 255, 255, 8][..]).is_err());
        assert!(read_largest(&mut &[0x80, 0x80, 0x80, 0x80, 0x80, 0][..]).is_err());
    }
}
