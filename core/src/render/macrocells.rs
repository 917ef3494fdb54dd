//! Macrocells: boxes of voxels that a renderer skips where the transfer function shows nothing of them.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::TransferFunction;
use crate::codec::{
    Agreement, BlockTexture, DecodeError, DecodedForm, DecodedFrame, Decoder, ShaderDecode, TexelFormat,
};
use crate::volume::{BrickKey, Extent, FrameIndex, Level, Region, ValueRange};

/// Lowest and highest *decoded* value of every macrocell of a frame at a level, its apron of one voxel included: what
/// a sample inside can come to under any filter. For the codec's original values they would be others: a lossy codec
/// shows what it decodes.
#[derive(Clone, Debug, PartialEq)]
pub struct MacrocellRanges {
    grid: Extent,
    /// `None` where a value is not finite: nothing can be said of that macrocell.
    ranges: Vec<Option<ValueRange>>,
}

/// Which macrocells show anything under a transfer function, one bit each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Macrocells {
    grid: Extent,
    words: Vec<u32>,
}

impl MacrocellRanges {
    /// Decodes `frame` at a level macrocell by macrocell, in parallel; macrocells are of voxels of that level. Memory stays
    /// within that of the ranges and of the decoder's own; a frame that is decoded as a whole is held while its macrocells
    /// are gone through. `stop` ends it early, with `None`.
    ///
    /// # Errors
    /// As [`Decoder::decode_brick`].
    pub fn decode(
        decoder: &dyn Decoder,
        frame: FrameIndex,
        level: Level,
        stop: &AtomicBool,
    ) -> Result<Option<Self>, DecodeError> {
        let layout = decoder.layout();
        let extent = layout.extent.at_resolution(level.resolution);
        let grid = extent.blocks_of(Macrocells::SIZE);
        let slack = Slack::of(decoder, level);
        let whole = DecodedFrame::if_whole(decoder, frame, level)?;
        let references = if whole.is_none() { decoder.references(frame, level)? } else { Default::default() };
        let range_of = |cell: usize| {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            // Between voxel centres, and over its faces, a trilinear filter reads one voxel beyond the macrocell.
            let region = Region::block(grid.position(cell), Macrocells::SIZE, extent).with_apron(1, extent);
            let mut values = vec![0.0; region.extent.voxels() as usize * layout.channels as usize];
            let key = BrickKey { frame, region, level };
            match &whole {
                Some(frame) => frame.copy_region(region, &mut values),
                None => decoder.decode_brick(key, &references, &mut values)?,
            }
            Ok(range_of(&values).map(|range| slack.widened(range, decoder.value_range(key))))
        };
        let ranges: Result<Vec<_>, DecodeError> =
            (0..grid.voxels() as usize).into_par_iter().map(range_of).collect();
        let ranges = ranges?;
        Ok((!stop.load(Ordering::Relaxed)).then_some(Self { grid, ranges }))
    }

    /// Those of a volume of one value.
    #[cfg(test)]
    pub(super) fn of_constant(extent: Extent, value: f32) -> Self {
        let grid = extent.blocks_of(Macrocells::SIZE);
        let range = ValueRange { min: value, max: value };
        Self { grid, ranges: vec![Some(range); grid.voxels() as usize] }
    }

    /// Macrocells along x, y, z.
    #[must_use]
    pub const fn grid(&self) -> Extent {
        self.grid
    }

    /// The range of a macrocell; `None` where a decoded value is not finite.
    #[must_use]
    pub fn range(&self, cell: [u32; 3]) -> Option<ValueRange> {
        self.ranges[self.grid.index(cell)]
    }

    /// What a transfer function leaves of them.
    #[must_use]
    pub fn classify(&self, transfer_function: &TransferFunction) -> Macrocells {
        let mut words = vec![0_u32; self.ranges.len().div_ceil(32)];
        for (i, range) in self.ranges.iter().enumerate() {
            if range.is_none_or(|range| !transfer_function.is_transparent(range)) {
                words[i / 32] |= 1 << (i % 32);
            }
        }
        Macrocells { grid: self.grid, words }
    }
}

impl Macrocells {
    /// Voxels along an edge. Mirror: `macrocell_edge` in `shaders/skipping/macrocells.wgsl`.
    pub const EDGE: u32 = 8;
    const SIZE: Extent = match Extent::cube(Self::EDGE) {
        Ok(size) => size,
        Err(_) => Extent::ONE,
    };

    /// Macrocells along x, y, z.
    #[must_use]
    pub const fn grid(&self) -> Extent {
        self.grid
    }

    /// One bit per macrocell, x fastest, the lowest bit of a word first: whether it shows anything.
    #[must_use]
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Whether this macrocell shows anything.
    #[must_use]
    pub fn shows(&self, cell: [u32; 3]) -> bool {
        let i = self.grid.index(cell);
        self.words[i / 32] >> (i % 32) & 1 == 1
    }

