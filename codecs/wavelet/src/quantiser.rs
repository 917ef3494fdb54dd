//! Steps of the bands: those of one step for the whole volume, and those of the paper.

use cvr_core::volume::ValueRange;
use serde::{Deserialize, Serialize};

use crate::stream::pyramid::{Band, Pyramid};
use crate::transform::{Filter, gain};

/// How the paper's largest number of steps follows from the quality `q`.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// 127 + 128 q / 255.
    Paper,
    /// 127 + 128 q, as the paper prints it.
    Printed,
}

/// How a quantised coefficient of a band becomes a coefficient: `offset + step · q`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Rule {
    /// In data units times the gain of the band.
    pub offset: f64,
    /// The same.
    pub step: f64,
}

/// Half the width of the dead zone in steps where no coder weighs error against bits: a little wider than rounding.
pub const DEAD_ZONE: f64 = 0.6;

/// The reversible filter's steps are multiples of one over this, so that a device and a CPU compute the same integers.
pub const INTEGER_STEPS: i32 = 256;

/// A coefficient of the reversible filter, rounded, halves upwards. `step` is in units of 1 / [`INTEGER_STEPS`].
#[inline]
#[must_use]
pub const fn integer(q: i32, step: i32) -> i32 {
    q.wrapping_mul(step).wrapping_add(INTEGER_STEPS / 2) >> INTEGER_STEPS.trailing_zeros()
}

/// A product over the axes of a band, whose coefficients stem from so many decompositions.
fn product(pyramid: &Pyramid, band: &Band, of: impl Fn(usize, usize, bool) -> f64) -> f64 {
    let decompositions = pyramid.levels() - band.level;
    let extent = pyramid.extent(0);
    [0, 1, 2].iter().map(|axis| of(extent[*axis], decompositions, band.high[*axis])).product()
}

/// Rules under which the same error of any coefficient adds the same squared error to the samples: a band's step is
/// `step` over the norm of what one of its coefficients becomes. LLL is counted from the lowest sample, `least`, except
/// for the reversible filter.
#[must_use]
pub fn rules(filter: Filter, pyramid: &Pyramid, step: f32, least: f32) -> Vec<Rule> {
    let norm = |band: &Band| product(pyramid, band, |n, d, high| gain::of_band(filter, n, d, high).synthesis);
    let own = |band: &Band| {
        let exact = f64::from(step) / norm(band);
        let unit = f64::from(INTEGER_STEPS);
        let step = if filter.is_integer() { (exact * unit).round().clamp(unit, 1e9) / unit } else { exact };
        let is_offset = band.kind() == 0 && !filter.is_integer();
        let gain = || product(pyramid, band, |n, d, _| gain::low(filter, n, d));
        Rule { offset: if is_offset { f64::from(least) * gain() } else { 0.0 }, step }
    };
    pyramid.bands().iter().map(own).collect()
}

/// The factors of the paper's Table 1, by level from the coarsest: those of LLH-, LHH- and HHH-bands, and that of their
/// dead zone.
const TABLE: [[f64; 4]; 5] = [
    [0.80, 0.60, 0.50, 0.33],
    [0.80, 0.60, 0.50, 0.60],
    [0.60, 0.40, 0.30, 0.60],
    [0.30, 0.20, 0.15, 0.60],
    [0.13, 0.08, 0.06, 1.00],
];

/// The dead zone of LLL (section 2.2).
const LLL_DEAD: f64 = 4.0 / 15.0;

