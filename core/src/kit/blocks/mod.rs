//! A trait for codecs of blocks: each block of each channel is a record of words, all of one length.
//!
//! The author writes what is particular to the method. The kit owns the grid, channels and frames, the tensor of records, the
//! rows in parallel, the measured error bound, the checks, the buffer and the rest of the shader.
//!
//! The stream is one tensor `blocks` of shape frames × blocks along z × channels × blocks along y × (blocks along x · words of
//! a record). Blocks that the volume's border cuts are filled up by their last voxels. The snippet declares
//! `<id>_value(record: u32, i: u32) -> f32`: voxel `i` (x fastest) of the block whose first word is `<id>_blocks(record)`.
//! It must not declare a name that the kit adds: `<id>_record`, `<id>_place`, `<id>_voxel`, `<id>_fetch`, `<id>_fetch_cell`,
//! but for a snippet that has a faster `<id>_fetch` of its own: it declares all that it needs, and the kit adds nothing.
//! [`CodecInfo::fetch_cell`] is then `true`, as it is with the kit's.

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

    /// From settings, which are complete. They are the parameters of the stream too: a decoder holds them to the schema once
    /// more before it asks.
    ///
    /// # Errors
    /// When settings contradict each other.
    fn from_settings(settings: &Settings) -> Result<Self, ConfigError>;

    /// Size of a block in voxels.
    fn block(&self) -> Block;

    /// Words of the record of a block of one channel.
    fn record_words(&self) -> usize;

    /// Fills the record, all of it zero, of a block of one channel (x fastest).
    fn encode(&self, values: &[f32], record: &mut [u32]);

    /// Voxel `i` of a block, in data units. This one defines the codec.
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

    /// A range that holds all that a record decodes to. By default it is decoded.
    fn range(&self, record: &[u32]) -> ValueRange {
        let values = (0..self.block().0.voxels() as usize).map(|i| self.decode(record, i));
        values
            .map(|v| ValueRange { min: v, max: v })
            .reduce(ValueRange::union)
            .unwrap_or(ValueRange { min: 0.0, max: 0.0 })
    }

    /// Whether an encoder could have written a record; a stream that holds another is refused. By default all that it decodes
    /// to is finite.
    fn is_sound(&self, record: &[u32]) -> bool {
        (0..self.block().0.voxels() as usize).all(|i| self.decode(record, i).is_finite())
    }

    /// The smallest texel that holds decoded values without loss.
    fn decoded_form(&self) -> DecodedForm {
        DecodedForm::FLOAT32
    }

    /// What texture units decode by themselves, if the records of a frame are such.
    fn block_texture<'a>(&self, _words: &'a [u32]) -> Option<BlockTexture<'a>> {
        None
    }

    /// Looks at the whole volume before the first block is coded. What it finds must be in [`BlockCodec::parameters`].
    ///
    /// # Errors
    /// Those of reading, when the codec cannot encode such a volume, and when `run` was cancelled.
    fn measure(&mut self, _source: &dyn BrickSource, _run: &Progress<'_>) -> Result<(), EncodeError> {
        Ok(())
    }

    /// What the stream keeps for a decoder, where that is not the settings.
    fn parameters(&self) -> Option<serde_json::Value> {
        None
    }

    /// From what the stream keeps.
    ///
    /// # Errors
    /// When that is not what [`BlockCodec::parameters`] writes.
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
