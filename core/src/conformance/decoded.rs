//! All frames of a stream, decoded in an order that their dependencies allow.

use crate::codec::{Decoder, decode_stages};
use crate::volume::{Dependencies, FrameIndex, Level, ReferenceFrames};

/// Decoded frames; those at hand serve as references.
#[derive(Debug, Default)]
pub struct Decoded(Vec<Option<Vec<f32>>>);

impl ReferenceFrames for Decoded {
    fn frame(&self, frame: FrameIndex) -> Option<&[f32]> {
        self.0.get(frame.0 as usize)?.as_deref()
    }
}

impl Decoded {
    /// Decodes every frame; a sentence says why that fails.
    pub fn all(decoder: &dyn Decoder) -> Result<Self, String> {
        Self::stages(decoder, Level::ALL_STAGES)
    }

    /// Decodes every frame from the first `stages`.
    pub fn stages(decoder: &dyn Decoder, stages: u8) -> Result<Self, String> {
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

    /// The samples of one frame; all are there once [`Decoded::all`] has succeeded.
    pub fn values(&self, frame: FrameIndex) -> &[f32] {
        self.frame(frame).unwrap_or(&[])
    }
}

/// The first sample in which two frames differ (zeros of either sign are equal), in words.
pub fn difference(expected: &[f32], actual: &[f32]) -> Option<String> {
    if expected.len() != actual.len() {
        return Some(format!("{} samples instead of {}", actual.len(), expected.len()));
    }
    let (i, (e, a)) = expected.iter().zip(actual).enumerate().find(|(_, (e, a))| e != a)?;
    Some(format!("sample {i} is {a}, expected {e}"))
}
