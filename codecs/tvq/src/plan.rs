//! What is sought before all blocks are coded: trials on few blocks tell how wide codes are, and at which error one pays.

use cvr_core::codec::EncodeError;

use crate::blocks::{Domain, Sample};
use crate::books::Book;
use crate::code::Plane;
use crate::encode::Work;
use crate::geometry::{BRICK, HEAD_WORDS, VOXELS, number, positions};
use crate::payload::mean_width;
use crate::settings::{CODE_BITS, Target};
use crate::train::Trainer;

/// Blocks on which trials train.
const OVERVIEW: u64 = 32768;
/// Least error, in units of sums, at which a bit may pay.
pub const LEAST_ERROR: f64 = 0.5;
/// Blocks of a table that are many.
const MANY: f64 = 65536.0;
/// Costs that differ by no more than this factor are about the same.
const ABOUT_AS_GOOD: f64 = 1.02;
/// Trials of one width.
const TRIALS: usize = 6;
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

/// What one trial promises.
#[derive(Copy, Clone, Debug)]
struct Promise {
    bits: f64,
    /// Squared error of everything, in units of sums.
    error: f64,
}

impl Point {
    /// Squared error that a bit is worth, in units of sums.
    pub fn price(self) -> f64 {
        PRICE * self.error * self.error
    }
}

/// Trials on few blocks.
struct Overview<'a, 'w> {
    work: &'a Work<'w>,
    trainer: Trainer<'a>,
    /// Means of all blocks in units of sums, by domain and plane.
    means: Vec<Vec<Plane>>,
}

impl Overview<'_, '_> {
    /// Bits of all means.
    fn mean_bits(&self, shift: u32) -> f64 {
        let domains = self.work.domains().zip(&self.means);
        domains
            .map(|(domain, planes)| planes.iter().map(|p| mean_bits(p, domain.size, shift)).sum::<f64>())
            .sum()
    }

    fn trial(&self, point: Point) -> Result<Promise, EncodeError> {
        let work = self.work;
        let shift = work.mean_shift(point.error);
        let outcome = self.trainer.variable(
            point.width,
            point.price(),
            (shift, work.threshold(point.error)),
            true,
            work.run,
        )?;
        let codewords: usize = outcome.books.iter().map(Book::size).sum();
        let count = outcome.books.len() as u32;
        // Blocks with codes lie together: about half the bricks that could hold one each do.
        let planes = f64::from(2 * 32 * (32 - count.leading_zeros()));
        let planes = bricks(work) * planes * (2.0 * outcome.open).min(1.0);
        let bits = self.mean_bits(shift)
            + outcome.code_bits
            + planes
            + fixed_bits(work, count, codewords as f64 * work.tables());
        Ok(Promise { bits, error: outcome.error })
    }

    /// The error at which a bit pays such that the target is met, for codes of one width.
    fn find(&self, mut point: Point) -> Result<(Point, Promise), EncodeError> {
        let work = self.work;
        let (by_error, target) = match work.options.target {
            Target::Psnr(psnr) => (true, work.error_of(psnr) / work.unit().powi(2)),
            _ => (false, most_bits(work)),
        };
        // Logarithm of the error at which a bit pays, and of what it leads to over what is wanted; both rise, or one
        // falls.
        let mut known: Vec<(f64, f64)> = Vec::new();
        let mut best: Option<(f64, Point, Promise)> = None;
        for _ in 0..TRIALS {
            let promise = self.trial(point)?;
            let off =
                ((if by_error { promise.error } else { promise.bits }).max(1e-9) / target.max(1e-9)).ln();
            if best.as_ref().is_none_or(|b| off.abs() < b.0.abs()) {
                best = Some((off, point, promise));
            }
            if off.abs() < 0.03 {
                break;
            }
            known.push((point.error.ln(), off));
            let next = match near_zero(&mut known) {
                Some(next) => next,
                None => point.error.ln() + if by_error { -off / 2.0 } else { off.clamp(-1.5, 1.5) },
            };
            point.error = next.clamp(-1.0, 12.0).exp();
        }
        best.map(|(_, point, promise)| (point, promise))
            .ok_or(EncodeError::Unsupported("no trial".to_owned()))
    }
}

/// Between the two known points nearest to zero on either side, where there are such.
fn near_zero(known: &mut [(f64, f64)]) -> Option<f64> {
    known.sort_by(|a, b| a.1.total_cmp(&b.1));
    let after = known.iter().position(|k| k.1 > 0.0)?;
    let (a, b) = (known.get(after.checked_sub(1)?)?, known.get(after)?);
    Some(a.0 + (b.0 - a.0) * (-a.1) / (b.1 - a.1))
}

/// Bits that there are for everything.
pub fn most_bits(work: &Work<'_>) -> f64 {
    match work.options.target {
        Target::Rate(rate) => rate * work.samples(),
        _ => f64::from(8 + CODE_BITS) * work.blocks() + fixed_bits(work, 0, 0.0),
    }
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
    let mut trainer = Trainer::new(&sample, work.training(true));
    trainer.copies = work.tables();
    let overview = Overview { work, trainer, means };
    let error = match work.options.target {
        Target::Psnr(psnr) => (work.error_of(psnr) / work.samples()).sqrt() / work.unit(),
        _ => 0.0126 * work.span / work.unit(),
    };
    let error = error.max(LEAST_ERROR);
    if work.options.index_bits > 0 {
        return Ok(overview.find(Point { width: work.options.index_bits, error })?.0);
    }
    // Widths that there are blocks for; the widest take too long on many blocks, and do not pay there.
    let blocks = work.blocks() / work.tables();
    let widest = ((blocks / 4.0).max(8.0).log2() as u32).min(if blocks > MANY { 8 } else { 12 });
    let first = ((blocks / 2000.0).max(1.0).log2().round() as u32).clamp(3, 6);
    let (mut point, promise) = overview.find(Point { width: first, error })?;
    let cost = |p: Promise| p.error + point.price() * p.bits;
    let mut costs = vec![(first, cost(promise))];
    let coarse = (first + 2..=widest).step_by(2).chain(first.checked_sub(1));
    for width in coarse {
        costs.push((width, cost(overview.trial(Point { width, ..point })?)));
    }
    let least = costs.iter().map(|c| c.1).fold(f64::INFINITY, f64::min);
    // Of those about as good the widest: fewer codes are fewer fetches.
    let good = costs.iter().filter(|c| c.1 <= ABOUT_AS_GOOD * least).map(|c| c.0);
    point.width = good.max().unwrap_or(first);
    if point.width.abs_diff(first) > 1 {
        point = overview.find(point)?.0;
    }
    Ok(point)
}
