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
    /// Range of the finite values of an iterator. `None` if there are none.
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

    /// Largest absolute value of the interval.
    #[must_use]
    pub fn magnitude(self) -> f32 {
        self.min.abs().max(self.max.abs())
    }

    /// One unit in the last place of [`ValueRange::magnitude`]: the distance to the next larger single-precision
    /// number. [`crate::codec::Agreement::Ulp`] counts in it.
    #[must_use]
    pub fn ulp(self) -> f64 {
        let m = self.magnitude();
        // The largest finite number has no larger neighbour. The distance to the next smaller one is the same.
        let (low, high) = if m < f32::MAX { (m, m.next_up()) } else { (f32::MAX.next_down(), f32::MAX) };
        f64::from(high) - f64::from(low)
    }

    /// `max − min`, in double precision so that it cannot overflow.
    #[must_use]
    pub fn span(self) -> f64 {
        f64::from(self.max) - f64::from(self.min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_ulp_follows_the_larger_end() {
        assert_eq!(ValueRange { min: -1.0, max: 0.5 }.ulp(), f64::from(f32::EPSILON));
        assert_eq!(ValueRange { min: 0.0, max: 0.0 }.ulp(), f64::from(f32::from_bits(1)));
        assert_eq!(ValueRange { min: f32::MIN, max: 0.0 }.ulp(), 2_f64.powi(104));
    }
}
