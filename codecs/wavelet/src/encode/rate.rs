//! The step at which a frame takes as many bits as asked for.

use cvr_core::codec::{EncodeError, Progress};
use cvr_core::volume::VolumeLayout;

use super::frame::{Coded, Frame};
use crate::quantiser::rules;

/// Bytes of the container's header, about. It is a multiple of 2048.
const HEADER: f64 = 2048.0;

/// A size within this fraction below the budget is near enough. Limit.
const NEAR: f64 = 0.0095;

/// A new step aims at this fraction of the budget, in the middle of what is near enough.
const AIM: f64 = 0.9955;

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
        let unit = shared.range.span();
        let mut counts = vec![0; (Self::OCTAVES * PARTS) as usize];
        let last = counts.len() - 1;
        // The rules of the step 1 are one over what coefficients weigh.
        let rules = rules(shared.filter, &shared.pyramid, 1.0, 0.0);
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
        // A coefficient of 2^-0.75 = 0.6 steps is the least that is not 0.
        let least = ((step / self.unit).log2() + 32.0 - 0.75) * PARTS;
        let cost = |(log, count): (usize, &u32)| {
            let above = log as f64 + 1.0 - least;
            let part = above.clamp(0.0, 1.0);
            // Measured: 3.1 to 4.3 bits for a coefficient that is not 0, at all rates.
            part * f64::from(*count) * (3.1 + 0.8 * (above - 0.5 * part) / PARTS)
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

/// The step at which a power law through two sizes gives `bytes`, away from both ends.
fn between(over: (f64, f64), under: (f64, f64), bytes: f64) -> f64 {
    let part = (over.1 / bytes).ln() / (over.1 / under.1).ln();
    over.0 * (under.0 / over.0).powf(part.clamp(0.02, 0.98))
}

/// Bits per voxel, and least bytes of a frame, where nothing is asked for.
pub const USUAL: (f64, f64) = (1.0, 4096.0);

/// The frame within `bits` per voxel of the whole file, or within the usual size.
///
/// # Errors
/// When that is less than the smallest frame takes, or the run was cancelled.
pub fn settle(
    frame: &Frame<'_>,
    bits: Option<f64>,
    layout: &VolumeLayout,
    run: &Progress<'_>,
) -> Result<Coded, EncodeError> {
    let voxels = layout.extent.voxels() as f64;
    let budget = |bits: f64| bits * voxels / 8.0 - HEADER / f64::from(layout.frames);
    let budget = bits.map_or_else(|| budget(USUAL.0).max(USUAL.1), budget);
    let sizes = Sizes::of(frame);
    let span = sizes.unit;
    let finest = if layout.sample.is_integer() { FINEST_INTEGER } else { FINEST_FLOAT * span };
    let mut step = sizes.step(budget.max(1.0), finest, span * 1e3);
    // The nearest steps that give too many and few enough bytes, with these.
    let (mut over, mut under) = (None::<(f64, f64)>, None::<(f64, f64)>);
    let mut best: Option<Coded> = None;
    let mut room = Vec::new();
    for _ in 0..TRIALS {
        let coded = frame.coded_in(step as f32, &mut room);
        let bytes = coded.bytes() as f64;
        if bytes <= budget {
            (under, best) = (Some((step, bytes)), Some(coded));
            if bytes >= budget * (1.0 - NEAR) || step <= finest {
                break;
            }
        } else {
            over = Some((step, bytes));
            if step >= span * 1e3 {
                break;
            }
        }
        run.advance(0)?;
        step = match (over, under) {
            (Some(over), Some(under)) if under.0 / over.0 < 1.0001 => break,
            (Some(over), Some(under)) => between(over, under, AIM * budget),
            _ => sizes.step(AIM * budget * sizes.at(step) / bytes, finest, span * 1e3),
        };
    }
    best.ok_or_else(|| {
        let needed = 8.0
            * (frame.coded((span * 1e3) as f32).bytes() as f64 + HEADER / f64::from(layout.frames))
            / voxels;
        EncodeError::Unsupported(format!(
            "`bits_per_voxel = {}` is less than the {needed:.4} that index and header take",
            bits.unwrap_or(USUAL.0)
        ))
    })
}