    /// Share of macrocells that show nothing, `0.0..=1.0`.
    #[must_use]
    pub fn empty_share(&self) -> f64 {
        let shown: u32 = self.words.iter().map(|word| word.count_ones()).sum();
        1.0 - f64::from(shown) / self.grid.voxels() as f64
    }
}

fn range_of(values: &[f32]) -> Option<ValueRange> {
    values.iter().all(|v| v.is_finite()).then(|| {
        let min = values.iter().copied().fold(f32::INFINITY, f32::min);
        let max = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        ValueRange { min, max }
    })
}

/// By how much a sample on a device may lie beyond what the decoder yields. Zeros are exact everywhere: air that is 0
/// stays so, or a transfer function that begins at 0 would never let anything be skipped.
#[derive(Copy, Clone, Debug)]
struct Slack {
    /// What the codec states of its shader, in units in the last place of the decoder's range.
    shader_ulps: f64,
    /// The same in data units.
    shader: f64,
    /// The same as a share of the span of the decoder's range.
    shader_share: f64,
    /// Value of texel 0, where texels are shares of a range.
    texel_offset: Option<f32>,
    /// What a texture unit may make of blocks that it decodes itself.
    blocks: Option<BlockSlack>,
}

/// Texture units yield levels of a block within a tolerance, and never leave the range of texels; of that, 0 is exact.
#[derive(Copy, Clone, Debug)]
struct BlockSlack {
    /// Data units.
    distance: f64,
    /// Of the span of what a block can hold.
    share: f64,
    /// Values of the texels 0 and 1.
    ends: [f64; 2],
}

impl BlockSlack {
    fn of(blocks: &BlockTexture<'_>) -> Option<Self> {
        let Agreement::Levels { distance, share } = blocks.agreement() else { return None };
        let (scale, offset) = (f64::from(blocks.scale), f64::from(blocks.offset));
        Some(Self { distance: distance.into(), share: share.into(), ends: [offset, offset + scale] })
    }

    /// Lowest and highest sample of voxels that decode to a range on the CPU, in blocks that the codec knows to lie within
    /// `known`.
    fn widened(self, [low, high]: [f64; 2], known: Option<ValueRange>) -> [f64; 2] {
        let [zero, one] = self.ends;
        if high <= zero {
            return [low, high];
        }
        let by = self.distance + self.share * known.map_or(one - zero, ValueRange::span);
        [(low - by).max(zero.min(low)), (high + by).min(one.max(high))]
    }
}

impl Slack {
    /// Interpolation between values, in units in the last place of the largest of them: three differences, products
    /// and sums.
    const INTERPOLATION_ULPS: f64 = 16.0;
    /// Turning a texel into a number from 0 to 1, scaling it and adding the offset, in units in the last place of the
    /// largest number in between.
    const TEXEL_ULPS: f64 = 8.0;

    fn of(decoder: &dyn Decoder, level: Level) -> Self {
        let (shader_ulps, shader, shader_share) = match decoder.shader().map(ShaderDecode::agreement) {
            Some(Agreement::Ulp(n)) => (f64::from(n), 0.0, 0.0),
            Some(Agreement::Levels { distance, share }) => (0.0, f64::from(distance), f64::from(share)),
            Some(Agreement::Exact) | None => (0.0, 0.0, 0.0),
        };
        let DecodedForm { format, offset, .. } = decoder.decoded_form();
        let texel_offset = match format {
            TexelFormat::Float16 | TexelFormat::Float32 => None,
            TexelFormat::Unorm8 | TexelFormat::Unorm16 => Some(offset),
        };
        // Every frame has the same scale.
        let blocks = decoder.block_texture(FrameIndex::FIRST, level).as_ref().and_then(BlockSlack::of);
        Self { shader_ulps, shader, shader_share, texel_offset, blocks }
    }

    /// `range` of the values of a macrocell, in which the codec knows them to lie within `known`.
    fn widened(self, range: ValueRange, known: Option<ValueRange>) -> ValueRange {
        let ulp = |range: ValueRange| if range.magnitude() > 0.0 { range.ulp() } else { 0.0 };
        let stated = known.map_or(range, |known| known.union(range));
        let texel = self.texel_offset.map_or(0.0, |offset| {
            let scaled = ValueRange { min: range.min - offset, max: range.max - offset };
            ulp(scaled.union(range))
        });
        let by = self.shader
            + self.shader_share * stated.span()
            + self.shader_ulps * ulp(stated)
            + Self::INTERPOLATION_ULPS * ulp(range)
            + Self::TEXEL_ULPS * texel;
        let sampled = [f64::from(range.min), f64::from(range.max)];
        let [low, high] = self
            .blocks
            .map_or(sampled, |blocks| blocks.widened(sampled, known.map(|known| known.union(range))));
        ValueRange { min: (low - by) as f32, max: (high + by) as f32 }
    }
}

#[cfg(test)]
mod tests;
