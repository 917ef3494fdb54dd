//! The traits of a codec: encoder, decoder, and a few lines of WGSL.

mod all_frames;
mod block;
mod block_texture;
mod decoded_frame;
mod encode;
mod encode_file;
mod encode_report;
mod error;
mod frame_decode;
mod frame_store;
mod info;
mod latest_frame;
mod parity;
mod pieces;
mod progress;
mod registry;
mod settings;
mod shader_decode;
mod site;
mod stream;

pub(crate) use all_frames::Decoded;
pub use block::Block;
pub use block_texture::{BlockFormat, BlockTexture};
pub use decoded_frame::DecodedFrame;
pub use encode::Encoder;
pub use encode_file::{encode_file, encode_temporary};
pub use encode_report::EncodeReport;
pub use error::{ConfigError, DecodeError, EncodeError};
pub use frame_decode::{FrameDecode, FramePass, FramePasses, Scratch, ScratchUse, deferred_agreement};
pub use frame_store::{FrameStore, References};
pub use info::{CodecInfo, Paper};
pub use latest_frame::LatestFrame;
pub use parity::{Mismatch, Parity};
pub use pieces::decode_pieces;
pub use progress::{Cancelled, Progress};
pub use registry::{Registry, RegistryError};
pub use settings::{Setting, SettingKind, SettingValue, Settings};
pub use shader_decode::{
    Agreement, Constant, ConstantValue, DecodedForm, Resource, ShaderDecode, TexelFormat, VoxelDump,
    WgslModule,
};
pub use site::{DecodedBy, Granularity, Site};
pub use stream::{check_key, check_key_at, check_stream};

use std::fmt::Debug;
use std::sync::Arc;

use crate::container::EncodedVolume;
use crate::memory;
use crate::volume::{BrickKey, Dependencies, FrameIndex, Level, ReferenceFrames, ValueRange, VolumeLayout};

/// A compression method for volumes.
pub trait Codec: Send + Sync + Debug {
    /// Identity, capabilities and the schema of the settings.
    fn info(&self) -> &CodecInfo;

    /// Number of stages of a volume encoded with these (complete) settings. The volume decodes from the first stage,
    /// from the first two, and so on. A codec without stages has one.
    fn stages(&self, _settings: &Settings) -> u8 {
        1
    }

    /// Number of resolutions of a volume encoded with these (complete) settings, the full one included.
    /// [`Level::resolution`] is below this number. A codec without coarser resolutions has one.
    fn resolutions(&self, _settings: &Settings) -> u8 {
        1
    }

    /// The block size with these (complete) settings, if blocks are coded on their own, so that errors may jump from
    /// block to block. Blocks start at the first voxel. By default it is the first setting of kind block. A codec whose
    /// block size is not a setting returns it here.
    fn block(&self, settings: &Settings) -> Option<Block> {
        let setting = self.info().settings.iter().find(|s| matches!(s.kind, SettingKind::Block { .. }))?;
        settings.block(setting.name).ok()
    }

    /// Who can decode a volume encoded with these (complete) settings. By default everyone who decodes volumes of this
    /// codec at all. [`CodecInfo::decoded_by`] is the union over all settings.
    fn decoded_by(&self, _settings: &Settings) -> &'static [DecodedBy] {
        self.info().decoded_by
    }

    /// Whether a volume encoded with these (complete) settings can be decoded at `site`.
    fn offers(&self, settings: &Settings, site: Site) -> bool {
        site.offered_by(self.decoded_by(settings))
    }

    /// An encoder with these settings. They must be complete (defaults filled in) and of the declared kinds.
    ///
    /// # Errors
    /// When settings contradict each other.
    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError>;

    /// A decoder. The stream holds every parameter that it needs.
    ///
    /// # Errors
    /// When tensors are missing, of the wrong type or size, or parameters contradict them.
    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError>;
}

/// Decodes one stream on the CPU. Stateless: the caller passes references in, so the order of calls does not matter.
/// The CPU decoder *defines* the codec. Parity tests compare the shader with it.
pub trait Decoder: Send + Sync + Debug {
    /// Shape of the decoded volume.
    fn layout(&self) -> &VolumeLayout;

    /// Frames that must be decoded before `frame`, at the same level as `frame`.
    fn dependencies(&self, _frame: FrameIndex) -> Dependencies {
        Dependencies::Intra
    }

    /// The decoded references of `frame`, at a level. A codec's own decoder holds none. [`FrameStore`] wraps every
    /// decoder of predicted frames and holds them.
    ///
    /// # Errors
    /// When one of them is missing from the stream or does not decode, or frames are predicted in a circle.
    fn references(&self, _frame: FrameIndex, _level: Level) -> Result<References, DecodeError> {
        Ok(References::default())
    }

