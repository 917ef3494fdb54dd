//! Pictures of held frames, drawn by a device or by the CPU mirror. Both give pictures and frame times.

use std::sync::Arc;
use std::time::Instant;

use cvr_core::codec::Site;
use cvr_core::render::{Blending, DecoderVoxels, Image, Plan, Renderer, View};
use cvr_core::shader::TextureSampling;
use cvr_engine::timing::FrameTime;
use cvr_engine::{Drawing, EngineError, RayPieces, TextureFallback, process_cpu_time};

use super::coded::CodedFrame;
use super::expected::{Checked, Expected};
use super::holding::{DecodeOnCpu, HeldFrame};
use super::of;
use super::target::{DrawError, Target};

/// The voxel source of a picture.
#[derive(Clone, Debug)]
pub struct VoxelSource<'a> {
    /// The site.
    pub site: Site,
    /// The frame that is drawn, as the stream has it.
    pub coded: CodedFrame<'a>,
    /// The same as the site holds it.
    pub held: Arc<dyn HeldFrame>,
}

impl<'a> VoxelSource<'a> {
    /// Makes a frame drawable at a site, once.
    ///
    /// # Errors
    /// As [`super::holding::Holding::prepare`].
    pub fn prepare(
        target: &Target,
        site: Site,
        coded: CodedFrame<'a>,
        decoded: DecodeOnCpu<'_>,
    ) -> Result<Self, DrawError> {
        Ok(Self { site, coded, held: of(site).prepare(target, coded, decoded, false)? })
    }
}

impl Target {
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
        let VoxelSource { site, coded, held } = voxels.clone();
        let (decoder, resolution) = (coded.decoder, coded.key.1.resolution);
        let view = &view.at_resolution(decoder.layout(), resolution, decoder.coarse_shift(resolution));
        let plan = of(site).plan(renderer, view, &coded.layout())?;
        let kind = match self {
            Self::Cpu { .. } => Kind::Mirror { renderer, view: Box::new(view.clone()) },
            Self::Device(device) => {
                Kind::Device(Box::new(Drawing::new(device, &plan, &held.source(coded)?, view.filter)?))
            }
        };
        // A missing texture format is not an error, but the record must mention it.
        let fallback = match &kind {
            Kind::Mirror { .. } => None,
            Kind::Device(drawing) => drawing.fallback(),
        };
        let blends_in_half = match &kind {
            Kind::Device(drawing) => asks_for_single(&plan) && drawing.blending() == Some(Blending::Float16),
            Kind::Mirror { .. } => false,
        };
        Ok(Picture { kind, coded, held, fallback, blends_in_half })
    }
}

/// Whether a plan wants sums blended in single precision.
fn asks_for_single(plan: &Plan) -> bool {
    let mut proxies = plan.passes.iter().filter_map(|pass| pass.pipeline.proxies());
    proxies.any(|proxies| proxies.blending == Blending::Float32)
}

/// A picture that can be drawn repeatedly.
#[derive(Debug)]
pub struct Picture<'a> {
    kind: Kind<'a>,
    coded: CodedFrame<'a>,
    held: Arc<dyn HeldFrame>,
    fallback: Option<TextureFallback>,
    blends_in_half: bool,
}

#[derive(Debug)]
enum Kind<'a> {
    Device(Box<Drawing>),
    Mirror { renderer: &'a dyn Renderer, view: Box<View> },
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

    /// Compares every voxel that the device decodes while it draws this picture with the CPU decoder. `None` if it
    /// decodes none, and for the mirror.
    ///
    /// # Errors
    /// A sentence, when the device fails.
    pub fn check(&self, expected: &Expected<'_>) -> Result<Option<Checked>, String> {
        match &self.kind {
            Kind::Device(drawing) => self.held.check_drawing(drawing, expected),
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

    /// The replacement for a texture format or filter that the device lacks.
    #[must_use]
    pub const fn fallback(&self) -> Option<TextureFallback> {
        self.fallback
    }

    /// The pieces in which the device follows rays. `None` if it follows them at once, or has not drawn yet.
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
        let Kind::Mirror { renderer, view } = &self.kind else {
            return Err(EngineError::Unsupported("a device's picture has no mirror".to_owned()).into());
        };
        let mut image = Image::new(view.size);
        match self.held.decoded() {
            Some(frame) => renderer.reference(view, &*frame, &mut image)?,
            None => {
                let (frame, level) = self.coded.key;
                let voxels = DecoderVoxels::new(self.coded.decoder, frame, level)?;
                renderer.reference(view, &voxels, &mut image)?;
            }
        }
        Ok(image)
    }
}
