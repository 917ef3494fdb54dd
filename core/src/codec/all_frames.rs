//! All frames of a stream at a level.

use std::sync::Arc;

use super::{DecodedFrame, Decoder};
use crate::volume::{FrameIndex, Level, ReferenceFrames};

/// Every frame, decoded; they serve as references.
#[derive(Debug, Default)]
pub(crate) struct Decoded(Vec<Arc<DecodedFrame>>);

impl ReferenceFrames for Decoded {
    fn frame(&self, frame: FrameIndex) -> Option<&[f32]> {
        self.0.get(frame.0 as usize).map(|decoded| decoded.values())
    }
}

impl Decoded {
    /// Decodes every frame. The error is a sentence. For a stream with predicted frames, `decoder` must keep decoded
    /// frames ([`super::FrameStore`]).
    pub(crate) fn at(decoder: &dyn Decoder, level: Level) -> Result<Self, String> {
        let decode = |frame: u32| {
            DecodedFrame::at(decoder, FrameIndex(frame), level)
                .map_err(|e| format!("frame {frame} does not decode: {e}"))
        };
        (0..decoder.layout().frames).map(decode).collect::<Result<_, _>>().map(Self)
    }

    /// The frames in their order.
    pub(crate) fn into_frames(self) -> Vec<Vec<f32>> {
        self.0.into_iter().map(|decoded| Arc::unwrap_or_clone(decoded).into_values()).collect()
    }
}