    /// A whole frame at a level, if this decoder keeps decoded frames. Else `None`.
    ///
    /// # Errors
    /// As [`Decoder::references`] and [`Decoder::decode_brick`].
    fn kept_frame(
        &self,
        _frame: FrameIndex,
        _level: Level,
    ) -> Result<Option<Arc<DecodedFrame>>, DecodeError> {
        Ok(None)
    }

    /// Decodes a box of voxels into `out` (x fastest, channels interleaved), in data units. The box may be any box
    /// inside the volume, also a single voxel.
    ///
    /// # Errors
    /// When the key lies outside, a level does not exist, a reference is missing or the stream is corrupt.
    ///
    /// # Panics
    /// When `out` has not exactly region voxels × channels elements.
    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError>;

    /// Whether any box costs a whole frame, because the codec rebuilds whole frames. Other codecs decode a frame piece
    /// by piece when it is written to a file.
    fn rebuilds_frames(&self) -> bool {
        false
    }

    /// A range that holds every *decoded* value of the box (all channels), if the codec knows one without decoding. It
    /// may be wider than necessary.
    fn value_range(&self, _key: BrickKey) -> Option<ValueRange> {
        None
    }

    /// How far voxels of a resolution are drawn before the place that they stand for, in voxels of the resolution along
    /// every axis. 0 if voxel `i` stands for the middle of the voxels `i · 2^r .. (i + 1) · 2^r`. A filter may have
    /// another middle.
    fn coarse_shift(&self, _resolution: u8) -> f32 {
        0.0
    }

    /// The smallest texel format that holds decoded values without loss.
    fn decoded_form(&self) -> DecodedForm {
        DecodedForm::FLOAT32
    }

    /// A frame at a level as blocks that texture units decode, if the stream consists of such blocks. If the device
    /// supports them, the site *host* uploads them instead of the decoded frame.
    fn block_texture(&self, _frame: FrameIndex, _level: Level) -> Option<BlockTexture<'_>> {
        None
    }

    /// How a shader decodes one voxel, if it can.
    fn shader(&self) -> Option<&dyn ShaderDecode> {
        None
    }

    /// How passes of the codec rebuild a whole frame on a device, if it has such passes. The site *deferred* then runs
    /// them and does not call [`Decoder::shader`].
    fn frame_decode(&self) -> Option<&dyn FrameDecode> {
        None
    }
}

/// Decodes a whole frame, bricks in parallel.
///
/// # Errors
/// As [`Decoder::decode_brick`]; also when there is no memory for it.
pub fn decode_frame(
    decoder: &dyn Decoder,
    frame: FrameIndex,
    references: &dyn ReferenceFrames,
) -> Result<Vec<f32>, DecodeError> {
    decode_stages(decoder, frame, Level::ALL_STAGES, references)
}

/// As [`decode_frame`], from the first `stages` stages. A number above the stream's stages means all stages.
///
/// # Errors
/// As [`decode_frame`].
pub fn decode_stages(
    decoder: &dyn Decoder,
    frame: FrameIndex,
    stages: u8,
    references: &dyn ReferenceFrames,
) -> Result<Vec<f32>, DecodeError> {
    decode_level(decoder, frame, Level { stages, ..Level::FULL }, references)
}

/// As [`decode_frame`], at a level. `references` have that level.
///
/// # Errors
/// As [`decode_frame`].
pub fn decode_level(
    decoder: &dyn Decoder,
    frame: FrameIndex,
    level: Level,
    references: &dyn ReferenceFrames,
) -> Result<Vec<f32>, DecodeError> {
    use rayon::prelude::*;

    use crate::volume::{Extent, Region};

    let layout = decoder.layout().at_resolution(level.resolution);
    let [x, y, _] = layout.extent.to_array();
    let slab = x as usize * y as usize * layout.channels as usize;
    let what = || format!("a decoded frame of {} voxels", layout.extent);
    let mut out = memory::zeroed(layout.samples_per_frame(), what)?;
    let held = memory::Held::of(&out);
    // Slabs of 8 slices are contiguous in memory, so each thread writes its own part of the output.
    const SLICES: u32 = 8;
    out.par_chunks_mut(slab * SLICES as usize).enumerate().try_for_each(|(i, out)| {
        let slices = (out.len() / slab) as u32;
        let extent = Extent::new(x, y, slices).map_err(|e| DecodeError::Corrupt(e.to_string()))?;
        let region = Region { origin: [0, 0, i as u32 * SLICES], extent };
        decoder.decode_brick(BrickKey { frame, level, region }, references, out)
    })?;
    // What keeps the values counts them from here on.
    drop(held);
    Ok(out)
}
