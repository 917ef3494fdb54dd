//! A trait for codecs of blocks. Each block of each channel is a record of words; all records have one length.
//!
//! The author writes only the method. The kit owns the grid, channels, frames, the tensor of records, parallel rows,
//! the measured error bound, checks, the buffer, and the rest of the shader.
//!
//! The stream is one tensor `blocks` of shape frames × blocks along z × channels × blocks along y × (blocks along x ·
//! words of a record). Blocks cut by the volume's border are padded with their last voxels. The snippet declares
//! `<id>_value(record: u32, i: u32) -> f32`: voxel `i` (x fastest) of the block whose first word is
//! `<id>_blocks(record)`. It must not declare names that the kit adds: `<id>_record`, `<id>_place`, `<id>_voxel`,
//! `<id>_fetch`, `<id>_fetch_cell`. Exception: a snippet with a faster `<id>_fetch` of its own. It declares everything
//! that it needs, and the kit adds nothing. [`CodecInfo::fetch_cell`] is `true` in both cases.

mod encoder;
mod reader;

use std::fmt::Debug;
use std::marker::PhantomData;
use std::sync::Arc;

use encoder::BlockEncoder;
use reader::Reader;

use crate::codec::{
    Agreement, Block, BlockTexture, Codec, CodecInfo, ConfigError, Constant, DecodeError, DecodedForm,
    Decoder, EncodeError, Encoder, Progress, Settings,
};
use crate::container::EncodedVolume;
use crate::volume::{BrickSource, ValueRange};

/// Tensor and shader resource: the records.
const BLOCKS: &str = "blocks";

/// A codec of blocks with its settings.
pub trait BlockCodec: Debug + Send + Sync + Sized + 'static {
    /// Identity, capabilities and the schema of the settings.
    const INFO: &'static CodecInfo;
    /// The snippet: its path as the author knows it, and its text.
    const SNIPPET: (&'static str, &'static str);

    /// The codec with these complete settings. They are also the parameters of the stream. A decoder checks them
    /// against the schema before it calls this.
    ///
    /// # Errors
    /// If settings contradict each other.
    fn from_settings(settings: &Settings) -> Result<Self, ConfigError>;

    /// Size of a block in voxels.
    fn block(&self) -> Block;

    /// Words of the record of a block of one channel.
    fn record_words(&self) -> usize;

    /// Encodes a block of one channel (`values`, x fastest) into `record`, which is all zero.
    fn encode(&self, values: &[f32], record: &mut [u32]);

    /// Voxel `i` of a block, in data units. This function defines the codec.
    fn decode(&self, record: &[u32], i: usize) -> f32;

    /// Constants of the snippet, without the codec's prefix. The kit adds `block`, `grid` (blocks along each axis),
    /// `channels` and `record_words`.
    fn constants(&self) -> Vec<Constant> {
        Vec::new()
    }

    /// How closely the snippet follows [`BlockCodec::decode`].
    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }

    /// A range that holds all decoded values of a record. By default the record is decoded.
    fn range(&self, record: &[u32]) -> ValueRange {
        let values = (0..self.block().0.voxels() as usize).map(|i| self.decode(record, i));
        values
            .map(|v| ValueRange { min: v, max: v })
            .reduce(ValueRange::union)
            .unwrap_or(ValueRange { min: 0.0, max: 0.0 })
    }

    /// Whether an encoder could have written this record. A stream with an unsound record is refused. By default a
    /// record is sound if all its decoded values are finite.
    fn is_sound(&self, record: &[u32]) -> bool {
        (0..self.block().0.voxels() as usize).all(|i| self.decode(record, i).is_finite())
    }

    /// The smallest texel that holds decoded values without loss.
    fn decoded_form(&self) -> DecodedForm {
        DecodedForm::FLOAT32
    }

    /// The records of a frame as a block texture, if texture units can decode them.
    fn block_texture<'a>(&self, _words: &'a [u32]) -> Option<BlockTexture<'a>> {
        None
    }

    /// Reads the whole volume before the first block is coded. Results that the decoder needs must be in
    /// [`BlockCodec::parameters`].
    ///
    /// # Errors
    /// If reading fails, if the codec cannot encode such a volume, or if `run` was cancelled.
    fn measure(&mut self, _source: &dyn BrickSource, _run: &Progress<'_>) -> Result<(), EncodeError> {
        Ok(())
    }

    /// Parameters that the stream keeps for a decoder, if they are not the settings.
    fn parameters(&self) -> Option<serde_json::Value> {
        None
    }

    /// The codec, from the parameters of a stream.
    ///
    /// # Errors
    /// If the parameters are not what [`BlockCodec::parameters`] writes.
    fn from_stream(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        let settings: Settings = volume.parameters()?;
        let of_schema = Self::INFO.complete(&settings).and_then(|settings| Self::from_settings(&settings));
        of_schema.map_err(|problem| DecodeError::Corrupt(problem.to_string()))
    }
}

/// The codec that a [`BlockCodec`] makes, as a registry takes it.
#[derive(Debug)]
pub struct CodecOfBlocks<C>(PhantomData<C>);

impl<C: BlockCodec> CodecOfBlocks<C> {
    /// The codec.
    #[must_use]
    pub const fn new() -> Self {
        Self(PhantomData)
    }
}

impl<C: BlockCodec> Default for CodecOfBlocks<C> {
    fn default() -> Self {
        Self::new()
    }
}

impl<C: BlockCodec> Codec for CodecOfBlocks<C> {
    fn info(&self) -> &CodecInfo {
        C::INFO
    }

    fn block(&self, settings: &Settings) -> Option<Block> {
        C::from_settings(settings).ok().map(|codec| codec.block())
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let codec = C::from_settings(settings)?;
        Ok(Box::new(BlockEncoder { codec, settings: settings.clone() }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(Reader::<C>::open(&volume)?))
    }
}
