//! A plan made runnable.

mod check;
mod rays;
mod runnable;

pub use rays::RayPieces;

use check::Check;
use cvr_core::render::{Blending, Filter, Image, Pipeline, Plan};
use cvr_core::shader::{BindingKind, TextureSampling};
use rays::{FollowedRays, InPieces};
use runnable::Runnable;

use crate::bindings::Parts;
use crate::canvas::Canvas;
use crate::layers::LayerRing;
use crate::raster::target_format;
use crate::timestamps::{FrameTimestamps, timed};
use crate::timing::FrameTime;
use crate::{Device, DrawSource, EngineError, TextureFallback};

/// A picture that can be drawn repeatedly. All its data is resident, so drawing runs only its passes. Another view of
/// the same volume needs other inputs, but no other drawing ([`Drawing::set_inputs`]).
///
/// Only one thread may draw at a time. Parallel draws of one drawing fail or distort each other's times.
#[derive(Debug)]
pub struct Drawing {
    device: Device,
    size: [u32; 2],
    canvas: Canvas,
    pipelines: Vec<Pipeline>,
    passes: Vec<Runnable>,
    rays: Option<FollowedRays>,
    check: Option<Check>,
    ring: Option<LayerRing>,
    timestamps: Option<FrameTimestamps>,
    resident_bytes: u64,
    filtering: TextureSampling,
    fallback: Option<TextureFallback>,
    wgsl: String,
}