/// The paper's rules (section 2.2 and Table 1), and the width of each band's dead zone in steps. Coefficients are
/// normalised to ±1 by the most that samples within `range` can make them, and LLL to 0 … 1. The finest level always has
/// the last row of the table; levels coarser than the fifth have the first.
#[must_use]
pub fn paper(
    filter: Filter,
    pyramid: &Pyramid,
    (quality, scale): (u8, Scale),
    range: ValueRange,
) -> Vec<(Rule, f64)> {
    let (min, span) = (f64::from(range.min), f64::from(range.max) - f64::from(range.min));
    // A constant volume has no span. All of it is the offset.
    let span = if span > 0.0 { span } else { 1.0 };
    let q = f64::from(quality);
    let most_dead = 20.0 * (255.0 - q) / 255.0;
    let steps = match scale {
        Scale::Paper => 127.0 + 128.0 * q / 255.0,
        Scale::Printed => 127.0 + 128.0 * q,
    };
    let own = |band: &Band| {
        let kind = band.kind();
        if kind == 0 {
            let gain = product(pyramid, band, |n, d, _| gain::low(filter, n, d));
            return (Rule { offset: min * gain, step: span * gain / steps }, 1.0 + LLL_DEAD * most_dead);
        }
        let row = TABLE[(band.level + 5).saturating_sub(pyramid.levels()).min(4)];
        // The sum of the weights of a high band is 0, so its largest value comes from samples at both ends of the range.
        let largest = 0.5 * product(pyramid, band, |n, d, high| gain::of_band(filter, n, d, high).analysis);
        (Rule { offset: 0.0, step: span * largest / (row[kind - 1] * steps) }, 1.0 + row[3] * most_dead)
    };
    pyramid.bands().iter().map(own).collect()
}

/// The quantised coefficient. `dead` is half the width of the dead zone in steps.
#[inline]
#[must_use]
pub fn quantised(coefficient: f32, rule: Rule, dead: f64) -> i32 {
    let exact = (f64::from(coefficient) - rule.offset) / rule.step;
    let limit = f64::from(1 << 30);
    if exact.abs() < dead { 0 } else { exact.round().clamp(-limit, limit) as i32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGE: ValueRange = ValueRange { min: -3.0, max: 7.0 };

    #[test]
    fn the_papers_steps_are_those_of_its_formulas() {
        let pyramid = Pyramid::new([64, 64, 64], 5, true);
        let rules = paper(Filter::Haar, &pyramid, (255, Scale::Paper), RANGE);
        // LLL of Haar is a mean.
        assert_eq!(rules[0], (Rule { offset: -3.0, step: 10.0 / 255.0 }, 1.0));
        // A difference of two samples along x, of means along y and z: at most the range.
        let finest = &pyramid.level(4)[0];
        let (rule, dead) = rules[pyramid.number(finest)];
        assert!((rule.step - 10.0 / (0.13 * 255.0)).abs() < 1e-12 && dead == 1.0);
        let at = |quality, scale| paper(Filter::Haar, &pyramid, (quality, scale), RANGE)[0];
        assert_eq!(at(0, Scale::Paper), (Rule { offset: -3.0, step: 10.0 / 127.0 }, 1.0 + 20.0 * 4.0 / 15.0));
        assert_eq!(at(255, Scale::Printed).0.step, 10.0 / (127.0 + 128.0 * 255.0));
    }

    #[test]
    fn the_finest_level_has_the_last_row() {
        let dead = |levels| {
            let pyramid = Pyramid::new([64, 64, 64], levels, false);
            let rules = paper(Filter::Cdf26, &pyramid, (0, Scale::Paper), RANGE);
            (0..levels).map(|level| rules[1 + 7 * level].1.round()).collect::<Vec<_>>()
        };
        assert_eq!(dead(2), [13.0, 21.0]);
        assert_eq!(dead(6), [8.0, 8.0, 13.0, 13.0, 13.0, 21.0]);
    }

    #[test]
    fn integers_are_rounded_and_a_step_of_one_is_exact() {
        assert_eq!([-3, 0, 5].map(|q| integer(q, INTEGER_STEPS)), [-3, 0, 5]);
        assert_eq!([1, -1, 3].map(|q| integer(q, 384)), [2, -1, 5]);
        let pyramid = Pyramid::new([16, 16, 16], 2, false);
        assert!(rules(Filter::FiveThree, &pyramid, 0.1, -7.0).iter().all(|rule| rule.step == 1.0));
    }

    #[test]
    fn the_dead_zone_is_zero() {
        let rule = Rule { offset: 1.0, step: 2.0 };
        assert_eq!([1.9, 2.2, 3.0, -2.9, 5.1].map(|c| quantised(c, rule, 0.55)), [0, 1, 1, -2, 2]);
    }
}
