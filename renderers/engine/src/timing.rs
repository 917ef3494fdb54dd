//! The paired timing protocol: a cell and the baseline are timed alternately, ABAB…
//!
//! Machines change speed during a measurement. The ratio of two neighbouring times is not affected. The protocol needs
//! only two closures that draw one picture each, for devices and CPU mirrors alike.

/// The time of one picture.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FrameTime {
    /// Wall clock around encode, submit and wait, in milliseconds; positive.
    pub wall_ms: f64,
    /// Milliseconds by the device's own clock, if it has one that agrees with the wall clock.
    pub gpu_ms: Option<f64>,
    /// CPU time of the whole process for the picture, in milliseconds, if the system reports it.
    pub cpu_ms: Option<f64>,
}

/// The clock behind a figure.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The device's timestamps around its passes.
    Timestamp,
    /// Wall clock around encode, submit and wait.
    Wall,
}

impl Clock {
    /// Name used in records: `timestamp` or `wall`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Timestamp => "timestamp",
            Self::Wall => "wall",
        }
    }
}

/// How long to measure.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PairBudget {
    /// Least number of pairs, regardless of their time. At least 1 is drawn.
    pub min_pairs: usize,
    /// Pairs after which to stop.
    pub max_pairs: usize,
    /// Seconds of drawing (warm-up included) after which no pair beyond `min_pairs` begins.
    pub max_seconds: f64,
}

impl Default for PairBudget {
    /// 7 to 31 pairs, more than 7 within 4 seconds.
    fn default() -> Self {
        Self { min_pairs: 7, max_pairs: 31, max_seconds: 4.0 }
    }
}

/// Result of a pairing. Ranges are interquartile.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PairedTiming {
    /// Median frame time of the cell, in milliseconds of `clock`.
    pub frame_ms: f64,
    /// Its range.
    pub frame_ms_iqr: f64,
    /// Median CPU time of the process per picture of the cell, in milliseconds, if every picture has one.
    pub frame_cpu_ms: Option<f64>,
    /// Median frame time of the baseline, in milliseconds of `clock`.
    pub baseline_ms: f64,
    /// The clock of both sides and all pairs.
    pub clock: Clock,
    /// Median over the pairs of cell / baseline.
    pub relative: f64,
    /// Its range.
    pub relative_iqr: f64,
    /// Pairs that these figures come from.
    pub pairs: usize,
}

/// Rounds of warm-up, if the first ones do not take longer than [`WARM_UP_MS`].
const WARM_UP_ROUNDS: usize = 3;
/// Milliseconds of drawing after which a device counts as warm. The first round is always drawn, because drivers
/// compile in it.
const WARM_UP_MS: f64 = 200.0;
/// Shortest time to divide by: one tick of a nanosecond clock.
const TICK_MS: f64 = 1e-6;

/// Times `cell` against `baseline`: warm-up, then baseline and cell in turn.
///
/// # Errors
/// The first error of either closure; nothing is reported of a pairing that is not whole.
pub fn paired<E>(
    mut baseline: impl FnMut() -> Result<FrameTime, E>,
    mut cell: impl FnMut() -> Result<FrameTime, E>,
    budget: PairBudget,
) -> Result<PairedTiming, E> {
    let mut spent_ms = 0.0;
    let mut round = |spent_ms: &mut f64| -> Result<[FrameTime; 2], E> {
        let times = [baseline()?, cell()?];
        *spent_ms += times[0].wall_ms + times[1].wall_ms;
        Ok(times)
    };
    for _ in 0..WARM_UP_ROUNDS {
        round(&mut spent_ms)?;
        if spent_ms >= WARM_UP_MS {
            break;
        }
    }
    let mut pairs = Vec::new();
    let min_pairs = budget.min_pairs.max(1);
    while pairs.len() < min_pairs || pairs.len() < budget.max_pairs && spent_ms < budget.max_seconds * 1000.0
    {
        pairs.push(round(&mut spent_ms)?);
    }
    Ok(summarise(&pairs, min_pairs))
}

/// Times work that is done once per volume: one warm-up run, then the median of `runs` (at least 1), in milliseconds.
/// Timestamps are used if every run has one, else the wall clock.
///
/// # Errors
/// The first error of `run`.
pub fn repeated<E>(mut run: impl FnMut() -> Result<FrameTime, E>, runs: usize) -> Result<(f64, Clock), E> {
    run()?;
    let times = (0..runs.max(1)).map(|_| run()).collect::<Result<Vec<_>, E>>()?;
    let stamped: Option<Vec<f64>> = times.iter().map(|time| time.gpu_ms).collect();
    Ok(match stamped {
        Some(stamped) => (Spread::of(stamped).median, Clock::Timestamp),
        None => (Spread::of(times.iter().map(|time| time.wall_ms)).median, Clock::Wall),
    })
}

