//! What draws: a graphics device, or the CPU mirror. Both yield pictures and frame times.

use std::sync::Arc;
use std::time::Instant;

use cvr_core::codec::{BlockTexture, Decoder, Site};
use cvr_core::render::{Blending, DecodedFrame, DecoderVoxels, Image, RenderError, Renderer, View};
use cvr_core::shader::TextureSampling;
use cvr_core::volume::{FrameIndex, Level};
use cvr_engine::timing::FrameTime;
use cvr_engine::{
    BlockFallback, Device, DeviceChoice, DrawSource, Drawing, EngineError, RayPieces, TextureFallback,
    VolumeTexture, process_cpu_time,
};

use super::deferred::DeferredVolume;

/// Why nothing was drawn.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// The device refused.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The renderer or its mirror refused.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// A graphics device, or the CPU mirror.
#[derive(Clone, Debug)]
pub enum Target {
    /// The mirror, on all cores.
    Cpu {
        /// Why no device draws, if one was wanted.
        reason: Option<String>,
    },
    /// A device.
    Device(Device),
}

impl Target {
    /// Opens what `--device` names: `cpu`, `auto`, a backend (`vulkan`, `gl`), or a part of an adapter's name. `auto`
    /// falls back to the mirror where no adapter exists.
    ///
    /// # Errors
    /// When a named adapter does not exist, or an existing one does not open.
    pub fn open(name: &str) -> Result<Self, EngineError> {
        if name.eq_ignore_ascii_case("cpu") {
            return Ok(Self::Cpu { reason: None });
        }
        let choice = name.parse().unwrap_or(DeviceChoice::Auto);
        match Device::open(&choice) {
            Ok(device) => Ok(Self::Device(device)),
            Err(error @ EngineError::NoAdapter { .. }) if choice == DeviceChoice::Auto => {
                Ok(Self::Cpu { reason: Some(error.to_string()) })
            }
            Err(error) => Err(error),
        }
    }

    /// Name in records: the adapter's, or `cpu`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Cpu { .. } => "cpu".to_owned(),
            Self::Device(device) => device.info().name.clone(),
        }
    }

    /// Driver and its version, in words.
    #[must_use]
    pub fn driver(&self) -> String {
        match self {
            Self::Cpu { .. } => "CPU mirror".to_owned(),
            Self::Device(device) => {
                let info = device.info();
                format!("{} {}", info.driver, info.driver_info).trim().to_owned()
            }
        }
    }

    /// Graphics interface, in words.
    #[must_use]
    pub fn backend(&self) -> String {
        match self {
            Self::Cpu { .. } => "none".to_owned(),
            Self::Device(device) => device.info().backend.to_string(),
        }
    }

    /// Why the device is gone for good; every later call on it fails. The mirror is never lost.
    #[must_use]
    pub fn lost(&self) -> Option<String> {
        match self {
            Self::Cpu { .. } => None,
            Self::Device(device) => device.lost(),
        }
    }

    /// Makes a frame at a level drawable at the site *host*: as the codec's blocks, where it has such as the device's
    /// texture units decode, or as decoded by the CPU, which is what the mirror draws from.
    ///
    /// # Errors
    /// When the device cannot hold it.
    pub fn upload(
        &self,
        decoder: &dyn Decoder,
        key: (FrameIndex, Level),
        frame: Arc<DecodedFrame>,
    ) -> Result<HostVolume, DrawError> {
        let Self::Device(device) = self else {
            return Ok(HostVolume { frame, texture: None, fallback: None });
        };
        let (layout, form) = (decoder.layout(), decoder.decoded_form());
        let (texture, fallback) = match self.blocks(decoder, key) {
            Some(Ok(blocks)) => (VolumeTexture::upload_blocks(device, layout, &blocks)?, None),
            Some(Err(reason)) => (VolumeTexture::upload(device, layout, frame.values(), form)?, Some(reason)),
            None => (VolumeTexture::upload(device, layout, frame.values(), form)?, None),
        };
        Ok(HostVolume { frame, texture: Some(Arc::new(texture)), fallback })
    }

    /// The blocks of a frame at a level that this device's texture units decode, or why not; `None` where the codec has no
    /// such blocks, and for the mirror.
    #[must_use]
    pub fn blocks<'d>(
        &self,
        decoder: &'d dyn Decoder,
        (frame, level): (FrameIndex, Level),
    ) -> Option<Result<BlockTexture<'d>, BlockFallback>> {
        let Self::Device(device) = self else { return None };
        let blocks = decoder.block_texture(frame, level)?;
        let takes = device.capabilities().blocks(blocks.format, decoder.layout().channels);
        Some(takes.map(|()| blocks))
    }

    /// Prepares a picture.
    ///
    /// # Errors
    /// When renderer or device refuse.
    pub fn picture<'a>(
        &self,
        renderer: &'a dyn Renderer,
        view: &View,
        voxels: &VoxelSource<'a>,
    ) -> Result<Picture<'a>, DrawError> {
        let layout = voxels.decoder.layout();
        let plan = match voxels.decoded {
            Decoded::Ring(_) => renderer.plan_layers(view, layout)?,
            _ => renderer.plan(view, layout)?,
        };
        let kind = match (self, &voxels.decoded) {
            (Self::Cpu { .. }, decoded) => Kind::Mirror {
                renderer,
                view: Box::new(view.clone()),
                decoder: voxels.decoder,
                index: voxels.frame,
                level: voxels.level,
                frame: decoded.frame(),
            },
            (Self::Device(device), Decoded::Inline) => {
                let source = DrawSource::Inline {
                    codec: voxels.codec,
                    decoder: voxels.decoder,
                    frame: voxels.frame,
                    level: voxels.level,
                };
                Kind::Device(Box::new(Drawing::new(device, &plan, &source, view.filter)?))
            }
            (Self::Device(device), Decoded::Ring(_)) => {
                let source = DrawSource::Ring {
                    codec: voxels.codec,
                    decoder: voxels.decoder,
                    frame: voxels.frame,
                    level: voxels.level,
                };
                Kind::Device(Box::new(Drawing::new(device, &plan, &source, view.filter)?))
            }
            (Self::Device(device), decoded) => {
                let missing = || {
                    let text = "the decoded frame does not lie on this device".to_owned();
                    EngineError::Unsupported(text)
                };
                let source = DrawSource::Texture(decoded.texture().ok_or_else(missing)?);
                Kind::Device(Box::new(Drawing::new(device, &plan, &source, view.filter)?))
            }
        };
        // A format that a device lacks is no fault, but whoever reads the figures must know.
        let fallback = match &kind {
            Kind::Mirror { .. } => None,
            Kind::Device(drawing) => drawing.fallback(),
        };
        let asked_for_single = plan
            .passes
            .iter()
            .any(|pass| pass.pipeline.proxies().is_some_and(|proxies| proxies.blending == Blending::Float32));
        let blends_in_half = match &kind {
            Kind::Device(drawing) => asked_for_single && drawing.blending() == Some(Blending::Float16),
            Kind::Mirror { .. } => false,
        };
        Ok(Picture { kind, fallback, blends_in_half })
    }
}

