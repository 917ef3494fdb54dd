//! The price of a bit and the size of codebooks, by trials on a few blocks.

use cvr_codebook::settings::TrainingSettings;
use cvr_codebook::{Initial, Vectors};
use cvr_core::codec::{Cancelled, Progress};
use cvr_groups::{Aim, Sum};

use super::grow::{Grown, Sample, Wanted, grow};
use super::means::Means;

/// Squared error that a bit is worth over the mean squared error of a sample: 2 ln 2, the slope of `2^(−2 R)` (Cover and Thomas,
/// 10.3.2).
pub const SLOPE: f64 = 2.0 * std::f64::consts::LN_2;
/// Training blocks of a trial. Limit.
const BLOCKS: usize = 24576;
/// Rounds of training of a trial. Limit.
const ROUNDS: u32 = 2;
/// Trials until the price fits. Limit.
const TRIALS: usize = 6;
/// A price fits if the logarithm of bits or of the error is off by less than this. Limit: the exact price is found later.
const FITS: f64 = 0.12;
/// Bits of a code that trials begin with, and the fewest and the most.
const WIDTHS: [u32; 3] = [8, 4, 12];
/// Bits of a record besides codes and escape: mean and count, as a guess.
const RECORD_BITS: f64 = 9.0;
/// Costs that differ by less than this factor are about equal.
const ABOUT: f64 = 1.02;
/// The largest change of a price in one step, as a logarithm of the error.
const FARTHEST: f64 = 1.5;

/// The root mean square error of a sample, in units of sums, bits of a code, and which blocks train.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Point {
    pub error: f64,
    pub width: u32,
    /// Whether blocks that are cheap to code directly train codebooks all the same.
    pub all_train: bool,
}

impl Point {
    /// Squared error that a bit is worth, in units of sums.
    #[must_use]
    pub fn price(self) -> f64 {
        SLOPE * self.error * self.error
    }

    /// The error at which a bit is worth so much.
    #[must_use]
    pub fn of_price(self, price: f64) -> Self {
        Self { error: (price / SLOPE).sqrt(), ..self }
    }
}

/// What trials need to know.
#[derive(Debug)]
pub struct Trials<'a> {
    /// Few blocks.
    pub sample: Sample,
    /// Whether a third of them measures and does not train: there are more blocks than these.
    pub held_out: bool,
    pub training: &'a TrainingSettings,
    /// Everything but size and price of codebooks and means.
    pub wanted: Wanted,
    /// The size that is asked for.
    pub size: Option<usize>,
    /// The aim; errors are in units of sums.
    pub aim: Aim,
    /// Bits of header and heads.
    pub fixed: f64,
    pub run: &'a Progress<'a>,
}

/// Every so many-th block of a sample, so that a trial has few.
#[must_use]
pub fn few(sample: &Sample) -> Sample {
    let every = sample.vectors.len().div_ceil(BLOCKS).max(1);
    let mut vectors = Vectors::new(sample.vectors.dimension());
    let chosen = (0..sample.vectors.len()).step_by(every);
    chosen.for_each(|i| vectors.push(sample.vectors.vector(i), sample.vectors.weight(i)));
    let scale = sample.scale * sample.vectors.total_weight() / vectors.total_weight().max(1e-300);
    Sample { vectors, scale }
}

