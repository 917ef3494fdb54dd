//! The encoder: one slab of blocks at a time, with its rows of blocks in parallel.

use cvr_core::codec::{Block, EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::{BlockRow, code_frame};
use cvr_core::volume::{BrickSource, FrameIndex, ValueRange};

use crate::decode::value;
use crate::endpoint::EntryPacker;
use crate::geometry::{Geometry, Parameters};
use crate::{INDEX, MINMAX};

/// Smallest step between two levels of a float block: 2^-100. With a smaller step, products come near the subnormals,
/// which a device may flush. Such a block is coded as its minimum.
const SMALLEST_STEP: f64 = 1.0 / (1_u128 << 100) as f64;

/// Rounding of the decoder's floating-point expression, in units in the last place of the block's largest magnitude:
/// difference 1, factor 4, product 1, sum 1/2, rounded up.
pub const SLACK_ULP: f64 = 8.0;

/// Encodes with one block size and index width.
#[derive(Debug)]
pub struct S3dcEncoder {
    pub block: Block,
    pub index_bits: u32,
}

/// A row of blocks along x.
struct CodedRow {
    /// Minimum and maximum, blocks × channels.
    ends: Vec<[f32; 2]>,
    /// Rows of indices, y fastest, `row_words` each.
    index: Vec<u32>,
    bound: f64,
    /// Number of blocks × channels whose step is below [`SMALLEST_STEP`].
    flattened: u64,
}

impl Encoder for S3dcEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let layout = source.layout().clone();
        let Self { block, index_bits } = *self;
        let Some(geometry) = Geometry::new(&layout, block, index_bits) else {
            let problem =
                format!("block {block} with {index_bits} index bits is outside the settings' ranges");
            return Err(EncodeError::Unsupported(problem));
        };
        let (mut error_bound, mut flattened) = (0.0_f64, 0);
        for frame in (0..layout.frames).map(FrameIndex) {
            let mut packer = EntryPacker::new(geometry.endpoint);
            let row = |by, bz| encode_block_row(&geometry, &BlockRow::read(source, block, frame, by, bz)?);
            code_frame(&geometry.grid, 1, run, row, |rows| {
                let mut words = Vec::new();
                for row in &rows {
                    row.ends.iter().for_each(|[low, high]| packer.push(*low, *high, &mut words));
                    error_bound = error_bound.max(row.bound);
                    flattened += row.flattened;
                }
                out.append_words(MINMAX, &words)?;
                append_index(out, &geometry, &rows)
            })?;
            let mut words = Vec::new();
            packer.flush(&mut words);
            out.append_words(MINMAX, &words)?;
        }
        out.shape(MINMAX, &geometry.minmax_shape(layout.frames))?;
        out.shape(INDEX, &geometry.index_shape(layout.frames))?;
        out.parameters_of(&Parameters { block, index_bits })?;
        let notes = (flattened > 0).then(|| {
            format!("{flattened} blocks were coded as constant: their levels lie less than 2^-100 apart")
        });
        Ok(EncodeReport { error_bound: Some(error_bound), notes: notes.into_iter().collect() })
    }
}

/// Appends the indices of a slab in volume order: slices, then rows of blocks, then rows of voxels.
fn append_index(
    out: &mut dyn StreamWriter,
    geometry: &Geometry,
    rows: &[CodedRow],
) -> Result<(), EncodeError> {
    let row_words = geometry.row_words as usize;
    let heights: Vec<usize> = (0..geometry.grid.blocks().y())
        .map(|by| geometry.grid.voxels([0, by, 0]).extent.y() as usize * row_words)
        .collect();
    let slices = rows.first().map_or(0, |row| row.index.len() / heights[0]);
    for slice in 0..slices {
        for (row, height) in rows.iter().zip(&heights) {
            out.append_words(INDEX, &row.index[slice * height..(slice + 1) * height])?;
        }
    }
    Ok(())
}

