//! Blocks in the encoder: in levels, with their means and the means of their sub-blocks.

use cvr_codebook::{Quantiser, Vectors};
use cvr_core::volume::{SampleType, ValueRange};

use crate::geometry::{EDGE, SUB_BLOCKS, VOXELS};

/// Value of a level, and of a mean's code.
#[derive(Copy, Clone, Debug)]
pub struct Levels {
    pub quantiser: Quantiser,
    /// Highest level.
    pub top: u32,
    /// Bits of a mean.
    pub mean_bits: u32,
    /// Levels per code of a mean.
    pub mean_step: u32,
}

impl Levels {
    /// Levels over a range. They have 8 bits if samples, means and codewords do, else 16. Integers of the range have
    /// their own levels. If possible, differences of two of them have their own codes.
    ///
    /// # Errors
    /// A sentence, when single precision cannot hold the range.
    pub fn over(
        range: ValueRange,
        sample: SampleType,
        mean_bits: Option<u32>,
        codeword_bits: u32,
    ) -> Result<Self, String> {
        let native = if sample.bytes() == 1 { 8 } else { 16 };
        let mean_bits = mean_bits.unwrap_or(native);
        let bits = native.max(mean_bits).max(codeword_bits);
        let twice = 2.0 * range.span();
        let integers = sample.is_integer();
        let spread = if integers && twice < f64::from(1_u32 << bits) {
            ValueRange { min: range.min, max: (f64::from(range.min) + twice) as f32 }
        } else {
            range
        };
        let quantiser = Quantiser::over(spread, bits, integers)?;
        let top = u32::from(quantiser.code(range.max.into()));
        let mean_step = top.div_ceil((1 << mean_bits) - 1).max(1);
        Ok(Self { quantiser, top, mean_bits, mean_step })
    }

    /// A value in levels, not rounded.
    pub fn of(&self, value: f32) -> f32 {
        ((f64::from(value) - f64::from(self.quantiser.offset())) / f64::from(self.quantiser.step())) as f32
    }

    /// The decoded value of a sum of levels.
    pub fn value(&self, level: i32) -> f32 {
        self.quantiser.value(level.clamp(0, self.top as i32) as u32)
    }

    /// The code of a mean.
    pub fn mean_code(&self, mean: f64) -> u32 {
        let code = (mean / f64::from(self.mean_step)).round();
        code.clamp(0.0, f64::from(self.top.div_ceil(self.mean_step))) as u32
    }

    /// Vectors of blocks in levels.
    pub fn vectors(&self, blocks: &Vectors) -> Vectors {
        let mut levels = Vectors::new(blocks.dimension());
        let mut vector = Vec::with_capacity(blocks.dimension());
        for i in 0..blocks.len() {
            vector.clear();
            vector.extend(blocks.vector(i).iter().map(|v| self.of(*v)));
            levels.push(&vector, blocks.weight(i));
        }
        levels
    }
}

/// Which sub-block a voxel lies in, by its number in the block.
pub const fn sub_block_of(voxel: usize) -> usize {
    let edge = EDGE as usize;
    let (x, y, z) = (voxel % edge, voxel / edge % edge, voxel / edge / edge);
    (z / 2 * 2 + y / 2) * 2 + x / 2
}

/// Means of a block, over its voxels in the volume.
#[derive(Clone, Debug)]
pub struct Means {
    /// Of each channel.
    pub block: Vec<f64>,
    /// Mean of each channel of each sub-block, channels adjacent. 0 if no voxel lies in the volume.
    pub sub_blocks: Vec<f64>,
    /// Number of voxels of each sub-block in the volume.
    pub counts: [u32; SUB_BLOCKS as usize],
}

impl Means {
    /// The means of a block in levels: voxels x fastest, channels interleaved. `exists` says whether a voxel lies in
    /// the volume. At least one must.
    pub fn of(levels: &[f32], exists: impl Fn(usize) -> bool) -> Self {
        let channels = levels.len() / VOXELS as usize;
        let mut means = Self {
            block: vec![0.0; channels],
            sub_blocks: vec![0.0; SUB_BLOCKS as usize * channels],
            counts: [0; SUB_BLOCKS as usize],
        };
        for (voxel, values) in levels.chunks_exact(channels).enumerate().filter(|(voxel, _)| exists(*voxel)) {
            let sub = sub_block_of(voxel);
            means.counts[sub] += 1;
            for (c, value) in values.iter().enumerate() {
                means.sub_blocks[sub * channels + c] += f64::from(*value);
            }
        }
        let all: u32 = means.counts.iter().sum();
        for (sub, sums) in means.sub_blocks.chunks_exact_mut(channels).enumerate() {
            for (c, sum) in sums.iter_mut().enumerate() {
                means.block[c] += *sum / f64::from(all);
                *sum /= f64::from(means.counts[sub].max(1));
            }
        }
        means
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sub_blocks_are_those_of_the_decoder() {
        let frame_order = |voxel: u32| {
            let inside = [voxel % 4, voxel / 4 % 4, voxel / 16];
            ((inside[2] & 2) << 1) | (inside[1] & 2) | (inside[0] >> 1)
        };
        for voxel in 0..64 {
            assert_eq!(sub_block_of(voxel as usize), frame_order(voxel) as usize);
        }
    }

    #[test]
    fn means_are_over_what_exists() {
        let levels: Vec<f32> = (0..64).map(|i| i as f32).collect();
        let whole = Means::of(&levels, |_| true);
        assert_eq!((whole.block[0], whole.counts), (31.5, [8; 8]));
        // Voxels 0, 1, 4, 5, 16, 17, 20, 21.
        assert_eq!(whole.sub_blocks[0], 10.5);
        let cut = Means::of(&levels, |voxel| voxel % 4 == 0 && voxel < 8);
        assert_eq!((cut.block[0], cut.sub_blocks[0], cut.sub_blocks[1]), (2.0, 2.0, 0.0));
        assert_eq!(cut.counts, [2, 0, 0, 0, 0, 0, 0, 0]);
        let colours: Vec<f32> = levels.iter().flat_map(|v| [*v, 0.0, 2.0 * v]).collect();
        assert_eq!(Means::of(&colours, |_| true).block, [31.5, 0.0, 63.0]);
    }

    #[test]
    fn levels_are_as_wide_as_what_is_widest() {
        let range = |max| ValueRange { min: 0.0, max };
        let levels = |sample, mean, bits| Levels::over(range(200.0), sample, mean, bits).unwrap();
        assert_eq!(levels(SampleType::U8, None, 8).quantiser.bits(), 8);
        assert_eq!(levels(SampleType::U8, None, 16).quantiser.bits(), 16);
        assert_eq!(levels(SampleType::I8, Some(16), 8).quantiser.bits(), 16);
        let deep = levels(SampleType::U16, Some(8), 8);
        assert_eq!((deep.quantiser.bits(), deep.mean_bits, deep.top), (16, 8, 200 * 128));
        assert_eq!(deep.mean_step, (200 * 128_u32).div_ceil(255));
        for mean in [0.0, 12345.0, 25600.0] {
            let decoded = f64::from(deep.mean_code(mean) * deep.mean_step);
            assert!((decoded - mean).abs() <= f64::from(deep.mean_step) / 2.0);
        }
        assert_eq!(levels(SampleType::F32, None, 8).mean_step, 1);
    }
}