impl Trials<'_> {
    /// What codebooks are grown for at a point.
    #[must_use]
    pub fn at(&self, point: Point) -> Wanted {
        let means = Means::fine_enough(self.wanted.means.channels, point.error);
        let size = self.size.unwrap_or(1 << point.width);
        Wanted { size, price: point.price(), means, all_train: point.all_train, ..self.wanted }
    }

    fn trial(&self, point: Point) -> Result<Sum, Cancelled> {
        let with = TrainingSettings { iterations: ROUNDS, initial: Initial::Pca, ..*self.training };
        let Grown { bits, kept, error, .. } =
            grow(&self.sample, &self.at(point), &with, self.held_out, self.run)?;
        Ok(Sum { bits: bits + RECORD_BITS * kept + self.fixed, error })
    }

    /// The logarithm by which a sum misses the aim: of bits, or of the error.
    fn off(&self, sum: Sum) -> f64 {
        match self.aim {
            Aim::Bits(most) => (sum.bits / most.max(1.0)).ln(),
            Aim::Error(most) => -(sum.error.max(1e-9) / most.max(1e-9)).ln(),
        }
    }

    /// The point of this width that is about as good as the aim asks for.
    fn of_width(&self, mut point: Point, trials: usize) -> Result<(Point, Sum), Cancelled> {
        // Bits fall about as the error grows, and its square is proportional to the sum of errors.
        let mut slope = if matches!(self.aim, Aim::Bits(_)) { 1.0 } else { 0.5 };
        let mut last: Option<(f64, f64)> = None;
        let mut best: Option<(f64, Point, Sum)> = None;
        for _ in 0..trials {
            let sum = self.trial(point)?;
            let off = self.off(sum);
            if best.is_none_or(|b| off.abs() < b.0) {
                best = Some((off.abs(), point, sum));
            }
            if off.abs() < FITS {
                break;
            }
            let now = (point.error.ln(), off);
            if let Some(last) = last.filter(|last| (last.1 - off).abs() > 1e-3) {
                slope = ((now.0 - last.0) / (last.1 - now.1)).clamp(0.2, 4.0);
            }
            last = Some(now);
            let step = (slope * off).clamp(-FARTHEST, FARTHEST);
            point.error = (point.error.ln() + step).exp().clamp(0.02, 65536.0);
        }
        Ok(best.map_or((point, Sum::default()), |b| (b.1, b.2)))
    }

    /// The best point from an error on: its width by trials at one price, then its price.
    ///
    /// # Errors
    /// When the run was cancelled.
    pub fn search(&self, begin: f64) -> Result<Point, Cancelled> {
        let (found, sum) = self.of_width(self.first(begin), TRIALS)?;
        let best = self.best_width(found, sum)?;
        if best == found { Ok(found) } else { Ok(self.of_width(best, 2)?.0) }
    }

    /// The point of an error with the best width.
    ///
    /// # Errors
    /// When the run was cancelled.
    pub fn at_error(&self, error: f64) -> Result<Point, Cancelled> {
        let point = self.first(error);
        if self.size.is_some() { Ok(point) } else { self.best_width(point, self.trial(point)?) }
    }

    fn first(&self, error: f64) -> Point {
        Point { error, width: self.size.map_or(WIDTHS[0], cvr_codebook::index_bits), all_train: false }
    }

    /// The width that costs the least at a point's price: from the point's own on, wider codes first. Of about equally good ones the
    /// widest: fewer codes are fewer fetches, and many blocks train wide codebooks better than these few.
    fn best_width(&self, point: Point, sum: Sum) -> Result<Point, Cancelled> {
        let [_, least, most] = WIDTHS;
        let cost = |sum: Sum| sum.error + point.price() * sum.bits;
        let mut tried = vec![(point.width, cost(sum))];
        for step in [1, -1] {
            let mut best = cost(sum);
            for n in 1.. {
                let width = point.width.checked_add_signed(step * n).filter(|w| (least..=most).contains(w));
                let Some(width) = width.filter(|_| self.size.is_none()) else { break };
                let cost = cost(self.trial(Point { width, ..point })?);
                tried.push((width, cost));
                if cost >= best {
                    break;
                }
                best = cost;
            }
            if best < cost(sum) {
                break;
            }
        }
        let best = tried.iter().map(|t| t.1).fold(f64::INFINITY, f64::min);
        let good = tried.into_iter().filter(|t| t.1 <= best * ABOUT).map(|t| t.0);
        let found = Point { width: good.max().unwrap_or(point.width), ..point };
        // Blocks of much energy that repeat are coded well by codebooks, which no rule tells from others.
        let all_train = Point { all_train: true, ..found };
        Ok(if cost(self.trial(all_train)?) * ABOUT < best { all_train } else { found })
    }
}
