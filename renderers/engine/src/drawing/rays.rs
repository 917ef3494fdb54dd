//! Rays that are followed in pieces, for devices that end loops early.

use std::sync::{Arc, OnceLock};

use cvr_core::render::{Contents, Filter, Pass, RayWalk, Stage};
use cvr_core::shader::{GeneratedShader, ShaderError};

use crate::bindings::{Bound, Parts, Supplies};
use crate::canvas::CutOff;
use crate::pipelines::Target;
use crate::source::Voxels;
use crate::timestamps::FrameTimestamps;
use crate::{Device, DrawSource, EngineError, VolumeTexture};

/// The pieces in which rays are followed.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct RayPieces {
    /// Samples that a ray takes in one piece at most.
    pub samples: u32,
    /// Pieces after which all rays are at their ends.
    pub pieces: u32,
}

impl std::fmt::Display for RayPieces {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { samples, pieces } = self;
        let count = |n: &u32, what: &str| format!("{n} {what}{}", if *n == 1 { "" } else { "s" });
        write!(
            f,
            "rays walked in {} of {}: this device ends loops that take longer",
            count(pieces, "piece"),
            count(samples, "sample")
        )
    }
}

/// A pass that follows rays at once, and its version in pieces. It is decided once per picture which one is used.
#[derive(Debug)]
pub(super) struct FollowedRays {
    contents: Vec<Contents>,
    workgroups: [u32; 3],
    shader: Result<Arc<GeneratedShader>, ShaderError>,
    image: wgpu::Buffer,
    /// Data of the volume: uploaded buffers, or a texture.
    parts: Parts,
    texture: Option<Arc<VolumeTexture>>,
    settled: OnceLock<Option<InPieces>>,
}

/// Workgroups that follow the rays of a picture.
pub(super) fn workgroups(size: [u32; 2]) -> [u32; 3] {
    let [x, y] = size.map(|pixels| pixels.div_ceil(RayWalk::WORKGROUP));
    [x, y, 1]
}

impl FollowedRays {
    /// `None` if the pass follows no rays. Only text is generated here. A picture without pieces compiles nothing for
    /// them.
    pub(super) fn new(
        device: &Device,
        (pass, size): (&Pass, [u32; 2]),
        (voxels, source): (&Voxels<'_>, &DrawSource<'_>),
        filter: Filter,
        (image, parts): (&wgpu::Buffer, Parts),
    ) -> Option<Self> {
        let Stage::Rays(_) = pass.pipeline.stage else { return None };
        let program = pass.pipeline.guarded_program()?;
        let shader = voxels.shader(device, &program, Some(filter));
        let texture = match source {
            DrawSource::Texture(texture) => Some(Arc::clone(texture)),
            DrawSource::Inline { .. } | DrawSource::Ring { .. } | DrawSource::Buffers(_) => None,
        };
        let (contents, workgroups, image) = (pass.inputs.contents.clone(), workgroups(size), image.clone());
        Some(Self { contents, workgroups, shader, image, parts, texture, settled: OnceLock::new() })
    }

    /// Takes other inputs. How they are drawn is undecided.
    pub(super) fn set_inputs(&mut self, contents: &[Contents]) {
        self.contents = contents.to_vec();
        self.settled = OnceLock::new();
    }

    /// How the picture is drawn, once decided: in pieces, or (`None` inside) at once.
    pub(super) fn settled(&self) -> Option<Option<&InPieces>> {
        self.settled.get().map(Option::as_ref)
    }

    /// The pieces, if it is settled that there are some.
    pub(super) fn in_pieces(&self) -> Option<&InPieces> {
        self.settled().flatten()
    }

    /// Nothing was cut off.
    pub(super) fn settle_at_once(&self) {
        self.settled.get_or_init(|| None);
    }

    /// Finds a length of pieces for rays that were cut off. It starts with the shortest number of samples that one of
    /// them reached.
    pub(super) fn settle_by(
        &self,
        device: &Device,
        cut_off: CutOff,
    ) -> Result<Option<&InPieces>, EngineError> {
        let samples = 1 << cut_off.sample.max(1).ilog2();
        let found = self.find(device, samples)?;
        Ok(self.settled.get_or_init(|| Some(found)).as_ref())
    }

    /// Finds pieces of at most this many samples, regardless of earlier decisions.
    pub(super) fn settle_in_pieces(&mut self, device: &Device, samples: u32) -> Result<(), EngineError> {
        self.settled = OnceLock::from(Some(self.find(device, samples.max(1))?));
        Ok(())
    }

