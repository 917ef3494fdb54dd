//! The step at which a frame takes as many bits as asked for.

use cvr_core::codec::{EncodeError, Progress};
use cvr_core::volume::VolumeLayout;

use super::frame::{Coded, Frame};
use crate::quantiser::rules;

/// Bytes of the container's header, about. It is a multiple of 2048.
const HEADER: f64 = 2048.0;

/// A size within this fraction below the budget is near enough. Limit.
const NEAR: f64 = 0.008;

/// A new step aims at this fraction of the budget, so that it seldom lies above.
const AIM: f64 = 0.997;

/// Most trials. Bisection alone needs no more. Limit.
const TRIALS: usize = 24;

/// Steps below this, in data units of integers, leave no error after rounding.
const FINEST_INTEGER: f64 = 0.2;

/// Steps below this share of the range are below what single precision resolves.
const FINEST_FLOAT: f64 = 1e-7;

/// Parts of an octave in a histogram of magnitudes.
const PARTS: f64 = 8.0;

/// A model of the size of a frame over its step, from a histogram of the logarithms of its coefficients. It knows no
/// contexts, so only ratios of its sizes are used after the first trial.
struct Sizes {
    /// Counts from 2⁻³² times `unit` on.
    counts: Vec<u32>,
    unit: f64,
}

impl Sizes {
    const OCTAVES: f64 = 64.0;

    fn of(frame: &Frame<'_>) -> Self {
        let shared = frame.shared;
        let unit = f64::from(shared.range.max - shared.range.min).max(f64::from(f32::MIN_POSITIVE));
        let mut counts = vec![0; (Self::OCTAVES * PARTS) as usize];
        let last = counts.len() - 1;
        // The rules of the step 1 are one over what coefficients weigh.
        let rules = rules(shared.filter, &shared.pyramid, 1.0);
        for coefficients in &frame.channels {
            for (band, rule) in shared.pyramid.bands().iter().zip(&rules) {
                let weight = (1.0 / (rule.step * unit)) as f32;
                for c in &coefficients[band.range()] {
                    // The bits of a float are its logarithm but for the curve of the mantissa.
                    let bits = (c.abs() * weight).to_bits();
                    let log = (i64::from(bits >> 20) - (127 << 3)) + 32 * 8;
                    if log > 0 {
                        counts[(log as usize).min(last)] += 1;
                    }
                }
            }
        }
        Self { counts, unit }
    }

    /// Bytes at a step, about.
    fn at(&self, step: f64) -> f64 {
        let from = ((step / self.unit).log2() + 32.0) * PARTS;
        let cost = |(log, count): (usize, &u32)| {
            // Octaves above the dead zone. Measured: 3.8 to 4.7 bits for a coefficient that is not 0, at all rates.
            let above = (log as f64 + 0.5 - from) / PARTS + 0.75;
            if above > 0.0 { f64::from(*count) * (3.4 + 0.9 * above) } else { 0.0 }
        };
        self.counts.iter().enumerate().map(cost).sum::<f64>() / 8.0 + 64.0
    }

    /// The step between two others at which the size is `bytes`.
    fn step(&self, bytes: f64, mut low: f64, mut high: f64) -> f64 {
        for _ in 0..40 {
            let middle = (low * high).sqrt();
            if self.at(middle) > bytes { low = middle } else { high = middle }
        }
        (low * high).sqrt()
    }
}

/// The frame within `bits` per voxel of the whole file.
///
/// # Errors
/// When that is less than the smallest frame takes, or the run was cancelled.
pub fn settle(
    frame: &Frame<'_>,
    bits: f64,
    layout: &VolumeLayout,
    run: &Progress<'_>,
) -> Result<Coded, EncodeError> {
    let voxels = layout.extent.voxels() as f64;
    let budget = bits * voxels / 8.0 - HEADER / f64::from(layout.frames);
    let sizes = Sizes::of(frame);
    let span = sizes.unit;
    let finest = if layout.sample.is_integer() { FINEST_INTEGER } else { FINEST_FLOAT * span };
    // A step too small gives too many bytes, a step too large too few.
    let [mut low, mut high] = [finest.min(span), span * 1e3];
    let mut step = sizes.step(budget.max(1.0), low, high);
    let mut best: Option<Coded> = None;
    for trial in 0..TRIALS {
        let coded = frame.coded(step as f32);
        let bytes = coded.bytes() as f64;
        let ratio = bytes / sizes.at(step);
        if bytes <= budget {
            high = step;
            best = Some(coded);
            if bytes >= budget * (1.0 - NEAR) || step <= finest * 1.001 {
                break;
            }
        } else {
            low = step;
            if trial > 0 && high / low < 1.0001 {
                break;
            }
        }
        run.advance(0)?;
        let next = sizes.step(AIM * budget / ratio, low, high);
        // Outside or at an end, the model says nothing.
        let inside = next > low * 1.0005 && next < high * 0.9995;
        step = if inside {
            next
        } else if best.is_some() && low <= finest {
            finest
        } else {
            (low * high).sqrt()
        };
    }
    best.ok_or_else(|| {
        let needed =
            8.0 * (frame.coded(high as f32).bytes() as f64 + HEADER / f64::from(layout.frames)) / voxels;
        EncodeError::Unsupported(format!(
            "`bits_per_voxel = {bits}` is less than the {needed:.4} that index and header take"
        ))
    })
}
