//! The site *ring*: in every picture the device decodes layers of voxels into a ring of four, and draws slices from
//! them.

use cvr_core::codec::Decoder;
use cvr_core::render::{Inputs, LayerStep, RING_LAYERS};
use cvr_core::shader::{DeferredShaders, Source, voxels_per_invocation};
use cvr_core::volume::{Axis, Extent, FrameIndex, Level, VolumeLayout};

use crate::bindings::{Bound, Parts, Supplies, check_workgroups};
use crate::canvas::blend;
use crate::pipelines::Target;
use crate::raster::BoundRaster;
use crate::slabs::{SLAB_UNIFORM_BYTES, Slab, Slabs, WORKGROUP, no_slab, slab_uniform};
use crate::source::Voxels;
use crate::texels::texture_channels;
use crate::timestamps::FrameTimestamps;
use crate::{Device, EngineError, VolumeTexture};

/// A ring of layers, and the means to fill it: the pass that runs the codec's snippet, a buffer of one layer for its
/// output, and a small texture whose slices are the slots.
#[derive(Debug)]
pub(crate) struct LayerRing {
    device: Device,
    layout: VolumeLayout,
    axis: Axis,
    /// The slots. Its third axis is the stack's, along any axis of the volume. A layer is a slice of it and is copied
    /// as a whole.
    ring: VolumeTexture,
    decode: Bound,
    workgroups: [u32; 3],
    /// The uniform of every layer, one after another.
    uniforms: wgpu::Buffer,
    texels: wgpu::Buffer,
    slabs: Slabs,
    /// Bytes of the codec's buffers.
    stream_bytes: u64,
    wgsl: String,
}

impl LayerRing {
    /// Generates and compiles the pass, uploads its data, and creates an empty ring. Form and fallbacks are those of
    /// the site *deferred*. Along the stack, the volume may be longer than a texture.
    pub(crate) fn new(
        device: &Device,
        (codec, decoder): (&str, &dyn Decoder),
        (frame, level): (FrameIndex, Level),
        axis: Axis,
    ) -> Result<Self, EngineError> {
        let layout = decoder.layout().at_resolution(level.resolution);
        let [width, height, layers] = axis.layered(layout.extent.to_array());
        let ring = VolumeLayout { extent: extent([width, height, RING_LAYERS])?, ..layout.clone() };
        let choice = device.capabilities().texture(decoder.decoded_form(), ring.extent)?;
        let limits = device.binding_limits();
        let texel_bytes = texture_channels(layout.channels) * choice.form.format.bytes();
        let most_bytes = limits.storage_words * 4;
        let slabs = Slabs::new(extent([width, height, 1])?, texel_bytes, most_bytes)?;
        let slab = Slab { first_row: 0, first_slice: 0, rows: height, slices: 1 };
        if slabs.bytes(slab) > most_bytes {
            let what = format!("a layer of {width}×{height} voxels");
            let (requested, limit, unit) = (slabs.bytes(slab), most_bytes, "bytes in one buffer");
            return Err(EngineError::TooLarge { what, requested, limit, unit });
        }
        let form = (choice.form.format, axis);
        let shaders = DeferredShaders::generate_layers(codec, decoder, (frame, level), form, limits)?;
        let ring = VolumeTexture::empty(device, &ring, choice)?;

        let voxels = voxels_per_invocation(choice.form.format, layout.channels);
        let workgroups = [width.div_ceil(voxels * WORKGROUP), height, 1];
        check_workgroups(device, "decoding a layer", workgroups)?;
        let of_layer = |first_slice| slab_uniform(Slab { first_slice, ..slab }, slabs, choice.form, width);
        let table: Vec<u8> = (0..layers).flat_map(of_layer).collect();
        let (uniforms, texels) = device.guarded("preparing to decode layers", || {
            let uniforms = device.filled_buffer("slabs", wgpu::BufferUsages::COPY_SRC, &table)?;
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            Ok((uniforms, device.empty_buffer("texels", usage, slabs.bytes(slab))?))
        })?;
        let supplies = Supplies {
            inputs: &[no_slab()],
            storage: &[("texels", &texels)],
            buffers: &shaders.resources,
            ..Supplies::default()
        };
        let mut parts = Parts::new();
        let decode = Bound::new(device, &shaders.pack, Target::Compute, &supplies, &mut parts)?;
        Ok(Self {
            device: device.clone(),
            layout,
            axis,
            ring,
            decode,
            workgroups,
            uniforms,
            texels,
            slabs,
            stream_bytes: parts.values().map(wgpu::Buffer::size).sum(),
            wgsl: shaders.pack.wgsl,
        })
    }

    /// The same ring, filtered by the shader even if the texture unit could.
    #[cfg(test)]
    pub(crate) fn with_manual_sampling(self) -> Self {
        Self { ring: self.ring.with_manual_sampling(), ..self }
    }

