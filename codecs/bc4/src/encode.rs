//! The encoder: slice by slice, its rows of blocks in parallel.

use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::volume::{BrickSource, Extent, FrameIndex, Region, SampleType, ValueRange, VolumeLayout};
use rayon::prelude::*;

use crate::block::{EDGE, TEXELS};
use crate::decode::voxel;
use crate::scale::Parameters;
use crate::search::encode_block;
use crate::{BLOCKS, Geometry, Quality, Scale};

/// Slices encoded at a time.
const SLAB: u32 = 16;

/// Smallest step between two codes of wide samples, 2^-100: below it a device that flushes subnormals would lose whole
/// steps.
const SMALLEST_STEP: f64 = 1.0 / (1_u128 << 100) as f64;

/// Encodes with one quality.
#[derive(Debug)]
pub struct Bc4Encoder {
    pub quality: Quality,
}

impl Encoder for Bc4Encoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let layout = source.layout().clone();
        let geometry = Geometry::new(&layout);
        let range = match Scale::native(layout.sample) {
            Some(range) => range,
            None => range_of(source, run)?,
        };
        let rows = RowEncoder { source, geometry, scale: Scale::over(range), quality: self.quality };
        let mut error_bound = 0.0_f64;
        for frame in (0..layout.frames).map(FrameIndex) {
            for first in (0..layout.extent.z()).step_by(SLAB as usize) {
                let slices = first..layout.extent.z().min(first + SLAB);
                let voxels =
                    slices.len() as u64 * u64::from(layout.extent.x()) * u64::from(layout.extent.y());
                for (planes, error) in rows.slab(frame, slices)? {
                    out.append_words(BLOCKS, &planes)?;
                    error_bound = error_bound.max(error);
                }
                run.advance(voxels)?;
            }
        }
        out.shape(BLOCKS, &geometry.shape(layout.frames))?;
        out.parameters_of(&Parameters { range })?;
        Ok(EncodeReport { error_bound: Some(error_bound), notes: Vec::new() })
    }
}

/// Encodes rows of blocks.
struct RowEncoder<'a> {
    source: &'a dyn BrickSource,
    geometry: Geometry,
    scale: Scale,
    quality: Quality,
}

impl RowEncoder<'_> {
    /// Of each slice the planes of its channels, and its largest error.
    fn slab(
        &self,
        frame: FrameIndex,
        slices: std::ops::Range<u32>,
    ) -> Result<Vec<(Vec<u32>, f64)>, EncodeError> {
        let [_, rows] = self.geometry.grid;
        let all: Vec<(u32, u32)> = slices.flat_map(|z| (0..rows).map(move |row| (z, row))).collect();
        let encoded = all.into_par_iter().map(|(z, row)| self.row(frame, z, row));
        let encoded: Vec<(Vec<u32>, f64)> = encoded.collect::<Result<_, EncodeError>>()?;
        let slice = |rows: &[(Vec<u32>, f64)]| {
            let row_words = 2 * self.geometry.grid[0] as usize;
            let plane =
                |c: usize| rows.iter().flat_map(move |(words, _)| &words[c * row_words..(c + 1) * row_words]);
            let planes = (0..self.geometry.channels as usize).flat_map(plane).copied().collect();
            (planes, rows.iter().map(|(_, error)| *error).fold(0.0, f64::max))
        };
        Ok(encoded.chunks(rows as usize).map(slice).collect())
    }

    /// The blocks of a row, channel after channel, and the largest error.
    fn row(&self, frame: FrameIndex, z: u32, row: u32) -> Result<(Vec<u32>, f64), EncodeError> {
        let layout = self.source.layout();
        let (width, first) = (layout.extent.x(), row * EDGE);
        let height = EDGE.min(layout.extent.y() - first);
        let extent = Extent::new(width, height, 1).unwrap_or(Extent::ONE);
        let channels = self.geometry.channels as usize;
        let mut values = vec![0.0; extent.voxels() as usize * channels];
        self.source.read(frame, Region { origin: [0, first, z], extent }, &mut values)?;
        let mut words = Vec::with_capacity(2 * self.geometry.grid[0] as usize * channels);
        let mut error = 0.0_f64;
        for c in 0..channels {
            for from in (0..width).step_by(EDGE as usize) {
                // Beyond the border the last voxel is repeated.
                let voxel = |texel: usize| {
                    let (x, y) = (from + texel as u32 % EDGE, texel as u32 / EDGE);
                    let at = y.min(height - 1) as usize * width as usize + x.min(width - 1) as usize;
                    values[at * channels + c]
                };
                let block: [f32; TEXELS] = std::array::from_fn(voxel);
                let encoded = encode_block(&block.map(|v| self.scale.level(v)), self.quality);
                words.extend(encoded);
                error = error.max(self.error(&block, encoded, layout.sample));
            }
        }
        Ok((words, error))
    }

    /// The largest error of a block, integers rounded.
    fn error(&self, block: &[f32; TEXELS], words: [u32; 2], sample: SampleType) -> f64 {
        let of_texel = |(texel, wanted): (usize, &f32)| {
            let back = voxel(&self.scale, words, texel as u32);
            let shown = if sample.is_integer() { back.round() } else { back };
            (f64::from(shown) - f64::from(*wanted)).abs()
        };
        block.iter().enumerate().map(of_texel).fold(0.0, f64::max)
    }
}

/// The range of the whole volume, if codes can be spread over it.
fn range_of(source: &dyn BrickSource, run: &Progress<'_>) -> Result<ValueRange, EncodeError> {
    let layout: &VolumeLayout = source.layout();
    let mut range: Option<ValueRange> = None;
    for frame in (0..layout.frames).map(FrameIndex) {
        for z in 0..layout.extent.z() {
            let extent = Extent::new(layout.extent.x(), layout.extent.y(), 1).unwrap_or(Extent::ONE);
            let mut values = vec![0.0; extent.voxels() as usize * layout.channels as usize];
            source.read(frame, Region { origin: [0, 0, z], extent }, &mut values)?;
            let part = values.par_chunks(1 << 14).filter_map(|c| ValueRange::of(c.iter().copied()));
            range = range.into_iter().chain(part.reduce_with(ValueRange::union)).reduce(ValueRange::union);
            run.advance(0)?;
        }
    }
    let range = range.unwrap_or(ValueRange { min: 0.0, max: 0.0 });
    let ValueRange { min, max } = range;
    if !(max - min).is_finite() {
        let problem = format!("the range {min} to {max} overflows single precision; scale the volume");
        return Err(EncodeError::Unsupported(problem));
    }
    if max > min && range.span() / 255.0 < SMALLEST_STEP {
        let problem = format!(
            "a 255th of the range {min} to {max} is too small for single precision on a device (less than 2^-100); \
             scale the volume"
        );
        return Err(EncodeError::Unsupported(problem));
    }
    Ok(range)
}