    /// Draws whole pictures in ever shorter pieces, from `samples` on, until no ray is cut off.
    fn find(&self, device: &Device, samples: u32) -> Result<InPieces, EngineError> {
        let shader = self.shader.as_ref().map_err(|problem| {
            EngineError::Unsupported(format!("rays cannot be followed in pieces on this device: {problem}"))
        })?;
        let rays = self.image.size() / size_of::<[f32; 4]>() as u64;
        let progress = device.guarded("preparing pieces of rays", || {
            let usage =
                wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
            device.empty_buffer("progress", usage, rays * size_of::<u32>() as u64)
        })?;
        let pieces = Contents { name: "pieces", bytes: samples.to_le_bytes().to_vec() };
        let contents: Vec<_> = self.contents.iter().cloned().chain([pieces]).collect();
        let supplies = Supplies {
            inputs: &contents,
            storage: &[("image", &self.image), ("progress", &progress)],
            texture: self.texture.as_deref(),
            ..Supplies::default()
        };
        let bound = Bound::new(device, shader, Target::Compute, &supplies, &mut self.parts.clone())?;
        let pieces = RayPieces { samples, pieces: 0 };
        let mut found = InPieces { bound, workgroups: self.workgroups, progress, pieces };
        loop {
            device.guarded("preparing pieces of rays", || {
                found.bound.write_uniform(device, "pieces", &found.pieces.samples.to_le_bytes());
                Ok(())
            })?;
            match found.try_frame(device)? {
                Tried::Drawn { pieces } => {
                    found.pieces.pieces = pieces;
                    return Ok(found);
                }
                Tried::CutOff { pixels } if found.pieces.samples == 1 => {
                    return Err(EngineError::CutOff { pixels });
                }
                Tried::CutOff { .. } => found.pieces.samples /= 2,
            }
        }
    }
}

/// Result of a picture in pieces of some length.
enum Tried {
    Drawn { pieces: u32 },
    CutOff { pixels: usize },
}

/// A pass that follows rays in pieces, ready to be dispatched.
#[derive(Debug)]
pub(super) struct InPieces {
    bound: Bound,
    workgroups: [u32; 3],
    progress: wgpu::Buffer,
    pieces: RayPieces,
}

impl InPieces {
    pub(super) const fn pieces(&self) -> RayPieces {
        self.pieces
    }

    /// Records all pieces of a picture. The reset of the rays lies between the timestamps as well.
    pub(super) fn record_frame(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamps: Option<&FrameTimestamps>,
    ) {
        let pass = |index| wgpu::ComputePassDescriptor {
            label: Some("draw"),
            timestamp_writes: timestamps.and_then(|t| t.writes(index, 2)),
        };
        drop(encoder.begin_compute_pass(&pass(0)));
        encoder.clear_buffer(&self.progress, 0, None);
        let mut pass = encoder.begin_compute_pass(&pass(1));
        for _ in 0..self.pieces.pieces {
            self.bound.dispatch(&mut pass, self.workgroups);
        }
    }

    /// Fails if a ray of the last picture is not at its end.
    pub(super) fn check(&self, device: &Device) -> Result<(), EngineError> {
        let progress: Vec<u32> = device.read_buffer(&self.progress, self.progress.size())?;
        match progress.iter().filter(|&&next| next != RayWalk::END).count() {
            0 => Ok(()),
            pixels => Err(EngineError::CutOff { pixels }),
        }
    }

    /// Draws a picture piece by piece and checks each piece. If a ray was cut off, the picture is invalid.
    fn try_frame(&self, device: &Device) -> Result<Tried, EngineError> {
        let mut before = Vec::new();
        for pieces in 1.. {
            device.guarded("drawing a piece of rays", || {
                let mut encoder =
                    device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                if pieces == 1 {
                    encoder.clear_buffer(&self.progress, 0, None);
                }
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                self.bound.dispatch(&mut pass, self.workgroups);
                drop(pass);
                device.queue().submit([encoder.finish()]);
                Ok(())
            })?;
            let progress: Vec<u32> = device.read_buffer(&self.progress, self.progress.size())?;
            let cut = progress.iter().filter(|&&next| next == RayWalk::CUT).count();
            if cut > 0 {
                return Ok(Tried::CutOff { pixels: cut });
            }
            if progress.iter().all(|&next| next == RayWalk::END) {
                return Ok(Tried::Drawn { pieces });
            }
            if progress == before {
                break;
            }
            before = progress;
        }
        Err(EngineError::Gpu("drawing in pieces: rays make no headway".to_owned()))
    }
}
