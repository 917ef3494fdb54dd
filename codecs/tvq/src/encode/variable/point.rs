//! Variables of a trial: the width of codes, and the error at which a bit pays.

use crate::encode::tuned::trials::{FARTHEST, OF_MEANS, PRICE};

/// Result of the search before all blocks are coded: bits of a code, and the error at which a bit pays.
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

    /// The error that fits the step of means.
    pub fn of_means(self) -> f64 {
        OF_MEANS * self.error
    }

    /// How much more a bit is worth than assumed: the logarithm of the ratio of the errors at which it pays. The price
    /// is in units of sums.
    pub fn off(self, price: f64) -> f64 {
        ((price / PRICE).sqrt() / self.error).ln().clamp(-FARTHEST, FARTHEST)
    }
}
