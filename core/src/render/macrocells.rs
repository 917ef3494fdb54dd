//! Macrocells: boxes of voxels. A renderer skips a box if the transfer function makes all its values transparent.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::TransferFunction;
use crate::codec::{
    Agreement, BlockTexture, DecodeError, DecodedForm, DecodedFrame, Decoder, ShaderDecode, TexelFormat,
};
use crate::volume::{BrickKey, Extent, FrameIndex, Level, Region, ValueRange};

/// Lowest and highest *decoded* value of every macrocell of a frame at a level, with an apron of one voxel. They bound
/// every sample inside, under any filter. Ranges of the original values would be wrong: a lossy codec changes values.
#[derive(Clone, Debug, PartialEq)]
pub struct MacrocellRanges {
    grid: Extent,
    /// `None` if a value is not finite. Such a macrocell is never skipped.
    ranges: Vec<Option<ValueRange>>,
}

/// Which macrocells show anything under a transfer function, one bit each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Macrocells {
    grid: Extent,
    words: Vec<u32>,
}

impl MacrocellRanges {
    /// Decodes `frame` at a level, macrocell by macrocell, in parallel. Macrocells consist of voxels of that level.
    /// Memory use: the ranges, and the decoder's own. A codec of whole frames also holds one frame. `stop` ends it
    /// early with `None`.
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
            // Near its faces, a trilinear filter reads one voxel beyond the macrocell.
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

    /// The ranges of a volume with one value.
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

    /// The range of a macrocell. `None` if a decoded value is not finite.
    #[must_use]
    pub fn range(&self, cell: [u32; 3]) -> Option<ValueRange> {
        self.ranges[self.grid.index(cell)]
    }

    /// Finds the macrocells that a transfer function makes visible.
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

    /// One bit per macrocell, x fastest, lowest bit of a word first: 1 if it shows anything.
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

    /// Fraction of macrocells that show nothing, `0.0..=1.0`.
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

/// How far a sample on a device may lie outside the CPU decoder's range. Zeros are exact everywhere: air of value 0
/// stays 0. Else a transfer function that begins at 0 would never allow skipping.
#[derive(Copy, Clone, Debug)]
struct Slack {
    /// The codec's stated agreement, in units in the last place of the decoder's range.
    shader_ulps: f64,
    /// The same in data units.
    shader: f64,
    /// The same, as a fraction of the span of the decoder's range.
    shader_share: f64,
    /// Value of texel 0, if texels are fractions of a range.
    texel_offset: Option<f32>,
    /// Tolerance of a texture unit that decodes blocks.
    blocks: Option<BlockSlack>,
}

/// A texture unit returns block values within a tolerance. They never leave the range of texels, and the texel 0 is
/// exact.
#[derive(Copy, Clone, Debug)]
struct BlockSlack {
    /// Data units.
    distance: f64,
    /// As a fraction of the span of a block's values.
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

    /// Lowest and highest device sample of voxels whose CPU values span a range. The codec knows that their blocks lie
    /// within `known`.
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
    /// Rounding of interpolation, in units in the last place of the largest value: three differences, products and
    /// sums.
    const INTERPOLATION_ULPS: f64 = 16.0;
    /// Rounding of a texel's conversion to 0..1, scaling and offset, in units in the last place of the largest
    /// intermediate number.
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

    /// The widened range of a macrocell. The codec knows that its values lie within `known`.
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
