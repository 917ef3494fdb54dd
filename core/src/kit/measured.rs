//! Results of encoding: the range of decoded values, and the largest error.

use crate::volume::ValueRange;

/// The range and the largest error of some samples.
#[derive(Copy, Clone, Debug)]
pub struct Measured {
    low: f32,
    high: f32,
    /// In data units. Integers are rounded first.
    pub error: f64,
}

impl Measured {
    /// No samples.
    pub const NOTHING: Self = Self { low: f32::INFINITY, high: f32::NEG_INFINITY, error: 0.0 };

    /// Adds a sample and its decoded value.
    pub fn add(&mut self, sample: f32, decoded: f32, integers: bool) {
        let shown = if integers { decoded.round() } else { decoded };
        self.low = self.low.min(decoded);
        self.high = self.high.max(decoded);
        self.error = self.error.max((f64::from(shown) - f64::from(sample)).abs());
    }

    /// The union of both.
    pub const fn and(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            error: self.error.max(other.error),
        }
    }

    /// The range. 0 to 0 if there is no sample.
    pub fn range(self) -> ValueRange {
        if self.low <= self.high {
            ValueRange { min: self.low, max: self.high }
        } else {
            ValueRange { min: 0.0, max: 0.0 }
        }
    }
}
