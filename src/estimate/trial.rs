//! A codec with its settings tried on a small computed volume.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use cvr_core::codec::{Codec, Decoder, FrameStore, Progress, Settings};
use cvr_core::pipeline::{Cell, Scene, TransferDomain};
use cvr_core::render::{DecodedFrame, Filter, Preset, View};
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, SampleType, Samples, VolumeLayout,
};

use crate::experiment::running::encoded::{Encoded, encode};
use crate::input::{Generator, generate};
use crate::registry::renderer;
use crate::site::coded::CodedFrame;
use crate::site::picture::VoxelSource;
use crate::site::target::Target;

/// Voxels along each axis of the trial volume.
pub const TRIAL_EDGE: u32 = 48;
/// Edges to try, one after another. The next one runs only if there is time.
pub(super) const EDGES: [u32; 2] = [16, TRIAL_EDGE];
/// Sides in pixels of the trial pictures, used likewise.
pub(super) const SIDES: [u32; 3] = [8, 32, 96];

/// Results of one codec with one set of settings on the small volume.
#[derive(Debug)]
pub struct Trial {
    encoded: Encoded,
    voxels: f64,
    /// Voxels along each axis.
    pub(super) edge: u32,
}

/// A picture of a trial: number of samples, and frame time in milliseconds.
pub(super) type Drawn = (f64, f64);

/// Frame time in milliseconds: `fixed_ms + ms_per_sample × samples`. `samples` counts the samples.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Frames {
    /// Time of a picture without samples.
    pub fixed_ms: f64,
    /// Additional time per ray sample.
    pub ms_per_sample: f64,
}

impl Frames {
    /// Frame time in milliseconds for this number of samples.
    #[must_use]
    pub fn frame_ms(self, samples: f64) -> f64 {
        self.fixed_ms + self.ms_per_sample * samples
    }

    /// The line through the last two measurements. Neither part is negative. A single one gives a time per sample.
    /// `None` without measurements.
    pub(super) fn of(drawn: &[Drawn]) -> Option<Self> {
        match *drawn {
            [] => None,
            [(samples, ms)] => Some(Self { fixed_ms: 0.0, ms_per_sample: ms / samples }),
            [.., few, many] => Some(Self::through([few, many])),
        }
    }

    fn through([(few, few_ms), (many, many_ms)]: [Drawn; 2]) -> Self {
        let ms_per_sample = ((many_ms - few_ms) / (many - few)).max(0.0);
        Self { fixed_ms: (few_ms - ms_per_sample * few).max(0.0), ms_per_sample }
    }
}

/// Number of samples of a picture: its pixels, times the steps across a cube as large as the volume. Rays that miss or
/// end early, clip boxes and skipping are not subtracted.
#[must_use]
pub fn samples(scene: &Scene, layout: &VolumeLayout) -> f64 {
    let [width, height] = scene.size.map(f64::from);
    let lengths = layout.extent.to_array().into_iter().zip(layout.spacing);
    let volume: f64 = lengths.map(|(n, spacing)| f64::from(n) * spacing / layout.voxel_length()).product();
    width * height * volume.cbrt() / f64::from(scene.step_voxels)
}

impl Trial {
    /// Encodes and decodes a small volume of this edge. Stops if `stop` becomes true.
    ///
    /// # Errors
    /// A sentence, when the codec or the disk refuses, or it was stopped.
    pub(super) fn new(
        codec: &dyn Codec,
        settings: &Settings,
        (sample, channels): (SampleType, u32),
        edge: u32,
        stop: &AtomicBool,
    ) -> Result<Self, String> {
        let volume = small_volume(edge, sample, channels)?;
        let scratch = tempfile::tempdir().map_err(|e| format!("a temporary folder: {e}"))?;
        let progress = Progress::new(|_| {}, Some(stop));
        let encoded = encode(codec, settings, &volume, (scratch.path(), FrameStore::DEFAULT_MB), &progress)?;
        Ok(Self { encoded, voxels: volume.layout().voxels() as f64, edge })
    }

