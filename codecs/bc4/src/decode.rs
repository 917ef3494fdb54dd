//! Decodes one voxel of a block. The twin of decode.wgsl, function for function, except that the kit finds the block
//! here. This code defines the codec.

use crate::Scale;
use crate::block::PARTS;

/// A thirty-fifth, rounded to single precision.
pub const PART: f32 = 1.0 / PARTS as f32;

/// Index of voxel `texel` of a block (x fastest).
#[must_use]
#[inline]
pub const fn index(words: [u32; 2], texel: u32) -> u32 {
    let bit = 16 + 3 * texel;
    if bit >= 32 {
        return (words[1] >> (bit - 32)) & 7;
    }
    // The sixth index lies in both words. For the others, the mask removes the bits of the second word.
    ((words[0] >> bit) | (words[1] << (32 - bit))) & 7
}

/// Level of an index of a block, in parts of a code ([`PARTS`]). An exact integer.
#[must_use]
#[inline]
pub const fn level(words: [u32; 2], index: u32) -> u32 {
    let (first, second) = (words[0] & 255, (words[0] >> 8) & 255);
    let eight = first > second;
    if !eight && index >= 6 {
        return (index - 6) * 255 * PARTS;
    }
    let whole = if eight { 7 } else { 5 };
    let share = match index {
        0 => 0,
        1 => whole,
        _ => index - 1,
    };
    ((whole - share) * first + share * second) * (PARTS / whole)
}

/// Value of a level, in data units. This is the codec's only floating-point code. A level that is a whole code has
/// exactly that code's 8-bit value.
#[must_use]
#[inline]
pub fn value(scale: &Scale, level: u32) -> f32 {
    let code = (level / PARTS) as f32 + (level % PARTS) as f32 * PART;
    (scale.offset + scale.step * code).min(scale.high)
}

/// Value of voxel `texel` of a block.
#[must_use]
#[inline]
pub fn voxel(scale: &Scale, words: [u32; 2], texel: u32) -> f32 {
    value(scale, level(words, index(words, texel)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::{Ends, pack};

    const NATIVE: Scale = Scale { offset: 0.0, step: 1.0, high: 255.0 };

    /// For every pair of endpoints, every level equals the encoder's integer. Its value is rounded at most twice, and a
    /// level that is a whole code has exactly its value.
    #[test]
    fn levels_are_those_of_the_encoder() {
        let indices = std::array::from_fn(|i| (i % 8) as u8);
        for (first, second) in (0..=255).flat_map(|a| (0..=255).map(move |b| (a, b))) {
            let ends = Ends([first, second]);
            let words = pack(ends, &indices);
            for (texel, level) in ends.levels().into_iter().enumerate() {
                assert_eq!(index(words, texel as u32), texel as u32);
                assert_eq!(index(words, texel as u32 + 8), texel as u32);
                assert_eq!(super::level(words, texel as u32), level as u32);
                let found = voxel(&NATIVE, words, texel as u32);
                let exact = f64::from(level) / f64::from(PARTS);
                assert!(
                    (f64::from(found) - exact).abs() <= exact * 1.5e-7,
                    "{first} {second} {texel}: {found}"
                );
                if level % PARTS as i16 == 0 {
                    assert_eq!(f64::from(found), exact, "{first} {second} {texel}");
                }
            }
        }
    }
}