/// Medians and ranges of at least one pair, by one clock.
///
/// If a late wake-up of this process makes a timestamp doubtful, its pair is left out, so that a few such pairs do not
/// switch a cell to another clock than its neighbours'. Only if fewer than `min_pairs`, or less than half of all,
/// remain, the wall clock times every pair.
fn summarise(pairs: &[[FrameTime; 2]], min_pairs: usize) -> PairedTiming {
    let stamped: Vec<_> =
        pairs.iter().copied().filter(|pair| pair.iter().all(|time| time.gpu_ms.is_some())).collect();
    let timestamps = stamped.len() >= min_pairs.min(pairs.len()) && 2 * stamped.len() >= pairs.len();
    let (clock, pairs) =
        if timestamps { (Clock::Timestamp, stamped.as_slice()) } else { (Clock::Wall, pairs) };
    let ms = |time: &FrameTime| match clock {
        Clock::Timestamp => time.gpu_ms.unwrap_or(time.wall_ms),
        Clock::Wall => time.wall_ms,
    };
    let frames = Spread::of(pairs.iter().map(|pair| ms(&pair[1])));
    let ratios = Spread::of(pairs.iter().map(|pair| ms(&pair[1]) / ms(&pair[0]).max(TICK_MS)));
    let cpu: Option<Vec<f64>> = pairs.iter().map(|pair| pair[1].cpu_ms).collect();
    PairedTiming {
        frame_ms: frames.median,
        frame_ms_iqr: frames.iqr,
        frame_cpu_ms: cpu.map(|cpu| Spread::of(cpu).median),
        baseline_ms: Spread::of(pairs.iter().map(|pair| ms(&pair[0]))).median,
        clock,
        relative: ratios.median,
        relative_iqr: ratios.iqr,
        pairs: pairs.len(),
    }
}

/// Median and interquartile range.
struct Spread {
    median: f64,
    iqr: f64,
}

impl Spread {
    /// The quartiles of at least one value.
    fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        // Quantiles between the two nearest order statistics.
        let quantile = |q: f64| {
            let at = q * (values.len() - 1) as f64;
            let (low, high) = (values[at.floor() as usize], values[at.ceil() as usize]);
            low + (high - low) * at.fract()
        };
        Self { median: quantile(0.5), iqr: quantile(0.75) - quantile(0.25) }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::convert::Infallible;

    use super::*;

    fn frame(wall_ms: f64, gpu_ms: Option<f64>) -> FrameTime {
        FrameTime { wall_ms, gpu_ms, cpu_ms: Some(2.0 * wall_ms) }
    }

    /// Draws repeatedly: `times[i]` for picture `i`, then the last one for ever.
    fn replay(times: &[FrameTime]) -> impl FnMut() -> Result<FrameTime, Infallible> {
        let mut i = 0;
        move || {
            i += 1;
            Ok(times[(i - 1).min(times.len() - 1)])
        }
    }

    #[test]
    fn frames_alternate_and_the_first_ones_do_not_count() {
        let order = RefCell::new(String::new());
        let side = |name, warm, cold| {
            let order = &order;
            move || {
                let first = !order.borrow().contains(name);
                order.borrow_mut().push(name);
                Ok::<_, Infallible>(frame(if first { cold } else { warm }, None))
            }
        };
        let budget = PairBudget { min_pairs: 7, max_pairs: 7, max_seconds: 100.0 };
        let timing = paired(side('A', 10.0, 500.0), side('B', 30.0, 900.0), budget).unwrap();
        assert_eq!(*order.borrow(), "AB".repeat(8));
        assert_eq!(timing.pairs, 7);
        assert_eq!((timing.baseline_ms, timing.frame_ms, timing.relative), (10.0, 30.0, 3.0));
        assert_eq!((timing.frame_ms_iqr, timing.relative_iqr), (0.0, 0.0));
        assert_eq!(timing.frame_cpu_ms, Some(60.0));
        assert_eq!(timing.clock, Clock::Wall);
    }

