//! Streams that are what texture units decode: blocks of a compressed texture format.

use std::borrow::Cow;

use super::Agreement;
use crate::volume::Extent;

/// A compressed texture format whose blocks are sets of voxels of one slice.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum BlockFormat {
    /// BC4, RGTC1: one channel of unsigned shares of a range, 4×4 voxels in 8 bytes.
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

    /// By how much a texture unit may be off through rounding, as a share of the range: no format here is specified to
    /// the bit. Of BC4 a level between endpoints is the sum of two shares of them; llvmpipe cuts each to 8 bits, and so
    /// falls below it by up to two 255ths.
    #[must_use]
    pub const fn rounding(self) -> f64 {
        match self {
            Self::Bc4 => 2.0 / 255.0,
        }
    }

    /// By how much the weights of a texture unit may be off, as a share of the distance between the endpoints of a block.
    /// NVIDIA's interpolate BC4 by 257ths, and not by the nearest: 48, 96, 161, 209 for fifths, 36, 72, 113, 144, 185,
    /// 221 for sevenths (measured on an H100, exact in all 65536 pairs of endpoints); 96/257 is 0.0265 below two fifths.
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

/// A frame as blocks that a texture unit decodes: `value = offset + scale · texel`, where texels lie in 0..1. A device
/// that lacks the format is handed the decoded frame instead, as [`super::DecodedForm`] says.
#[derive(Clone, Debug)]
pub struct BlockTexture<'a> {
    /// Format of the blocks.
    pub format: BlockFormat,
    /// The blocks, bytes in little-endian words: x fastest, then y, of each slice the planes of its channels one after
    /// another. Blocks at the border are whole.
    pub words: Cow<'a, [u32]>,
    /// Data units per texel unit; 0 where all voxels are `offset`.
    pub scale: f32,
    /// Value of texel 0, which every texture unit yields exactly.
    pub offset: f32,
}

impl BlockTexture<'_> {
    /// What a texture unit is held to: no voxel is farther from the CPU decoder's than the format allows between the
    /// endpoints of the voxel's block, and what single precision rounds.
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
