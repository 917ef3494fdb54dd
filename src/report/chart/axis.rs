//! Range and ticks of an axis.

use std::sync::Arc;

use kuva::TickFormat;

/// How values map to places.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios; values at or below zero cannot be drawn.
    Log,
}

/// What an axis shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The record's field.
    pub field: &'static str,
    /// Quantity, unit, and which direction is better.
    pub label: String,
    /// Scale.
    pub scale: Scale,
    /// Values that must lie in the range.
    pub include: Vec<f64>,
    /// On a linear axis: a name for `+∞`, which then has the tick above the highest finite one.
    pub infinity: Option<&'static str>,
    /// The highest value that the quantity can take; a range that would end above it ends here.
    pub limit: Option<f64>,
}

impl Axis {
    /// An axis of nothing but its field, label and scale.
    #[must_use]
    pub fn new(field: &'static str, label: impl Into<String>, scale: Scale) -> Self {
        Self { field, label: label.into(), scale, include: Vec::new(), infinity: None, limit: None }
    }

    /// Whether a value has a place on this axis.
    #[must_use]
    pub fn shows(&self, value: f64) -> bool {
        let positive = self.scale == Scale::Linear || value > 0.0;
        value.is_finite() && positive || value == f64::INFINITY && self.infinity.is_some()
    }
}

/// An axis with its range settled.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Distance of ticks; `None` on a logarithmic axis, whose ticks are kuva's.
    pub(super) step: Option<f64>,
    /// Place and label of infinity.
    infinity: Option<(f64, &'static str)>,
}

impl Range {
    /// The range that holds all of `values` that [`Axis::shows`].
    pub(super) fn of(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let shown: Vec<f64> = values.filter(|v| axis.shows(*v)).chain(axis.include.iter().copied()).collect();
        let finite = || shown.iter().copied().filter(|v| v.is_finite());
        let (low, high) =
            (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 1.0) };
        match axis.scale {
            Scale::Log => Self::log(low, high),
            Scale::Linear => {
                let infinity = axis.infinity.filter(|_| shown.contains(&f64::INFINITY));
                Self::linear(low, high, axis.limit, infinity)
            }
        }
    }

    /// At least a factor of 5 wide, so that two ticks of 1–2–5 lie inside.
    fn log(low: f64, high: f64) -> Self {
        let widen = (5.0 / (high / low)).max(1.0).sqrt() * 1.12;
        Self { low: low / widen, high: high * widen, step: None, infinity: None }
    }

    fn linear(low: f64, high: f64, limit: Option<f64>, infinity: Option<&'static str>) -> Self {
        // Without an extent, a tenth of the value is used: ticks stay readable at any magnitude.
        let span = if high > low { high - low } else { (high.abs() * 0.1).max(1e-6) };
        let step = nice_step(span / 5.0);
        let (mut from, mut to) = ((low / step).floor() * step, (high / step).ceil() * step);
        // Marks need room: none sits in a corner of the frame.
        if low - from < 0.15 * step && from != 0.0 {
            from -= step;
        }
        if to - high < 0.15 * step {
            to += step;
        }
        if let Some(limit) = limit.filter(|l| to > *l) {
            to = limit;
        }
        match infinity {
            Some(name) => {
                let top = ((to / step).round() + 1.0) * step;
                Self { low: from, high: top, step: Some(step), infinity: Some((top, name)) }
            }
            None => Self { low: from, high: to, step: Some(step), infinity: None },
        }
    }

    /// The value at whose place `value` is drawn.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.infinity {
            Some((top, _)) if value == f64::INFINITY => top,
            _ => value,
        }
    }

    /// How kuva is to write ticks.
    pub(super) fn format(&self) -> TickFormat {
        let Self { step, infinity, .. } = self.clone();
        TickFormat::Custom(Arc::new(move |v| match (infinity, step) {
            (Some((top, name)), Some(step)) if v > top - 0.5 * step => name.to_owned(),
            (_, Some(step)) => {
                let decimals = (-step.log10().floor()).max(0.0) as usize;
                // 2.5 needs a digit more than 2 or 5.
                let exact = (step * 10f64.powi(decimals as i32)).fract().abs() < 1e-6;
                let v = if v.abs() < step * 1e-6 { 0.0 } else { v };
                format!("{v:.*}", decimals + usize::from(!exact))
            }
            // Longer numbers would reach into the axis' label.
            (_, None) if !(0.000_999..=999_999.0).contains(&v) => format!("{v:.0e}"),
            (_, None) => {
                let decimals = (-v.log10().floor()).clamp(0.0, 12.0) as usize;
                format!("{v:.decimals$}")
            }
        }))
    }
}

/// The smallest of 1, 2, 2.5, 5, 10 × 10ⁿ that is not below `raw`.
fn nice_step(raw: f64) -> f64 {
    let magnitude = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 2.5, 5.0].into_iter().map(|m| m * magnitude).find(|s| *s >= raw).unwrap_or(10.0 * magnitude)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(axis: &Axis, values: &[f64]) -> Range {
        Range::of(axis, values.iter().copied())
    }

    #[test]
    fn infinity_has_a_tick_of_its_own_above_all_finite_ones() {
        let axis = Axis { infinity: Some("lossless"), ..Axis::new("field", "PSNR", Scale::Linear) };
        let with = range(&axis, &[31.0, 48.0, f64::INFINITY]);
        assert_eq!(with.place(f64::INFINITY), with.high);
        assert!(with.high >= 48.0 + with.step.unwrap());
        assert_eq!(with.format().format(with.high), "lossless");
        assert_eq!(with.format().format(45.0), "45");
        let without = range(&axis, &[31.0, 48.0]);
        assert!(without.format().format(without.high).parse::<f64>().is_ok());
    }

    #[test]
    fn nothing_one_value_and_hostile_values_have_a_range_too() {
        for scale in [Scale::Linear, Scale::Log] {
            for values in [&[][..], &[3.0], &[0.0], &[f64::NAN, f64::INFINITY], &[-1.0, 0.0, 2.0]] {
                let r = range(&Axis::new("field", "x", scale), values);
                assert!(r.low.is_finite() && r.high.is_finite() && r.low < r.high, "{values:?} {r:?}");
            }
        }
    }

    #[test]
    fn ticks_say_what_they_mean() {
        let axis = Axis::new("field", "x", Scale::Log);
        assert_eq!(range(&axis, &[1.0]).format().format(0.5), "0.5");
        assert_eq!(range(&axis, &[1.0]).format().format(20.0), "20");
        assert_eq!(range(&axis, &[1.0]).format().format(0.001), "0.001");
        assert_eq!(range(&axis, &[1.0]).format().format(0.0002), "2e-4");
        assert!(range(&axis, &[1.0]).high / range(&axis, &[1.0]).low >= 5.0);
        let ssim =
            range(&Axis { limit: Some(1.0), ..Axis::new("field", "SSIM", Scale::Linear) }, &[0.91, 0.9999]);
        assert_eq!(ssim.high, 1.0);
        assert_eq!(ssim.format().format(0.92), "0.92");
    }
}
