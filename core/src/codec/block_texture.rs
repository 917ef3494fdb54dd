//! Streams that texture units decode: blocks of a compressed texture format.

use std::borrow::Cow;

use super::Agreement;
use crate::volume::Extent;

/// A compressed texture format. Each of its blocks covers voxels of one slice.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum BlockFormat {
    /// BC4 (RGTC1): one channel, 4×4 voxels in 8 bytes. Texels are unsigned fractions of a range.
    Bc4,
}

impl BlockFormat {
    /// Edge of a block in voxels, along x and along y.
    #[must_use]
    pub const fn edge(self) -> u32 {
        match self {
            Self::Bc4 => 4,
        }
    }

    /// Words of 32 bits in a block.
    #[must_use]
    pub const fn words(self) -> u32 {
        match self {
            Self::Bc4 => 2,
        }
    }

    /// Largest rounding error of a texture unit, as a fraction of the range. No format here is specified bit for bit. A
    /// BC4 level between the endpoints is a sum of two weighted endpoints. llvmpipe truncates each to 8 bits, so it
    /// lies up to two 255ths too low.
    #[must_use]
    pub const fn rounding(self) -> f64 {
        match self {
            Self::Bc4 => 2.0 / 255.0,
        }
    }

    /// Largest error of a texture unit's weights, as a fraction of the distance between a block's endpoints. NVIDIA
    /// interpolates BC4 in 257ths, but not the nearest ones: 48, 96, 161, 209 for fifths; 36, 72, 113, 144, 185, 221
    /// for sevenths (measured on an H100, exact for all 65536 pairs of endpoints). 96/257 lies 0.0265 below two fifths.
    #[must_use]
    pub const fn weights(self) -> f64 {
        match self {
            Self::Bc4 => 0.0265,
        }
    }

    /// Size of a texture that holds a volume in whole blocks.
    #[must_use]
    pub const fn padded(self, extent: Extent) -> [u32; 3] {
        let edge = self.edge();
        [extent.x().next_multiple_of(edge), extent.y().next_multiple_of(edge), extent.z()]
    }

    /// Bytes of a volume of one channel in whole blocks.
    #[must_use]
    pub fn bytes(self, extent: Extent) -> u64 {
        let [width, height, depth] = self.padded(extent).map(u64::from);
        let edge = u64::from(self.edge());
        width / edge * (height / edge) * depth * u64::from(self.words()) * 4
    }
}

/// A frame as blocks that a texture unit decodes: `value = offset + scale · texel`, with texels in 0..1. A device
/// without the format gets the decoded frame instead, in the form [`super::DecodedForm`].
#[derive(Clone, Debug)]
pub struct BlockTexture<'a> {
    /// Format of the blocks.
    pub format: BlockFormat,
    /// The blocks, bytes in little-endian words: x fastest, then y, then the channels of a slice, then z. Blocks at the
    /// border are stored whole.
    pub words: Cow<'a, [u32]>,
    /// Data units per texel unit. 0 if all voxels equal `offset`.
    pub scale: f32,
    /// Value of texel 0. Every texture unit returns it exactly.
    pub offset: f32,
}

impl BlockTexture<'_> {
    /// The agreement that a texture unit must keep with the CPU decoder. It allows the errors of the format, scaled by
    /// the endpoints of the voxel's block, and the rounding of single precision.
    #[must_use]
    pub fn agreement(&self) -> Agreement {
        let rounding = f64::from(self.scale.abs() + self.offset.abs()) * f64::from(f32::EPSILON) * 4.0;
        let distance = f64::from(self.scale.abs()) * self.format.rounding() + rounding;
        Agreement::Levels { distance: distance as f32, share: self.format.weights() as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::ValueRange;

    #[test]
    fn volumes_are_padded_within_their_slices() {
        let extent = Extent::new(13, 4, 5).unwrap();
        assert_eq!(BlockFormat::Bc4.padded(extent), [16, 4, 5]);
    }

    #[test]
    fn two_steps_of_8_bits_and_a_share_of_the_blocks_range_are_allowed_and_no_more() {
        let blocks = BlockTexture {
            format: BlockFormat::Bc4,
            words: Cow::Borrowed(&[]),
            scale: 510.0,
            offset: -100.0,
        };
        let agreement = blocks.agreement();
        assert!(agreement.allows(7.0, 11.0, None) && agreement.allows(11.0, 7.0, None));
        assert!(!agreement.allows(7.0, 11.01, None) && !agreement.allows(7.0, f32::NAN, None));
        // A block from 0 to 200: 5.3 more.
        let block = Some(ValueRange { min: 0.0, max: 200.0 });
        assert!(agreement.allows(7.0, 16.29, block) && !agreement.allows(7.0, 16.31, block));
    }
}
