//! Rate control: the number of codebooks to keep, and the price at which a code pays.

use std::cmp::Ordering;

/// Number of halvings of a range of prices. Their logarithms are then known within 2 · ln 10⁷ / 2²⁸. Derived.
const HALVINGS: usize = 28;
/// Prices are searched within this factor of the expected one, up and down. Tested: any first guess within 10³.
const REACH: f64 = 1e7;
/// Bits or errors that miss the target by at most this fraction are accepted. Limit.
const NEAR: f64 = 1e-5;
/// Number of codebook counts that are tried one by one. Limit.
const COUNTS: usize = 8;

/// A bound on bits or on error. The other quantity is minimised.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Aim {
    /// Bits of everything, at most.
    Bits(f64),
    /// Squared error, at most.
    Error(f64),
}

/// Bits and error at a price.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Sum {
    /// Bits of everything.
    pub bits: f64,
    /// Squared error of everything.
    pub error: f64,
}

/// Number of kept codebooks, price of a bit, and the resulting bits and error.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Settled {
    /// Number of codebooks that are kept, from the first on.
    pub books: usize,
    /// Squared error per bit.
    pub price: f64,
    /// The next price, at which the aim is missed. Some groups may keep what it buys, as long as the aim is met.
    pub missed: f64,
    /// What that comes to.
    pub sum: Sum,
}

impl Aim {
    /// Whether the aim is met.
    #[must_use]
    pub fn met(self, sum: Sum) -> bool {
        match self {
            Self::Bits(most) => sum.bits <= most,
            Self::Error(most) => sum.error <= most,
        }
    }

    /// Bits of everything at most.
    #[must_use]
    pub const fn most_bits(self) -> f64 {
        match self {
            Self::Bits(most) => most,
            Self::Error(_) => f64::INFINITY,
        }
    }

    /// The quantity to minimise: the free one if the aim is met, else the bounded one.
    #[must_use]
    pub fn left(self, sum: Sum) -> f64 {
        if matches!(self, Self::Bits(_)) == self.met(sum) { sum.error } else { sum.bits }
    }

    /// The better sum is less: among those that meet the aim, the one with less of the free quantity; else the one
    /// nearest to the aim.
    #[must_use]
    pub fn order(self, a: Sum, b: Sum) -> Ordering {
        let met = self.met(b).cmp(&self.met(a));
        let asked = |s: Sum| s.bits + s.error;
        met.then(self.left(a).total_cmp(&self.left(b))).then(asked(a).total_cmp(&asked(b)))
    }

    /// Whether the aim is met with next to nothing to spare.
    fn just_met(self, sum: Sum) -> bool {
        let (is, most) = match self {
            Self::Bits(most) => (sum.bits, most),
            Self::Error(most) => (sum.error, most),
        };
        self.met(sum) && is >= most * (1.0 - NEAR)
    }

    /// Two neighbouring prices: the one that still meets the aim, and the one that does not. `at` gives the sum at a
    /// price.
    fn border(self, about: f64, at: impl Fn(f64) -> Sum) -> [f64; 2] {
        // A high price gives few bits, a low one a small error.
        let ends = [(about / REACH).ln(), (about * REACH).ln()];
        let [mut met, mut missed] =
            if matches!(self, Self::Bits(_)) { [ends[1], ends[0]] } else { [ends[0], ends[1]] };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (met + missed);
            let sum = at(middle.exp());
            if self.met(sum) {
                met = middle;
            } else {
                missed = middle;
            }
            if self.just_met(sum) {
                break;
            }
        }
        [met.exp(), missed.exp()]
    }
}