    /// The ring as a source of voxels.
    pub(crate) fn voxels(&self) -> Voxels<'_> {
        let choice = self.ring.choice();
        let source = Source::Ring { form: choice.form, sampling: choice.sampling, axis: self.axis };
        Voxels { layout: self.layout.clone(), source, buffers: Vec::new(), texture: Some(&self.ring) }
    }

    /// Bytes that hold the volume during drawing: ring, buffer of one layer, and the codec's buffers.
    pub(crate) fn resident_bytes(&self) -> u64 {
        self.ring.bytes() + self.texels.size() + self.stream_bytes
    }

    /// The pass that decodes.
    pub(crate) fn wgsl(&self) -> &str {
        &self.wgsl
    }

    /// Records that a layer is decoded into the buffer.
    fn decode(&self, encoder: &mut wgpu::CommandEncoder, layer: u32) {
        // The uniform `slab` is the only one of the pass.
        if let Some(uniform) = self.decode.uniforms() {
            let at = u64::from(layer) * SLAB_UNIFORM_BYTES;
            encoder.copy_buffer_to_buffer(&self.uniforms, at, uniform, 0, SLAB_UNIFORM_BYTES);
        }
        let descriptor = wgpu::ComputePassDescriptor { label: Some("decode"), timestamp_writes: None };
        self.decode.dispatch(&mut encoder.begin_compute_pass(&descriptor), self.workgroups);
    }

    /// Records that the layer in the buffer is copied into a slot.
    fn place(&self, encoder: &mut wgpu::CommandEncoder, slot: u32) {
        let [_, rows, _] = self.axis.layered(self.layout.extent.to_array());
        let slab = Slab { first_row: 0, first_slice: 0, rows, slices: 1 };
        let source =
            wgpu::TexelCopyBufferInfo { buffer: &self.texels, layout: self.slabs.buffer_layout(slab) };
        encoder.copy_buffer_to_texture(source, self.ring.place(0, slot), self.slabs.size(slab));
    }

    /// Every sample of the frame, decoded layer by layer and read from the layer's slot, in the order of a frame.
    pub(crate) fn read_layers(&self) -> Result<Vec<f32>, EngineError> {
        let [width, height, layers] = self.axis.layered(self.layout.extent.to_array());
        let channels = self.layout.channels as usize;
        let mut all = vec![0.0; self.layout.samples_per_frame() as usize];
        for first in (0..layers).step_by(RING_LAYERS as usize) {
            let turn = first..layers.min(first + RING_LAYERS);
            self.device.guarded("decoding layers", || {
                let mut encoder =
                    self.device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                for layer in turn.clone() {
                    self.decode(&mut encoder, layer);
                    self.place(&mut encoder, layer % RING_LAYERS);
                }
                self.device.queue().submit([encoder.finish()]);
                Ok(())
            })?;
            let slots = self.ring.read(&self.device)?;
            let mut voxels = slots.chunks_exact(channels);
            for layer in turn {
                for (row, along) in (0..height).flat_map(|row| (0..width).map(move |along| (row, along))) {
                    let at = self.layout.extent.index(self.axis.unlayered([along, row, layer])) * channels;
                    let voxel = voxels.next().unwrap_or_default();
                    all[at..at + voxel.len()].copy_from_slice(voxel);
                }
            }
        }
        Ok(all)
    }
}

fn extent(size: [u32; 3]) -> Result<Extent, EngineError> {
    Extent::try_from(size).map_err(|e| EngineError::Unsupported(format!("a ring of layers: {e}")))
}

/// Clearing the picture, and every piece that is drawn.
fn passes_of(steps: &[LayerStep]) -> usize {
    steps.iter().filter(|step| matches!(step, LayerStep::Draw { .. })).count() + 1
}

/// A pass that draws layer by layer, made runnable.
#[derive(Debug)]
pub(crate) struct BoundLayers {
    raster: BoundRaster,
    steps: Vec<LayerStep>,
    passes: usize,
}

impl BoundLayers {
    pub(crate) fn new(raster: BoundRaster, steps: &[LayerStep]) -> Self {
        Self { raster, steps: steps.to_vec(), passes: passes_of(steps) }
    }

    /// Takes other contents, triangles and steps.
    pub(crate) fn set_inputs(&mut self, device: &Device, inputs: &Inputs) -> Result<(), EngineError> {
        self.raster.set_inputs(device, inputs)?;
        self.steps.clone_from(&inputs.steps);
        self.passes = passes_of(&inputs.steps);
        Ok(())
    }

    /// Records the whole pass into a picture, which it clears first. Decoding lies between its timestamps.
    pub(crate) fn record(
        &self,
        ring: &LayerRing,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        timestamps: Option<&FrameTimestamps>,
    ) {
        let writes = |pass| timestamps.and_then(|t| t.render_writes(pass, self.passes));
        drop(blend(encoder, view, true, writes(0)));
        let mut drawn = 0;
        for step in &self.steps {
            match step {
                LayerStep::Decode(layer) => ring.decode(encoder, *layer),
                LayerStep::Place(slot) => ring.place(encoder, *slot),
                LayerStep::Draw { between, vertices } => {
                    drawn += 1;
                    let mut pass = blend(encoder, view, false, writes(drawn));
                    self.raster.draw_instance(&mut pass, vertices.clone(), (between + 1).unsigned_abs());
                }
            }
        }
    }
}
