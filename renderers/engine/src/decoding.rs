//! The site *deferred*: the device decodes a whole frame, once, into a texture.

use cvr_core::codec::{Decoder, TexelFormat};
use cvr_core::shader::{generate_decode, voxels_per_invocation};
use cvr_core::volume::{FrameIndex, Level};

use crate::bindings::{Bound, Parts, Supplies};
use crate::slabs::{Slab, Slabs};
use crate::timestamps::{FrameTimestamps, timed};
use crate::timing::FrameTime;
use crate::upload::SLAB_BYTES;
use crate::{Device, DrawSource, EngineError, TextureChoice, VolumeTexture};

/// Invocations of one workgroup of the template, along x.
const WORKGROUP: u32 = 64;
/// Bytes of the uniform `slab`.
const UNIFORM_BYTES: u64 = 32;

/// A frame and the pass that decodes it into a texture, any number of times.
///
/// The pass runs the codec's own snippet, the one that the site *inline* runs at every fetch, and writes texels into a
/// buffer that is copied into the texture, slab by slab, so that the buffer stays small and within what a binding
/// holds. It lives as long as this does.
#[derive(Debug)]
pub struct FrameDecoder {
    device: Device,
    texture: VolumeTexture,
    bound: Bound,
    uniform: wgpu::Buffer,
    texels: wgpu::Buffer,
    slabs: Slabs,
    timestamps: Option<FrameTimestamps>,
    wgsl: String,
}

impl FrameDecoder {
    /// Generates and compiles the pass, uploads what it reads, and makes the texture, which is empty until
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
        let source = DrawSource::Inline { codec, decoder, frame, level };
        let voxels = source.voxels()?;
        let choice = device.capabilities().texture(decoder.decoded_form(), voxels.layout.extent)?;
        let limits = device.binding_limits();
        let shader = generate_decode(&voxels.source, voxels.layout, choice.form.format, limits)?;
        let texture = VolumeTexture::empty(device, voxels.layout, choice)?;
        let most_bytes = (limits.storage_words * 4).min(SLAB_BYTES as u64);
        let slabs = Slabs::new(voxels.layout.extent, texture.texel_bytes(), most_bytes)?;
        let (uniform, texels) = device.guarded("preparing to decode a frame", || {
            let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
            let uniform = device.empty_buffer("slab", usage, UNIFORM_BYTES)?;
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            Ok((uniform, device.empty_buffer("texels", usage, slabs.most_bytes())?))
        })?;
        let supplies = Supplies {
            slab: Some(&uniform),
            output: Some(&texels),
            buffers: &voxels.buffers,
            ..Supplies::default()
        };
        let mut parts = Parts::new();
        let bound = Bound::new(device, &shader, &supplies, &mut parts)?;
        Ok(Self {
            device: device.clone(),
            texture: texture.keeping(parts.into_values().collect()),
            bound,
            uniform,
            texels,
            slabs,
            timestamps: device.guarded("preparing timestamps", || FrameTimestamps::new(device))?,
            wgsl: shader.wgsl,
        })
    }

    /// Decodes the frame into the texture and waits for it. The time holds the copies into the texture.
    ///
    /// # Errors
    /// What the driver refuses; a lost device.
    pub fn decode(&self) -> Result<FrameTime, EngineError> {
        // One pass per slab, and an empty one that marks the end of the last copy.
        let passes = self.slabs.iter().count() + 1;
        let timestamps = self.timestamps.as_ref();
        let begin = |encoder: &mut wgpu::CommandEncoder, pass| {
            let timestamp_writes = timestamps.and_then(|t| t.writes(pass, passes));
            let descriptor = wgpu::ComputePassDescriptor { label: Some("decode"), timestamp_writes };
            encoder.begin_compute_pass(&descriptor).forget_lifetime()
        };
        timed(&self.device, "decoding a frame", timestamps, || {
            for (pass, slab) in self.slabs.iter().enumerate() {
                self.device.queue().write_buffer(&self.uniform, 0, &self.uniform_of(slab));
                let mut encoder =
                    self.device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
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

    /// The texture. Clones share it: a later [`FrameDecoder::decode`] shows in all of them.
    #[must_use]
    pub const fn texture(&self) -> &VolumeTexture {
        &self.texture
    }

    /// The generated pass.
    #[must_use]
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }

    fn workgroups(&self, slab: Slab) -> [u32; 3] {
        let layout = self.texture.layout();
        let voxels = voxels_per_invocation(self.texture.choice().form.format, layout.channels);
        [layout.extent.x().div_ceil(voxels * WORKGROUP), slab.rows, slab.slices]
    }

    /// The struct `Slab` of shaders/deferred/decode.wgsl.
    fn uniform_of(&self, slab: Slab) -> [u8; UNIFORM_BYTES as usize] {
        let TextureChoice { form, .. } = self.texture.choice();
        let steps = match form.format {
            TexelFormat::Unorm8 => 255.0,
            TexelFormat::Unorm16 => 65535.0,
            TexelFormat::Float16 | TexelFormat::Float32 => 1.0,
        };
        let per_unit = (steps / f64::from(form.scale)) as f32;
        let row_words = self.slabs.row_bytes() as u32 / 4;
        let [offset, per_unit] = [form.offset, per_unit].map(f32::to_bits);
        bytemuck::cast([slab.first_row, slab.first_slice, slab.rows, row_words, offset, per_unit, 0, 0])
    }
}

impl VolumeTexture {
    /// Decodes one frame on the device: the same texels as [`VolumeTexture::upload`] of what the CPU decodes, within
    /// the codec's statement. [`FrameDecoder`] does it more than once.
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
