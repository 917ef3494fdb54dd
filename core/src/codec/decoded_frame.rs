//! A decoded frame in memory.

use std::sync::Arc;

use super::{DecodeError, Decoder, decode_level};
use crate::memory::Held;
use crate::volume::{FrameIndex, Level, ReferenceFrames, Region, VolumeLayout};

/// A whole decoded frame at one level. The site *host* draws from it, and predicted frames are decoded from it.
#[derive(Clone, Debug)]
pub struct DecodedFrame {
    layout: VolumeLayout,
    values: Vec<f32>,
    _held: Held,
}

impl DecodedFrame {
    /// A frame made of `values`: x fastest, channels interleaved. `None` if their number does not match `layout`.
    #[must_use]
    pub fn new(layout: VolumeLayout, values: Vec<f32>) -> Option<Self> {
        (values.len() as u64 == layout.samples_per_frame()).then(|| Self {
            layout,
            _held: Held::of(&values),
            values,
        })
    }

    /// Decodes a whole frame at full quality.
    ///
    /// # Errors
    /// As [`Decoder::decode_brick`].
    pub fn decode(decoder: &dyn Decoder, frame: FrameIndex) -> Result<Self, DecodeError> {
        Self::at(decoder, frame, Level::FULL).map(Arc::unwrap_or_clone)
    }

    /// A whole frame at a level. A decoder that keeps frames returns the kept one.
    ///
    /// # Errors
    /// As [`Decoder::decode_brick`].
    pub fn at(decoder: &dyn Decoder, frame: FrameIndex, level: Level) -> Result<Arc<Self>, DecodeError> {
        match decoder.kept_frame(frame, level)? {
            Some(kept) => Ok(kept),
            None => Self::fresh(decoder, frame, level, &decoder.references(frame, level)?).map(Arc::new),
        }
    }

    /// Decodes a whole frame at a level. `references` hold the frames that it is predicted from.
    pub(super) fn fresh(
        decoder: &dyn Decoder,
        frame: FrameIndex,
        level: Level,
        references: &dyn ReferenceFrames,
    ) -> Result<Self, DecodeError> {
        let values = decode_level(decoder, frame, level, references)?;
        let layout = decoder.layout().at_resolution(level.resolution);
        Ok(Self { layout, _held: Held::of(&values), values })
    }

    /// The whole frame, if its codec decodes whole frames (the decoder keeps or rebuilds them). `None` if boxes decode
    /// on their own.
    ///
    /// # Errors
    /// As [`Decoder::decode_brick`].
    pub fn if_whole(
        decoder: &dyn Decoder,
        frame: FrameIndex,
        level: Level,
    ) -> Result<Option<Arc<Self>>, DecodeError> {
        match decoder.kept_frame(frame, level)? {
            None if decoder.rebuilds_frames() => Self::at(decoder, frame, level).map(Some),
            kept => Ok(kept),
        }
    }

    /// Shape of the frame at its level.
    #[must_use]
    pub const fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    /// The values, x fastest, channels interleaved.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The values alone.
    #[must_use]
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// Copies the values of a box. The box must lie inside the frame.
    ///
    /// # Panics
    /// When `out` has not exactly region voxels × channels elements.
    pub fn copy_region(&self, region: Region, out: &mut [f32]) {
        let channels = self.layout.channels as usize;
        assert_eq!(out.len() as u64, region.extent.voxels() * channels as u64, "output of the wrong size");
        let row = region.extent.x() as usize * channels;
        for (start, out) in region.rows().zip(out.chunks_exact_mut(row)) {
            out.copy_from_slice(&self.values[self.layout.extent.index(start) * channels..][..row]);
        }
    }
}
