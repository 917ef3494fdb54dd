//! The encoder: chunks of slices, packed in parallel, in the order of the samples.

use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::volume::{BrickSource, Extent, FrameIndex, Region, SampleType, ValueRange, VolumeLayout};
use rayon::prelude::*;

use crate::SAMPLES;
use crate::decode::value;
use crate::form::{Bits, Form, Kind, Parameters};

/// Slices read at a time: a multiple of 4, so that every chunk except a frame's last fills whole words.
const SLAB: u32 = 8;

/// Largest finite half.
const HALF_MAX: f32 = 65504.0;

/// Smallest step of `bits = 8`. With a smaller one, a device that flushes subnormals would lose whole steps.
const SMALLEST_STEP: f32 = 1.0 / (1_u128 << 100) as f32;

/// Encodes with one value of the setting `bits`.
#[derive(Debug)]
pub struct RawEncoder {
    pub bits: Bits,
}

impl Encoder for RawEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let layout = source.layout().clone();
        let range = if self.bits == Bits::Eight { quantiser_range(source)? } else { ZERO };
        let form = Form::new(self.bits, layout.sample, range);
        let mut decoded: Option<ValueRange> = None;
        let mut error_bound = 0.0_f64;
        for frame in (0..layout.frames).map(FrameIndex) {
            for slab in slabs(&layout) {
                let values = read(source, frame, slab)?;
                let codes = Codes::new(form, layout.sample);
                if form.kind == Kind::Half {
                    refuse_large(&values)?;
                }
                out.append_words(SAMPLES, &codes.pack(&values))?;
                let (slab_range, slab_error) = codes.check(&values);
                decoded = Some(decoded.map_or(slab_range, |r| r.union(slab_range)));
                error_bound = error_bound.max(slab_error);
                run.advance(slab.extent.voxels())?;
            }
        }
        out.shape(SAMPLES, &[u64::from(layout.frames), form.words_per_frame(&layout)])?;
        // With 8 bits, the quantiser's range is a parameter of decoding. Otherwise the decoded range is only
        // informative.
        let range = if self.bits == Bits::Eight { range } else { decoded.unwrap_or(ZERO) };
        out.parameters_of(&Parameters { bits: self.bits, range })?;
        Ok(EncodeReport { error_bound: Some(error_bound), notes: Vec::new() })
    }
}

const ZERO: ValueRange = ValueRange { min: 0.0, max: 0.0 };

/// Turns values into codes and back.
struct Codes {
    form: Form,
    sample: SampleType,
    span: f64,
}

impl Codes {
    fn new(form: Form, sample: SampleType) -> Self {
        Self { form, sample, span: f64::from(form.high) - f64::from(form.offset) }
    }

    fn code(&self, v: f32) -> u32 {
        let mask = u32::MAX >> (32 - self.form.bits);
        match self.form.kind {
            Kind::Unsigned => v as u32 & mask,
            Kind::Signed => v as i32 as u32 & mask,
            Kind::Single => v.to_bits(),
            Kind::Half => u32::from(half::f16::from_f32(v).to_bits()),
            Kind::Scaled if self.span > 0.0 => {
                let offset = f64::from(v) - f64::from(self.form.offset);
                (offset * 255.0 / self.span + 0.5).floor().min(255.0) as u32
            }
            Kind::Scaled => 0,
        }
    }

    /// The words of consecutive samples that begin on a word.
    fn pack(&self, values: &[f32]) -> Vec<u32> {
        const WORDS: usize = 1 << 14;
        let lanes = self.form.lanes();
        let mut words = vec![0_u32; values.len().div_ceil(lanes)];
        let parts = words.par_chunks_mut(WORDS).zip(values.par_chunks(WORDS * lanes));
        parts.for_each(|(words, values)| {
            for (word, values) in words.iter_mut().zip(values.chunks(lanes)) {
                for (lane, &v) in values.iter().enumerate() {
                    *word |= self.code(v) << (lane as u32 * self.form.bits);
                }
            }
        });
        words
    }

