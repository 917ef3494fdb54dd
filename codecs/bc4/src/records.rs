//! BC4 as a codec of blocks. A block is a record of two words.

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, Block, BlockFormat, BlockTexture, CodecInfo, ConfigError, Constant, DecodeError, DecodedForm,
    EncodeError, Progress, Settings, TexelFormat,
};
use cvr_core::container::EncodedVolume;
use cvr_core::kit::{BlockCodec, value_range};
use cvr_core::volume::{BrickSource, Extent, ValueRange};

use crate::INFO;
use crate::block::{EDGE, Ends, PARTS, TEXELS};
use crate::decode::{PART, index, level, value, voxel};
use crate::scale::{Parameters, Scale, checked};
use crate::search::{Quality, encode_block};

/// Texel values of 16 bits per part of a code: the largest number that fits.
const TEXELS_PER_PART: u32 = 65535 / (255 * PARTS);

/// How blocks are coded.
#[derive(Copy, Clone, Debug)]
pub struct Records {
    /// How endpoints are found. The decoder does not use it.
    quality: Quality,
    /// Values of the codes 0 and 255.
    range: ValueRange,
    /// Conversion between codes and values of the range.
    scale: Scale,
}

impl Records {
    fn over(quality: Quality, range: ValueRange) -> Self {
        Self { quality, range, scale: Scale::over(range) }
    }
}

impl BlockCodec for Records {
    const INFO: &'static CodecInfo = &INFO;
    const SNIPPET: (&'static str, &'static str) = ("codecs/bc4/src/decode.wgsl", include_str!("decode.wgsl"));

    fn from_settings(settings: &Settings) -> Result<Self, ConfigError> {
        let quality = Quality::from_name(settings.text("quality")?);
        let quality = quality.ok_or_else(|| ConfigError::Incomplete("quality".to_owned()))?;
        Ok(Self::over(quality, ValueRange { min: 0.0, max: 255.0 }))
    }

    /// Blocks of 4×4 voxels of one slice.
    fn block(&self) -> Block {
        Block(Extent::new(EDGE, EDGE, 1).unwrap_or(Extent::ONE))
    }

    fn record_words(&self) -> usize {
        2
    }

    /// Samples of 8 bits are their own codes. For other types, codes cover the volume's range.
    fn measure(&mut self, source: &dyn BrickSource, run: &Progress<'_>) -> Result<(), EncodeError> {
        let range = match Scale::native(source.layout().sample) {
            Some(range) => range,
            None => checked(value_range(source, self.block(), run)?).map_err(EncodeError::Unsupported)?,
        };
        *self = Self::over(self.quality, range);
        Ok(())
    }

    fn parameters(&self) -> Option<serde_json::Value> {
        serde_json::to_value(Parameters { range: self.range }).ok()
    }

    fn from_stream(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        let Parameters { range } = volume.parameters()?;
        let ordered = range.min.is_finite() && range.max.is_finite() && range.min <= range.max;
        let codec = Self::over(Quality::Search, range);
        if !ordered || !codec.scale.step.is_finite() {
            return Err(DecodeError::Corrupt(format!("a value range of {} to {}", range.min, range.max)));
        }
        Ok(codec)
    }

    fn encode(&self, values: &[f32], record: &mut [u32]) {
        let levels: [i16; TEXELS] = std::array::from_fn(|i| self.scale.level(values[i]));
        record.copy_from_slice(&encode_block(&levels, self.quality));
    }

    #[inline]
    fn decode(&self, record: &[u32], i: usize) -> f32 {
        voxel(&self.scale, [record[0], record[1]], i as u32)
    }

    fn constants(&self) -> Vec<Constant> {
        let Scale { offset, step, high } = self.scale;
        [("offset", offset), ("step", step), ("high", high), ("part", PART)]
            .map(|(name, value)| Constant::new(name, value))
            .into()
    }

    /// A fused multiply-add or another order of the product of three factors and the sum changes two roundings. Each is
    /// half a unit of at most twice the magnitude. The bound is twice that.
    fn agreement(&self) -> Agreement {
        Agreement::Ulp(4)
    }

    /// The range of the endpoints and the value of code 0, because the rounding of `offset + step · code` depends on
    /// both magnitudes.
    fn range(&self, record: &[u32]) -> ValueRange {
        let words = [record[0], record[1]];
        let ends = Ends([words[0] as u8, (words[0] >> 8) as u8]);
        let extremes = (0..TEXELS as u32).fold([false; 2], |[low, high], texel| {
            let index = index(words, texel);
            [low | (index == 6), high | (index == 7)]
        });
        let used = [6, 7].into_iter().zip(extremes).filter(|(_, used)| *used && ends.has_extremes());
        let indices = [0, 1].into_iter().chain(used.map(|(index, _)| index));
        let values = indices.map(|index| value(&self.scale, level(words, index)));
        let ranges = values.map(|v| ValueRange { min: v, max: v });
        ranges.fold(ValueRange { min: self.scale.offset, max: self.scale.offset }, ValueRange::union)
    }

    /// All words are blocks.
    fn is_sound(&self, _record: &[u32]) -> bool {
        true
    }

    fn decoded_form(&self) -> DecodedForm {
        // A constant volume has no range to scale texels over.
        if self.scale.step == 0.0 {
            return DecodedForm::FLOAT32;
        }
        // Every seventh and every fifth of a code is a whole number of texel values.
        let per_code = f64::from(TEXELS_PER_PART * PARTS);
        let scale = (f64::from(self.scale.step) * 65535.0 / per_code) as f32;
        DecodedForm { format: TexelFormat::Unorm16, scale, offset: self.scale.offset }
    }

    fn block_texture<'a>(&self, words: &'a [u32]) -> Option<BlockTexture<'a>> {
        let (scale, offset) = (self.range.span() as f32, self.scale.offset);
        Some(BlockTexture { format: BlockFormat::Bc4, words: Cow::Borrowed(words), scale, offset })
    }
}
