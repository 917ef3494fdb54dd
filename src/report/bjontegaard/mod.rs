//! Bjøntegaard's differences between two rate–distortion curves: how much better at the same rate, how much smaller at
//! the same quality.
//!
//! G. Bjøntegaard: Calculation of Average PSNR Differences between RD-Curves. ITU-T SG16 VCEG-M33, 2001; with monotone
//! piecewise cubics in place of one polynomial, as JCTVC-B055 (2010) and the common test conditions since have them. The
//! means are over the logarithm of the rate and over decibels.

mod pchip;

pub use pchip::Pchip;

use super::pareto;

/// Points that a curve needs for a difference.
pub const LEAST_POINTS: usize = 4;
/// Share of the narrower of two ranges that both curves must cover.
pub const LEAST_OVERLAP: f64 = 0.5;

/// A rate–distortion curve: what no other point beats, as (log10 of the rate, quality), both strictly rising.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve(Vec<(f64, f64)>);

/// Why two curves have no difference.
#[derive(Copy, Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// A curve has too few points.
    #[error("a curve of {0} points, {LEAST_POINTS} are needed")]
    Few(usize),
    /// The curves overlap too little. The value is the overlap as a fraction of the narrower range; 0 means none.
    #[error("ranges overlap by {:.0} % of the narrower, {:.0} % are needed", 100.0 * .0, 100.0 * LEAST_OVERLAP)]
    Apart(f64),
}

impl Curve {
    /// A curve from points (rate in any unit, quality in dB). Lossless points and NaN are left out.
    #[must_use]
    pub fn of(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let finite = |(rate, quality): &(f64, f64)| *rate > 0.0 && rate.is_finite() && quality.is_finite();
        let points: Vec<(f64, f64)> =
            points.into_iter().filter(finite).map(|(rate, quality)| (rate.log10(), quality)).collect();
        let costs: Vec<(f64, f64)> = points.iter().map(|(rate, quality)| (*rate, -quality)).collect();
        Self(pareto::front(&costs).into_iter().map(|i| points[i]).collect())
    }

    /// How many points it has.
    #[must_use]
    pub const fn points(&self) -> usize {
        self.0.len()
    }

    /// Quality over log10 of the rate; `None` for fewer than two points.
    #[must_use]
    pub fn quality(&self) -> Option<Pchip> {
        Pchip::new(&self.0)
    }

    /// Log10 of the rate over quality.
    fn rate(&self) -> Option<Pchip> {
        Pchip::new(&self.0.iter().map(|(rate, quality)| (*quality, *rate)).collect::<Vec<_>>())
    }
}

/// BD-PSNR: the mean of `test` − `anchor` in decibels over the rates that both have; above 0 `test` is better.
///
/// # Errors
/// When a curve has too few points, or their rates overlap too little.
pub fn decibels(anchor: &Curve, test: &Curve) -> Result<f64, Refused> {
    mean_difference(anchor, test, Curve::quality)
}

/// BD-rate as the mean of log10(rate of `test` ÷ rate of `anchor`) over the qualities that both have; below 0 `test` is
/// smaller. [`percent`] makes it what tables show.
///
/// # Errors
/// When a curve has too few points, or their qualities overlap too little.
pub fn log_rate(anchor: &Curve, test: &Curve) -> Result<f64, Refused> {
    mean_difference(anchor, test, Curve::rate)
}

/// How much larger a rate is, in percent, from the log10 of the ratio.
#[must_use]
pub fn percent(log_rate: f64) -> f64 {
    100.0 * (10f64.powf(log_rate) - 1.0)
}

fn mean_difference(anchor: &Curve, test: &Curve, of: fn(&Curve) -> Option<Pchip>) -> Result<f64, Refused> {
    let points = anchor.points().min(test.points());
    if points < LEAST_POINTS {
        return Err(Refused::Few(points));
    }
    let (Some(a), Some(b)) = (of(anchor), of(test)) else { return Err(Refused::Few(points)) };
    let ([a_low, a_high], [b_low, b_high]) = (a.domain(), b.domain());
    let (low, high) = (a_low.max(b_low), a_high.min(b_high));
    let share = ((high - low) / (a_high - a_low).min(b_high - b_low)).max(0.0);
    if share < LEAST_OVERLAP {
        return Err(Refused::Apart(share));
    }
    Ok((b.integral(low, high) - a.integral(low, high)) / (high - low))
}

#[cfg(test)]
mod tests;
