//! Volumes from formulas: test signals of any size and sample type, without a file.
//!
//! A signal maps the unit cube to 0..1. Voxel `i` of `n` along an axis has its centre at `(i + 0.5) / n`, so a
//! volume that is no cube shows the same signal stretched, and spacing is 1. Integers take the signal scaled
//! to `0..=MAX` of their type and rounded (signed types stay in their positive half); `f32` takes it as it is.

mod advected_blobs;
mod generator;
mod marschner_lobb;
mod shepp_logan;
mod turbulence;
mod white_noise;

pub use generator::Generator;

use cvr_core::volume::{DenseVolume, Extent, SampleType, Samples, StoredType};
use rayon::prelude::*;

use super::layout::{Shape, StoredLayout};
use super::{InputError, Place};

/// A function on the unit cube, sampled at the voxel centres of one volume.
trait Signal: Sync {
    /// The row of voxels at `y`, `z`: values in 0..=1. `row` holds as many as the volume has along x.
    fn fill_row(&self, y: u32, z: u32, row: &mut [f64]);
}

/// Centre of voxel `i` of `n`, in the unit interval.
fn centre(i: u32, n: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(n)
}

/// The same as [`centre`], in −1..1: the domain of the published signals.
fn signed_centre(i: u32, n: u32) -> f64 {
    2.0 * centre(i, n) - 1.0
}

/// One frame of a test signal; see [`generate_frames`].
///
/// # Errors
/// As [`generate_frames`].
pub fn generate(
    kind: Generator,
    extent: Extent,
    sample: SampleType,
    seed: u64,
) -> Result<DenseVolume, InputError> {
    generate_frames(kind, extent, 1, sample, seed)
}

/// Samples a test signal over so many time steps. [`Generator::Turbulence`], [`Generator::AdvectedBlobs`] and
/// [`Generator::WhiteNoise`] depend on `seed`, and only the blobs move: the frames of the others are equal.
///
/// The samples are the same on every machine, but for [`Generator::MarschnerLobb`]: it calls the machine's `sin`
/// and `cos`, whose last bit may differ.
///
/// # Errors
/// When there is no frame, or the volume is larger than [`super::MAX_VOLUME_BYTES`] or does not fit into memory.
pub fn generate_frames(
    kind: Generator,
    extent: Extent,
    frames: u32,
    sample: SampleType,
    seed: u64,
) -> Result<DenseVolume, InputError> {
    let place = Place::Generator(kind);
    let shape = Shape { frames, ..Shape::scalar(extent.to_array()) };
    let StoredLayout { layout, .. } = StoredLayout::new(&place, shape, [1.0; 3], StoredType::from(sample))?;
    cvr_core::memory::check(layout.bytes(), String::new)
        .map_err(|_| InputError::Memory { place: place.clone(), bytes: layout.bytes() })?;
    let signal = |frame: u32| -> Box<dyn Signal> {
        match kind {
            Generator::SheppLogan => Box::new(shepp_logan::SheppLogan::new(extent)),
            Generator::MarschnerLobb => Box::new(marschner_lobb::MarschnerLobb::new(extent)),
            Generator::Turbulence => Box::new(turbulence::Turbulence::new(extent, seed)),
            Generator::AdvectedBlobs => Box::new(advected_blobs::AdvectedBlobs::new(extent, seed, frame)),
            Generator::WhiteNoise => Box::new(white_noise::WhiteNoise::new(seed)),
        }
    };
    let series = Series { extent, frames, moves: kind == Generator::AdvectedBlobs, signal: &signal };
    let samples = match sample {
        SampleType::U8 => series.sampled(|v| (v * f64::from(u8::MAX)).round() as u8).map(Samples::U8),
        SampleType::I8 => series.sampled(|v| (v * f64::from(i8::MAX)).round() as i8).map(Samples::I8),
        SampleType::U16 => series.sampled(|v| (v * f64::from(u16::MAX)).round() as u16).map(Samples::U16),
        SampleType::I16 => series.sampled(|v| (v * f64::from(i16::MAX)).round() as i16).map(Samples::I16),
        SampleType::F32 => series.sampled(|v| v as f32).map(Samples::F32),
        other => {
            return Err(InputError::Unsupported {
                place,
                found: format!("sample type {other}"),
                supported: "u8, i8, u16, i16, f32".to_owned(),
            });
        }
    };
    let Some(samples) = samples else {
        return Err(InputError::Memory { place, bytes: layout.bytes() });
    };
    DenseVolume::new(layout, samples).map_err(|problem| InputError::Data {
        place,
        problem,
        remedy: "this is a fault of the generator".to_owned(),
    })
}

/// A signal over time.
struct Series<'a> {
    extent: Extent,
    frames: u32,
    /// Whether frames differ.
    moves: bool,
    signal: &'a dyn Fn(u32) -> Box<dyn Signal>,
}

impl Series<'_> {
    /// Evaluates the signal frame by frame; `None` without the memory for it.
    fn sampled<T: Copy + Default + Send>(&self, quantised: impl Fn(f64) -> T + Sync) -> Option<Vec<T>> {
        let voxels = usize::try_from(self.extent.voxels()).ok()?;
        let count = voxels.checked_mul(self.frames as usize)?;
        let mut samples = Vec::new();
        samples.try_reserve_exact(count).ok()?;
        samples.resize(count, T::default());
        let (first, others) = samples.split_at_mut(voxels);
        sample_frame(self.extent, (self.signal)(0).as_ref(), &quantised, first);
        for (frame, number) in others.chunks_exact_mut(voxels).zip(1..) {
            if self.moves {
                sample_frame(self.extent, (self.signal)(number).as_ref(), &quantised, frame);
            } else {
                frame.copy_from_slice(first);
            }
        }
        Some(samples)
    }
}

/// Evaluates one frame slice by slice in parallel.
fn sample_frame<T: Copy + Default + Send>(
    extent: Extent,
    signal: &dyn Signal,
    quantised: &(impl Fn(f64) -> T + Sync),
    samples: &mut [T],
) {
    let nx = extent.x() as usize;
    let slice = nx * extent.y() as usize;
    samples.par_chunks_mut(slice).zip(0..extent.z()).for_each_init(
        || vec![0.0; nx],
        |row, (slice, z)| {
            for (out, y) in slice.chunks_exact_mut(nx).zip(0..) {
                signal.fill_row(y, z, row);
                for (o, v) in out.iter_mut().zip(&*row) {
                    *o = quantised(*v);
                }
            }
        },
    );
}
