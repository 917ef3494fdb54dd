//! The encoder of whole volumes: each channel of each frame is transformed, quantised and coded on its own.

mod blocks;
mod bound;
mod frame;
mod psnr;
mod rate;

use cvr_core::codec::{Block, EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::{Element, StreamWriter};
use cvr_core::kit::value_range;
use cvr_core::volume::{BrickSource, Extent, FrameIndex, Region, ValueRange, VolumeLayout};

pub use self::blocks::BlockEncoder;
use self::frame::{Coded, Frame};
use crate::decode::Shared;
use crate::settings::{Options, Target};
use crate::stream::parameters::{CHUNKS, LENGTHS, Mode, Parameters, STEPS};
use crate::stream::pyramid::Pyramid;

/// Encodes with one set of settings.
#[derive(Debug)]
pub struct WaveletEncoder {
    pub options: Options,
}

impl Encoder for WaveletEncoder {
    /// Coefficients before and after quantisation, and samples to compare with.
    fn scratch_bytes(&self, layout: &VolumeLayout) -> u64 {
        16 * layout.samples_per_frame()
    }

    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let (options, layout) = (self.options, source.layout().clone());
        if options.filter.is_integer() && !layout.sample.is_integer() {
            let problem =
                format!("filter 5-3 maps integers, not {}; use cdf-9-7 or another filter", layout.sample);
            return Err(EncodeError::Unsupported(problem));
        }
        let extent = layout.extent.to_array().map(|n| n as usize);
        if layout.samples_per_frame() > i32::MAX as u64 {
            let problem =
                format!("a frame of {} has more than 2³¹ − 1 samples; cut it into bricks", layout.extent);
            return Err(EncodeError::Unsupported(problem));
        }
        let range = value_range(source, Block(Extent::cube(SLAB).unwrap_or(Extent::ONE)), run)?;
        refuse_extremes(range)?;
        let mut shared = Shared {
            filter: options.filter,
            pyramid: Pyramid::new(extent, options.decompositions, options.filter.pads()),
            coding: options.coding,
            paper: match options.target {
                Target::Quality(quality) => Some((quality, options.scale)),
                _ => None,
            },
            correction: None,
            range,
        };
        if let Target::MaxError(bound) = options.target {
            shared.correction = Some(bound::unit(bound, layout.sample.is_integer()));
        }
        let (mut steps, mut lengths, mut error) = (Vec::new(), Vec::new(), None::<f64>);
        for index in (0..layout.frames).map(FrameIndex) {
            let frame = Frame::read(source, index, &shared)?;
            run.advance(0)?;
            let coded = match options.target {
                Target::Lossless => (frame.lossless(), Some(0.0)),
                Target::Quality(_) => (frame.coded(0.0), None),
                // The range alone decodes a constant volume, whatever its coefficients are.
                _ if range.max == range.min => (frame.constant(), Some(0.0)),
                Target::BitsPerVoxel(bits) => (rate::settle(&frame, Some(bits), &layout, run)?, None),
                Target::Usual => (rate::settle(&frame, None, &layout, run)?, None),
                Target::Psnr(psnr) => {
                    let found = psnr::settle(&frame, psnr, source, run)?;
                    (found.0, Some(found.1))
                }
                Target::MaxError(bound) => {
                    let found = bound::settle(&frame, bound, source, run)?;
                    (found.0, Some(found.1))
                }
            };
            let (Coded { step, channels }, own_error) = coded;
            error = own_error.map(|own| error.unwrap_or(0.0).max(own));
            for chunks in channels {
                steps.push(step.to_bits());
                for chunk in chunks {
                    lengths.push(chunk.len() as u32);
                    out.append(CHUNKS, Element::U8, &chunk)?;
                }
            }
            run.advance(layout.extent.voxels())?;
        }
        let channels = u64::from(layout.frames) * u64::from(layout.channels);
        out.append_words(LENGTHS, &lengths)?;
        out.shape(LENGTHS, &[channels, shared.chunks() as u64])?;
        out.append_words(STEPS, &steps)?;
        out.shape(STEPS, &[channels])?;
        out.append(CHUNKS, Element::U8, &[0])?;
        out.shape(CHUNKS, &[lengths.iter().map(|n| u64::from(*n)).sum::<u64>() + 1])?;
        out.parameters_of(&Parameters {
            mode: Mode::Volume,
            extent: layout.extent.to_array(),
            filter: options.filter,
            decompositions: options.decompositions as u32,
            coder: options.coding,
            paper: shared.paper,
            correction: shared.correction,
            range,
        })?;
        Ok(EncodeReport { error_bound: error, notes: Vec::new() })
    }
}

/// Magnitudes from here on leave no room for sums of samples in single precision.
const LARGEST: f32 = 1e37;

/// Steps of a smaller range would be so small that devices flush them to 0.
const SMALLEST_SPAN: f64 = 1e-30;

fn refuse_extremes(range: ValueRange) -> Result<(), EncodeError> {
    let (largest, span) = (range.min.abs().max(range.max.abs()), range.span());
    if largest > LARGEST {
        let problem = format!("a sample of {largest:e} leaves no room for sums in single precision; use raw");
        return Err(EncodeError::Unsupported(problem));
    }
    if span > 0.0 && span < SMALLEST_SPAN {
        let problem =
            format!("samples that differ by {span:e} at most have steps that devices flush to 0; use raw");
        return Err(EncodeError::Unsupported(problem));
    }
    Ok(())
}

/// Slices that are read at a time.
const SLAB: u32 = 16;

/// Reads slab after slab of a frame.
fn for_slabs(
    source: &dyn BrickSource,
    frame: FrameIndex,
    mut take: impl FnMut(&[f32]),
) -> Result<(), EncodeError> {
    let layout = source.layout();
    let [x, y, z] = layout.extent.to_array();
    let mut values = Vec::new();
    for at in (0..z).step_by(SLAB as usize) {
        let Ok(extent) = Extent::new(x, y, SLAB.min(z - at)) else { continue };
        values.resize(extent.voxels() as usize * layout.channels as usize, 0.0);
        source.read(frame, Region { origin: [0, 0, at], extent }, &mut values)?;
        take(&values);
    }
    Ok(())
}
