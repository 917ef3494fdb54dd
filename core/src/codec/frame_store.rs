//! Decoded frames of a stream, kept within a bound. Predicted frames are decoded from them.

use std::borrow::Cow;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{
    BlockTexture, DecodeError, DecodedForm, DecodedFrame, Decoder, FrameDecode, Resource, ShaderDecode,
};
use crate::memory;
use crate::volume::{BrickKey, Dependencies, FrameIndex, Level, ReferenceFrames, ValueRange, VolumeLayout};

/// The decoded frames that one frame is predicted from, in the order of its [`Dependencies`].
#[derive(Clone, Debug, Default)]
pub struct References(Vec<(FrameIndex, Arc<DecodedFrame>)>);

impl ReferenceFrames for References {
    fn frame(&self, frame: FrameIndex) -> Option<&[f32]> {
        self.0.iter().find(|(of, _)| *of == frame).map(|(_, decoded)| decoded.values())
    }
}

impl References {
    /// Names of the buffers of [`References::resources`], without the codec's prefix.
    pub const RESOURCES: [&str; 2] = ["reference", "second_reference"];

    /// The references as buffers that a shader reads next to the codec's own: the bits of one `f32` per sample, x
    /// fastest, channels interleaved. `<id>_reference(i)` is the frame of [`Dependencies::Predicted`], or the first of
    /// [`Dependencies::Bidirectional`]; `<id>_second_reference(i)` is the second. Empty for a frame that decodes on its
    /// own.
    ///
    /// # Errors
    /// If there is no memory for the copies.
    pub fn resources(&self) -> Result<Vec<Resource<'static>>, DecodeError> {
        let resource = |(name, (frame, decoded)): (&&'static str, &(FrameIndex, Arc<DecodedFrame>))| {
            let values = decoded.values();
            memory::check(size_of_val(values) as u64, || format!("frame {} as a reference", frame.0))?;
            let words = values.iter().map(|value| value.to_bits()).collect();
            Ok(Resource { name, words: Cow::Owned(words) })
        };
        Self::RESOURCES.iter().zip(&self.0).map(resource).collect()
    }
}

/// A decoder that keeps decoded frames and decodes predicted frames from them. It decodes frames in an order that their
/// dependencies allow. It keeps the frames used last, up to a bound on their bytes. References of a frame stay while
/// that frame is decoded, even beyond the bound. The bound changes how often frames are decoded, never their values.
///
/// References have the level of the decoded frame.
#[derive(Debug)]
pub struct FrameStore {
    decoder: Arc<dyn Decoder>,
    bound_bytes: u64,
    kept: Mutex<Vec<Kept>>,
}

/// A kept frame. The last in the list is the one used last.
#[derive(Debug)]
struct Kept {
    key: (FrameIndex, Level),
    frame: Arc<DecodedFrame>,
}

/// A frame that is being decoded, with the references found so far.
struct Pending {
    frame: FrameIndex,
    found: References,
}

impl FrameStore {
    /// Megabytes (10⁶ bytes) of decoded frames that are kept unless the user says otherwise.
    pub const DEFAULT_MB: u32 = 512;

    /// `decoder` itself if every frame decodes on its own. Else a decoder that keeps at most `bound_bytes` of decoded
    /// frames.
    #[must_use]
    pub fn open(decoder: Arc<dyn Decoder>, bound_bytes: u64) -> Arc<dyn Decoder> {
        let is_predicted = |frame| decoder.dependencies(FrameIndex(frame)) != Dependencies::Intra;
        if (0..decoder.layout().frames).any(is_predicted) {
            Arc::new(Self { decoder, bound_bytes, kept: Mutex::default() })
        } else {
            decoder
        }
    }

