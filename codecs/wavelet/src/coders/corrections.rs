//! Corrections of samples that miss a bound: places as gaps, and multiples of a unit, both adaptively coded.

use cvr_core::codec::DecodeError;

use super::contexts::binarisation::{read, write};
use super::contexts::models::Models;
use super::fault::Fault;
use super::range::{Decoder, Encoder};

/// A sample and the multiple of the unit that it gains.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Correction {
    /// Number of the sample in its frame and channel.
    pub place: u32,
    /// Not 0.
    pub units: i32,
}

/// The corrections as bytes: their number, then gaps and multiples. None are no bytes. `corrections` are in order.
#[must_use]
pub fn encode(corrections: &[Correction]) -> Vec<u8> {
    if corrections.is_empty() {
        return Vec::new();
    }
    let (mut encoder, [mut gaps, mut units]) = (Encoder::new(), [Models::default(), Models::default()]);
    let (mut next, mut before) = (0, 0);
    for correction in corrections {
        // A gap fits, because a frame has fewer than 2³¹ samples.
        let gap = correction.place - next;
        write(&mut encoder, &mut gaps, gap as i32, class(before), || (0, 13));
        write(&mut encoder, &mut units, correction.units, 0, || (0, 13));
        (next, before) = (correction.place + 1, gap);
    }
    let mut bytes = (corrections.len() as u32).to_le_bytes().to_vec();
    bytes.extend(encoder.finish());
    bytes
}

/// Gaps are alike after gaps of as many bits.
const fn class(gap: u32) -> usize {
    (u32::BITS - gap.leading_zeros()) as usize
}

/// Reads corrections of a frame of `samples`.
///
/// # Errors
/// They are corrupt.
pub fn decode(bytes: &[u8], samples: usize) -> Result<Vec<Correction>, DecodeError> {
    let Some((count, bytes)) = bytes.split_first_chunk() else {
        return if bytes.is_empty() {
            Ok(Vec::new())
        } else {
            Err(Fault("corrections lack their number").into())
        };
    };
    let count = u32::from_le_bytes(*count) as usize;
    if count > samples {
        return Err(Fault("there are more corrections than samples").into());
    }
    let (mut decoder, [mut gaps, mut units]) = (Decoder::new(bytes)?, [Models::default(), Models::default()]);
    let (mut next, mut before) = (0_u64, 0);
    // Corrections are not as many as their number says before they are read.
    let mut out = Vec::new();
    for _ in 0..count {
        let gap = read(&mut decoder, &mut gaps, class(before), || (0, 13))?;
        let units = read(&mut decoder, &mut units, 0, || (0, 13))?;
        before = u32::try_from(gap).map_err(|_| Fault("a gap between corrections is negative"))?;
        let place = next + u64::from(before);
        if place >= samples as u64 || units == 0 {
            return Err(Fault("a correction lies outside of the volume, or is 0").into());
        }
        out.push(Correction { place: place as u32, units });
        next = place + 1;
    }
    decoder.finish()?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Vec<Correction> {
        let of = |i: u32| Correction { place: i * i * 7 + i % 3, units: (i as i32 % 5 - 2) * 2 + 1 };
        (0..200).map(of).collect()
    }

    #[test]
    fn corrections_come_back() {
        assert!(encode(&[]).is_empty());
        assert_eq!(decode(&[], 10).unwrap(), []);
        let bytes = encode(&some());
        assert_eq!(decode(&bytes, 300_000).unwrap(), some());
        // Not beyond the last sample.
        assert!(decode(&bytes, 199 * 199 * 7).is_err());
    }

    #[test]
    fn corrupt_corrections_are_refused_or_others() {
        let whole = encode(&some());
        for len in 1..whole.len() {
            assert_ne!(decode(&whole[..len], 300_000).ok(), Some(some()), "{len}");
        }
        let mut many = whole.clone();
        many[..4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(decode(&many, 300_000).is_err());
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(decode(&flipped, 300_000).ok(), Some(some()), "bit {bit}");
        }
    }
}
