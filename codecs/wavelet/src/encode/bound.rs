//! Coding within a bound on every sample: a step near the bound, and corrections of the samples that miss it.

use cvr_core::codec::{EncodeError, Progress};
use cvr_core::volume::BrickSource;

use super::for_slabs;
use super::frame::{Coded, Frame};
use super::psnr::measure;
use crate::coders::corrections::{self, Correction};

/// Steps that are tried, in bounds. The step of least bytes lies at 1.5 in SPERR (S. Li, P. Lindstrom, J. Clyne, Lossy
/// Scientific Data Compression With SPERR, 2023).
const STEPS: [f64; 3] = [1.1, 1.5, 2.0];

/// A correction is a multiple of this many bounds of floats. Twice the bound would leave errors of exactly the bound,
/// which rounding passes.
const UNIT: f64 = 1.98;

/// What a correction is a multiple of, in data units.
#[must_use]
pub fn unit(bound: f64, integers: bool) -> f32 {
    if integers { (2.0 * bound.floor() + 1.0) as f32 } else { (UNIT * bound) as f32 }
}

/// Corrections of a channel: of all samples whose error is above the bound.
fn corrections_of(
    frame: &Frame<'_>,
    (bound, unit): (f64, f64),
    decoded: &[Vec<f32>],
    source: &dyn BrickSource,
) -> Result<Vec<Vec<Correction>>, EncodeError> {
    let integers = source.layout().sample.is_integer();
    let mut out = vec![Vec::new(); decoded.len()];
    let (mut at, clamp) = (0, frame.shared.range);
    for_slabs(source, frame.index, |values| {
        let channels = decoded.len();
        for (i, voxel) in values.chunks_exact(channels).enumerate() {
            for ((sample, decoded), out) in voxel.iter().zip(decoded).zip(&mut out) {
                let clamped = decoded[at + i].max(clamp.min).min(clamp.max);
                let shown = if integers { clamped.round() } else { clamped };
                let missing = f64::from(*sample) - f64::from(shown);
                if missing.abs() > bound {
                    let units = (missing / unit).round();
                    out.push(Correction { place: (at + i) as u32, units: units as i32 });
                }
            }
        }
        at += values.len() / channels;
    })?;
    Ok(out)
}

/// The frame with no error above `bound`, and its largest error.
///
/// # Errors
/// When single precision cannot keep the bound, the source fails, or the run was cancelled.
pub fn settle(
    frame: &Frame<'_>,
    bound: f64,
    source: &dyn BrickSource,
    run: &Progress<'_>,
) -> Result<(Coded, f64), EncodeError> {
    let (shared, integers) = (frame.shared, source.layout().sample.is_integer());
    // Integers are rounded, so their errors may reach half a unit more before.
    let (bound, reach) = if integers { (bound.floor(), bound.floor() + 0.5) } else { (bound, bound) };
    let unit = f64::from(shared.correction.unwrap_or(1.0));
    let mut best: Option<(Coded, f64)> = None;
    let mut room = Vec::new();
    for factor in STEPS {
        let mut coded = frame.coded_in((factor * reach) as f32, &mut room);
        let mut decoded: Vec<Vec<f32>> = room.iter().map(|q| shared.transformed(0, coded.step, q)).collect();
        let corrections = corrections_of(frame, (bound, unit), &decoded, source)?;
        for ((chunks, decoded), corrections) in coded.channels.iter_mut().zip(&mut decoded).zip(&corrections)
        {
            chunks.push(corrections::encode(corrections));
            shared.correct(decoded, corrections);
        }
        let largest = measure(frame, &decoded, source)?.largest;
        if largest <= bound && best.as_ref().is_none_or(|(best, _)| coded.bytes() < best.bytes()) {
            best = Some((coded, largest));
        }
        run.advance(0)?;
    }
    best.ok_or_else(|| {
        let problem =
            format!("single precision cannot keep `max_error = {bound}`; ask for a larger one, or use raw");
        EncodeError::Unsupported(problem)
    })
}