    /// Tries one edge after another, as long as the next one will probably end within `limit`. Sends each result.
    pub(super) fn grow(
        codec: &dyn Codec,
        settings: &Settings,
        layout: (SampleType, u32),
        (limit, stop): (Duration, &AtomicBool),
        tell: &Sender<Result<Self, String>>,
    ) {
        let begin = Instant::now();
        let mut before: Option<(u32, Duration)> = None;
        for edge in EDGES {
            let growth = |smaller: u32| (edge / smaller).pow(3);
            let likely = before.map_or(Duration::ZERO, |(smaller, took)| took * growth(smaller));
            if begin.elapsed() + likely > limit {
                return;
            }
            let start = Instant::now();
            let trial = Self::new(codec, settings, layout, edge, stop);
            let failed = trial.is_err();
            if tell.send(trial).is_err() || failed {
                return;
            }
            before = Some((edge, start.elapsed()));
        }
    }

    /// Wall seconds to encode a voxel, the file written and synced.
    #[must_use]
    pub fn encode_seconds_per_voxel(&self) -> f64 {
        self.encoded.encode_seconds / self.voxels
    }

    /// Wall seconds to decode a voxel on the CPU.
    #[must_use]
    pub fn decode_seconds_per_voxel(&self) -> f64 {
        self.encoded.decode_seconds / self.voxels
    }

    /// Bytes of the encoded file for each voxel.
    #[must_use]
    pub fn stream_bytes_per_voxel(&self) -> f64 {
        self.encoded.file_bytes as f64 / self.voxels
    }

    /// The frame of the small stream. `codec` is the codec's id.
    #[must_use]
    pub fn coded<'a>(&'a self, codec: &'a str) -> CodedFrame<'a> {
        self.encoded.coded(codec, FrameIndex::FIRST)
    }

    /// The pictures of a cell.
    ///
    /// # Errors
    /// A sentence, when its frame does not decode.
    pub(super) fn pictures(&self, target: &Target, cell: &Cell, scene: &Scene) -> Result<Pictures, String> {
        Ok(Pictures {
            decoder: self.encoded.decoder.clone(),
            frame: DecodedFrame::at(self.encoded.decoder.as_ref(), FrameIndex::FIRST, cell.level())
                .map_err(|e| e.to_string())?,
            target: target.clone(),
            cell: cell.clone(),
            scene: scene.clone(),
        })
    }
}

/// Pictures of the small volume as a cell would draw it: with the scene's step, light and box, and a faint transfer
/// function that ends no ray. It owns all its data, because it may still draw when nobody waits for it.
pub(super) struct Pictures {
    decoder: Arc<dyn Decoder>,
    frame: Arc<DecodedFrame>,
    target: Target,
    cell: Cell,
    scene: Scene,
}

impl Pictures {
    /// Draws one picture after the other, each once to warm up and once to time it, as long as the next is likely to end
    /// within `limit` and `stop` is false; tells each.
    pub(super) fn grow(&self, limit: (Duration, &AtomicBool), tell: &Sender<Result<Drawn, String>>) {
        if let Err(problem) = self.draw(limit, tell) {
            _ = tell.send(Err(problem));
        }
    }

    fn draw(
        &self,
        (limit, stop): (Duration, &AtomicBool),
        tell: &Sender<Result<Drawn, String>>,
    ) -> Result<(), String> {
        let go_on = || if stop.load(Ordering::Relaxed) { Err("stopped".to_owned()) } else { Ok(()) };
        let Self { decoder, frame, target, cell, scene } = self;
        let begin = Instant::now();
        let renderer = renderer(&cell.renderer)?;
        let decoder = decoder.as_ref();
        let coded = CodedFrame { codec: &cell.codec, decoder, key: (FrameIndex::FIRST, cell.level()) };
        let voxels = VoxelSource::prepare(target, cell.site, coded, &|| Ok(frame.clone()));
        let voxels = voxels.map_err(|e| e.to_string())?;
        let mut before: Option<(u32, f64)> = None;
        for side in SIDES {
            // Twice, since it warms up.
            let pixels = |smaller: u32| f64::from((side / smaller).pow(2));
            let likely_ms = before.map_or(0.0, |(smaller, ms)| 2.0 * ms * pixels(smaller));
            if begin.elapsed().as_secs_f64() + likely_ms / 1000.0 > limit.as_secs_f64() {
                return Ok(());
            }
            go_on()?;
            let scene = small_scene(scene, side);
            let view = view_of(&scene, decoder.layout(), cell.filter)?;
            let picture = target.picture(renderer.as_ref(), &view, &voxels).map_err(|e| e.to_string())?;
            go_on()?;
            picture.draw().map_err(|e| e.to_string())?;
            go_on()?;
            let time = picture.draw().map_err(|e| e.to_string())?;
            if tell.send(Ok((samples(&scene, decoder.layout()), time.wall_ms))).is_err() {
                return Ok(());
            }
            before = Some((side, time.wall_ms));
        }
        Ok(())
    }
}