    /// Range of the decoded values and the largest error, integers rounded.
    fn check(&self, values: &[f32]) -> (ValueRange, f64) {
        let one = |&v: &f32| {
            let back = value(&self.form, self.code(v));
            let shown = if self.sample.is_integer() { back.round() } else { back };
            (ValueRange { min: back, max: back }, (f64::from(shown) - f64::from(v)).abs())
        };
        let both = |a: (ValueRange, f64), b: (ValueRange, f64)| (a.0.union(b.0), a.1.max(b.1));
        values.par_iter().map(one).reduce_with(both).unwrap_or((ZERO, 0.0))
    }
}

/// Boxes of [`SLAB`] slices, from the first to the last.
fn slabs(layout: &VolumeLayout) -> impl Iterator<Item = Region> + use<> {
    let [x, y, z] = layout.extent.to_array();
    (0..z).step_by(SLAB as usize).filter_map(move |at| {
        let extent = Extent::new(x, y, SLAB.min(z - at)).ok()?;
        Some(Region { origin: [0, 0, at], extent })
    })
}

fn read(source: &dyn BrickSource, frame: FrameIndex, region: Region) -> Result<Vec<f32>, EncodeError> {
    let mut values = vec![0.0; region.extent.voxels() as usize * source.layout().channels as usize];
    source.read(frame, region, &mut values)?;
    Ok(values)
}

/// The range of the whole volume, if 8 bits can cover it.
fn quantiser_range(source: &dyn BrickSource) -> Result<ValueRange, EncodeError> {
    let layout = source.layout();
    let mut range: Option<ValueRange> = None;
    for frame in (0..layout.frames).map(FrameIndex) {
        for slab in slabs(layout) {
            let values = read(source, frame, slab)?;
            let part = values.par_chunks(1 << 16).filter_map(|c| ValueRange::of(c.iter().copied()));
            range = range.into_iter().chain(part.reduce_with(ValueRange::union)).reduce(ValueRange::union);
        }
    }
    let range = range.unwrap_or(ZERO);
    let ValueRange { min, max } = range;
    if !(max - min).is_finite() {
        let problem =
            format!("bits = 8: the range {min} to {max} overflows single precision; use bits = native");
        return Err(EncodeError::Unsupported(problem));
    }
    if max > min && (max - min) / 255.0 < SMALLEST_STEP {
        let problem = format!(
            "bits = 8: a 255th of the range {min} to {max} is too small for single precision on a device (less \
             than 2^-100); use bits = native"
        );
        return Err(EncodeError::Unsupported(problem));
    }
    Ok(range)
}

fn refuse_large(values: &[f32]) -> Result<(), EncodeError> {
    match values.par_iter().find_first(|v| v.abs() > HALF_MAX) {
        Some(v) => Err(EncodeError::Unsupported(format!(
            "bits = half: a sample is {v}, beyond ±{HALF_MAX}, the largest half; use bits = native"
        ))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bits_reach_both_ends_exactly() {
        let range = ValueRange { min: -3.5, max: 1e6 };
        let codes = Codes::new(Form::new(Bits::Eight, SampleType::F32, range), SampleType::F32);
        assert_eq!((codes.code(-3.5), codes.code(1e6)), (0, 255));
        assert_eq!(value(&codes.form, 0), -3.5);
        assert!((f64::from(value(&codes.form, 255)) - 1e6).abs() <= 2.0 * range.ulp());
        assert!(value(&codes.form, 255) <= 1e6);
    }

    #[test]
    fn four_bytes_share_a_word_lowest_first() {
        let codes = Codes::new(Form::new(Bits::Native, SampleType::I8, ZERO), SampleType::I8);
        assert_eq!(codes.pack(&[1.0, -1.0, 127.0, -128.0, 5.0]), [0x807f_ff01, 5]);
    }
}