/// A decoded frame, and its texture where a device draws.
#[derive(Clone, Debug)]
pub struct HostVolume {
    pub(super) frame: Arc<DecodedFrame>,
    pub(super) texture: Option<Arc<VolumeTexture>>,
    /// Why the texture does not hold the codec's blocks, if it has such.
    pub(super) fallback: Option<BlockFallback>,
}

impl HostVolume {
    /// Why the texture does not hold the codec's blocks, if it has such: the frame was uploaded as the CPU decodes it.
    #[must_use]
    pub const fn fallback(&self) -> Option<BlockFallback> {
        self.fallback
    }
}

/// What is decoded before a picture is drawn.
#[derive(Clone, Debug)]
pub enum Decoded {
    /// Nothing: every fetch decodes.
    Inline,
    /// A frame, by the device.
    Deferred(DeferredVolume),
    /// Nothing: layers are decoded while they are drawn. The mirror draws from this frame, decoded on the CPU.
    Ring(Arc<DecodedFrame>),
    /// A frame, by the CPU.
    Host(HostVolume),
}

impl Decoded {
    fn frame(&self) -> Option<Arc<DecodedFrame>> {
        match self {
            Self::Inline => None,
            Self::Deferred(volume) => volume.frame.clone(),
            Self::Ring(frame) => Some(frame.clone()),
            Self::Host(volume) => Some(volume.frame.clone()),
        }
    }

    fn texture(&self) -> Option<Arc<VolumeTexture>> {
        match self {
            Self::Inline | Self::Ring(_) => None,
            Self::Deferred(volume) => volume.texture.clone(),
            Self::Host(volume) => volume.texture.clone(),
        }
    }
}

/// Where a picture's voxels come from.
#[derive(Clone, Debug)]
pub struct VoxelSource<'a> {
    /// Codec id.
    pub codec: &'a str,
    /// The opened stream.
    pub decoder: &'a dyn Decoder,
    /// The frame that is drawn.
    pub frame: FrameIndex,
    /// The level that is drawn, and of what is decoded already.
    pub level: Level,
    /// What of it is decoded already.
    pub decoded: Decoded,
}

