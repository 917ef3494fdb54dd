//! The transfer function: data value → colour and opacity, piecewise linear.

use serde::{Deserialize, Serialize};

use crate::volume::ValueRange;

/// One point of a transfer function.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlPoint {
    /// Data value.
    pub value: f32,
    /// Straight (not premultiplied) RGBA, `0.0..=1.0`; opacity is that of one voxel length.
    pub rgba: [f32; 4],
}

/// Piecewise linear, constant beyond its ends.
///
/// Shader and mirror read the same table of [`TransferFunction::ENTRIES`] values over the first to the last
/// control point, and interpolate between its entries; a step between two points of one value is as wide as
/// one entry.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
    table: Vec<[f32; 4]>,
    scale: f32,
}

/// Why control points make no transfer function.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TransferFunctionError {
    /// Fewer than two points.
    #[error("a transfer function needs at least two control points, this has {0}")]
    TooFew(usize),
    /// Values decrease or are not finite.
    #[error("control point {0}: its value must be finite and not below the one before")]
    Order(usize),
    /// All points at one value.
    #[error("all control points lie at one value")]
    Flat,
}

impl TransferFunction {
    /// Entries of the table.
    pub const ENTRIES: usize = 1024;

    /// From at least two points of non-decreasing value.
    ///
    /// # Errors
    /// When there are too few points, or their values are out of order or all equal.
    pub fn new(points: Vec<ControlPoint>) -> Result<Self, TransferFunctionError> {
        if points.len() < 2 {
            return Err(TransferFunctionError::TooFew(points.len()));
        }
        for (i, point) in points.iter().enumerate() {
            if !point.value.is_finite() || i > 0 && point.value < points[i - 1].value {
                return Err(TransferFunctionError::Order(i + 1));
            }
        }
        let mut function = Self { points, table: Vec::new(), scale: 0.0 };
        let domain = function.domain();
        if domain.span() <= 0.0 {
            return Err(TransferFunctionError::Flat);
        }
        let entry = |i: usize| {
            let t = i as f64 / (Self::ENTRIES - 1) as f64;
            function.exact((f64::from(domain.min) + t * domain.span()) as f32)
        };
        function.table = (0..Self::ENTRIES).map(entry).collect();
        function.scale = ((Self::ENTRIES - 1) as f64 / domain.span()) as f32;
        Ok(function)
    }

    /// First to last control point.
    #[must_use]
    pub fn domain(&self) -> ValueRange {
        ValueRange { min: self.points[0].value, max: self.points[self.points.len() - 1].value }
    }

    /// The control points.
    #[must_use]
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// The table that shaders bind: [`TransferFunction::ENTRIES`] straight RGBA values.
    #[must_use]
    pub fn table(&self) -> &[[f32; 4]] {
        &self.table
    }

    /// Table position = `(value − domain.min) · scale`.
    #[must_use]
    pub const fn scale(&self) -> f32 {
        self.scale
    }

    /// Colour and opacity of a data value, by the arithmetic of `classify` in the shaders.
    #[must_use]
    pub fn classify(&self, value: f32) -> [f32; 4] {
        let last = (Self::ENTRIES - 1) as f32;
        let at = ((value - self.points[0].value) * self.scale).clamp(0.0, last);
        let low = at.floor().min(last - 1.0);
        let t = at - low;
        let (a, b) = (self.table[low as usize], self.table[low as usize + 1]);
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
    }

    /// Whether no value of `range` shows anything. It errs towards showing: an entry on each side counts along, for what
    /// rounding may do to the position. Beyond the ends of the domain there is but one entry, whatever is rounded.
    #[must_use]
    pub fn is_transparent(&self, range: ValueRange) -> bool {
        const LAST: usize = TransferFunction::ENTRIES - 1;
        // Positions are off by less than this, in entries; which side of the first point a value lies on is exact.
        const ROUNDING: f32 = 0.01;
        let at = |value: f32| (value - self.points[0].value) * self.scale;
        let (low, high) = (at(range.min), at(range.max));
        // A position that is no number says nothing.
        if low.is_nan() || high.is_nan() {
            return false;
        }
        let first = if low >= LAST as f32 + ROUNDING { LAST } else { (low as usize).saturating_sub(1) };
        let end = if high <= 0.0 { 0 } else { (high as usize).saturating_add(2).min(LAST) };
        self.table[first.min(end)..=end].iter().all(|entry| entry[3] <= 0.0)
    }

