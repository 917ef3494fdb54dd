//! What is sought before all blocks are coded: trials on few blocks tell how wide codes are, and at which error one pays.

use cvr_core::codec::EncodeError;

use crate::blocks::{Domain, Sample};
use crate::books::Book;
use crate::code::Plane;
use crate::encode::Work;
use crate::geometry::{BRICK, HEAD_WORDS, VOXELS, number, positions};
use crate::payload::mean_width;
use crate::settings::Target;
use crate::settle::{Aim, Settled, Sum, best_counts, settle};
use crate::train::Trainer;

/// Blocks on which trials train.
const OVERVIEW: u64 = 32768;
/// Least error, in units of sums, at which a bit may pay.
pub const LEAST_ERROR: f64 = 0.5;
/// Blocks of a table that are many.
const MANY: f64 = 65536.0;
/// Blocks of a table that are not many, and such as are few.
pub const SOME: f64 = 16384.0;
pub const FEW: f64 = 4096.0;
/// Errors, or bits, that differ by no more than this factor are about the same.
const ABOUT_AS_GOOD: f64 = 1.03;
/// Trials of one width.
const TRIALS: usize = 6;
/// Errors at which a bit pays are the same where their logarithms differ by less.
const NEAR: f64 = 0.05;
/// Interpolation takes errors at which a bit pays for no farther off than this.
const STEEP: f64 = 0.5;
/// The farthest that one trial leads, as the logarithm of the error at which a bit pays: where codebooks are few, a price may
/// be any in a wide range.
const FARTHEST: f64 = 1.5;
/// Squared error of a block that one bit is worth, over the mean square of its voxels: a bit less in each of 64
/// dimensions would raise it by 2 ln 2.
pub const PRICE: f64 = 2.0 * std::f64::consts::LN_2;

/// What is sought before all blocks are coded: codes of how many bits, and the error at which a bit pays.
#[derive(Copy, Clone, Debug)]
pub struct Point {
    pub width: u32,
    /// Root mean square, in units of sums.
    pub error: f64,
}

impl Point {
    /// Squared error that a bit is worth, in units of sums.
    pub fn price(self) -> f64 {
        PRICE * self.error * self.error
    }

    /// The error that suits the step of means. A step `s` adds `64 s² / 12` to the error of a block, and one twice as long takes
    /// a bit less: that pays up to 0.59 of the error at which a bit does.
    pub fn of_means(self) -> f64 {
        1.45 * self.error
    }

    /// By how much a bit turns out to be worth more than was assumed: the logarithm of the ratio of the errors at which it
    /// pays. The price is in units of sums.
    pub fn off(self, price: f64) -> f64 {
        ((price / PRICE).sqrt() / self.error).ln().clamp(-FARTHEST, FARTHEST)
    }
}

/// Trials on few blocks.
struct Overview<'a, 'w> {
    work: &'a Work<'w>,
    trainer: Trainer<'a>,
    /// Means of all blocks in units of sums, by domain and plane.
    means: Vec<Vec<Plane>>,
    /// Errors in units of sums.
    aim: Aim,
}

impl Overview<'_, '_> {
    /// Bits of all means.
    fn mean_bits(&self, shift: u32) -> f64 {
        let domains = self.work.domains().zip(&self.means);
        domains
            .map(|(domain, planes)| planes.iter().map(|p| mean_bits(p, domain.size, shift)).sum::<f64>())
            .sum()
    }

