//! A pass of a plan made runnable.

use std::sync::Arc;

use cvr_core::render::{Filter, Pass, Stage};
use cvr_core::shader::GeneratedShader;

use super::rays;
use crate::bindings::{Bound, Parts, Supplies, check_workgroups};
use crate::canvas::{Canvas, blend};
use crate::layers::{BoundLayers, LayerRing};
use crate::pipelines::Target;
use crate::raster::BoundRaster;
use crate::source::Voxels;
use crate::timestamps::FrameTimestamps;
use crate::{Device, EngineError};

/// A pass made runnable.
#[derive(Debug)]
pub(super) enum Runnable {
    Compute(Bound, [u32; 3]),
    Raster(BoundRaster, wgpu::TextureView),
    Layers(BoundLayers, wgpu::TextureView),
}

impl Runnable {
    pub(super) fn new(
        device: &Device,
        (pass, size): (&Pass, [u32; 2]),
        (voxels, filter): (&Voxels<'_>, Filter),
        canvas: &Canvas,
        parts: &mut Parts,
    ) -> Result<(Self, Arc<GeneratedShader>), EngineError> {
        let Pass { pipeline, inputs } = pass;
        let shader = voxels.shader(device, &pipeline.program(), Some(filter))?;
        let supplies = Supplies {
            inputs: &inputs.contents,
            buffers: &voxels.buffers,
            texture: voxels.texture,
            ..Supplies::default()
        };
        let runnable = match (pipeline.proxies(), canvas) {
            (None, Canvas::Buffer(image)) => {
                let workgroups = workgroups(device, pass, size)?;
                let supplies = Supplies { storage: &[("image", image)], ..supplies };
                Self::Compute(Bound::new(device, &shader, Target::Compute, &supplies, parts)?, workgroups)
            }
            (Some(proxies), Canvas::Target(texture)) => {
                let (triangles, format) = ((proxies, &inputs.vertices[..]), texture.format());
                let bound = BoundRaster::new(device, triangles, &shader, format, &supplies, parts)?;
                let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                match pipeline.layers() {
                    Some(_) => Self::Layers(BoundLayers::new(bound, &inputs.steps), view),
                    None => Self::Raster(bound, view),
                }
            }
            _ => {
                let text = "passes of one picture either compute or blend, and this plan mixes them";
                return Err(EngineError::Unsupported(text.to_owned()));
            }
        };
        Ok((runnable, shader))
    }

    /// Takes other inputs.
    pub(super) fn set_inputs(
        &mut self,
        device: &Device,
        pass: &Pass,
        size: [u32; 2],
    ) -> Result<(), EngineError> {
        match self {
            Self::Compute(bound, of_frame) => {
                *of_frame = workgroups(device, pass, size)?;
                bound.set_inputs(device, &pass.inputs.contents)
            }
            Self::Raster(bound, _) => bound.set_inputs(device, &pass.inputs),
            Self::Layers(bound, _) => bound.set_inputs(device, &pass.inputs),
        }
    }

    /// Records the pass, which is the one of this number among `passes`.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (index, passes): (usize, usize),
        ring: Option<&LayerRing>,
        timestamps: Option<&FrameTimestamps>,
    ) {
        match self {
            Self::Compute(bound, workgroups) => {
                let timestamp_writes = timestamps.and_then(|t| t.writes(index, passes));
                let descriptor = wgpu::ComputePassDescriptor { label: Some("draw"), timestamp_writes };
                let mut pass = encoder.begin_compute_pass(&descriptor);
                bound.dispatch(&mut pass, *workgroups);
            }
            Self::Raster(bound, view) => {
                let writes = timestamps.and_then(|t| t.render_writes(index, passes));
                let mut pass = blend(encoder, view, index == 0, writes);
                bound.draw(&mut pass);
            }
            // The only pass of its plan: the timestamps are its own.
            Self::Layers(bound, view) => {
                if let Some(ring) = ring {
                    bound.record(ring, encoder, view, timestamps);
                }
            }
        }
    }
}

/// Workgroups of a compute pass.
fn workgroups(device: &Device, pass: &Pass, size: [u32; 2]) -> Result<[u32; 3], EngineError> {
    let workgroups = match pass.pipeline.stage {
        Stage::Rays(_) => rays::workgroups(size),
        Stage::Compute { .. } | Stage::Triangles(_) | Stage::Layers { .. } => pass.inputs.workgroups,
    };
    check_workgroups(device, "a pass", workgroups)?;
    Ok(workgroups)
}
