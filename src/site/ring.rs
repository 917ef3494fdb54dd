//! The site *ring*: layers that the device decodes while it draws, compared with the CPU's.

use std::sync::Arc;

use cvr_core::codec::Site;
use cvr_core::render::{Plan, RING_LAYERS, RenderError, Renderer, View};
use cvr_core::shader::{BindingLimits, DeferredShaders, Source, TextureSampling};
use cvr_core::volume::{Axis, VolumeLayout};
use cvr_engine::{DrawSource, Drawing, EngineError};

use super::coded::CodedFrame;
use super::expected::{Checked, Expected};
use super::holding::{DecodeOnCpu, HeldFrame, Holding, MirrorFrame};
use super::target::{DrawError, Target};

/// The site *ring*. The CPU mirror, which has no ring, draws from the whole frame.
#[derive(Debug)]
pub struct Ring;

impl Holding for Ring {
    fn site(&self) -> Site {
        Site::Ring
    }

    fn plan(&self, renderer: &dyn Renderer, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
        renderer.plan_layers(view, layout)
    }

    fn prepare(
        &self,
        target: &Target,
        _coded: CodedFrame<'_>,
        decoded: DecodeOnCpu<'_>,
        _timed: bool,
    ) -> Result<Arc<dyn HeldFrame>, DrawError> {
        match target {
            Target::Cpu { .. } => MirrorFrame::held(decoded),
            Target::Device(_) => Ok(Arc::new(RingFrame)),
        }
    }

    fn source<'a>(&self, coded: CodedFrame<'a>, plan: &Plan, _target: &Target) -> Result<Source<'a>, String> {
        let (form, axis) = (coded.decoder.decoded_form(), axis(plan)?);
        Ok(Source::Ring { form, sampling: TextureSampling::Hardware, axis })
    }

    fn passes(&self, coded: CodedFrame<'_>, plan: &Plan) -> Result<Vec<String>, String> {
        let CodedFrame { codec, decoder, key } = coded;
        let (of_layer, limits) = ((decoder.decoded_form().format, axis(plan)?), BindingLimits::default());
        let shaders = DeferredShaders::generate_layers(codec, decoder, key, of_layer, limits);
        Ok(shaders.map_err(|e| e.to_string())?.texts().map(str::to_owned).collect())
    }

    /// For layers across the axis that makes them largest.
    fn device_bytes(
        &self,
        trial: CodedFrame<'_>,
        _target: &Target,
        layout: &VolumeLayout,
    ) -> Result<f64, String> {
        let voxels = layout.extent.voxels() as f64;
        let shortest = layout.extent.to_array().into_iter().min().unwrap_or(1);
        // The ring, and one buffer of the size of a layer.
        let layers = f64::from(RING_LAYERS + 1);
        let buffers = voxels * trial.buffer_bytes_per_voxel()?;
        Ok(buffers + voxels * trial.texel_bytes() as f64 * layers / f64::from(shortest))
    }

    fn mirror_remark(&self) -> Option<&'static str> {
        Some("the CPU mirror has no ring of layers: drawn from the whole frame, as at site deferred")
    }
}

/// The axis across which the layers of a plan lie.
fn axis(plan: &Plan) -> Result<Axis, String> {
    let axis = plan.passes.iter().find_map(|pass| pass.pipeline.layers());
    axis.ok_or_else(|| "the plan does not draw layer by layer".to_owned())
}

/// Nothing in addition to the stream. The ring belongs to the drawing.
#[derive(Debug)]
struct RingFrame;

impl HeldFrame for RingFrame {
    fn source<'a>(&self, coded: CodedFrame<'a>) -> Result<DrawSource<'a>, EngineError> {
        let CodedFrame { codec, decoder, key: (frame, level) } = coded;
        Ok(DrawSource::Ring { codec, decoder, frame, level })
    }

    fn check_drawing(&self, drawing: &Drawing, expected: &Expected<'_>) -> Result<Option<Checked>, String> {
        let Some(values) = drawing.read_layers().map_err(|e| e.to_string())? else { return Ok(None) };
        let shader =
            expected.decoder.shader().ok_or("a ring of layers without a shader that decodes them")?;
        Ok(Some(expected.compare("what came through the ring", shader.agreement(), &values)))
    }

    fn holds_memory(&self) -> bool {
        false
    }
}
