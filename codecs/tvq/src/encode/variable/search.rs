//! The search before all blocks are coded. Trials on few blocks give the width of codes, and the error at which a code
//! pays.

use cvr_core::codec::EncodeError;

use super::cost::{aim, default_bits, fixed_bits};
use super::point::Point;
use super::trials::{Overview, Trial};
use crate::encode::closed_loop::Plane;
use crate::encode::sample::Sample;
use crate::encode::train::trainer::Trainer;
use crate::encode::tuned::codebooks::FIRST_ERROR;
use crate::encode::tuned::trials::{
    ANEW, BLOCKS, BUDGETS, CLOSE, CLOSER, FEW, FINER_GAINS, FIRST_BLOCKS, FIRST_WIDTHS, LEAST_ERROR, MANY,
    OF_WIDTH, PARTS, SLOPE, SLOPES, SOME, STEPS, WIDEST,
};
use crate::encode::work::{COARSE, Work};
use crate::settings::Target;
use cvr_groups::Aim;
use cvr_groups::Expected;

/// Bits of an entry if coarse entries leave too large an error.
const FINE: u32 = 16;

/// Result of the search.
#[derive(Clone, Debug)]
pub struct Plan {
    pub point: Point,
    /// Codewords of each codebook. Empty if codebooks are added while they pay.
    pub sizes: Vec<usize>,
    /// Bits of an entry.
    pub entry_bits: u32,
}

/// Bits of a code and of an entry, and the error at which a bit pays, so that the target is met.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn plan(work: &Work<'_>, expected: Expected) -> Result<Plan, EncodeError> {
    let domains: Vec<_> = work.domains().cloned().collect();
    let seed = work.options.training.seed;
    let sample = Sample::draw(work.source, &domains, work.quantiser, BLOCKS, seed, work.run)?;
    let coder = work.coder(&[], 0, 0.0);
    let means = domains.iter().map(|domain| coder.code(work.source, domain, work.run));
    let means = means.collect::<Result<Vec<_>, _>>()?;
    let of = |trial: Trial, entry_bits| Plan { point: trial.point, sizes: trial.sizes, entry_bits };
    if let Some(bits) = work.options.entry_bits {
        return Ok(of(search(&mut overview(work, &sample, &means, expected))?, bits));
    }
    let coarse = work.with_entry_bits(COARSE);
    let found = search(&mut overview(&coarse, &sample, &means, expected))?;
    let fine = work.with_entry_bits(FINE);
    let finer = finer(&mut overview(&fine, &sample, &means, expected), &found)?;
    Ok(finer.map_or_else(|| of(found, COARSE), |trial| of(trial, FINE)))
}

/// The best trial with fine entries, if its error is enough below that with coarse entries. Fine entries make codewords
/// more expensive, so the next smaller width is tried as well.
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

/// Whether tables have so few blocks that codebooks are chosen one by one.
fn few_enough(work: &Work<'_>) -> bool {
    work.blocks() / work.tables() <= SOME
}

/// What may be expected of coding blocks of this volume directly, where each expectation is to be followed to its end. Where blocks
/// are few, large codebooks know most of them by heart: those that serve a rate best are then often found as if nothing was coded
/// directly, which only adds to them.
pub fn expectations(work: &Work<'_>) -> Vec<Expected> {
    let expected = Expected::of(work.layout.sample.is_integer().then(|| 1.0 / work.unit()), 1);
    let blocks = work.blocks() / work.tables();
    match aim(work) {
        Aim::Bits(_) if blocks <= FEW => vec![Expected::never()],
        Aim::Bits(_) if blocks <= SOME => vec![Expected::never(), expected],
        _ => vec![expected],
    }
}

/// What trials need.
fn overview<'a, 'w>(
    work: &'a Work<'w>,
    sample: &'a Sample,
    means: &'a [Vec<Plane>],
    expected: Expected,
) -> Overview<'a, 'w> {
    let unit = work.unit().powi(2);
    let aim = match aim(work) {
        Aim::Error(error) => Aim::Error(error / unit),
        bits @ Aim::Bits(_) => bits,
    };
    let mut trainer = Trainer::new(sample, work.training(true));
    trainer.copies = work.tables();
    trainer.most_bits = aim.most_bits();
    Overview { work, trainer, means, expected, aim, by_aim: few_enough(work) }
}