fn encode_block_row(g: &Geometry, voxels: &BlockRow) -> Result<CodedRow, EncodeError> {
    let channels = g.channels as usize;
    let (values, line) = (voxels.values(), g.grid.volume().x() as usize * channels);
    let mut row = CodedRow {
        ends: Vec::with_capacity(g.grid.blocks().x() as usize * channels),
        index: vec![0; values.len() / line * g.row_words as usize],
        bound: 0.0,
        flattened: 0,
    };
    let block = g.grid.block().0.x() as usize * channels;
    for from in (0..line).step_by(block) {
        let to = (from + block).min(line);
        for c in 0..channels {
            let samples =
                || values.chunks_exact(line).flat_map(|l| l[from..to].iter().skip(c).step_by(channels));
            let found = ValueRange::of(samples().copied()).unwrap_or(ValueRange { min: 0.0, max: 0.0 });
            let quantiser = Quantiser::new(g, found)?;
            row.bound = row.bound.max(quantiser.bound);
            row.flattened += u64::from(quantiser.flattened);
            row.ends.push(quantiser.ends);
            if quantiser.ends[0] == quantiser.ends[1] {
                continue; // every index is 0
            }
            let words = row.index.chunks_exact_mut(g.row_words as usize);
            for (values, words) in values.chunks_exact(line).zip(words) {
                for k in (from + c..to).step_by(channels) {
                    let bit = k * g.index_bits as usize;
                    words[bit >> 5] |= quantiser.index(values[k]) << (bit & 31);
                }
            }
        }
    }
    Ok(row)
}

/// Converts the values of one block and channel to indices.
struct Quantiser {
    ends: [f32; 2],
    levels: u32,
    reciprocal: f32,
    integers: bool,
    bound: f64,
    flattened: bool,
}

impl Quantiser {
    fn new(g: &Geometry, found: ValueRange) -> Result<Self, EncodeError> {
        let ValueRange { min, max } = found;
        let integers = g.endpoint.is_integer();
        if !(max - min).is_finite() {
            let problem = format!(
                "a block holds values from {min} to {max}, a range that overflows single precision; scale the \
                 volume, or take smaller blocks"
            );
            return Err(EncodeError::Unsupported(problem));
        }
        let step = found.span() / f64::from(g.levels());
        let flattened = !integers && step > 0.0 && step < SMALLEST_STEP;
        let bound = match (integers, flattened, step > 0.0) {
            (true, ..) => (0.5 * step).ceil(),
            (_, true, _) => found.span(),
            (_, _, true) => 0.5 * step + SLACK_ULP * found.ulp(),
            _ => 0.0,
        };
        let ends = if flattened { [min, min] } else { [min, max] };
        Ok(Self { ends, levels: g.levels(), reciprocal: g.reciprocal, integers, bound, flattened })
    }

    /// Equation 1 of the paper in double precision: the nearest level.
    fn index(&self, v: f32) -> u32 {
        let [low, high] = self.ends.map(f64::from);
        let index = ((f64::from(v) - low) * f64::from(self.levels) / (high - low) + 0.5).floor();
        let index = (index as u32).min(self.levels);
        debug_assert!(
            self.holds(v, index),
            "the bound {} does not hold for {v} of {:?}",
            self.bound,
            self.ends
        );
        index
    }

    fn holds(&self, v: f32, index: u32) -> bool {
        let back = value(self.ends, index, self.reciprocal);
        let back = if self.integers { back.round() } else { back };
        (f64::from(back) - f64::from(v)).abs() <= self.bound && self.ends[0] <= back && back <= self.ends[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::{Extent, SampleType, VolumeLayout};

    fn quantiser(sample: SampleType, bits: u32, min: f32, max: f32) -> Quantiser {
        let layout = VolumeLayout::scalar(Extent::ONE, sample);
        let geometry = Geometry::new(&layout, Block(Extent::ONE), bits).unwrap();
        Quantiser::new(&geometry, ValueRange { min, max }).unwrap()
    }

    #[test]
    fn two_bits_round_to_the_nearest_of_four_levels() {
        let q = quantiser(SampleType::U8, 2, 10.0, 40.0);
        let indices: Vec<u32> = [10.0, 14.0, 15.0, 24.0, 25.0, 34.0, 35.0, 40.0].map(|v| q.index(v)).into();
        assert_eq!(indices, [0, 0, 1, 1, 2, 2, 3, 3]);
        assert_eq!(q.bound, 5.0);
    }

    #[test]
    fn the_bound_is_rounded_up_for_integers_alone() {
        assert_eq!(quantiser(SampleType::U8, 4, 0.0, 255.0).bound, 9.0);
        let bound = quantiser(SampleType::F32, 4, 0.0, 255.0).bound;
        assert!(bound > 8.5 && bound < 8.501, "{bound}");
        assert_eq!(quantiser(SampleType::F32, 4, 7.0, 7.0).bound, 0.0);
    }

    #[test]
    fn levels_too_close_for_a_device_become_one() {
        let q = quantiser(SampleType::F32, 4, 1e-37, 2e-37);
        assert_eq!(q.ends, [1e-37, 1e-37]);
        assert!(q.flattened);
        assert_eq!(q.bound, ValueRange { min: 1e-37, max: 2e-37 }.span());
    }
}