    /// The piecewise linear function itself.
    fn exact(&self, value: f32) -> [f32; 4] {
        let after = self.points.partition_point(|p| p.value <= value);
        if after == 0 {
            return self.points[0].rgba;
        }
        let (a, b) = (self.points[after - 1], self.points[after.min(self.points.len() - 1)]);
        let width = b.value - a.value;
        let t = if width > 0.0 { (value - a.value) / width } else { 0.0 };
        std::array::from_fn(|c| a.rgba[c] + (b.rgba[c] - a.rgba[c]) * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: f32, alpha: f32) -> ControlPoint {
        ControlPoint { value, rgba: [alpha, 0.0, 1.0, alpha] }
    }

    #[test]
    fn is_piecewise_linear_and_constant_beyond_its_ends() {
        let f = TransferFunction::new(vec![point(10.0, 0.0), point(20.0, 1.0), point(40.0, 0.5)]).unwrap();
        for (value, alpha) in [(-5.0, 0.0), (10.0, 0.0), (15.0, 0.5), (30.0, 0.75), (40.0, 0.5), (99.0, 0.5)]
        {
            let got = f.classify(value)[3];
            assert!((got - alpha).abs() < 2e-3, "{value}: {got} for {alpha}");
        }
    }

    #[test]
    fn what_is_transparent_shows_nothing_and_what_shows_is_not() {
        let f = TransferFunction::new(vec![point(0.0, 0.0), point(10.0, 0.0), point(11.0, 1.0)]).unwrap();
        let transparent = |min, max| f.is_transparent(ValueRange { min, max });
        assert!(transparent(-50.0, 9.9) && transparent(3.0, 3.0));
        assert!(!transparent(3.0, 10.1) && !transparent(10.5, 99.0) && !transparent(12.0, 13.0));
        assert!(!transparent(f32::NAN, 1.0));
        assert!(transparent(f32::MIN, -1.0) && !transparent(f32::MIN, f32::MAX));
    }

    /// Most transfer functions begin where something begins to show, and the air lies below.
    #[test]
    fn beyond_its_ends_a_function_is_what_it_is_there() {
        let window =
            TransferFunction::new(vec![point(10.0, 0.0), point(11.0, 1.0), point(12.0, 0.0)]).unwrap();
        let transparent = |min, max| window.is_transparent(ValueRange { min, max });
        assert!(transparent(-50.0, 9.9) && transparent(0.0, 10.0) && transparent(12.1, 900.0));
        assert!(!transparent(0.0, 10.0_f32.next_up()) && !transparent(11.99, 900.0));
        assert!(!transparent(12.0_f32.next_down(), 900.0) && !transparent(0.0, 900.0));
        let ends = TransferFunction::new(vec![point(10.0, 0.5), point(11.0, 0.0), point(12.0, 0.5)]).unwrap();
        let transparent = |min, max| ends.is_transparent(ValueRange { min, max });
        assert!(!transparent(-50.0, -20.0) && !transparent(20.0, 50.0) && !transparent(10.9, 11.1));
    }

    #[test]
    fn refuses_what_is_no_function() {
        assert_eq!(TransferFunction::new(vec![point(1.0, 0.0)]), Err(TransferFunctionError::TooFew(1)));
        let backwards = vec![point(1.0, 0.0), point(0.0, 1.0)];
        assert_eq!(TransferFunction::new(backwards), Err(TransferFunctionError::Order(2)));
        let flat = vec![point(1.0, 0.0), point(1.0, 1.0)];
        assert_eq!(TransferFunction::new(flat), Err(TransferFunctionError::Flat));
    }
}
