//! A checked stream. The kit turns it into a decoder.

use std::fmt::Debug;

use super::FetchVoxels;
use super::voxels::decode_region;
use crate::codec::{
    Agreement, BlockTexture, DecodeError, DecodedForm, Decoder, Resource, ShaderDecode, WgslModule,
    check_key_at,
};
use crate::volume::{BrickKey, FrameIndex, Level, ReferenceFrames, Region, ValueRange, VolumeLayout};

/// A stream that was checked when it was opened. Its frames do not depend on each other, and any voxel can be fetched.
/// A [`Decoder`] with a shader is derived from it: keys and frame numbers are checked before a method is called.
pub trait StreamReader: Debug + Send + Sync {
    /// A frame at a level.
    type Frame<'a>: FetchVoxels
    where
        Self: 'a;

    /// Shape of the decoded volume.
    fn layout(&self) -> &VolumeLayout;

    /// Number of resolutions, the full one included. See [`crate::codec::Codec::resolutions`].
    fn resolutions(&self) -> u8 {
        1
    }

    /// A frame at a level.
    fn frame(&self, frame: FrameIndex, level: Level) -> Self::Frame<'_>;

    /// A range that holds every decoded value of a box. See [`Decoder::value_range`].
    fn range(&self, key: BrickKey) -> Option<ValueRange>;

    /// The smallest texel format that holds decoded values without loss.
    fn decoded_form(&self) -> DecodedForm {
        DecodedForm::FLOAT32
    }

    /// A frame as a block texture. See [`Decoder::block_texture`].
    fn block_texture(&self, _frame: FrameIndex, _level: Level) -> Option<BlockTexture<'_>> {
        None
    }

    /// Whether a shader can address one frame with 32-bit numbers.
    fn fits_a_shader(&self) -> bool;

    /// The snippet and its constants.
    fn module(&self) -> WgslModule<'_>;

    /// How closely the shader follows the CPU decoder.
    fn agreement(&self) -> Agreement;

    /// The buffers of a frame, in binding order.
    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>>;
}

impl<R: StreamReader> Decoder for R {
    fn layout(&self) -> &VolumeLayout {
        StreamReader::layout(self)
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        _references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        check_key_at(StreamReader::layout(self), self.resolutions(), key)?;
        decode_region(&self.frame(key.frame, key.level), key.region, out);
        Ok(())
    }

    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        check_key_at(StreamReader::layout(self), self.resolutions(), key).ok()?;
        self.range(key)
    }

    fn decoded_form(&self) -> DecodedForm {
        StreamReader::decoded_form(self)
    }

    fn block_texture(&self, frame: FrameIndex, level: Level) -> Option<BlockTexture<'_>> {
        let layout = StreamReader::layout(self);
        let region = Region::whole(layout.extent.at_resolution(level.resolution));
        check_key_at(layout, self.resolutions(), BrickKey { frame, level, region }).ok()?;
        StreamReader::block_texture(self, frame, level)
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.fits_a_shader().then_some(self as &dyn ShaderDecode)
    }
}

impl<R: StreamReader> ShaderDecode for R {
    fn module(&self) -> WgslModule<'_> {
        StreamReader::module(self)
    }

    fn agreement(&self) -> Agreement {
        StreamReader::agreement(self)
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        let frames = StreamReader::layout(self).frames;
        if frame.0 >= frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {frames}", frame.0)));
        }
        Ok(self.buffers(frame))
    }
}
