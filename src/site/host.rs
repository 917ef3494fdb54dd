//! The site *host*: a frame in a texture that the device only reads. If the texture holds the codec's blocks, the
//! texture unit decodes them, and its values are compared with the CPU's.

use std::sync::Arc;

use cvr_core::codec::Site;
use cvr_core::render::Plan;
use cvr_core::shader::Source;
use cvr_core::volume::VolumeLayout;
use cvr_engine::{BlockFallback, DrawSource, EngineError, VolumeTexture};

use super::coded::CodedFrame;
use super::expected::{Checked, Expected};
use super::holding::{DecodeOnCpu, HeldFrame, Holding, MirrorFrame, Preparation, SayHolder};
use super::host_texture::{HostTexture, blocks};
use super::target::{DrawError, Target};

/// The site *host*.
#[derive(Debug)]
pub struct Host;

impl Holding for Host {
    fn site(&self) -> Site {
        Site::Host
    }

    fn prepare(
        &self,
        target: &Target,
        coded: CodedFrame<'_>,
        decoded: DecodeOnCpu<'_>,
        _timed: bool,
    ) -> Result<Arc<dyn HeldFrame>, DrawError> {
        let Target::Device(device) = target else { return MirrorFrame::held(decoded) };
        let (layout, form) = (&coded.layout(), coded.decoder.decoded_form());
        let (texture, fallback) = match blocks(target, coded) {
            Some(Ok(blocks)) => (VolumeTexture::upload_blocks(device, layout, &blocks)?, None),
            other => {
                let frame = decoded().map_err(DrawError::Frame)?;
                let reason = other.and_then(Result::err);
                (VolumeTexture::upload(device, layout, frame.values(), form)?, reason)
            }
        };
        Ok(Arc::new(HostFrame { texture: Arc::new(texture), fallback }))
    }

    fn source<'a>(&self, coded: CodedFrame<'a>, _plan: &Plan, target: &Target) -> Result<Source<'a>, String> {
        HostTexture::of(target, coded).map(|texture| texture.source(coded)).map_err(|e| e.to_string())
    }

    fn device_bytes(
        &self,
        trial: CodedFrame<'_>,
        target: &Target,
        layout: &VolumeLayout,
    ) -> Result<f64, String> {
        let bytes_per_voxel = match blocks(target, trial) {
            Some(Ok(blocks)) => (blocks.words.len() * 4) as f64 / trial.layout().extent.voxels() as f64,
            _ => trial.texel_bytes() as f64,
        };
        Ok(layout.extent.voxels() as f64 * bytes_per_voxel)
    }

    fn holder(&self) -> Option<SayHolder> {
        Some(|coded, target| match HostTexture::of(target, coded) {
            Ok(texture) => Ok(texture.to_string()),
            Err(problem) => Err(problem.to_string()),
        })
    }

    /// A texture unit decodes if the texture holds the codec's blocks.
    fn device_decodes(&self, coded: CodedFrame<'_>) -> bool {
        let (frame, level) = coded.key;
        coded.decoder.layout().channels == 1 && coded.decoder.block_texture(frame, level).is_some()
    }
}

/// A frame in a texture: the codec's blocks if the device's texture units can decode them, else the frame that the CPU
/// decoded.
#[derive(Debug)]
struct HostFrame {
    texture: Arc<VolumeTexture>,
    /// Why the texture does not hold the codec's blocks, if the codec has blocks.
    fallback: Option<BlockFallback>,
}

impl HeldFrame for HostFrame {
    fn source<'a>(&self, _coded: CodedFrame<'a>) -> Result<DrawSource<'a>, EngineError> {
        Ok(DrawSource::Texture(self.texture.clone()))
    }

    /// Compares the blocks that a shader loads, within the tolerance of their format.
    fn check(
        &self,
        target: &Target,
        expected: &Expected<'_>,
        _as_cells: bool,
    ) -> Result<Option<Checked>, String> {
        let Target::Device(device) = target else { return Ok(None) };
        let Some(Ok(blocks)) = blocks(target, expected.coded()) else { return Ok(None) };
        let values = self.texture.read(device).map_err(|e| e.to_string())?;
        let checked = expected.compare("what the texture unit decodes", blocks.agreement(), &values);
        let off = checked.largest;
        let remark = (off > 0.0)
            .then(|| format!("the texture unit decodes up to {off:.4} beside the definition of its format"));
        Ok(Some(Checked { remark, ..checked }))
    }

    fn preparation(&self) -> Preparation {
        Preparation {
            remarks: self.fallback.iter().map(ToString::to_string).collect(),
            ..Preparation::default()
        }
    }
}
