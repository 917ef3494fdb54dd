//! What is sought before all blocks are coded: trials on few blocks tell how wide codes are, and at which error one pays.

use cvr_core::codec::EncodeError;

use crate::blocks::{Domain, Sample};
use crate::code::Plane;
use crate::encode::Work;
use crate::geometry::{BRICK, HEAD_WORDS, VOXELS, number, positions};
use crate::overview::{Overview, Trial};
use crate::payload::mean_width;
use crate::settings::Target;
use crate::settle::Aim;
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
/// Trials of one width, and of one beside another whose price is known.
const TRIALS: usize = 6;
const ANEW: usize = 3;
/// The farthest that one trial leads, as the logarithm of the error at which a bit pays: where codebooks are few, a price may
/// be any in a wide range.
const FARTHEST: f64 = 1.5;
/// Squared error of a block that one bit is worth, over the mean square of its voxels: a bit less in each of 64
/// dimensions would raise it by 2 ln 2.
pub const PRICE: f64 = 2.0 * std::f64::consts::LN_2;

/// Bits of an entry as a rule, and where these leave an error that codes cannot mend.
pub const COARSE: u32 = 8;
const FINE: u32 = 16;
/// What finer entries must leave of the error, or of the bits, before all trials are made with them.
const FINER_GAINS: f64 = 0.97;

/// Budgets that are tried for an error, and how near its logarithm is to come, or else those of two budgets to each other.
const BUDGETS: usize = 5;
const CLOSE: f64 = 0.1;
const CLOSER: f64 = 0.02;
/// Logarithm of bits per logarithm of error, about.
const SLOPE: f64 = 0.3;

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

/// Bits of header, tables, codebooks and heads of bricks.
pub fn fixed_bits(work: &Work<'_>, books: u32, codewords: f64) -> f64 {
    let entries = codewords * VOXELS as f64 * f64::from(work.entry_bits());
    work.overhead(books) + entries + bricks(work) * f64::from(32 * HEAD_WORDS)
}

/// Bricks of all channels and frames.
pub fn bricks(work: &Work<'_>) -> f64 {
    let of_domain = |d: &Domain| {
        let bricks = d.size.map(|s| f64::from(s.div_ceil(BRICK))).iter().product::<f64>();
        bricks * d.blocks() as f64 / d.plane_blocks() as f64
    };
    work.domains().map(of_domain).sum()
}

/// Bits of the means of one plane, whose codes are finer by `shift` bits than what is stored.
pub fn mean_bits(plane: &Plane, size: [u32; 3], shift: u32) -> f64 {
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

/// What is sought before all blocks are coded.
#[derive(Clone, Debug)]
pub struct Plan {
    pub point: Point,
    /// Codewords of each codebook; none, where codebooks are added as long as they pay.
    pub sizes: Vec<usize>,
    /// Bits of an entry.
    pub entry_bits: u32,
}

/// Bits of a code and of an entry and the error at which a bit pays, such that the target is met.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn plan(work: &Work<'_>) -> Result<Plan, EncodeError> {
    let domains: Vec<_> = work.domains().cloned().collect();
    let seed = work.options.seed;
    let sample = Sample::draw(work.source, &domains, work.quantiser, OVERVIEW, seed, work.run)?;
    let coder = work.coder(&[], 0, 0.0);
    let means = domains.iter().map(|domain| coder.code(work.source, domain, work.run));
    let means = means.collect::<Result<Vec<_>, _>>()?;
    let of = |trial: Trial, entry_bits| Plan { point: trial.point, sizes: trial.sizes, entry_bits };
    if let Some(bits) = work.options.entry_bits {
        return Ok(of(search(&mut overview(work, &sample, &means))?, bits));
    }
    let coarse = work.with_entry_bits(COARSE);
    let found = search(&mut overview(&coarse, &sample, &means))?;
    let fine = work.with_entry_bits(FINE);
    let finer = finer(&mut overview(&fine, &sample, &means), &found)?;
    Ok(finer.map_or_else(|| of(found, COARSE), |trial| of(trial, FINE)))
}

