//! A plan made runnable.

use cvr_core::render::{Filter, Image, Pass, Plan};
use cvr_core::shader::{BindingKind, Request, TextureSampling, generate};

use crate::bindings::{Bound, Parts, Supplies};
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
    image: wgpu::Buffer,
    passes: Vec<(Bound, [u32; 3])>,
    timestamps: Option<FrameTimestamps>,
    resident_bytes: u64,
    filtering: TextureSampling,
    wgsl: String,
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
        let image = new_image(device, plan.size)?;
        let mut parts = Parts::new();
        let mut passes = Vec::new();
        let mut texts = Vec::new();
        let mut filtering = TextureSampling::Manual;
        for pass in &plan.passes {
            let Pass::Compute(pass) = pass else {
                return Err(EngineError::Unsupported("this engine runs compute passes only".to_owned()));
            };
            check_workgroups(device, "a pass", pass.workgroups)?;
            let shader = generate(&Request {
                templates: &pass.templates,
                entry: pass.entry,
                bindings: pass.bindings,
                layout: voxels.layout,
                source: voxels.source.clone(),
                filter: Some(filter),
                limits: device.binding_limits(),
            })?;
            if shader.bindings.iter().any(|binding| binding.kind == BindingKind::VolumeSampler) {
                filtering = TextureSampling::Hardware;
            }
            let supplies = Supplies {
                view: &pass.view,
                table: &plan.transfer_table,
                output: Some(&image),
                buffers: &voxels.buffers,
                texture: voxels.texture,
                ..Supplies::default()
            };
            passes.push((Bound::new(device, &shader, &supplies, &mut parts)?, pass.workgroups));
            texts.push(shader.wgsl);
        }
        if passes.is_empty() {
            return Err(EngineError::Unsupported("the plan has no passes".to_owned()));
        }
        let words: u64 = parts.values().map(wgpu::Buffer::size).sum();
        Ok(Self {
            device: device.clone(),
            size: plan.size,
            image,
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
            for (i, (bound, workgroups)) in self.passes.iter().enumerate() {
                let timestamps = self.timestamps.as_ref();
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("draw"),
                    timestamp_writes: timestamps.and_then(|t| t.writes(i, self.passes.len())),
                });
                bound.dispatch(&mut pass, *workgroups);
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
        let pixels = self.device.read_buffer(&self.image, self.image.size())?;
        Image::from_pixels(self.size, pixels)
            .ok_or_else(|| EngineError::Gpu("the picture came back in another size".to_owned()))
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

    /// The generated shaders, in the order of their passes.
    #[must_use]
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }
}

fn new_image(device: &Device, size: [u32; 2]) -> Result<wgpu::Buffer, EngineError> {
    // The product of two sides fits, that with the bytes of a pixel may not.
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    let bytes = pixels.saturating_mul(size_of::<[f32; 4]>() as u64);
    if bytes == 0 {
        return Err(EngineError::Unsupported(format!("a picture of {}×{} pixels", size[0], size[1])));
    }
    let limit = device.capabilities().storage_bytes();
    if bytes > limit {
        let what = format!("a picture of {}×{} pixels", size[0], size[1]);
        return Err(EngineError::TooLarge { what, requested: bytes, limit, unit: "bytes in one buffer" });
    }
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    device.guarded("making a picture", || device.empty_buffer("image", usage, bytes))
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