impl Drawing {
    /// Generates and compiles the shaders of `plan`, unless the device has kept them, and uploads their data. For a
    /// source *inline* or *ring* these are the codec's buffers, for buffers the buffers themselves. A texture is
    /// shared. A plan that draws layer by layer needs a source *ring*; no other plan may have one.
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
        let ring = ring_of(device, plan, source)?;
        Self::from_ring(device, plan, source, filter, ring)
    }

    /// As [`Drawing::new`], the ring being made, if there is to be one.
    fn from_ring(
        device: &Device,
        plan: &Plan,
        source: &DrawSource<'_>,
        filter: Filter,
        ring: Option<LayerRing>,
    ) -> Result<Self, EngineError> {
        let voxels = ring.as_ref().map_or_else(|| source.voxels(), |ring| Ok(ring.voxels()))?;
        let canvas = canvas_of(device, plan)?;
        let mut parts = Parts::new();
        let mut passes = Vec::new();
        let mut texts: Vec<String> = ring.iter().map(|ring| ring.wgsl().to_owned()).collect();
        let mut filtering = TextureSampling::Manual;
        for pass in &plan.passes {
            let (runnable, shader) =
                Runnable::new(device, (pass, plan.size), (&voxels, filter), &canvas, &mut parts)?;
            let sampler =
                |kind: &BindingKind| matches!(kind, BindingKind::VolumeSampler | BindingKind::RingSampler);
            if shader.bindings.iter().any(|binding| sampler(&binding.kind)) {
                filtering = TextureSampling::Hardware;
            }
            passes.push(runnable);
            texts.push(shader.wgsl.clone());
        }
        if passes.is_empty() {
            return Err(EngineError::Unsupported("the plan has no passes".to_owned()));
        }
        let words: u64 = parts.values().map(wgpu::Buffer::size).sum();
        let texture_bytes = voxels.texture.map_or(0, crate::VolumeTexture::resident_bytes);
        let fallback = voxels.texture.and_then(|texture| texture.choice().fallback);
        let check = match (&plan.passes[..], &canvas, source) {
            ([pass], Canvas::Target(texture), DrawSource::Inline { .. }) => {
                Check::new(device, pass, &voxels, filter, (texture, &mut parts))?
            }
            _ => None,
        };
        let rays = match (&plan.passes[..], &canvas) {
            ([pass], Canvas::Buffer(image)) => {
                FollowedRays::new(device, (pass, plan.size), (&voxels, source), filter, (image, parts))
            }
            _ => None,
        };
        Ok(Self {
            device: device.clone(),
            size: plan.size,
            pipelines: plan.passes.iter().map(|pass| pass.pipeline.clone()).collect(),
            rays,
            check,
            canvas,
            passes,
            timestamps: device.guarded("preparing timestamps", || FrameTimestamps::new(device))?,
            resident_bytes: ring.as_ref().map_or(words + texture_bytes, LayerRing::resident_bytes),
            filtering,
            fallback,
            ring,
            wgsl: texts.join("\n// ---- next pass ----\n"),
        })
    }

    /// Whether a plan differs from this drawing's in inputs alone.
    #[must_use]
    pub fn takes(&self, plan: &Plan) -> bool {
        let pipelines = plan.passes.iter().map(|pass| &pass.pipeline);
        self.size == plan.size && self.pipelines.iter().eq(pipelines)
    }

    /// Draws another view from now on. Uploads the inputs of `plan`, and compiles nothing.
    ///
    /// # Errors
    /// [`EngineError::Unsupported`] when the plan has another pipeline or size than the drawing ([`Drawing::takes`]);
    /// what the driver refuses.
    pub fn set_inputs(&mut self, plan: &Plan) -> Result<(), EngineError> {
        if !self.takes(plan) {
            let text =
                "the plan has another pipeline or size than the drawing: it takes a drawing of its own";
            return Err(EngineError::Unsupported(text.to_owned()));
        }
        for (runnable, pass) in self.passes.iter_mut().zip(&plan.passes) {
            runnable.set_inputs(&self.device, pass, plan.size)?;
            if let Some(rays) = &mut self.rays {
                rays.set_inputs(&pass.inputs.contents);
            }
            if let Some(check) = &mut self.check {
                check.set_inputs(&self.device, &pass.inputs)?;
            }
        }
        Ok(())
    }

    /// The same drawing, with its rays in pieces of at most this many samples, or fewer if the device needs it. Also if
    /// the device needs no pieces.
    ///
    /// # Errors
    /// [`EngineError::Unsupported`] when the plan follows no rays, or the device cannot bind what pieces need;
    /// [`EngineError::CutOff`] when even pieces of one sample are too long; what the driver refuses.
    pub fn with_rays_in_pieces(mut self, samples: u32) -> Result<Self, EngineError> {
        let Some(rays) = &mut self.rays else {
            return Err(EngineError::Unsupported(
                "the plan follows no rays that could be cut in pieces".to_owned(),
            ));
        };
        rays.settle_in_pieces(&self.device, samples)?;
        Ok(self)
    }

    /// Draws one picture and waits for it. The device's own time is returned only if it agrees with the wall clock.
    ///
    /// The first picture of a plan with rays is checked. If the device ended loops in it, this picture and all later
    /// ones are drawn with rays in pieces. The pieces are as long as possible, and keep their length. Before the first
    /// picture that blends voxels decoded at every fetch, an untimed picture is drawn and checked.
    ///
    /// # Errors
    /// What the driver refuses; a lost device. [`EngineError::CutOff`] when the device ends the loops of a single sample.
    pub fn draw_timed(&self) -> Result<FrameTime, EngineError> {
        if let Some(check) = &self.check {
            check.pass(&self.device, &self.canvas)?;
        }
        let Some(rays) = &self.rays else { return self.frame(None) };
        if let Some(settled) = rays.settled() {
            return self.frame(settled);
        }
        let time = self.frame(None)?;
        match self.canvas.cut_off(&self.device)? {
            None => {
                rays.settle_at_once();
                Ok(time)
            }
            Some(cut_off) => self.frame(rays.settle_by(&self.device, cut_off)?),
        }
    }

    /// Draws a picture without timing, and waits for it. If blended fragments still need a check, the checked picture
    /// is this one, so it is drawn only once.
    ///
    /// # Errors
    /// As [`Drawing::draw_timed`].
    pub fn draw(&self) -> Result<(), EngineError> {
        match &self.check {
            Some(check) if !check.passed() => check.pass(&self.device, &self.canvas),
            _ => self.draw_timed().map(drop),
        }
    }

    /// Draws one picture, with rays at once or in pieces, and waits for it.
    fn frame(&self, pieces: Option<&InPieces>) -> Result<FrameTime, EngineError> {
        timed(&self.device, "drawing", self.timestamps.as_ref(), || {
            let device = self.device.wgpu();
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            match pieces {
                Some(pieces) => pieces.record_frame(&mut encoder, self.timestamps.as_ref()),
                None => {
                    let (ring, timestamps) = (self.ring.as_ref(), self.timestamps.as_ref());
                    for (i, pass) in self.passes.iter().enumerate() {
                        pass.record(&mut encoder, (i, self.passes.len()), ring, timestamps);
                    }
                }
            }
            if let Some(timestamps) = &self.timestamps {
                timestamps.resolve(&mut encoder);
            }
            self.device.queue().submit([encoder.finish()]);
            Ok(())
        })
    }

    /// The last picture. Transparent before the first.
    ///
    /// # Errors
    /// What the driver refuses; a lost device. [`EngineError::CutOff`] when the device did not follow all rays.
    pub fn read_image(&self) -> Result<Image, EngineError> {
        if let Some(Some(pieces)) = self.rays.as_ref().map(FollowedRays::in_pieces) {
            pieces.check(&self.device)?;
        }
        self.canvas.read(&self.device, self.size)
    }

    /// The pieces in which rays are followed. `None` if they are followed at once, or before the first picture.
    #[must_use]
    pub fn ray_pieces(&self) -> Option<RayPieces> {
        self.rays.as_ref()?.in_pieces().map(InPieces::pieces)
    }

    /// Bytes of device memory that hold the volume: the codec's buffers; or the resident bytes of the texture
    /// ([`crate::VolumeTexture::resident_bytes`]); or the ring, the buffer of one layer and the codec's buffers.
    /// Picture, transfer function and view are not counted.
    #[must_use]
    pub const fn resident_bytes(&self) -> u64 {
        self.resident_bytes
    }

    /// Every sample of the frame as pictures read it from the ring: decoded by the same pass, copied by the same
    /// copies, and read from the slots, layer by layer (x fastest, channels interleaved, data units). `None` without a
    /// ring. This overwrites the ring. Each picture fills it again.
    ///
    /// # Errors
    /// What the driver refuses; a lost device.
    pub fn read_layers(&self) -> Result<Option<Vec<f32>>, EngineError> {
        self.ring.as_ref().map(LayerRing::read_layers).transpose()
    }

    /// The replacement for a texture format or filter that the device lacks. `None` if no texture holds voxels.
    #[must_use]
    pub const fn fallback(&self) -> Option<TextureFallback> {
        self.fallback
    }

    /// What interpolates: the texture unit only if a shader samples through it.
    #[must_use]
    pub const fn filtering(&self) -> TextureSampling {
        self.filtering
    }

    /// Precision of blended sums. `None` if nothing is blended. Half if the device cannot blend the plan's precision.
    #[must_use]
    pub fn blending(&self) -> Option<Blending> {
        self.canvas.blending()
    }

    /// The generated shaders, in the order of their passes.
    #[must_use]
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }
}

/// The ring that a plan draws from, if it draws layer by layer.
fn ring_of(device: &Device, plan: &Plan, source: &DrawSource<'_>) -> Result<Option<LayerRing>, EngineError> {
    let axes: Vec<_> = plan.passes.iter().map(|pass| pass.pipeline.layers()).collect();
    match (&axes[..], source) {
        ([Some(axis)], DrawSource::Ring { codec, decoder, frame, level }) => {
            LayerRing::new(device, (codec, *decoder), (*frame, *level), *axis).map(Some)
        }
        (axes, _) if axes.iter().any(Option::is_some) => {
            let text = "a pass that draws layer by layer is the only one of its plan, and draws from a ring of layers";
            Err(EngineError::Unsupported(text.to_owned()))
        }
        _ => Ok(None),
    }
}

/// The target of a plan's passes.
fn canvas_of(device: &Device, plan: &Plan) -> Result<Canvas, EngineError> {
    match plan.passes.last().and_then(|pass| pass.pipeline.proxies()) {
        Some(proxies) => Canvas::target(device, plan.size, target_format(device, proxies.blending)),
        None => Canvas::buffer(device, plan.size),
    }
}

#[cfg(test)]
mod tests;
