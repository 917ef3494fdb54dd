//! The site *deferred*: the device decodes a whole frame once, into a texture.

use cvr_core::codec::Decoder;
use cvr_core::shader::{DeferredShaders, voxels_per_invocation};
use cvr_core::volume::{FrameIndex, Level};

use crate::bindings::{Bound, Parts, Supplies};
use crate::frame_passes::{BoundPasses, scratch_buffers};
use crate::pipelines::Target;
use crate::slabs::{SLAB_UNIFORM_BYTES, Slab, Slabs, WORKGROUP, no_slab, slab_uniform};
use crate::timestamps::{FrameTimestamps, timed};
use crate::timing::FrameTime;
use crate::upload::SLAB_BYTES;
use crate::{Device, EngineError, VolumeTexture};

/// Decodes a frame into a texture, any number of times.
///
/// If the codec has passes of its own, they run first and leave the frame in a scratch buffer. Then a packing pass
/// reads that buffer, or runs the codec's snippet (the one that the site *inline* runs at every fetch). It writes
/// texels into a buffer, which is copied into the texture chunk by chunk, so that the buffer stays small and fits a
/// binding. This buffer and the scratch buffers live as long as this object.
#[derive(Debug)]
pub struct FrameDecoder {
    device: Device,
    texture: VolumeTexture,
    passes: BoundPasses,
    bound: Bound,
    texels: wgpu::Buffer,
    slabs: Slabs,
    timestamps: Option<FrameTimestamps>,
    wgsl: String,
}

impl FrameDecoder {
    /// Generates and compiles the passes, uploads their data, and creates the texture, which is empty until
    /// [`FrameDecoder::decode`]. Form and fallbacks of the texture are those of the site *host*.
    ///
    /// # Errors
    /// As [`crate::Drawing::new`] for a source *inline* and as [`crate::Capabilities::texture`].
    pub fn new(
        device: &Device,
        codec: &str,
        decoder: &dyn Decoder,
        frame: FrameIndex,
        level: Level,
    ) -> Result<Self, EngineError> {
        let layout = &decoder.layout().at_resolution(level.resolution);
        let choice = device.capabilities().texture(decoder.decoded_form(), layout.extent)?;
        let limits = device.binding_limits();
        let format = choice.form.format;
        let shaders = DeferredShaders::generate(codec, decoder, (frame, level), format, limits)?;
        let texture = VolumeTexture::empty(device, layout, choice)?;
        let most_bytes = (limits.storage_words * 4).min(SLAB_BYTES as u64);
        let slabs = Slabs::new(layout.extent, texture.texel_bytes(), most_bytes)?;
        let texels = device.guarded("preparing to decode a frame", || {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            device.empty_buffer("texels", usage, slabs.most_bytes())
        })?;
        let scratch = scratch_buffers(device, &shaders)?;
        let supplies = Supplies {
            inputs: &[no_slab()],
            storage: &[("texels", &texels)],
            buffers: &shaders.resources,
            scratch: Some(&scratch),
            ..Supplies::default()
        };
        let mut parts = Parts::new();
        let passes = BoundPasses::new(device, &shaders.passes, &supplies, &mut parts)?;
        let bound = Bound::new(device, &shaders.pack, Target::Compute, &supplies, &mut parts)?;
        Ok(Self {
            device: device.clone(),
            texture: texture.keeping(parts.into_values().collect()),
            passes,
            bound,
            texels,
            slabs,
            timestamps: device.guarded("preparing timestamps", || FrameTimestamps::new(device))?,
            wgsl: shaders.texts().collect::<Vec<_>>().join("\n// ---- next pass ----\n"),
        })
    }