/// The best trial with fine entries, if it leaves enough less than one with coarse entries. Fewer codewords are as dear, so
/// that the width below is tried beside the one that suits the coarse.
fn finer(overview: &mut Overview<'_, '_>, found: &Trial) -> Result<Option<Trial>, EncodeError> {
    let asked = overview.aim;
    // Few blocks are led to an error by rates: see `of_error`.
    if overview.by_aim && matches!(asked, Aim::Error(_)) {
        overview.aim = Aim::Bits(found.settled.sum.bits);
    }
    let aim = overview.aim;
    let order = |a: &Trial, b: &Trial| aim.order(a.settled.sum, b.settled.sum);
    let width = found.point.width;
    let widths =
        if overview.work.options.index_bits > 0 || width < 2 { width..=width } else { width - 1..=width };
    let tried = widths.map(|width| overview.trial(Point { width, ..found.point }));
    let best = tried.collect::<Result<Vec<_>, _>>()?.into_iter().min_by(order);
    let pays = |trial: &Trial| {
        let [is, was] = [trial.settled.sum, found.settled.sum].map(|sum| (aim.met(sum), aim.left(sum)));
        is.0 == was.0 && is.1 < FINER_GAINS * was.1
    };
    let Some(best) = best.filter(pays) else { return Ok(None) };
    let again = overview.find(best.point, ANEW)?;
    overview.aim = asked;
    if aim != asked {
        let point = Point { error: again.point.error, ..best.point };
        let Aim::Error(most) = asked else { return Ok(None) };
        return of_error(overview, point, Widths::Near, most);
    }
    Ok([best, again].into_iter().min_by(order))
}

/// What trials need.
fn overview<'a, 'w>(work: &'a Work<'w>, sample: &'a Sample, means: &'a [Vec<Plane>]) -> Overview<'a, 'w> {
    let unit = work.unit().powi(2);
    let aim = match work.aim() {
        Aim::Error(error) => Aim::Error(error / unit),
        bits @ Aim::Bits(_) => bits,
    };
    let mut trainer = Trainer::new(sample, work.training(true));
    trainer.copies = work.tables();
    trainer.most_bits = aim.most_bits();
    let blocks = work.blocks() / work.tables();
    Overview { work, trainer, means, aim, by_aim: blocks <= SOME }
}

/// The trial that meets the aim best.
fn search(overview: &mut Overview<'_, '_>) -> Result<Trial, EncodeError> {
    let (work, aim) = (overview.work, overview.aim);
    let blocks = work.blocks() / work.tables();
    let error = match work.options.target {
        Target::Psnr(psnr) => (work.error_of(psnr) / work.samples()).sqrt() / work.unit(),
        _ => 0.0126 * work.span / work.unit(),
    };
    let error = error.max(LEAST_ERROR);
    let first = ((blocks / 2000.0).max(1.0).log2().round() as u32).clamp(3, 6);
    let given = work.options.index_bits;
    if overview.by_aim {
        let (begin, widths) = if given > 0 { (given, Widths::Given) } else { (first + 2, Widths::All) };
        let begin = Point { width: begin, error };
        let found = match aim {
            Aim::Bits(_) => Some(best_width(overview, begin, widths)?),
            Aim::Error(most) => of_error(overview, begin, widths, most)?,
        };
        if let Some(trial) = found {
            return Ok(trial);
        }
        overview.aim = aim;
        overview.by_aim = false;
    }
    if given > 0 {
        return overview.find(Point { width: given, error }, TRIALS);
    }
    let widest = widest(overview);
    let first = first.min(widest);
    let begun = overview.find(Point { width: first, error }, TRIALS)?;
    let mut trials = vec![begun.clone()];
    let few = blocks <= FEW;
    let step = if blocks > SOME { 2 } else { 1 };
    for width in (first + step..=widest).step_by(step as usize).chain(first.checked_sub(1).filter(|w| *w > 0))
    {
        let point = Point { width, ..begun.point };
        trials.push(if few { overview.find(point, TRIALS)? } else { overview.trial(point)? });
    }
    let best = widest_of(overview.good(trials)).unwrap_or(begun);
    let anew = !few && best.point.width.abs_diff(first) > 1;
    if anew { overview.find(best.point, TRIALS) } else { Ok(best) }
}

/// Of trials about as good as each other the widest: fewer codes are fewer fetches.
fn widest_of(good: Vec<Trial>) -> Option<Trial> {
    good.into_iter().max_by_key(|t| t.point.width)
}

/// The greatest width that there are blocks for, and bits for a codebook; the widest take too long on many blocks, and do not
/// pay there.
fn widest(overview: &Overview<'_, '_>) -> u32 {
    let blocks = overview.work.blocks() / overview.work.tables();
    let payable = (overview.aim.most_bits() / overview.trainer.codeword_bits()).max(2.0).log2();
    // Codebooks of the greatest width may have little more than half as many codewords.
    let payable = if overview.by_aim { payable.ceil() } else { payable } as u32;
    let most = if blocks > MANY { 8 } else { 12 };
    ((blocks / 4.0).max(8.0).log2() as u32).min(most).min(payable)
}

