//! The step that meets a target. The source is read again for every step that is tried, so nothing is held.

use cvr_core::codec::{EncodeError, Progress};
use cvr_core::metrics::psnr_db;
use cvr_core::volume::{BrickSource, ValueRange};

use crate::stream::HEADER;

use super::quantise::{BIT_PRICE, Quantiser};
use super::rows::{Errors, over_rows, row};
use super::scale::Scale;
use super::shape::grid;
use super::sizes::Sizes;
use super::write::Coded;
use super::{Options, Target};

/// A rate is used up to this fraction. Limit: 1 % is promised.
const USED: f64 = 0.996;
/// Steps that differ by this factor are alike. Derived: 0.01 dB.
const ALIKE: f64 = 1.001;
/// Most steps, and most shares of blocks, that are tried between two. Limit.
const TRIES: usize = 16;
/// Factor between steps while both ends are searched.
const REACH: f64 = 4.0;

/// The search for a step.
pub struct Search<'a> {
    pub source: &'a dyn BrickSource,
    pub options: &'a Options,
    pub range: ValueRange,
    pub run: &'a Progress<'a>,
}

impl Search<'_> {
    /// The sizes of a stream with this quantiser.
    pub fn sizes(&self, quantiser: &Quantiser) -> Result<Sizes, EncodeError> {
        let mut all = Sizes::NONE;
        let of_row = |frame, by, bz| {
            let mut sizes = Sizes::NONE;
            row(self.source, quantiser, (frame, by, bz), false, |c| sizes.add(&Coded::of(c)))?;
            Ok(sizes)
        };
        over_rows(self.source, self.options.block, self.run, of_row, |sizes| all = all.clone().and(&sizes))?;
        Ok(all)
    }

    /// Bits of all tensors.
    fn bits(&self, quantiser: &Quantiser) -> Result<f64, EncodeError> {
        let layout = self.source.layout();
        let entries = grid(layout, self.options.block).blocks().voxels() * u64::from(layout.channels);
        // Each frame ends on a word.
        let frames = u64::from(layout.frames);
        Ok(8.0 * (self.sizes(quantiser)?.bytes() + frames * (4 * entries + 3)) as f64)
    }

    fn errors(&self, quantiser: &Quantiser) -> Result<Errors, EncodeError> {
        let mut all = Errors::NONE;
        let of_row = |frame, by, bz| row(self.source, quantiser, (frame, by, bz), true, |_| ());
        over_rows(self.source, self.options.block, self.run, of_row, |errors| all = all.and(errors))?;
        Ok(all)
    }

    /// A quantiser that meets the target.
    pub fn settle(&self) -> Result<Quantiser, EncodeError> {
        let sample = self.source.layout().sample;
        // What keeps all integers. Floats have none.
        let exact = || Quantiser::exact(self.options, Scale::of(sample, self.range, true));
        let lossy = match self.options.target {
            Target::Lossless if sample.is_integer() => return Ok(exact()),
            Target::Lossless => {
                let problem = "lossless blocks hold integers, these samples are floats: name the error that may \
                               remain (max_error), or use a codec that keeps floats (raw)";
                return Err(EncodeError::Unsupported(problem.to_owned()));
            }
            // An integer that errs by less than 1 does not err.
            Target::MaxError(most) if sample.is_integer() && most < 1.0 => return Ok(exact()),
            Target::BitsPerVoxel(rate) => {
                let most = rate * self.source.layout().voxels() as f64 - 8.0 * HEADER;
                if sample.is_integer() && self.bits(&exact())? <= most {
                    return Ok(exact());
                }
                return self.of_rate(most);
            }
            Target::Psnr(psnr) => self.of_psnr(psnr)?,
            Target::MaxError(most) => self.of_max_error(most)?,
        };
        let mut rivals = vec![lossy];
        if sample.is_integer() {
            // A small error may cost more than none, or more than keeping only some integers.
            rivals.push(exact());
            if let Target::MaxError(most) = self.options.target {
                rivals.push(Quantiser::exact(self.options, Scale::apart(self.range, most as i32)));
            }
        }
        let sized = rivals.into_iter().map(|rival| Ok((self.bits(&rival)?, rival)));
        let sized = sized.collect::<Result<Vec<_>, EncodeError>>()?;
        let least = sized.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        Ok(least.map_or_else(exact, |(_, rival)| rival))
    }

    /// The quantiser of a step in data units.
    fn quantiser(&self, step: f64) -> Quantiser {
        let scale = Scale::of(self.source.layout().sample, self.range, false);
        // What is dropped errs by more than half a step.
        let price = if matches!(self.options.target, Target::MaxError(_)) { 0.0 } else { BIT_PRICE };
        let units = f64::from(1_u32 << scale.fraction) / f64::from(scale.unit);
        Quantiser::of_step(self.options, scale, step * units, price)
    }

    fn of_rate(&self, most: f64) -> Result<Quantiser, EncodeError> {
        let bits = |step| self.bits(&self.quantiser(step));
        // Larger steps take fewer bits.
        let found = self.border(false, |step| {
            let bits = bits(step)?;
            Ok((bits <= most, bits <= most && bits >= USED * most))
        })?;
        let step = found.map_err(|step| match bits(step) {
            Ok(bits) => {
                let voxels = self.source.layout().voxels() as f64;
                let (least, block) = ((bits + 8.0 * HEADER) / voxels, self.options.block);
                let larger = if block == 8 { ", or use blocks of 16" } else { "" };
                EncodeError::Unsupported(format!(
                    "blocks of {block} need at least {least:.4} bits per voxel for this volume: allow more{larger}"
                ))
            }
            Err(e) => e,
        })?;
        let [met, missed] = step;
        let mut settled = self.quantiser(met);
        // Where bits jump between the two steps, some blocks have the dead zone of the one that met the rate.
        let (mut most_wide, mut least_wide) = (u32::MAX, 0);
        let mut used = self.bits(&settled)?;
        for _ in 0..TRIES {
            if missed >= met || used >= USED * most {
                break;
            }
            let wider = least_wide + (most_wide - least_wide) / 2;
            let shared = Quantiser { wider, ..self.quantiser(missed) };
            let bits = self.bits(&shared)?;
            if bits > most {
                least_wide = wider;
                continue;
            }
            most_wide = wider;
            if bits > used {
                (settled, used) = (shared, bits);
            }
        }
        Ok(settled)
    }

    fn of_psnr(&self, psnr: f64) -> Result<Quantiser, EncodeError> {
        let samples = self.source.layout().samples() as f64;
        let found = self.border(true, |step| {
            let mse = self.errors(&self.quantiser(step))?.squares / samples;
            // Others may sum in another order.
            Ok((psnr_db(mse * (1.0 + 1e-9), self.range.span()) >= psnr, false))
        })?;
        found.map(|[met, _]| self.quantiser(met)).map_err(|_| {
            EncodeError::Unsupported(format!(
                "{psnr} dB: blocks hold the range of floats in 2^22 steps, which is less: ask for a lower psnr"
            ))
        })
    }

    fn of_max_error(&self, most: f64) -> Result<Quantiser, EncodeError> {
        let found = self
            .border(true, |step| Ok((self.errors(&self.quantiser(step))?.measured.error <= most, false)))?;
        found.map(|[met, _]| self.quantiser(met)).map_err(|step| match self.errors(&self.quantiser(step)) {
            Ok(errors) => EncodeError::Unsupported(format!(
                "max_error {most}: blocks hold the range of floats in 2^22 steps, and an error of {:e} remains: \
                 allow as much",
                errors.measured.error
            )),
            Err(e) => e,
        })
    }

    /// Two neighbouring steps: one meets the target, the other misses it. Both are the same step if it is near enough, or if
    /// all steps meet the target. `met` says whether a step meets it, and whether it is near enough. `small` says whether small
    /// steps meet it. An error is the step at the end that should have met it.
    fn border(
        &self,
        small: bool,
        met: impl Fn(f64) -> Result<(bool, bool), EncodeError>,
    ) -> Result<Result<[f64; 2], f64>, EncodeError> {
        let scale = Scale::of(self.source.layout().sample, self.range, false);
        let unit = f64::from(scale.unit) / f64::from(1_u32 << scale.fraction);
        // Below the lowest, all steps are 1; above the highest, nothing is left. No norm reaches 2^9.
        let ends = [unit / 8.0, (self.range.span() * 1024.0).max(unit)];
        let begun = (self.range.span() / 64.0).clamp(ends[0], ends[1]);
        let inward = |step: f64, up: bool| {
            if up { (step * REACH).min(ends[1]) } else { (step / REACH).max(ends[0]) }
        };
        let (is_met, near) = met(begun)?;
        if near {
            return Ok(Ok([begun; 2]));
        }
        // Towards the side where the other answer lies.
        let up = is_met == small;
        let mut last = begun;
        let (mut yes, mut no) = loop {
            let next = inward(last, up);
            if next == last {
                return Ok(if is_met { Ok([last; 2]) } else { Err(last) });
            }
            let (now, near) = met(next)?;
            if near {
                return Ok(Ok([next; 2]));
            }
            if now != is_met {
                break if now { (next, last) } else { (last, next) };
            }
            last = next;
        };
        for _ in 0..TRIES {
            if yes.max(no) <= ALIKE * yes.min(no) {
                break;
            }
            let middle = (yes * no).sqrt();
            let (is_met, near) = met(middle)?;
            if near {
                return Ok(Ok([middle; 2]));
            }
            if is_met {
                yes = middle;
            } else {
                no = middle;
            }
        }
        Ok(Ok([yes, no]))
    }
}
