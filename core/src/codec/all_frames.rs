//! All frames of a stream, decoded in an order that their dependencies allow.

use super::{Decoder, decode_stages};
use crate::volume::{Dependencies, FrameIndex, Level, ReferenceFrames};

/// Decoded frames; those at hand serve as references.
#[derive(Debug, Default)]
pub(crate) struct Decoded(Vec<Option<Vec<f32>>>);

impl ReferenceFrames for Decoded {
    fn frame(&self, frame: FrameIndex) -> Option<&[f32]> {
        self.0.get(frame.0 as usize)?.as_deref()
    }
}

impl Decoded {
    /// Decodes every frame; a sentence says why that fails.
    pub(crate) fn all(decoder: &dyn Decoder) -> Result<Self, String> {
        Self::stages(decoder, Level::ALL_STAGES)
    }

    /// Decodes every frame from the first `stages`.
    pub(crate) fn stages(decoder: &dyn Decoder, stages: u8) -> Result<Self, String> {
        let frames = decoder.layout().frames;
        let mut decoded = Self((0..frames).map(|_| None).collect());
        for _ in 0..frames {
            let ready = |f: &FrameIndex| {
                let at_hand = |r| decoded.frame(r).is_some();
                decoded.frame(*f).is_none()
                    && match decoder.dependencies(*f) {
                        Dependencies::Intra => true,
                        Dependencies::Predicted(a) => at_hand(a),
                        Dependencies::Bidirectional(a, b) => at_hand(a) && at_hand(b),
                    }
            };
            let Some(next) = (0..frames).map(FrameIndex).find(ready) else {
                return Err("the dependencies of the frames form a circle".to_owned());
            };
            let values = decode_stages(decoder, next, stages, &decoded)
                .map_err(|e| format!("frame {} does not decode: {e}", next.0))?;
            decoded.0[next.0 as usize] = Some(values);
        }
        Ok(decoded)
    }

    /// The frames in their order; all are there once [`Decoded::all`] has succeeded.
    pub(crate) fn into_frames(self) -> Vec<Vec<f32>> {
        self.0.into_iter().flatten().collect()
    }
}
