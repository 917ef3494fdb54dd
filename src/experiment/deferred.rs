//! The site *deferred*: a frame that the device decodes, once, before it draws.

use std::sync::Arc;

use cvr_core::codec::{Decoder, Parity};
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{FrameIndex, Level};
use cvr_engine::timing::repeated;
use cvr_engine::{FrameDecoder, VolumeTexture};

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
    /// Has the device decode the first frame. The mirror draws from `frame`, the same as decoded on the CPU.
    ///
    /// # Errors
    /// When the codec has no shader, or the device refuses it or cannot hold the frame.
    pub fn decode(
        &self,
        codec: &str,
        decoder: &dyn Decoder,
        frame: &Arc<DecodedFrame>,
    ) -> Result<DeferredVolume, DrawError> {
        let Self::Device(device) = self else { return Ok(DeferredVolume::of_mirror(frame)) };
        let (texture, _) = VolumeTexture::decode(device, codec, decoder, FrameIndex::FIRST, Level::FULL)?;
        Ok(DeferredVolume { texture: Some(Arc::new(texture)), frame: None })
    }

    /// As [`Target::decode`], several times over; with the median milliseconds, which the mirror has not.
    ///
    /// # Errors
    /// As [`Target::decode`].
    pub fn decode_timed(
        &self,
        codec: &str,
        decoder: &dyn Decoder,
        frame: &Arc<DecodedFrame>,
    ) -> Result<(DeferredVolume, Option<f64>), DrawError> {
        let Self::Device(device) = self else { return Ok((DeferredVolume::of_mirror(frame), None)) };
        let pass = FrameDecoder::new(device, codec, decoder, FrameIndex::FIRST, Level::FULL)?;
        let (decode_ms, _) = repeated(|| pass.decode(), RUNS)?;
        let texture = Some(Arc::new(pass.texture().clone()));
        Ok((DeferredVolume { texture, frame: None }, Some(decode_ms)))
    }
}

impl DeferredVolume {
    fn of_mirror(frame: &Arc<DecodedFrame>) -> Self {
        Self { texture: None, frame: Some(frame.clone()) }
    }

    /// The texels against `frame`, which the CPU decoded, under the codec's statement; `None` for the mirror, which
    /// draws from that very frame, and for a decoder without a shader.
    ///
    /// # Errors
    /// When the texture cannot be read back.
    pub fn parity(
        &self,
        target: &Target,
        decoder: &dyn Decoder,
        frame: &DecodedFrame,
    ) -> Result<Option<Parity>, DrawError> {
        let (Target::Device(device), Some(texture), Some(shader)) = (target, &self.texture, decoder.shader())
        else {
            return Ok(None);
        };
        let values = texture.read(device)?;
        let agreement = shader.agreement();
        Ok(Some(Parity::compare(decoder, agreement, FrameIndex::FIRST, frame.values(), &values)))
    }
}