    /// What codebooks for a point lead to where the aim is met as well as they can; prices and errors in units of sums.
    fn trial(&self, point: Point) -> Result<Settled, EncodeError> {
        let work = self.work;
        let shift = work.mean_shift(point.of_means());
        let threshold = work.threshold(point.error);
        let outcome =
            self.trainer.variable(point.width, point.price(), (shift, threshold), true, work.run)?;
        let counts = outcome.books.len() + 1;
        let mean_bits = self.mean_bits(shift);
        let codewords = |m: usize| outcome.books.iter().take(m).map(Book::size).sum::<usize>() as f64;
        let fixed: Vec<f64> = (0..counts)
            .map(|m| mean_bits + fixed_bits(work, m as u32, codewords(m) * work.tables()))
            .collect();
        let bricks = bricks(work);
        let sums = |price: f64| {
            let prices = vec![price * f64::from(point.width); counts];
            let mut found = vec![(0.0, 0_u64, 0_u64); counts];
            for errors in outcome.errors.chunks_exact(counts) {
                best_counts(
                    |n| errors[n],
                    &prices,
                    |m, count, error| {
                        let (sum, codes, open) = &mut found[m];
                        *sum += error;
                        *codes += count as u64;
                        *open += u64::from(count > 0);
                    },
                );
            }
            let blocks = (outcome.errors.len() / counts).max(1) as f64;
            let sum = |(m, (error, codes, open)): (usize, (f64, u64, u64))| {
                // Blocks with codes lie together: about half the bricks that could hold one each do.
                let planes = f64::from(2 * 32 * (usize::BITS - m.leading_zeros()));
                let planes = bricks * planes * (2.0 * open as f64 / blocks).min(1.0);
                let codes = codes as f64 * f64::from(point.width) * outcome.scale;
                Sum { bits: fixed[m] + codes + planes, error: error * outcome.scale }
            };
            found.into_iter().enumerate().map(sum).collect()
        };
        Ok(settle(self.aim, point.price(), sums))
    }

    /// The error at which a bit pays such that the aim is met best, for codes of one width. Of errors that do about as well,
    /// the one at which a bit turns out to be worth what was assumed.
    fn find(&self, mut point: Point) -> Result<(Point, Settled), EncodeError> {
        let mut trials: Vec<(Point, Settled)> = Vec::new();
        // Logarithm of the error at which a bit pays, and by how much it turns out to be off, which falls.
        let mut known: Vec<(f64, f64)> = Vec::new();
        for _ in 0..TRIALS {
            let settled = self.trial(point)?;
            trials.push((point, settled));
            let off = point.off(settled.price);
            if off.abs() < NEAR {
                break;
            }
            known.push((point.error.ln(), off.clamp(-STEEP, STEEP)));
            let next = near_zero(&known).unwrap_or(point.error.ln() + off);
            let next = next.clamp(LEAST_ERROR.ln(), 12.0);
            if (next - point.error.ln()).abs() < NEAR {
                break;
            }
            point.error = next.exp();
        }
        let off = |t: &(Point, Settled)| t.0.off(t.1.price).abs();
        let mut good = self.good(trials, |t| t.1.sum);
        good.sort_by(|a, b| off(a).total_cmp(&off(b)).then(self.aim.order(a.1.sum, b.1.sum)));
        good.into_iter().next().ok_or(EncodeError::Unsupported("no trial".to_owned()))
    }

    /// The trials that do about as well as the best of them. Bits that are left over are worth nothing, nor is less error
    /// than was asked for.
    fn good<T>(&self, mut trials: Vec<T>, sum: impl Fn(&T) -> Sum) -> Vec<T> {
        let aim = self.aim;
        let best = trials.iter().map(&sum).min_by(|a, b| aim.order(*a, *b)).unwrap_or_default();
        trials.retain(|t| {
            let [is, least] = [sum(t), best].map(|s| aim.left(s));
            aim.met(sum(t)) == aim.met(best) && is <= ABOUT_AS_GOOD * least
        });
        trials
    }
}

/// Between the two known points nearest to zero on either side, where there are such: of pairs of a place and a value that
/// falls.
fn near_zero(known: &[(f64, f64)]) -> Option<f64> {
    let before = known.iter().filter(|k| k.1 > 0.0).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let after = known.iter().filter(|k| k.1 <= 0.0).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(before.0 + (after.0 - before.0) * before.1 / (before.1 - after.1))
}

/// Bits of header, tables, codebooks and heads of bricks.
pub fn fixed_bits(work: &Work<'_>, books: u32, codewords: f64) -> f64 {
    let entries = codewords * VOXELS as f64 * f64::from(work.options.entry_bits);
    work.overhead(books) + entries + bricks(work) * f64::from(32 * HEAD_WORDS)
}