    #[test]
    fn the_budget_buys_pairs_between_the_least_and_the_most() {
        let pairs = |ms: f64, max_seconds| {
            let budget = PairBudget { min_pairs: 7, max_pairs: 15, max_seconds };
            paired(replay(&[frame(ms, None)]), replay(&[frame(ms, None)]), budget).unwrap().pairs
        };
        assert_eq!(pairs(1.0, 20.0), 15);
        assert_eq!(pairs(5000.0, 20.0), 7);
        // 1 s per round; one round of warm-up.
        assert_eq!(pairs(500.0, 11.0), 10);
        assert_eq!(pairs(1.0, 0.0), 7);
    }

    #[test]
    fn a_pair_without_timestamps_is_left_out_while_enough_remain() {
        let budget = PairBudget { min_pairs: 3, max_pairs: 8, ..PairBudget::default() };
        let exact = [frame(10.0, Some(4.0))];
        let mut gap = [frame(11.0, Some(8.0)); 11];
        (gap[5].gpu_ms, gap[6].gpu_ms) = (None, None);
        let timing = paired(replay(&exact), replay(&gap), budget).unwrap();
        assert_eq!((timing.clock, timing.relative, timing.pairs), (Clock::Timestamp, 2.0, 6));
        // More than half are doubtful: none is believed.
        gap[5..10].iter_mut().for_each(|f| f.gpu_ms = None);
        let timing = paired(replay(&exact), replay(&gap), budget).unwrap();
        assert_eq!((timing.clock, timing.pairs), (Clock::Wall, 8));
    }

    #[test]
    fn timestamps_count_only_if_as_many_pairs_have_them_as_must_be_drawn() {
        let budget = PairBudget { max_pairs: 7, ..PairBudget::default() };
        let exact = [frame(10.0, Some(4.0))];
        let cell = [frame(11.0, Some(8.0))];
        let timing = paired(replay(&exact), replay(&cell), budget).unwrap();
        assert_eq!((timing.clock, timing.relative, timing.frame_ms), (Clock::Timestamp, 2.0, 8.0));
        // The 6th picture, the third that counts, has no timestamp.
        let mut gap = [frame(11.0, Some(8.0)); 7];
        gap[5].gpu_ms = None;
        let timing = paired(replay(&exact), replay(&gap), budget).unwrap();
        assert_eq!((timing.clock, timing.frame_ms), (Clock::Wall, 11.0));
        assert!((timing.relative - 1.1).abs() < 1e-12);
    }

    #[test]
    fn the_ratio_is_taken_pair_by_pair() {
        // The machine halves its speed in the middle: the ratio stays.
        let slow: Vec<_> = (0..20).map(|i| frame(if i < 6 { 10.0 } else { 20.0 }, None)).collect();
        let slow2: Vec<_> = slow.iter().map(|f| frame(f.wall_ms * 1.5, None)).collect();
        let budget = PairBudget { max_pairs: 7, ..PairBudget::default() };
        let timing = paired(replay(&slow), replay(&slow2), budget).unwrap();
        assert!((timing.relative - 1.5).abs() < 1e-12 && timing.relative_iqr < 1e-12);
        assert!(timing.frame_ms_iqr > 0.0);
    }

    #[test]
    fn an_error_ends_the_pairing() {
        let mut left = 5;
        let failing = || {
            left -= 1;
            if left == 0 { Err("gone") } else { Ok(frame(1.0, None)) }
        };
        assert_eq!(paired(|| Ok(frame(1.0, None)), failing, PairBudget::default()), Err("gone"));
    }

    #[test]
    fn repeated_runs_have_one_clock_and_leave_the_first_one_out() {
        let exact =
            [frame(500.0, None), frame(9.0, Some(5.0)), frame(11.0, Some(7.0)), frame(8.0, Some(6.0))];
        assert_eq!(repeated(replay(&exact), 3), Ok((6.0, Clock::Timestamp)));
        let mut doubtful = exact;
        doubtful[2].gpu_ms = None;
        assert_eq!(repeated(replay(&doubtful), 3), Ok((9.0, Clock::Wall)));
        assert_eq!(repeated(|| Err("gone"), 3), Err("gone"));
    }

    #[test]
    fn quantiles_lie_between_order_statistics() {
        let spread = Spread::of([4.0, 1.0, 3.0, 2.0]);
        assert_eq!((spread.median, spread.iqr), (2.5, 1.5));
        let one = Spread::of([7.0]);
        assert_eq!((one.median, one.iqr), (7.0, 0.0));
    }
}