/// The number of codebooks and the price that meet the aim best, or come nearest to it. `sums(price)[m]` is the sum at
/// a price if the first `m` codebooks are kept, from none to all. The price lies near `about`.
///
/// Codebooks cost bits even if they are not used, and the bits of a stream jump with each of them. So the price of
/// codes alone cannot meet an aim: with one codebook too many, the codes would have to pay for all of it. Along the
/// lower hull of error over bits (Shoham and Gersho 1988) one price serves both. Between its corners, numbers of
/// codebooks are tried one by one.
#[must_use]
pub fn settle(aim: Aim, about: f64, sums: impl Fn(f64) -> Vec<Sum>) -> Settled {
    let about = about.clamp(1e-200, 1e200);
    let on_hull = |price: f64| -> (usize, Sum) {
        let cost = |s: &Sum| s.error + price * s.bits;
        let sums = sums(price).into_iter().enumerate();
        sums.min_by(|a, b| cost(&a.1).total_cmp(&cost(&b.1))).unwrap_or_default()
    };
    let [met, missed] = aim.border(about, |price| on_hull(price).1);
    let (kept, other) = (on_hull(met).0, on_hull(missed).0);
    let (least, most) = (kept.min(other), kept.max(other));
    let of_count = |books: usize| {
        settle_all(aim, books, about, |price| sums(price).get(books).copied().unwrap_or_default())
    };
    let step = (most - least).div_ceil(COUNTS).max(1);
    let counts = (least..most).step_by(step).chain([most]);
    let best = counts.map(of_count).min_by(|a, b| aim.order(a.sum, b.sum));
    best.unwrap_or_else(|| of_count(0))
}

/// The price that meets the aim best with all `books` codebooks.
#[must_use]
pub fn settle_all(aim: Aim, books: usize, about: f64, sum: impl Fn(f64) -> Sum) -> Settled {
    let [price, missed] = aim.border(about.clamp(1e-200, 1e200), &sum);
    Settled { books, price, missed, sum: sum(price) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::best;

    /// A few kinds of blocks: the first codebook alone gains little, the second much, the third nothing.
    fn sums(price: f64) -> Vec<Sum> {
        let kinds: [([f64; 4], f64); 3] =
            [([90.0, 80.0, 10.0, 10.0], 20.0), ([50.0, 45.0, 30.0, 30.0], 10.0), ([1.0; 4], 100.0)];
        let mut sums: Vec<Sum> = (0..4).map(|m| Sum { bits: 50.0 * f64::from(m), error: 0.0 }).collect();
        for (errors, blocks) in kinds {
            best(
                |n| errors[n],
                &[4.0 * price; 4],
                (&[], price, 1),
                |m, kept| {
                    sums[m].bits += blocks * 4.0 * f64::from(kept.codes);
                    sums[m].error += blocks * kept.error;
                },
            );
        }
        sums
    }

    /// With all three codebooks 150 bits are gone before the first code: whoever cannot drop one keeps no code at 200.
    #[test]
    fn codebooks_that_are_not_worth_their_bits_are_dropped() {
        let settled = settle(Aim::Bits(340.0), 1.0, sums);
        assert_eq!((settled.books, settled.sum), (2, Sum { bits: 340.0, error: 600.0 }));
        let settled = settle(Aim::Bits(200.0), 1.0, sums);
        assert!(settled.books < 3 && settled.sum.bits <= 200.0, "{settled:?}");
        let settled = settle(Aim::Error(600.0), 1.0, sums);
        assert_eq!((settled.books, settled.sum.bits), (2, 340.0));
    }

    /// For any first guess of a price, more bits never give a larger error.
    #[test]
    fn more_bits_never_harm() {
        let mut last = f64::INFINITY;
        for bits in 0..40 {
            let aim = Aim::Bits(10.0 * f64::from(bits));
            let settled = [1e-3, 1.0, 1e3].map(|about| settle(aim, about, sums).sum);
            assert!(settled.iter().all(|s| aim.met(*s) && *s == settled[0]), "{bits}: {settled:?}");
            assert!(settled[0].error <= last, "{bits}: {settled:?} after {last}");
            last = settled[0].error;
        }
    }

    #[test]
    fn what_cannot_be_met_comes_as_near_as_it_can() {
        assert_eq!(settle(Aim::Bits(-1.0), 1.0, sums).sum.bits, 0.0);
        let settled = settle(Aim::Error(1.0), 1.0, sums);
        assert_eq!((settled.books, settled.sum.error), (2, 600.0));
    }
}
