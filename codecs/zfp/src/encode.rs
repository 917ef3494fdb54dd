//! The encoder: rows of blocks in parallel. Each block is padded and coded on its own.

use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::{BlockRow, Measured, code_frame};
use cvr_core::volume::{BrickSource, FrameIndex, VolumeLayout};

use crate::BLOCKS;
use crate::decode::decoded;
use crate::geometry::{Geometry, Parameters, SAMPLES, block};
use crate::planes::BlockBits;

/// Encodes at one rate.
#[derive(Debug)]
pub struct ZfpEncoder {
    pub block_bits: u32,
}

impl Encoder for ZfpEncoder {
    /// Bits of all channels except the first.
    fn scratch_bytes(&self, layout: &VolumeLayout) -> u64 {
        4 * u64::from(layout.channels - 1) * Geometry::of(layout, self.block_bits).channel_words()
    }

    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let layout = source.layout().clone();
        let geometry = Geometry::of(&layout, self.block_bits);
        let mut measured = Measured::NOTHING;
        for frame in (0..layout.frames).map(FrameIndex) {
            // The stream is ordered by channel. Later channels are held until the frame is read.
            let mut joined: Vec<Joined> = (0..layout.channels).map(|_| Joined::default()).collect();
            let row = |by, bz| {
                let row = BlockRow::read(source, block(), frame, by, bz)?;
                Ok(code_row(&geometry, &row, layout.sample.is_integer()))
            };
            code_frame(&geometry.grid, 1, run, row, |rows| {
                for (channels, row) in rows {
                    for (joined, blocks) in joined.iter_mut().zip(channels) {
                        blocks.iter().for_each(|block| joined.append(block.words(), self.block_bits));
                    }
                    measured = measured.and(row);
                }
                Ok(out.append_words(BLOCKS, &joined[0].whole())?)
            })?;
            for joined in joined {
                out.append_words(BLOCKS, &joined.end())?;
            }
        }
        out.shape(BLOCKS, &geometry.shape(layout.frames))?;
        let parameters = Parameters {
            block_bits: self.block_bits,
            grid: geometry.grid.blocks().to_array(),
            range: measured.range(),
        };
        out.parameters_of(&parameters)?;
        Ok(EncodeReport { error_bound: Some(measured.error), notes: Vec::new() })
    }
}

/// Codes a row of blocks along x, channel by channel, and decodes it to measure the error.
fn code_row(g: &Geometry, row: &BlockRow, integers: bool) -> (Vec<Vec<BlockBits>>, Measured) {
    let channels = g.channels as usize;
    let mut coded: Vec<Vec<BlockBits>> = vec![Vec::new(); channels];
    let (mut measured, mut vector) = (Measured::NOTHING, Vec::with_capacity(SAMPLES * channels));
    for bx in 0..g.grid.blocks().x() {
        let there = row.cut(bx);
        vector.clear();
        row.append(bx, &mut vector);
        for (c, coded) in coded.iter_mut().enumerate() {
            let mut values: [f32; SAMPLES] = std::array::from_fn(|i| vector[i * channels + c]);
            fill(&mut values, there);
            let bits = BlockBits::of(&values, g.block_bits);
            let back = decoded(bits.words(), g.block_bits);
            for i in
                (0..SAMPLES).filter(|i| [i & 3, i >> 2 & 3, i >> 4].iter().zip(there).all(|(i, n)| *i < n))
            {
                measured.add(values[i], back[i], integers);
            }
            coded.push(bits);
        }
    }
    (coded, measured)
}

/// Pads a block that has `there` voxels along x, y and z, axis by axis. The last voxel is repeated, and the fourth
/// position gets the first voxel.
fn fill(values: &mut [f32; SAMPLES], there: [usize; 3]) {
    for (stride, n) in [1, 4, 16].into_iter().zip(there) {
        for place in n..4 {
            let from = if place == 3 { 0 } else { place - 1 };
            for i in (0..SAMPLES).filter(|i| i / stride % 4 == place) {
                values[i] = values[i - (place - from) * stride];
            }
        }
    }
}

/// The bits of blocks, concatenated without gaps.
#[derive(Default)]
struct Joined {
    words: Vec<u32>,
    /// Used bits of the last word. 0 if it is full.
    taken: u32,
    /// Words that were handed on, modulo 2.
    odd: bool,
}

impl Joined {
    fn append(&mut self, bits: &[u32], count: u32) {
        for (word, left) in bits.iter().zip((1..=count).rev().step_by(32)) {
            match self.words.last_mut() {
                Some(last) if self.taken > 0 => {
                    *last |= word << self.taken;
                    // The bits that do not fit into the last word.
                    if left.min(32) > 32 - self.taken {
                        self.words.push(word >> (32 - self.taken));
                    }
                }
                _ => self.words.push(*word),
            }
            self.taken = (self.taken + left.min(32)) % 32;
        }
    }

    /// The words that are full.
    fn whole(&mut self) -> Vec<u32> {
        let full = self.words.len() - usize::from(self.taken > 0);
        let rest = self.words.split_off(full);
        self.odd ^= full % 2 == 1;
        std::mem::replace(&mut self.words, rest)
    }

    /// All remaining words, padded to a whole number of 64-bit words.
    fn end(mut self) -> Vec<u32> {
        if self.odd != (self.words.len() % 2 == 1) {
            self.words.push(0);
        }
        self.words
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_follow_each_other_without_gaps() {
        for count in [9_u32, 31, 32, 33, 64, 70, 96, 100] {
            let mut joined = Joined::default();
            let bit =
                |block: u32, i: u32| block.wrapping_mul(2_654_435_761).wrapping_add(i * i * 40_503) >> 7 & 1;
            let mut words = Vec::new();
            for block in 0..50 {
                let mut own = vec![0; count.div_ceil(32) as usize];
                (0..count).for_each(|i| own[(i / 32) as usize] |= bit(block, i) << (i % 32));
                joined.append(&own, count);
                if block % 7 == 3 {
                    words.extend(joined.whole());
                }
            }
            words.extend(joined.end());
            assert_eq!(words.len() as u32, (50 * count).div_ceil(64) * 2, "{count}");
            for (at, (block, i)) in (0..50).flat_map(|b| (0..count).map(move |i| (b, i))).enumerate() {
                assert_eq!(words[at / 32] >> (at % 32) & 1, bit(block, i), "{count}: {block} {i}");
            }
        }
    }

    #[test]
    fn a_cut_block_is_filled_up_axis_by_axis() {
        let line = |n: usize| {
            let mut values = [0.0; SAMPLES];
            (0..n).for_each(|x| values[x] = x as f32 + 1.0);
            fill(&mut values, [n, 1, 1]);
            assert!((4..SAMPLES).all(|i| values[i] == values[i % 4]));
            [0, 1, 2, 3].map(|x| values[x])
        };
        assert_eq!(line(1), [1.0, 1.0, 1.0, 1.0]);
        assert_eq!(line(2), [1.0, 2.0, 2.0, 1.0]);
        assert_eq!(line(3), [1.0, 2.0, 3.0, 1.0]);
        assert_eq!(line(4), [1.0, 2.0, 3.0, 4.0]);
    }
}
