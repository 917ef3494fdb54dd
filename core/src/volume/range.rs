//! A closed interval of sample values.

use serde::{Deserialize, Serialize};

/// `min ..= max` in data units; both finite, `min <= max`.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValueRange {
    /// Lowest value.
    pub min: f32,
    /// Highest value.
    pub max: f32,
}

impl ValueRange {
    /// Range of the finite values of an iterator; `None` when there is none.
    pub fn of(values: impl IntoIterator<Item = f32>) -> Option<Self> {
        values.into_iter().filter(|v| v.is_finite()).fold(None, |range: Option<Self>, v| {
            Some(range.map_or(Self { min: v, max: v }, |r| Self { min: r.min.min(v), max: r.max.max(v) }))
        })
    }

    /// Smallest range that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether `value` lies inside, bounds included.
    #[must_use]
    pub fn contains(self, value: f32) -> bool {
        self.min <= value && value <= self.max
    }

    /// `max − min`, in double precision so that it cannot overflow.
    #[must_use]
    pub fn span(self) -> f64 {
        f64::from(self.max) - f64::from(self.min)
    }
}