fn small_scene(scene: &Scene, side: u32) -> Scene {
    let ramp = Preset::named("ramp").map(Preset::control_points).unwrap_or_default();
    Scene {
        size: [side; 2],
        control_points: ramp,
        domain: TransferDomain::Range,
        early_termination: 1.0,
        ..scene.clone()
    }
}

fn view_of(scene: &Scene, layout: &VolumeLayout, filter: Filter) -> Result<View, String> {
    let (min, max) = layout.sample.integer_range().unwrap_or((0, 1));
    let range = cvr_core::volume::ValueRange { min: min.max(0) as f32, max: max as f32 };
    scene.view(range, filter).map_err(|e| e.to_string())
}

/// Noise of several octaves: neither the easiest nor the hardest data for a codec. All channels hold the same values.
fn small_volume(edge: u32, sample: SampleType, channels: u32) -> Result<FiniteVolume, String> {
    fn repeated<T: Copy>(values: Vec<T>, channels: u32) -> Vec<T> {
        values.into_iter().flat_map(|v| std::iter::repeat_n(v, channels as usize)).collect()
    }
    let extent = Extent::cube(edge).map_err(|e| e.to_string())?;
    let scalar = generate(Generator::Turbulence, extent, sample, 1).map_err(|e| e.to_string())?;
    let layout = VolumeLayout { channels, ..scalar.layout().clone() };
    let samples = match scalar.into_samples() {
        Samples::U8(v) => Samples::U8(repeated(v, channels)),
        Samples::I8(v) => Samples::I8(repeated(v, channels)),
        Samples::U16(v) => Samples::U16(repeated(v, channels)),
        Samples::I16(v) => Samples::I16(repeated(v, channels)),
        Samples::F32(v) => Samples::F32(repeated(v, channels)),
        _ => return Err(format!("samples of type {sample} are not generated")),
    };
    Ok(FiniteVolume::new(DenseVolume::new(layout, samples)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_picture_counts_by_its_samples() {
        assert_eq!(Frames::of(&[]), None);
        let one = Frames::of(&[(100.0, 3.0)]).unwrap();
        assert!((one.frame_ms(200.0) - 6.0).abs() < 1e-9);
        // The first of three measurements is not used.
        assert_eq!(
            Frames::of(&[(1.0, 900.0), (100.0, 3.0), (1100.0, 5.0)]),
            Frames::of(&[(100.0, 3.0), (1100.0, 5.0)])
        );
    }

    #[test]
    fn a_line_goes_through_both_measurements_unless_a_part_were_negative() {
        let line = Frames::through([(100.0, 3.0), (1100.0, 5.0)]);
        assert!((line.frame_ms(100.0) - 3.0).abs() < 1e-9 && (line.frame_ms(1100.0) - 5.0).abs() < 1e-9);
        assert_eq!(
            Frames::through([(100.0, 5.0), (1100.0, 3.0)]),
            Frames { fixed_ms: 5.0, ms_per_sample: 0.0 }
        );
        let steep = Frames::through([(100.0, 1.0), (200.0, 10.0)]);
        assert!(steep.fixed_ms == 0.0 && steep.ms_per_sample > 0.0);
    }
}