/// Which widths are tried.
#[derive(Copy, Clone, PartialEq)]
enum Widths {
    All,
    /// One, and those beside it.
    Near,
    /// One.
    Given,
}

/// The best trial under an aim of bits, where codebooks are few and one more does not fit as often as not, so that each
/// width has a price of its own: every second width, each from the price that suited the one before it, then those beside the
/// best.
fn best_width(overview: &Overview<'_, '_>, begin: Point, widths: Widths) -> Result<Trial, EncodeError> {
    let order = |a: &Trial, b: &Trial| overview.aim.order(a.settled.sum, b.settled.sum);
    let mut trials: Vec<(u32, Trial)> = Vec::new();
    let at = |width: u32, error: f64, trials: &mut Vec<(u32, Trial)>| -> Result<f64, EncodeError> {
        let trial = overview.find(Point { width, error }, ANEW)?;
        let error = trial.point.error;
        trials.push((width, trial));
        Ok(error)
    };
    if widths == Widths::Given {
        return overview.find(begin, TRIALS);
    }
    let best_of = |trials: &[(u32, Trial)]| {
        let best = trials.iter().min_by(|a, b| order(&a.1, &b.1));
        best.map_or((begin.width, begin.error), |b| (b.0, b.1.point.error))
    };
    let widest = widest(overview);
    let first = begin.width.min(widest);
    let mut error = at(first, begin.error, &mut trials)?;
    if widths == Widths::All {
        for width in (first + 2..=widest).step_by(2) {
            error = at(width, error, &mut trials)?;
        }
        // Narrower ones as long as they are better.
        let mut width = first;
        while width > 2 && best_of(&trials).0 == width {
            width -= 2;
            at(width, best_of(&trials).1, &mut trials)?;
        }
    }
    let (best, error) = best_of(&trials);
    for width in [best - 1, best + 1].into_iter().filter(|w| (1..=widest).contains(w)) {
        at(width, error, &mut trials)?;
    }
    let trials = trials.into_iter().map(|t| t.1).collect();
    widest_of(overview.good(trials)).ok_or(EncodeError::Unsupported("no trial".to_owned()))
}

/// The best trial of about the fewest bits that leave no more than so much error, if any does that was tried.
fn of_error(
    overview: &mut Overview<'_, '_>,
    mut begin: Point,
    mut widths: Widths,
    most: f64,
) -> Result<Option<Trial>, EncodeError> {
    let work = overview.work;
    let mut bits = fixed_bits(work, 3, 0.0) + work.default_bits().iter().sum::<f64>();
    // Logarithms of bits, and of the error over what is allowed: of what missed it, of what reached it, and of the last.
    let mut missed: Option<[f64; 2]> = None;
    let mut reached: Option<([f64; 2], Trial)> = None;
    let mut last: Option<[f64; 2]> = None;
    let mut slope = SLOPE;
    for _ in 0..BUDGETS {
        overview.aim = Aim::Bits(bits);
        let trial = best_width(overview, begin, widths)?;
        begin = Point { width: trial.point.width.max(1), error: trial.point.error };
        if widths == Widths::All {
            widths = Widths::Near;
        }
        let over = (trial.settled.sum.error.max(1e-9) / most.max(1e-9)).ln().clamp(-4.0, 4.0);
        let now = [bits.ln(), over];
        if let Some(last) = last.filter(|l| l[1] != over) {
            slope = ((last[0] - now[0]) / (now[1] - last[1])).clamp(0.1, 1.0);
        }
        last = Some(now);
        if over > 0.0 {
            missed = Some(now);
        } else {
            reached = Some((now, trial));
        }
        bits = match (&missed, &reached) {
            (_, Some((b, _))) if b[1] > -CLOSE => break,
            (Some(a), Some((b, _))) if (b[0] - a[0]).abs() < CLOSER => break,
            // A little to the side that reaches it.
            (Some(a), Some((b, _))) => {
                let part = (a[1] + 0.5 * CLOSE) / (a[1] - b[1]);
                a[0] + (b[0] - a[0]) * part.clamp(0.2, 0.8)
            }
            (Some(a), None) => a[0] + (slope * (a[1] + 0.5 * CLOSE)).clamp(0.05, 0.7),
            (None, Some((b, _))) => b[0] + (slope * (b[1] + 0.5 * CLOSE)).clamp(-0.7, -0.05),
            (None, None) => break,
        }
        .exp();
    }
    Ok(reached.map(|r| r.1))
}