    /// [`FrameStore::open`] with a bound in megabytes.
    #[must_use]
    pub fn open_mb(decoder: Arc<dyn Decoder>, megabytes: u32) -> Arc<dyn Decoder> {
        Self::open(decoder, u64::from(megabytes) * 1_000_000)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Kept>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn find(&self, key: (FrameIndex, Level)) -> Option<Arc<DecodedFrame>> {
        let mut kept = self.lock();
        let at = kept.iter().position(|kept| kept.key == key)?;
        let found = kept.remove(at);
        let frame = found.frame.clone();
        kept.push(found);
        Some(frame)
    }

    /// Decodes a frame and keeps it. Kept frames are dropped if memory is short.
    fn decode(
        &self,
        (frame, level): (FrameIndex, Level),
        references: &References,
    ) -> Result<Arc<DecodedFrame>, DecodeError> {
        let fresh = || DecodedFrame::fresh(self.decoder.as_ref(), frame, level, references);
        let decoded = match fresh() {
            Err(DecodeError::Memory(_)) => {
                self.lock().clear();
                fresh()
            }
            other => other,
        };
        let decoded = Arc::new(decoded?);
        self.keep((frame, level), &decoded);
        Ok(decoded)
    }

    fn keep(&self, key: (FrameIndex, Level), frame: &Arc<DecodedFrame>) {
        let mut kept = self.lock();
        kept.retain(|kept| kept.key != key);
        kept.push(Kept { key, frame: frame.clone() });
        let bytes = |kept: &[Kept]| kept.iter().map(|k| size_of_val(k.frame.values()) as u64).sum::<u64>();
        while bytes(&kept) > self.bound_bytes && !kept.is_empty() {
            kept.remove(0);
        }
    }

    /// The first reference of a frame that is not found yet.
    fn missing(&self, pending: &Pending) -> Option<FrameIndex> {
        let needed = self.decoder.dependencies(pending.frame).frames();
        needed.into_iter().flatten().nth(pending.found.0.len())
    }

    /// Finds the references of a frame. Decodes those that are not kept.
    fn resolve(&self, frame: FrameIndex, level: Level) -> Result<References, DecodeError> {
        let frames = self.decoder.layout().frames;
        if frame.0 >= frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {frames}", frame.0)));
        }
        // A list instead of recursion: chains of hundreds of predicted frames are common.
        let mut path = vec![Pending { frame, found: References::default() }];
        while let Some(top) = path.last_mut() {
            let Some(next) = self.missing(top) else {
                let Some(Pending { frame: done, found }) = path.pop() else { break };
                let Some(waiting) = path.last_mut() else { return Ok(found) };
                waiting.found.0.push((done, self.decode((done, level), &found)?));
                continue;
            };
            if next.0 >= frames {
                let problem =
                    format!("frame {} is predicted from frame {}, of {frames}", top.frame.0, next.0);
                return Err(DecodeError::Corrupt(problem));
            }
            if let Some(kept) = self.find((next, level)) {
                top.found.0.push((next, kept));
            } else if let Some(from) = path.iter().position(|pending| pending.frame == next) {
                let circle = path[from..].iter().map(|pending| pending.frame).chain([next]);
                let circle: Vec<String> = circle.map(|frame| frame.0.to_string()).collect();
                let problem = format!("frames are predicted in a circle: {}", circle.join(" from "));
                return Err(DecodeError::Corrupt(problem));
            } else {
                path.push(Pending { frame: next, found: References::default() });
            }
        }
        Ok(References::default())
    }
}

impl Decoder for FrameStore {
    fn layout(&self) -> &VolumeLayout {
        self.decoder.layout()
    }

    fn dependencies(&self, frame: FrameIndex) -> Dependencies {
        self.decoder.dependencies(frame)
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        self.decoder.decode_brick(key, references, out)
    }

    fn references(&self, frame: FrameIndex, level: Level) -> Result<References, DecodeError> {
        self.resolve(frame, level)
    }

    fn kept_frame(&self, frame: FrameIndex, level: Level) -> Result<Option<Arc<DecodedFrame>>, DecodeError> {
        if let Some(kept) = self.find((frame, level)) {
            return Ok(Some(kept));
        }
        let references = self.resolve(frame, level)?;
        self.decode((frame, level), &references).map(Some)
    }

    fn rebuilds_frames(&self) -> bool {
        self.decoder.rebuilds_frames()
    }

    fn coarse_shift(&self, resolution: u8) -> f32 {
        self.decoder.coarse_shift(resolution)
    }

    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        self.decoder.value_range(key)
    }

    fn decoded_form(&self) -> DecodedForm {
        self.decoder.decoded_form()
    }

    fn block_texture(&self, frame: FrameIndex, level: Level) -> Option<BlockTexture<'_>> {
        self.decoder.block_texture(frame, level)
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.decoder.shader()
    }

    fn frame_decode(&self) -> Option<&dyn FrameDecode> {
        self.decoder.frame_decode()
    }
}

#[cfg(test)]
mod tests;
