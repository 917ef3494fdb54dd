//! The site *inline*: a shader decodes at every fetch, from the codec's buffers.

use std::sync::Arc;

use cvr_core::codec::{Site, VoxelDump as _};
use cvr_core::render::Plan;
use cvr_core::shader::{ResourceSize, Source, snippet_resources};
use cvr_core::volume::VolumeLayout;
use cvr_engine::{DrawSource, EngineError};

use super::coded::CodedFrame;
use super::expected::{Checked, Expected};
use super::holding::{DecodeOnCpu, HeldFrame, Holding};
use super::target::{DrawError, Target};

/// The site *inline*.
#[derive(Debug)]
pub struct Inline;

impl Holding for Inline {
    fn site(&self) -> Site {
        Site::Inline
    }

    fn prepare(
        &self,
        _target: &Target,
        _coded: CodedFrame<'_>,
        _decoded: DecodeOnCpu<'_>,
        _timed: bool,
    ) -> Result<Arc<dyn HeldFrame>, DrawError> {
        Ok(Arc::new(InlineFrame))
    }

    fn source<'a>(
        &self,
        coded: CodedFrame<'a>,
        _plan: &Plan,
        _target: &Target,
    ) -> Result<Source<'a>, String> {
        let CodedFrame { codec, decoder, key: (frame, level) } = coded;
        let shader =
            decoder.shader().ok_or_else(|| format!("codec `{codec}` does not decode in a shader"))?;
        let resources = snippet_resources(codec, decoder, shader, coded.key).map_err(|e| e.to_string())?;
        let resources = resources.iter().map(ResourceSize::of).collect();
        Ok(Source::Inline { codec, module: shader.module(), resources, frame, level })
    }

    fn device_bytes(
        &self,
        trial: CodedFrame<'_>,
        _target: &Target,
        layout: &VolumeLayout,
    ) -> Result<f64, String> {
        Ok(layout.extent.voxels() as f64 * trial.buffer_bytes_per_voxel()?)
    }

    fn draws_mismatches(&self) -> bool {
        true
    }
}

/// Nothing in addition to the stream.
#[derive(Debug)]
struct InlineFrame;

impl HeldFrame for InlineFrame {
    fn source<'a>(&self, coded: CodedFrame<'a>) -> Result<DrawSource<'a>, EngineError> {
        let CodedFrame { codec, decoder, key: (frame, level) } = coded;
        Ok(DrawSource::Inline { codec, decoder, frame, level })
    }

    fn check(
        &self,
        target: &Target,
        expected: &Expected<'_>,
        as_cells: bool,
    ) -> Result<Option<Checked>, String> {
        let Expected { codec, decoder, key, .. } = *expected;
        let (Target::Device(device), Some(shader)) = (target, decoder.shader()) else { return Ok(None) };
        let by = |what: &str, use_cell: bool| {
            let dump = device.dump_at(codec, decoder, key, use_cell)?;
            Ok::<_, String>(expected.compare(what, shader.agreement(), &dump))
        };
        let fetched = by("what the shader fetches", false)?;
        if !as_cells {
            return Ok(Some(fetched));
        }
        Ok(Some(fetched.and(by("what the shader fetches as cells (fetch_cell)", true)?)))
    }

    fn holds_memory(&self) -> bool {
        false
    }
}