    /// Decodes the frame into the texture and waits. The time includes the copies into the texture.
    ///
    /// # Errors
    /// What the driver refuses; a lost device.
    pub fn decode(&self) -> Result<FrameTime, EngineError> {
        // The codec's own passes, one pass per chunk, and an empty pass that marks the end of the last copy.
        let own = self.passes.len();
        let passes = own + self.slabs.iter().count() + 1;
        let timestamps = self.timestamps.as_ref();
        let begin = |encoder: &mut wgpu::CommandEncoder, pass| {
            let timestamp_writes = timestamps.and_then(|t| t.writes(pass, passes));
            let descriptor = wgpu::ComputePassDescriptor { label: Some("decode"), timestamp_writes };
            encoder.begin_compute_pass(&descriptor).forget_lifetime()
        };
        let encoder =
            || self.device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        timed(&self.device, "decoding a frame", timestamps, || {
            // Each pass is submitted separately, so that no driver's watchdog sums their times.
            for pass in 0..own {
                let mut encoder = encoder();
                self.passes.dispatch(pass, &mut begin(&mut encoder, pass));
                self.device.queue().submit([encoder.finish()]);
            }
            for (pass, slab) in (own..).zip(self.slabs.iter()) {
                self.bound.write_uniform(&self.device, "slab", &self.uniform_of(slab));
                let mut encoder = encoder();
                self.bound.dispatch(&mut begin(&mut encoder, pass), self.workgroups(slab));
                let source = wgpu::TexelCopyBufferInfo {
                    buffer: &self.texels,
                    layout: self.slabs.buffer_layout(slab),
                };
                let target = self.texture.place(slab.first_row, slab.first_slice);
                encoder.copy_buffer_to_texture(source, target, self.slabs.size(slab));
                if pass + 2 == passes {
                    drop(begin(&mut encoder, pass + 1));
                    timestamps.inspect(|t| t.resolve(&mut encoder));
                }
                self.device.queue().submit([encoder.finish()]);
            }
            Ok(())
        })
    }

    /// The texture. Clones share it, so they all show a later [`FrameDecoder::decode`].
    #[must_use]
    pub const fn texture(&self) -> &VolumeTexture {
        &self.texture
    }

    /// Bytes of the scratch buffers. They are freed with this object.
    #[must_use]
    pub fn scratch_bytes(&self) -> u64 {
        self.passes.scratch_bytes()
    }

    /// Bytes on the device during decoding: the resident bytes of the texture ([`VolumeTexture::resident_bytes`]), the
    /// scratch buffers, and the buffer for texels.
    #[must_use]
    pub fn peak_bytes(&self) -> u64 {
        self.texture.resident_bytes() + self.scratch_bytes() + self.texels.size() + SLAB_UNIFORM_BYTES
    }

    /// The generated passes, in their order.
    #[must_use]
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }

    fn workgroups(&self, slab: Slab) -> [u32; 3] {
        let layout = self.texture.layout();
        let voxels = voxels_per_invocation(self.texture.choice().form.format, layout.channels);
        [layout.extent.x().div_ceil(voxels * WORKGROUP), slab.rows, slab.slices]
    }

    fn uniform_of(&self, slab: Slab) -> [u8; SLAB_UNIFORM_BYTES as usize] {
        let texture = &self.texture;
        slab_uniform(slab, self.slabs, texture.choice().form, texture.layout().extent.x())
    }
}

impl VolumeTexture {
    /// Decodes one frame on the device. Within the codec's stated agreement, the texels equal those of
    /// [`VolumeTexture::upload`] with the CPU's values. Use [`FrameDecoder`] to decode repeatedly.
    ///
    /// # Errors
    /// As [`FrameDecoder`].
    pub fn decode(
        device: &Device,
        codec: &str,
        decoder: &dyn Decoder,
        frame: FrameIndex,
        level: Level,
    ) -> Result<(Self, FrameTime), EngineError> {
        let decoder = FrameDecoder::new(device, codec, decoder, frame, level)?;
        let time = decoder.decode()?;
        Ok((decoder.texture().clone(), time))
    }
}

#[cfg(test)]
mod tests;
