//! Making shaders and pipelines, and taking those that the device has kept.

use std::sync::Arc;

use cvr_core::render::ProxyVertex;
use cvr_core::shader::{Binding, BindingKind, GeneratedShader, Request, ShaderError, draft, generate};

use crate::pipelines::{Compiled, Executable, Key, Target};
use crate::{Device, EngineError};

impl Device {
    /// The shader of a request. An existing one is reused.
    pub(crate) fn shader(&self, request: &Request<'_>) -> Result<Arc<GeneratedShader>, ShaderError> {
        self.pipelines().shader(draft(request)?, || generate(request))
    }

    /// The pipeline of a shader. An existing one is reused.
    pub(crate) fn compiled(
        &self,
        shader: &GeneratedShader,
        target: Target,
    ) -> Result<Arc<Compiled>, EngineError> {
        let (wgsl, entry) = (shader.wgsl.clone(), shader.entry.clone());
        let key = Key { wgsl, entry, bindings: shader.bindings.clone(), target };
        self.pipelines().compiled(key, || compile(self, shader, target))
    }

    /// Number of pipelines that this device has compiled. Reused ones do not count.
    #[must_use]
    pub fn pipelines_compiled(&self) -> u64 {
        self.pipelines().made()
    }

    /// Drops kept shaders and pipelines, so that compile times can be measured.
    pub fn forget_pipelines(&self) {
        self.pipelines().forget();
    }
}

fn compile(device: &Device, shader: &GeneratedShader, target: Target) -> Result<Compiled, EngineError> {
    let module = device.guarded("compiling a shader", || {
        let source = wgpu::ShaderSource::Wgsl(shader.wgsl.as_str().into());
        let label = Some(shader.entry.as_str());
        Ok(device.wgpu().create_shader_module(wgpu::ShaderModuleDescriptor { label, source }))
    })?;
    let layouts = device.guarded("binding what a shader reads", || Ok(layouts(device, shader, target)))?;
    let pipeline =
        device.guarded("building a pipeline", || Ok(pipeline(device, shader, target, &module, &layouts)))?;
    Ok(Compiled { bindings: shader.bindings.clone(), layouts, pipeline })
}

fn layouts(device: &Device, shader: &GeneratedShader, target: Target) -> Vec<wgpu::BindGroupLayout> {
    let stage = match target {
        Target::Compute => wgpu::ShaderStages::COMPUTE,
        Target::Blend { .. } => wgpu::ShaderStages::FRAGMENT,
    };
    let groups = shader.bindings.iter().map(|binding| binding.group + 1).max().unwrap_or(0);
    let layout = |group| {
        let of_group = shader.bindings.iter().filter(|binding| binding.group == group);
        let entries: Vec<_> = of_group.map(|binding| layout_entry(binding, stage)).collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
        device.wgpu().create_bind_group_layout(&descriptor)
    };
    (0..groups).map(layout).collect()
}

fn layout_entry(binding: &Binding, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
    let texture = |filterable, view_dimension| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension,
        multisampled: false,
    };
    let ty = match binding.kind {
        BindingKind::Uniforms(_) => buffer(wgpu::BufferBindingType::Uniform),
        BindingKind::Storage { written, .. } | BindingKind::Scratch { written, .. } => storage(!written),
        BindingKind::Words { .. } => storage(true),
        BindingKind::Table { .. } => texture(false, wgpu::TextureViewDimension::D2),
        BindingKind::VolumeTexture { filterable } => texture(filterable, wgpu::TextureViewDimension::D3),
        BindingKind::VolumeSampler | BindingKind::RingSampler => {
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)
        }
    };
    wgpu::BindGroupLayoutEntry { binding: binding.binding, visibility, ty, count: None }
}

fn pipeline(
    device: &Device,
    shader: &GeneratedShader,
    target: Target,
    module: &wgpu::ShaderModule,
    layouts: &[wgpu::BindGroupLayout],
) -> Executable {
    let layouts: Vec<_> = layouts.iter().map(Some).collect();
    let layout = device.wgpu().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &layouts,
        immediate_size: 0,
    });
    let (label, layout) = (Some(shader.entry.as_str()), Some(&layout));
    let compilation_options = wgpu::PipelineCompilationOptions::default();
    let (vertex, format) = match target {
        Target::Compute => {
            return Executable::Compute(device.wgpu().create_compute_pipeline(
                &wgpu::ComputePipelineDescriptor {
                    label,
                    layout,
                    module,
                    entry_point: label,
                    compilation_options,
                    cache: None,
                },
            ));
        }
        Target::Blend { vertex, format } => (vertex, format),
    };
    let attributes = wgpu::vertex_attr_array![0 => Float32x2, 1 => Uint32];
    let corners = wgpu::VertexBufferLayout {
        array_stride: size_of::<ProxyVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &attributes,
    };
    let state = wgpu::ColorTargetState {
        format,
        blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        write_mask: wgpu::ColorWrites::ALL,
    };
    Executable::Blend(device.wgpu().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: compilation_options.clone(),
            buffers: &[Some(corners)],
        },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: label,
            compilation_options,
            targets: &[Some(state)],
        }),
        // Proxies are seen from either side.
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        multiview_mask: None,
        cache: None,
    }))
}