/// The trial that meets the aim best.
fn search(overview: &mut Overview<'_, '_>) -> Result<Trial, EncodeError> {
    let (work, aim) = (overview.work, overview.aim);
    let blocks = work.blocks() / work.tables();
    let error = match work.options.target {
        Target::Psnr(psnr) => (work.error_of(psnr) / work.samples()).sqrt() / work.unit(),
        _ => FIRST_ERROR * work.span / work.unit(),
    };
    let error = error.max(LEAST_ERROR);
    let first =
        ((blocks / FIRST_BLOCKS).max(1.0).log2().round() as u32).clamp(FIRST_WIDTHS[0], FIRST_WIDTHS[1]);
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
        return overview.find(Point { width: given, error }, OF_WIDTH);
    }
    let widest = widest(overview);
    let first = first.min(widest);
    let begun = overview.find(Point { width: first, error }, OF_WIDTH)?;
    let mut trials = vec![begun.clone()];
    let few = blocks <= FEW;
    let step = if blocks > SOME { 2 } else { 1 };
    for width in (first + step..=widest).step_by(step as usize).chain(first.checked_sub(1).filter(|w| *w > 0))
    {
        let point = Point { width, ..begun.point };
        trials.push(if few { overview.find(point, OF_WIDTH)? } else { overview.trial(point)? });
    }
    let best = widest_of(overview.good(trials)).unwrap_or(begun);
    let anew = !few && best.point.width.abs_diff(first) > 1;
    if anew { overview.find(best.point, OF_WIDTH) } else { Ok(best) }
}

/// The widest of trials that are about equally good: fewer codes are fewer fetches.
fn widest_of(good: Vec<Trial>) -> Option<Trial> {
    good.into_iter().max_by_key(|t| t.point.width)
}

/// The greatest width for which there are enough blocks, and bits for a codebook. With many blocks, the widest codes
/// take too long and do not pay.
fn widest(overview: &Overview<'_, '_>) -> u32 {
    let blocks = overview.work.blocks() / overview.work.tables();
    let payable = (overview.aim.most_bits() / overview.trainer.codeword_bits()).max(2.0).log2();
    // Codebooks of the greatest width may have little more than half as many codewords.
    let payable = if overview.by_aim { payable.ceil() } else { payable } as u32;
    let most = WIDEST[usize::from(blocks <= MANY)];
    ((blocks / 4.0).max(8.0).log2() as u32).min(most).min(payable)
}

/// Which widths are tried.
#[derive(Copy, Clone, PartialEq)]
enum Widths {
    All,
    /// One width, and its neighbours.
    Near,
    /// One.
    Given,
}

/// The best trial for an aim of bits with few codebooks. One more codebook often does not fit, so each width has its
/// own price. Every second width is tried, each from the price of the one before it, then the neighbours of the best.
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
        return overview.find(begin, OF_WIDTH);
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
        // Narrower widths while they are better.
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

/// Of the tried points whose error is small enough, the best trial with about the fewest bits.
fn of_error(
    overview: &mut Overview<'_, '_>,
    mut begin: Point,
    mut widths: Widths,
    most: f64,
) -> Result<Option<Trial>, EncodeError> {
    let work = overview.work;
    let mut bits = fixed_bits(work, 3, 0.0) + default_bits(work).iter().sum::<f64>();
    // Logarithms of bits, and of the error over the target: of a point that missed, of one that reached it, and of the
    // last.
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
            slope = ((last[0] - now[0]) / (now[1] - last[1])).clamp(SLOPES[0], SLOPES[1]);
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
                a[0] + (b[0] - a[0]) * part.clamp(PARTS[0], PARTS[1])
            }
            (Some(a), None) => a[0] + (slope * (a[1] + 0.5 * CLOSE)).clamp(STEPS[0], STEPS[1]),
            (None, Some((b, _))) => b[0] + (slope * (b[1] + 0.5 * CLOSE)).clamp(-STEPS[1], -STEPS[0]),
            (None, None) => break,
        }
        .exp();
    }
    Ok(reached.map(|r| r.1))
}
