//! The site *deferred*: a frame that the device decodes, once, before it draws.

use std::sync::Arc;

use cvr_core::codec::{Decoder, Parity, deferred_agreement};
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{FrameIndex, Level};
use cvr_engine::timing::repeated;
use cvr_engine::{EngineError, FrameDecoder, VolumeTexture};

use super::checked::{Checked, Expected};
use super::record::Record;
use super::target::{DrawError, Target};

/// Runs that are timed, after one to warm up.
const RUNS: usize = 3;

/// A frame in a texture that the device filled; for the CPU mirror, which has no textures, the decoded frame.
#[derive(Clone, Debug)]
pub struct DeferredVolume {
    pub(super) texture: Option<Arc<VolumeTexture>>,
    pub(super) frame: Option<Arc<DecodedFrame>>,
}

impl Target {
    /// Has the device decode a frame at a level. The mirror draws from `frame`, the same as decoded on the CPU.
    ///
    /// # Errors
    /// When the codec has no shader, or the device refuses it or cannot hold the frame.
    pub fn decode(
        &self,
        codec: &str,
        decoder: &dyn Decoder,
        key: (FrameIndex, Level),
        frame: &Arc<DecodedFrame>,
    ) -> Result<DeferredVolume, DrawError> {
        let Self::Device(device) = self else { return Ok(DeferredVolume::of_mirror(frame)) };
        let (texture, _) = VolumeTexture::decode(device, codec, decoder, key.0, key.1)?;
        Ok(DeferredVolume { texture: Some(Arc::new(texture)), frame: None })
    }
}

/// A frame that the device decoded once for all cells of a codec and its settings: timed, and compared with what the
/// CPU decodes. The cells clone the volume; its memory is freed with the last of them and this.
#[derive(Clone, Debug)]
pub struct SharedDecode {
    volume: DeferredVolume,
    decode_ms: Option<f64>,
    peak_bytes: Option<u64>,
    checked: Option<Checked>,
}

impl SharedDecode {
    /// Has the device decode a frame at a level, several times over. The mirror, which draws from the frame as the CPU
    /// decodes it, has nothing to time and to compare.
    ///
    /// # Errors
    /// As [`Target::decode`], and when the texture cannot be read back.
    pub fn new(target: &Target, expected: &Expected<'_>) -> Result<Self, String> {
        let Expected { codec, decoder, key: (frame, level), .. } = *expected;
        let Target::Device(device) = target else {
            let volume = DeferredVolume::of_mirror(&expected.frame);
            return Ok(Self { volume, decode_ms: None, peak_bytes: None, checked: None });
        };
        let text = |e: EngineError| e.to_string();
        let passes = FrameDecoder::new(device, codec, decoder, frame, level).map_err(text)?;
        let (decode_ms, _) = repeated(|| passes.decode(), RUNS).map_err(text)?;
        let peak_bytes = Some(passes.peak_bytes());
        let texture = Some(Arc::new(passes.texture().clone()));
        // What only decoding needs is freed before the texture is read back.
        drop(passes);
        let volume = DeferredVolume { texture, frame: None };
        let checked = expected.deferred(target, &volume)?;
        Ok(Self { volume, decode_ms: Some(decode_ms), peak_bytes, checked })
    }

    /// The volume, for a cell in whose record time, memory and mismatches are entered.
    ///
    /// # Errors
    /// A sentence, when the device decodes other values than the CPU.
    pub fn enter(&self, record: &mut Record) -> Result<DeferredVolume, String> {
        record.device_decode_ms = self.decode_ms;
        record.device_decode_bytes = self.peak_bytes;
        self.checked.as_ref().map_or(Ok(()), |checked| checked.enter(record))?;
        Ok(self.volume.clone())
    }
}

impl DeferredVolume {
    fn of_mirror(frame: &Arc<DecodedFrame>) -> Self {
        Self { texture: None, frame: Some(frame.clone()) }
    }

    /// The texels against `frame`, at its place in the stream `key`, which the CPU decoded, under the codec's statement; `None` for the mirror, which
    /// draws from that very frame.
    ///
    /// # Errors
    /// When the texture cannot be read back.
    pub fn parity(
        &self,
        target: &Target,
        decoder: &dyn Decoder,
        key: (FrameIndex, Level),
        frame: &DecodedFrame,
    ) -> Result<Option<Parity>, DrawError> {
        let agreement = deferred_agreement(decoder);
        let (Target::Device(device), Some(texture), Some(agreement)) = (target, &self.texture, agreement)
        else {
            return Ok(None);
        };
        let values = texture.read(device)?;
        Ok(Some(Parity::compare_at(decoder, agreement, key, frame.values(), &values)))
    }
}
