//! A plan made runnable.

mod canvas;

use canvas::Canvas;
use cvr_core::render::{Blending, Filter, Image, Pass, Plan};
use cvr_core::shader::{BindingKind, Request, TextureSampling, generate};

use crate::bindings::{Bound, Parts, Supplies};
use crate::raster::{BoundRaster, target_format};
use crate::timestamps::{FrameTimestamps, timed};
use crate::timing::FrameTime;
use crate::{Device, DrawSource, EngineError};

/// A picture that can be drawn any number of times. Everything it reads is resident, so that a frame is its
/// passes and nothing else.
///
/// One thread draws at a time: frames of one drawing that run beside each other fail or time each other.
#[derive(Debug)]
pub struct Drawing {
    device: Device,
    size: [u32; 2],
    canvas: Canvas,
    passes: Vec<Runnable>,
    blending: Option<Blending>,
    timestamps: Option<FrameTimestamps>,
    resident_bytes: u64,
    filtering: TextureSampling,
    wgsl: String,
}

/// A pass made runnable.
#[derive(Debug)]
enum Runnable {
    Compute(Bound, [u32; 3]),
    Raster(BoundRaster, wgpu::TextureView),
}

impl Drawing {
    /// Generates and compiles the shaders of `plan`, and uploads what they read. For a source *inline* that is
    /// the codec's buffers; a texture is shared.
    ///
    /// # Errors
    /// [`EngineError::Shader`] when the generator refuses the shader, [`EngineError::TooLarge`] when picture
    /// or buffers exceed the device, [`EngineError::Unsupported`] when the plan is empty or the decoder has no
    /// shader, [`EngineError::Decode`] when the stream lacks what the shader reads, and what the driver refuses.
    pub fn new(
        device: &Device,
        plan: &Plan,
        source: &DrawSource<'_>,
        filter: Filter,
    ) -> Result<Self, EngineError> {
        let voxels = source.voxels()?;
        let canvas = canvas_of(device, plan)?;
        let mut parts = Parts::new();
        let mut passes = Vec::new();
        let mut texts = Vec::new();
        let mut filtering = TextureSampling::Manual;
        for pass in &plan.passes {
            let shader = generate(&Request {
                templates: pass.templates(),
                entry: pass.entry(),
                bindings: &pass.bindings(),
                layout: voxels.layout,
                source: voxels.source.clone(),
                filter: Some(filter),
                limits: device.binding_limits(),
            })?;
            if shader.bindings.iter().any(|binding| binding.kind == BindingKind::VolumeSampler) {
                filtering = TextureSampling::Hardware;
            }
            let mut supplies = Supplies {
                inputs: pass.inputs(),
                buffers: &voxels.buffers,
                texture: voxels.texture,
                ..Supplies::default()
            };
            passes.push(match (pass, &canvas) {
                (Pass::Compute(pass), Canvas::Buffer(image)) => {
                    check_workgroups(device, "a pass", pass.workgroups)?;
                    supplies.output = Some(image);
                    let bound = Bound::new(device, &shader, &supplies, &mut parts)?;
                    Runnable::Compute(bound, pass.workgroups)
                }
                (Pass::Raster(pass), Canvas::Target(texture)) => {
                    let format = texture.format();
                    let bound = BoundRaster::new(device, pass, &shader, format, &supplies, &mut parts)?;
                    Runnable::Raster(bound, texture.create_view(&wgpu::TextureViewDescriptor::default()))
                }
                _ => {
                    let text = "passes of one picture either compute or blend, and this plan mixes them";
                    return Err(EngineError::Unsupported(text.to_owned()));
                }
            });
            texts.push(shader.wgsl);
        }
        if passes.is_empty() {
            return Err(EngineError::Unsupported("the plan has no passes".to_owned()));
        }
        let words: u64 = parts.values().map(wgpu::Buffer::size).sum();
        Ok(Self {
            device: device.clone(),
            size: plan.size,
            blending: canvas.blending(),
            canvas,
            passes,
            timestamps: device.guarded("preparing timestamps", || FrameTimestamps::new(device))?,
            resident_bytes: words + voxels.texture.map_or(0, crate::VolumeTexture::resident_bytes),
            filtering,
            wgsl: texts.join("\n// ---- next pass ----\n"),
        })
    }

    /// Draws one frame and waits for it. The device's own time is reported only where it agrees with the wall
    /// clock.
    ///
    /// # Errors
    /// What the driver refuses; a lost device.
    pub fn draw_timed(&self) -> Result<FrameTime, EngineError> {
        timed(&self.device, "drawing", self.timestamps.as_ref(), || {
            let device = self.device.wgpu();
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for (i, pass) in self.passes.iter().enumerate() {
                self.record(&mut encoder, pass, i);
            }
            if let Some(timestamps) = &self.timestamps {
                timestamps.resolve(&mut encoder);
            }
            self.device.queue().submit([encoder.finish()]);
            Ok(())
        })
    }

    /// The picture of the last frame; transparent before the first.
    ///
    /// # Errors
    /// What the driver refuses; a lost device.
    pub fn read_image(&self) -> Result<Image, EngineError> {
        self.canvas.read(&self.device, self.size)
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder, pass: &Runnable, index: usize) {
        let (timestamps, label, passes) = (self.timestamps.as_ref(), Some("draw"), self.passes.len());
        match pass {
            Runnable::Compute(bound, workgroups) => {
                let timestamp_writes = timestamps.and_then(|t| t.writes(index, passes));
                let mut pass =
                    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
                bound.dispatch(&mut pass, *workgroups);
            }
            Runnable::Raster(bound, view) => {
                let load = if index == 0 {
                    wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT)
                } else {
                    wgpu::LoadOp::Load
                };
                let attachment = wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                };
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label,
                    color_attachments: &[Some(attachment)],
                    depth_stencil_attachment: None,
                    timestamp_writes: timestamps.and_then(|t| t.render_writes(index, passes)),
                    occlusion_query_set: None,
                    multiview_mask: None,
                });
                bound.draw(&mut pass);
            }
        }
    }

    /// Bytes of device memory that hold the volume: the codec's buffers, or what stays resident with the texture
    /// ([`crate::VolumeTexture::resident_bytes`]). Picture, transfer function and view are not counted.
    #[must_use]
    pub const fn resident_bytes(&self) -> u64 {
        self.resident_bytes
    }

    /// Who interpolates: the texture unit only if a shader really samples through it.
    #[must_use]
    pub const fn filtering(&self) -> TextureSampling {
        self.filtering
    }

    /// Precision of blended sums; `None` where nothing is blended. It is half where the device cannot blend what the
    /// plan asks for.
    #[must_use]
    pub const fn blending(&self) -> Option<Blending> {
        self.blending
    }

    /// The generated shaders, in the order of their passes.
    #[must_use]
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }
}

/// What the passes of a plan draw into.
fn canvas_of(device: &Device, plan: &Plan) -> Result<Canvas, EngineError> {
    match plan.passes.last() {
        Some(Pass::Raster(pass)) => Canvas::target(device, plan.size, target_format(device, pass.blending)),
        _ => Canvas::buffer(device, plan.size),
    }
}

pub(crate) fn check_workgroups(device: &Device, what: &str, workgroups: [u32; 3]) -> Result<(), EngineError> {
    let most = workgroups.into_iter().max().unwrap_or(0);
    let limit = device.capabilities().workgroups_per_axis;
    if most > limit {
        let (what, requested, limit) = (what.to_owned(), u64::from(most), u64::from(limit));
        return Err(EngineError::TooLarge { what, requested, limit, unit: "workgroups along one axis" });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
