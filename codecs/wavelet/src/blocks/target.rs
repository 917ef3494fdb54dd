//! The step that meets a target. The source is read again for every step that is tried, so nothing is held.

use cvr_core::codec::{EncodeError, Progress};
use cvr_core::metrics::psnr_db;
use cvr_core::volume::{BrickSource, ValueRange};

use super::quantise::{BIT_PRICE, Quantiser, Scale};
use super::rows::{Errors, over_rows, row};
use super::shape::grid;
use super::write::{Coded, Size};
use super::{Options, Target};

/// A rate is used up to this fraction. Limit: 1 % is promised.
const USED: f64 = 0.996;
/// Steps that differ by this factor are alike. Derived: 0.01 dB.
const ALIKE: f64 = 1.001;
/// Most steps, and most prices, that are tried between two. Limit.
const TRIES: usize = 16;
/// At this price every place of −1, 0 and 1 is dropped. Derived: each bit saves less than a square of a step.
const DEAREST: f64 = 2.0;
/// Factor between steps while both ends are searched.
const REACH: f64 = 4.0;

/// Low-pass coefficients of the blocks that have bits, and the size of a stream.
#[derive(Clone, Debug)]
pub struct Extent {
    /// Lowest and highest. The lowest is above the highest if no block has bits.
    low: i32,
    high: i32,
    /// Number of blocks by the bits of their root beyond whole bytes.
    beyond: [u64; 8],
    bytes: u64,
}

impl Extent {
    const NONE: Self = Self { low: i32::MAX, high: i32::MIN, beyond: [0; 8], bytes: 0 };

    fn add(&mut self, coded: &Coded) {
        let Some(Size { root, children }) = coded.size() else { return };
        (self.low, self.high) = (self.low.min(coded.low()), self.high.max(coded.low()));
        self.beyond[(root % 8) as usize] += 1;
        self.bytes += u64::from(root / 8 + children);
    }

    fn and(mut self, other: &Self) -> Self {
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
        self.beyond.iter_mut().zip(other.beyond).for_each(|(beyond, other)| *beyond += other);
        self.bytes += other.bytes;
        self
    }

    /// What low-pass coefficients count from, and their bits.
    pub const fn low(&self) -> (i32, u32) {
        if self.low > self.high {
            return (0, 0);
        }
        (self.low, 32 - self.high.wrapping_sub(self.low).leading_zeros())
    }

    /// Bytes of the bits of all blocks.
    fn bytes(&self) -> u64 {
        let (_, width) = self.low();
        let of = |(beyond, count): (usize, &u64)| count * u64::from((beyond as u32 + width).div_ceil(8));
        self.bytes + self.beyond.iter().enumerate().map(of).sum::<u64>()
    }
}

/// The search for a step.
pub struct Search<'a> {
    pub source: &'a dyn BrickSource,
    pub options: &'a Options,
    pub range: ValueRange,
    pub run: &'a Progress<'a>,
}

impl Search<'_> {
    /// The sizes of a stream with this quantiser.
    pub fn extent(&self, quantiser: &Quantiser) -> Result<Extent, EncodeError> {
        let mut all = Extent::NONE;
        let of_row = |frame, by, bz| {
            let mut extent = Extent::NONE;
            row(self.source, quantiser, (frame, by, bz), false, |c| extent.add(&Coded::of(c)))?;
            Ok(extent)
        };
        over_rows(self.source, self.options.block, self.run, of_row, |extent| {
            all = all.clone().and(&extent)
        })?;
        Ok(all)
    }

    /// Bits of all tensors.
    fn bits(&self, quantiser: &Quantiser) -> Result<f64, EncodeError> {
        let layout = self.source.layout();
        let entries = grid(layout, self.options.block).blocks().voxels() * u64::from(layout.channels);
        // Each frame ends on a word.
        let frames = u64::from(layout.frames);
        Ok(8.0 * (self.extent(quantiser)?.bytes() + frames * (4 * entries + 3)) as f64)
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
                let most = rate * self.source.layout().voxels() as f64;
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
        // What is dropped errs by more than half a step.
        self.priced(step, if matches!(self.options.target, Target::MaxError(_)) { 0.0 } else { BIT_PRICE })
    }

    /// The same with another price of a bit.
    fn priced(&self, step: f64, price: f64) -> Quantiser {
        let scale = Scale::of(self.source.layout().sample, self.range, false);
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
                let (least, block) = (bits / self.source.layout().voxels() as f64, self.options.block);
                let larger = if block == 8 { ", or use blocks of 16" } else { "" };
                EncodeError::Unsupported(format!(
                    "blocks of {block} need at least {least:.4} bits per voxel for this volume: allow more{larger}"
                ))
            }
            Err(e) => e,
        })?;
        let [met, missed] = step;
        let mut settled = self.quantiser(met);
        // In a volume of few blocks, bits jump from step to step. Then a higher price uses up more of the rate at a step
        // that missed it.
        let (mut low, mut high) = (BIT_PRICE, DEAREST);
        let mut used = self.bits(&settled)?;
        for _ in 0..TRIES {
            if missed >= met || used >= USED * most {
                break;
            }
            let price = 0.5 * (low + high);
            let dearer = self.priced(missed, price);
            let bits = self.bits(&dearer)?;
            if bits > most {
                low = price;
                continue;
            }
            high = price;
            if bits > used {
                (settled, used) = (dearer, bits);
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

    /// The nearest steps of which one meets the target and the other misses it; twice the same if that is near enough, or
    /// if all steps meet it. `met` says whether a step meets it, and whether it is near enough. `small` says whether small
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