/// Bricks of all channels and frames.
fn bricks(work: &Work<'_>) -> f64 {
    let of_domain = |d: &Domain| {
        let bricks = d.size.map(|s| f64::from(s.div_ceil(BRICK))).iter().product::<f64>();
        bricks * d.blocks() as f64 / d.plane_blocks() as f64
    };
    work.domains().map(of_domain).sum()
}

/// Bits of the means of one plane, whose codes are finer by `shift` bits than what is stored.
fn mean_bits(plane: &Plane, size: [u32; 3], shift: u32) -> f64 {
    let bricks = size.map(|s| s.div_ceil(BRICK));
    let of_brick = |brick: [u32; 3]| {
        let first = brick.map(|b| b * BRICK);
        let cut = [0, 1, 2].map(|a| BRICK.min(size[a] - first[a]));
        let code = |p: [u32; 3]| {
            let mean = plane.means[number([0, 1, 2].map(|a| first[a] + p[a]), size)];
            (mean + (1 << shift >> 1)) >> shift
        };
        let (_, width) = mean_width(&positions(cut).map(code).collect::<Vec<_>>());
        f64::from(width * cut.iter().product::<u32>())
    };
    positions(bricks).map(of_brick).sum()
}

/// Bits of a code and the error at which a bit pays, such that the target is met.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn plan(work: &Work<'_>) -> Result<Point, EncodeError> {
    let domains: Vec<_> = work.domains().cloned().collect();
    let seed = work.options.seed;
    let sample = Sample::draw(work.source, &domains, work.quantiser, OVERVIEW, seed, work.run)?;
    let coder = work.coder(&[], 0, 0.0);
    let means = domains.iter().map(|domain| coder.code(work.source, domain, work.run));
    let means = means.collect::<Result<Vec<_>, _>>()?;
    let unit = work.unit().powi(2);
    let aim = match work.aim() {
        Aim::Error(error) => Aim::Error(error / unit),
        bits @ Aim::Bits(_) => bits,
    };
    let mut trainer = Trainer::new(&sample, work.training(true));
    trainer.copies = work.tables();
    trainer.most_bits = aim.most_bits();
    let overview = Overview { work, trainer, means, aim };
    let error = match work.options.target {
        Target::Psnr(psnr) => (work.error_of(psnr) / work.samples()).sqrt() / work.unit(),
        _ => 0.0126 * work.span / work.unit(),
    };
    let error = error.max(LEAST_ERROR);
    if work.options.index_bits > 0 {
        return Ok(overview.find(Point { width: work.options.index_bits, error })?.0);
    }
    // Widths that there are blocks for, and bits for a codebook; the widest take too long on many blocks, and do not
    // pay there.
    let blocks = work.blocks() / work.tables();
    let codeword = VOXELS as f64 * f64::from(work.options.entry_bits) * work.tables();
    let payable = (aim.most_bits() / codeword).max(2.0).log2() as u32;
    let widest = ((blocks / 4.0).max(8.0).log2() as u32).min(if blocks > MANY { 8 } else { 12 }).min(payable);
    let first = ((blocks / 2000.0).max(1.0).log2().round() as u32).clamp(3, 6).min(widest);
    let begun = overview.find(Point { width: first, error })?;
    let mut trials = vec![(begun.0, begun.1.sum)];
    // Where blocks are few, so are codebooks, and one more does not fit as often as not: each width has a price of its own.
    let step = if blocks > SOME { 2 } else { 1 };
    for width in (first + step..=widest).step_by(step as usize).chain(first.checked_sub(1).filter(|w| *w > 0))
    {
        let point = Point { width, ..begun.0 };
        let found = if blocks > FEW { (point, overview.trial(point)?) } else { overview.find(point)? };
        trials.push((found.0, found.1.sum));
    }
    // The widest: fewer codes are fewer fetches.
    let good = overview.good(trials, |t| t.1).into_iter().max_by_key(|t| t.0.width);
    let point = good.map_or(begun.0, |t| t.0);
    let anew = blocks > FEW && point.width.abs_diff(first) > 1;
    if anew { Ok(overview.find(point)?.0) } else { Ok(point) }
}
