//! The step at which a frame reaches a PSNR.

use cvr_core::codec::{EncodeError, Progress};
use cvr_core::volume::BrickSource;

use super::for_slabs;
use super::frame::{Coded, Frame};

/// More decibels than asked for by this share are near enough. Limit.
const NEAR: f64 = 0.004;

/// Most trials. Limit.
const TRIALS: usize = 16;

/// Steps below this share of the range are below what single precision resolves.
const FINEST: f64 = 1e-7;

/// The step between two others at which a line over its logarithm gives `psnr`, away from both ends.
fn between(low: (f64, f64), high: (f64, f64), psnr: f64) -> f64 {
    let part = (low.1 - psnr) / (low.1 - high.1);
    low.0 * (high.0 / low.0).powf(part.clamp(0.1, 0.9))
}

/// Squared error and largest error of decoded channels, integers rounded.
pub struct Measured {
    pub squares: f64,
    pub largest: f64,
}

/// Compares the decoded channels of a frame with its source.
///
/// # Errors
/// When the source fails.
pub fn measure(
    frame: &Frame<'_>,
    decoded: &[Vec<f32>],
    source: &dyn BrickSource,
) -> Result<Measured, EncodeError> {
    let integers = source.layout().sample.is_integer();
    let mut sum = Measured { squares: 0.0, largest: 0.0 };
    let mut at = 0;
    for_slabs(source, frame.index, |values| {
        let channels = decoded.len();
        for (i, voxel) in values.chunks_exact(channels).enumerate() {
            for (sample, decoded) in voxel.iter().zip(decoded) {
                let decoded = decoded[at + i];
                let shown = if integers { decoded.round() } else { decoded };
                let error = f64::from(shown) - f64::from(*sample);
                sum.squares += error * error;
                sum.largest = sum.largest.max(error.abs());
            }
        }
        at += values.len() / channels;
    })?;
    Ok(sum)
}

/// The frame at `psnr` decibels or more, and its largest error.
///
/// # Errors
/// When no step reaches it, the source fails, or the run was cancelled.
pub fn settle(
    frame: &Frame<'_>,
    psnr: f64,
    source: &dyn BrickSource,
    run: &Progress<'_>,
) -> Result<(Coded, f64), EncodeError> {
    let span = frame.shared.range.span();
    let samples = source.layout().samples_per_frame() as f64;
    let allowed = span * span * 10_f64.powf(-psnr / 10.0);
    // At high rates, the squared error is a twelfth of the step's square.
    let mut step = (12.0 * allowed).sqrt();
    let aim = psnr * (1.0 + 0.5 * NEAR);
    // The largest step that reaches the PSNR and the smallest that does not, with theirs.
    let (mut met, mut missed) = (None::<((f64, f64), Coded, f64)>, None::<(f64, f64)>);
    let mut room = Vec::new();
    for _ in 0..TRIALS {
        let coded = frame.coded_in(step as f32, &mut room);
        let decoded: Vec<Vec<f32>> =
            room.iter().map(|q| frame.shared.samples(0, coded.step, q, &[])).collect();
        let Measured { squares, largest } = measure(frame, &decoded, source)?;
        drop(decoded);
        // Without an error, rounded integers say nothing but that it is enough.
        let found = 10.0 * (span * span * samples / squares.max(f64::MIN_POSITIVE)).log10();
        if found >= psnr {
            met = Some(((step, found), coded, largest));
            if found <= psnr * (1.0 + NEAR) {
                break;
            }
        } else {
            missed = Some((step, found));
            if step < span * FINEST {
                break;
            }
        }
        run.advance(0)?;
        step = match (&met, missed) {
            (Some((low, ..)), Some(high)) if high.0 / low.0 < 1.0005 => break,
            (Some((low, ..)), Some(high)) if low.1 < psnr + 20.0 => between(*low, high, aim),
            (Some((low, ..)), Some(high)) => (low.0 * high.0).sqrt(),
            // Twenty decibels to a factor of ten, fewer at low rates.
            _ => step * 10_f64.powf((found - aim).clamp(-40.0, 40.0) / 17.0),
        };
    }
    met.map(|(_, coded, largest)| (coded, largest)).ok_or_else(|| {
        let problem =
            format!("`psnr = {psnr}` is beyond what single precision reaches; use `max_error`, or raw");
        EncodeError::Unsupported(problem)
    })
}
