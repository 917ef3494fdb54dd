//! Triangles blended into a picture.

use std::ops::Range;

use cvr_core::render::{Blending, ProxyVertex, RasterPass};
use cvr_core::shader::GeneratedShader;

use crate::bindings::{Bindings, Parts, Supplies};
use crate::{Device, EngineError};

/// A render pipeline, what is bound to it, and the triangles that it draws.
#[derive(Debug)]
pub(crate) struct BoundRaster {
    pipeline: wgpu::RenderPipeline,
    groups: Vec<(u32, wgpu::BindGroup)>,
    vertices: Option<(wgpu::Buffer, u32)>,
}

/// The format in which a device blends sums of this precision.
pub(crate) fn target_format(device: &Device, blending: Blending) -> wgpu::TextureFormat {
    match blending {
        Blending::Float32 if device.blends_single() => wgpu::TextureFormat::Rgba32Float,
        _ => wgpu::TextureFormat::Rgba16Float,
    }
}

impl BoundRaster {
    /// Compiles `shader`, which holds both entry points, uploads what it reads and draws, and binds everything.
    pub(crate) fn new(
        device: &Device,
        pass: &RasterPass,
        shader: &GeneratedShader,
        format: wgpu::TextureFormat,
        supplies: &Supplies<'_>,
        parts: &mut Parts,
    ) -> Result<Self, EngineError> {
        let bindings = Bindings::new(device, shader, wgpu::ShaderStages::FRAGMENT, supplies, parts)?;
        let pipeline =
            device.guarded("building a pipeline", || Ok(pipeline(device, pass, &bindings, format)))?;
        let vertices = device.guarded("uploading triangles", || {
            let bytes: &[u8] = bytemuck::cast_slice(&pass.vertices);
            let upload = || device.filled_buffer("proxies", wgpu::BufferUsages::VERTEX, bytes);
            (!bytes.is_empty()).then(upload).transpose()
        })?;
        let count = u32::try_from(pass.vertices.len()).map_err(|_| EngineError::TooLarge {
            what: "proxy geometry".to_owned(),
            requested: pass.vertices.len() as u64,
            limit: u64::from(u32::MAX),
            unit: "vertices",
        })?;
        Ok(Self { pipeline, groups: bindings.groups, vertices: vertices.map(|buffer| (buffer, count)) })
    }

    /// Records all triangles.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        let count = self.vertices.as_ref().map_or(0, |(_, count)| *count);
        self.draw_instance(pass, 0..count, 0);
    }

    /// Records some of the triangles, as this instance.
    pub(crate) fn draw_instance(&self, pass: &mut wgpu::RenderPass<'_>, vertices: Range<u32>, instance: u32) {
        let Some((buffer, _)) = &self.vertices else { return };
        pass.set_pipeline(&self.pipeline);
        for (group, bound) in &self.groups {
            pass.set_bind_group(*group, bound, &[]);
        }
        pass.set_vertex_buffer(0, buffer.slice(..));
        pass.draw(vertices, instance..instance + 1);
    }
}

/// Begins a pass that blends into a picture, or first makes it transparent.
pub(crate) fn blend<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    clear: bool,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'e> {
    let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
    let attachment = wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
    };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("draw"),
        color_attachments: &[Some(attachment)],
        depth_stencil_attachment: None,
        timestamp_writes,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}

fn pipeline(
    device: &Device,
    pass: &RasterPass,
    bindings: &Bindings,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let attributes = wgpu::vertex_attr_array![0 => Float32x2, 1 => Uint32];
    let vertices = wgpu::VertexBufferLayout {
        array_stride: size_of::<ProxyVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &attributes,
    };
    let target = wgpu::ColorTargetState {
        format,
        blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        write_mask: wgpu::ColorWrites::ALL,
    };
    device.wgpu().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(pass.fragment),
        layout: Some(&bindings.layout),
        vertex: wgpu::VertexState {
            module: &bindings.module,
            entry_point: Some(pass.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(vertices)],
        },
        fragment: Some(wgpu::FragmentState {
            module: &bindings.module,
            entry_point: Some(pass.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(target)],
        }),
        // Proxies are seen from either side.
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        multiview_mask: None,
        cache: None,
    })
}
