//! Triangles blended into a picture.

use std::ops::Range;

use cvr_core::render::{Blending, Inputs, Proxies, ProxyVertex};
use cvr_core::shader::GeneratedShader;

use crate::bindings::{Bound, Parts, Supplies};
use crate::pipelines::Target;
use crate::{Device, EngineError};

/// A render pipeline, its bindings, and its triangles.
#[derive(Debug)]
pub(crate) struct BoundRaster {
    bound: Bound,
    corners: Option<wgpu::Buffer>,
    count: u32,
}

/// The format in which a device blends sums of this precision.
pub(crate) fn target_format(device: &Device, blending: Blending) -> wgpu::TextureFormat {
    match blending {
        Blending::Float32 if device.blends_single() => wgpu::TextureFormat::Rgba32Float,
        _ => wgpu::TextureFormat::Rgba16Float,
    }
}

impl BoundRaster {
    /// The pipeline of `shader`, which holds both entry points, with its data and triangles, and everything bound.
    pub(crate) fn new(
        device: &Device,
        (proxies, vertices): (Proxies, &[ProxyVertex]),
        shader: &GeneratedShader,
        format: wgpu::TextureFormat,
        supplies: &Supplies<'_>,
        parts: &mut Parts,
    ) -> Result<Self, EngineError> {
        let target = Target::Blend { vertex: proxies.vertex, format };
        let bound = Bound::new(device, shader, target, supplies, parts)?;
        let mut raster = Self { bound, corners: None, count: 0 };
        raster.set_vertices(device, vertices)?;
        Ok(raster)
    }

    /// Takes other contents and triangles.
    pub(crate) fn set_inputs(&mut self, device: &Device, inputs: &Inputs) -> Result<(), EngineError> {
        self.bound.set_inputs(device, &inputs.contents)?;
        self.set_vertices(device, &inputs.vertices)
    }

    fn set_vertices(&mut self, device: &Device, vertices: &[ProxyVertex]) -> Result<(), EngineError> {
        self.count = u32::try_from(vertices.len()).map_err(|_| EngineError::TooLarge {
            what: "proxy geometry".to_owned(),
            requested: vertices.len() as u64,
            limit: u64::from(u32::MAX),
            unit: "vertices",
        })?;
        let bytes: &[u8] = bytemuck::cast_slice(vertices);
        device.guarded("uploading triangles", || {
            match &self.corners {
                _ if bytes.is_empty() => {}
                Some(buffer) if buffer.size() >= bytes.len() as u64 => {
                    device.queue().write_buffer(buffer, 0, bytes);
                }
                _ => {
                    let buffer = device.filled_buffer("proxies", wgpu::BufferUsages::VERTEX, bytes)?;
                    self.corners = Some(buffer);
                }
            }
            Ok(())
        })
    }

    /// Records all triangles.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.draw_instance(pass, 0..self.count, 0);
    }

    /// Records some of the triangles, with this instance index.
    pub(crate) fn draw_instance(&self, pass: &mut wgpu::RenderPass<'_>, vertices: Range<u32>, instance: u32) {
        let Some(buffer) = self.corners.as_ref().filter(|_| self.count > 0) else { return };
        self.bound.set(pass);
        pass.set_vertex_buffer(0, buffer.slice(..));
        pass.draw(vertices, instance..instance + 1);
    }
}
