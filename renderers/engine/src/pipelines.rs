//! Shaders and pipelines of a device, kept for equal requests: another view, another frame, another scene.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use cvr_core::render::ProxyVertex;
use cvr_core::shader::{Binding, BindingKind, Draft, GeneratedShader, Request, ShaderError, draft, generate};

use crate::{Device, EngineError};

/// Largest number of shaders, and of pipelines, that a device keeps. The least recently used ones are dropped.
const MOST_KEPT: usize = 64;

/// Shaders and pipelines that a device keeps.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    shaders: Mutex<Recent<Draft, Arc<GeneratedShader>>>,
    compiled: Mutex<Recent<Key, Arc<Compiled>>>,
    made: AtomicU64,
}

/// The parts that determine a pipeline.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    wgsl: String,
    entry: String,
    bindings: Vec<Binding>,
    target: Target,
}

/// What runs a shader.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Target {
    /// Dispatches.
    Compute,
    /// Triangles, blended into a picture of this format.
    Blend { vertex: &'static str, format: wgpu::TextureFormat },
}

/// A compiled shader.
#[derive(Debug)]
pub(crate) struct Compiled {
    pub(crate) bindings: Vec<Binding>,
    /// One for each group of bindings.
    pub(crate) layouts: Vec<wgpu::BindGroupLayout>,
    pub(crate) pipeline: Executable,
}

#[derive(Debug)]
pub(crate) enum Executable {
    Compute(wgpu::ComputePipeline),
    Blend(wgpu::RenderPipeline),
}

impl Device {
    /// The shader of a request. An existing one is reused.
    pub(crate) fn shader(&self, request: &Request<'_>) -> Result<Arc<GeneratedShader>, ShaderError> {
        let draft = draft(request)?;
        let kept = &self.pipelines().shaders;
        if let Some(shader) = lock(kept).get(&draft) {
            return Ok(shader);
        }
        let shader = Arc::new(generate(request)?);
        lock(kept).insert(draft, Arc::clone(&shader));
        Ok(shader)
    }

    /// The pipeline of a shader. An existing one is reused.
    pub(crate) fn compiled(
        &self,
        shader: &GeneratedShader,
        target: Target,
    ) -> Result<Arc<Compiled>, EngineError> {
        let (wgsl, entry) = (shader.wgsl.clone(), shader.entry.clone());
        let key = Key { wgsl, entry, bindings: shader.bindings.clone(), target };
        let kept = &self.pipelines().compiled;
        if let Some(compiled) = lock(kept).get(&key) {
            return Ok(compiled);
        }
        let compiled = Arc::new(compile(self, shader, target)?);
        self.pipelines().made.fetch_add(1, Ordering::Relaxed);
        lock(kept).insert(key, Arc::clone(&compiled));
        Ok(compiled)
    }

    /// Number of pipelines that this device has compiled. Reused ones do not count.
    #[must_use]
    pub fn pipelines_compiled(&self) -> u64 {
        self.pipelines().made.load(Ordering::Relaxed)
    }

    /// Drops kept shaders and pipelines, so that compile times can be measured.
    pub fn forget_pipelines(&self) {
        *lock(&self.pipelines().shaders) = Recent::default();
        *lock(&self.pipelines().compiled) = Recent::default();
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

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Values by their keys, at most [`MOST_KEPT`].
#[derive(Debug)]
struct Recent<K, V> {
    kept: HashMap<K, (V, u64)>,
    asked: u64,
}

impl<K, V> Default for Recent<K, V> {
    fn default() -> Self {
        Self { kept: HashMap::new(), asked: 0 }
    }
}

impl<K: Hash + Eq + Clone, V: Clone> Recent<K, V> {
    fn get(&mut self, key: &K) -> Option<V> {
        self.asked += 1;
        let (value, asked) = self.kept.get_mut(key)?;
        *asked = self.asked;
        Some(value.clone())
    }

    fn insert(&mut self, key: K, value: V) {
        let longest = || self.kept.iter().min_by_key(|(_, (_, asked))| *asked).map(|(key, _)| key.clone());
        if self.kept.len() >= MOST_KEPT
            && !self.kept.contains_key(&key)
            && let Some(longest) = longest()
        {
            self.kept.remove(&longest);
        }
        self.asked += 1;
        self.kept.insert(key, (value, self.asked));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_not_been_asked_for_longest_goes() {
        let mut recent = Recent::default();
        (0..MOST_KEPT).for_each(|i| recent.insert(i, 2 * i));
        assert_eq!(recent.get(&0), Some(0));
        recent.insert(MOST_KEPT, 7);
        recent.insert(MOST_KEPT, 8);
        assert_eq!(recent.kept.len(), MOST_KEPT);
        assert_eq!([0, 1, 2, MOST_KEPT].map(|key| recent.get(&key)), [Some(0), None, Some(4), Some(8)]);
    }
}
