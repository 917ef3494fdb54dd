//! The site *deferred*: the device decodes a frame once, before it draws.

use std::sync::Arc;

use cvr_core::codec::{Site, deferred_agreement};
use cvr_core::render::Plan;
use cvr_core::shader::{BindingLimits, DeferredShaders, Source, TextureSampling};
use cvr_core::volume::VolumeLayout;
use cvr_engine::timing::repeated;
use cvr_engine::{DrawSource, EngineError, FrameDecoder, VolumeTexture};

use super::coded::CodedFrame;
use super::expected::{Checked, Expected};
use super::holding::{DecodeOnCpu, HeldFrame, Holding, MirrorFrame, Preparation};
use super::target::{DrawError, Target};

/// Runs that are timed, after one to warm up.
const RUNS: usize = 3;

/// The site *deferred*. The CPU mirror, which has no textures, draws from the frame that the CPU decodes.
#[derive(Debug)]
pub struct Deferred;

impl Holding for Deferred {
    fn site(&self) -> Site {
        Site::Deferred
    }

    fn prepare(
        &self,
        target: &Target,
        coded: CodedFrame<'_>,
        decoded: DecodeOnCpu<'_>,
        timed: bool,
    ) -> Result<Arc<dyn HeldFrame>, DrawError> {
        let Target::Device(device) = target else { return MirrorFrame::held(decoded) };
        let CodedFrame { codec, decoder, key: (frame, level) } = coded;
        let passes = FrameDecoder::new(device, codec, decoder, frame, level)?;
        let mut preparation = Preparation::default();
        if timed {
            preparation.device_decode_ms = Some(repeated(|| passes.decode(), RUNS)?.0);
            preparation.device_decode_bytes = Some(passes.peak_bytes());
        } else {
            passes.decode()?;
        }
        // Resources that only decoding needs are freed here.
        let texture = Arc::new(passes.texture().clone());
        Ok(Arc::new(DeferredFrame { texture, preparation }))
    }

    fn source<'a>(
        &self,
        coded: CodedFrame<'a>,
        _plan: &Plan,
        _target: &Target,
    ) -> Result<Source<'a>, String> {
        let form = coded.decoder.decoded_form();
        Ok(Source::Texture { form, sampling: TextureSampling::Hardware, padded: None })
    }

    fn passes(&self, coded: CodedFrame<'_>, _plan: &Plan) -> Result<Vec<String>, String> {
        let CodedFrame { codec, decoder, key } = coded;
        let (format, limits) = (decoder.decoded_form().format, BindingLimits::default());
        let shaders = DeferredShaders::generate(codec, decoder, key, format, limits);
        Ok(shaders.map_err(|e| e.to_string())?.texts().map(str::to_owned).collect())
    }

    fn device_bytes(
        &self,
        trial: CodedFrame<'_>,
        _target: &Target,
        layout: &VolumeLayout,
    ) -> Result<f64, String> {
        let voxels = layout.extent.voxels() as f64;
        Ok(voxels * trial.texel_bytes() as f64 + voxels * trial.buffer_bytes_per_voxel()?)
    }
}

/// A frame in a texture that the device filled.
#[derive(Debug)]
struct DeferredFrame {
    texture: Arc<VolumeTexture>,
    preparation: Preparation,
}

impl HeldFrame for DeferredFrame {
    fn source<'a>(&self, _coded: CodedFrame<'a>) -> Result<DrawSource<'a>, EngineError> {
        Ok(DrawSource::Texture(self.texture.clone()))
    }

    fn check(
        &self,
        target: &Target,
        expected: &Expected<'_>,
        _as_cells: bool,
    ) -> Result<Option<Checked>, String> {
        let (Target::Device(device), Some(agreement)) = (target, deferred_agreement(expected.decoder)) else {
            return Ok(None);
        };
        let values = self.texture.read(device).map_err(|e| e.to_string())?;
        Ok(Some(expected.compare("what the device decoded", agreement, &values)))
    }

    fn preparation(&self) -> Preparation {
        self.preparation.clone()
    }
}