impl VoxelSource<'_> {
    /// Where voxels are decoded.
    #[must_use]
    pub const fn site(&self) -> Site {
        match self.decoded {
            Decoded::Inline => Site::Inline,
            Decoded::Deferred(_) => Site::Deferred,
            Decoded::Ring(_) => Site::Ring,
            Decoded::Host(_) => Site::Host,
        }
    }
}

/// A picture that can be drawn any number of times.
#[derive(Debug)]
pub struct Picture<'a> {
    kind: Kind<'a>,
    fallback: Option<TextureFallback>,
    blends_in_half: bool,
}

#[derive(Debug)]
enum Kind<'a> {
    Device(Box<Drawing>),
    Mirror {
        renderer: &'a dyn Renderer,
        view: Box<View>,
        decoder: &'a dyn Decoder,
        index: FrameIndex,
        level: Level,
        frame: Option<Arc<DecodedFrame>>,
    },
}

impl Picture<'_> {
    /// Draws one frame and waits for it.
    ///
    /// # Errors
    /// When device or mirror fail.
    pub fn draw(&self) -> Result<FrameTime, DrawError> {
        match &self.kind {
            Kind::Device(drawing) => Ok(drawing.draw_timed()?),
            Kind::Mirror { .. } => {
                let (start, cpu) = (Instant::now(), process_cpu_time());
                self.mirror()?;
                let wall_ms = start.elapsed().as_secs_f64() * 1000.0;
                let spent = process_cpu_time().zip(cpu).and_then(|(now, then)| now.checked_sub(then));
                Ok(FrameTime { wall_ms, gpu_ms: None, cpu_ms: spent.map(|t| t.as_secs_f64() * 1000.0) })
            }
        }
    }

    /// Draws once and reads the picture.
    ///
    /// # Errors
    /// When device or mirror fail.
    pub fn image(&self) -> Result<Image, DrawError> {
        match &self.kind {
            Kind::Device(drawing) => {
                drawing.draw_timed()?;
                Ok(drawing.read_image()?)
            }
            Kind::Mirror { .. } => self.mirror(),
        }
    }

    /// Every sample as it comes through the ring of layers that this picture is drawn from; `None` at other sites, and for
    /// the mirror, which has no ring.
    ///
    /// # Errors
    /// When the device fails.
    pub fn read_layers(&self) -> Result<Option<Vec<f32>>, DrawError> {
        match &self.kind {
            Kind::Device(drawing) => Ok(drawing.read_layers()?),
            Kind::Mirror { .. } => Ok(None),
        }
    }

    /// Bytes in device memory for the volume; the mirror has none.
    #[must_use]
    pub fn resident_bytes(&self) -> Option<u64> {
        match &self.kind {
            Kind::Device(drawing) => Some(drawing.resident_bytes()),
            Kind::Mirror { .. } => None,
        }
    }

    /// Who interpolates: `hardware` or `manual`.
    #[must_use]
    pub fn filtering(&self) -> &'static str {
        match &self.kind {
            Kind::Device(drawing) if drawing.filtering() == TextureSampling::Hardware => "hardware",
            _ => "manual",
        }
    }

    /// What stands in for a texture format or filter that the device lacks.
    #[must_use]
    pub const fn fallback(&self) -> Option<TextureFallback> {
        self.fallback
    }

    /// The pieces in which the device walks rays; `None` where it walks them at once, or has not drawn yet.
    #[must_use]
    pub fn ray_pieces(&self) -> Option<RayPieces> {
        match &self.kind {
            Kind::Device(drawing) => drawing.ray_pieces(),
            Kind::Mirror { .. } => None,
        }
    }

    /// Whether slices are summed in half precision although single was asked for.
    #[must_use]
    pub const fn blends_in_half(&self) -> bool {
        self.blends_in_half
    }

    fn mirror(&self) -> Result<Image, DrawError> {
        let Kind::Mirror { renderer, view, decoder, index, level, frame } = &self.kind else {
            return Err(EngineError::Unsupported("a device's picture has no mirror".to_owned()).into());
        };
        let mut image = Image::new(view.size);
        match frame {
            Some(frame) => renderer.reference(view, &**frame, &mut image)?,
            None => {
                let voxels = DecoderVoxels::new(*decoder, *index).with_stages(level.stages);
                renderer.reference(view, &voxels, &mut image)?;
            }
        }
        Ok(image)
    }
}
