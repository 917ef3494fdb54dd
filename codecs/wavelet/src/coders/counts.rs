//! An adaptive model: how often each symbol has been coded (section 2.3 of the paper, after Moffat, Neal and Witten).

use std::num::NonZeroU32;

use constriction::stream::model::{DecoderModel, EncoderModel, EntropyModel};

/// Bits of a probability.
pub const PRECISION: usize = 24;

/// Counts never exceed this total, so no interval of [`PRECISION`] bits is empty.
const MOST: u32 = 1 << 20;

/// One count per symbol, at least 1, in a Fenwick tree: sums and changes take O(log n).
#[derive(Clone, Debug)]
pub struct Counts {
    counts: Vec<u32>,
    /// Node `i` is the sum of the `i & -i` counts before `i`. There are as many as the next power of two, and node 0.
    tree: Vec<u32>,
    total: u32,
}

impl Counts {
    /// Each of `symbols` has been counted once. There are 2 at least, and few enough to be counted.
    #[must_use]
    pub fn new(symbols: usize) -> Self {
        debug_assert!((2..MOST as usize / 4).contains(&symbols));
        let tree = vec![0; symbols.next_power_of_two() + 1];
        let mut counts = Self { counts: vec![1; symbols], tree, total: 0 };
        counts.sum();
        counts
    }

    /// Sums the tree from the counts.
    fn sum(&mut self) {
        self.total = self.counts.iter().sum();
        self.tree.fill(0);
        self.tree[1..=self.counts.len()].copy_from_slice(&self.counts);
        for i in 1..self.tree.len() {
            let parent = i + (i & i.wrapping_neg());
            if parent < self.tree.len() {
                self.tree[parent] += self.tree[i];
            }
        }
    }

    /// Counts a symbol. At a total of 2^20, all counts are first halved and rounded up.
    #[inline]
    pub fn count(&mut self, symbol: usize) {
        if self.total == MOST {
            self.halve();
        }
        self.counts[symbol] += 1;
        self.total += 1;
        let mut i = symbol + 1;
        while i < self.tree.len() {
            self.tree[i] += 1;
            i += i & i.wrapping_neg();
        }
    }

    #[cold]
    fn halve(&mut self) {
        for count in &mut self.counts {
            *count = count.div_ceil(2);
        }
        self.sum();
    }

    /// Sum of the counts before a symbol.
    #[inline]
    fn before(&self, symbol: usize) -> u32 {
        let (mut sum, mut i) = (0, symbol);
        while i > 0 {
            sum += self.tree[i];
            i &= i - 1;
        }
        sum
    }

    /// The symbol with this place among all counted, and the sum of the counts before it. `place` is below the total.
    #[inline]
    fn find(&self, place: u32) -> (usize, u32) {
        let (mut symbol, mut sum) = (0, 0);
        let mut step = self.tree.len() / 2;
        while step > 0 {
            let next = sum + self.tree[symbol + step];
            if next <= place {
                (symbol, sum) = (symbol + step, next);
            }
            step /= 2;
        }
        (symbol, sum)
    }

    /// The model of all symbols.
    #[inline]
    #[must_use]
    pub const fn all(&self) -> Intervals<'_> {
        Intervals { counts: self, first: 0 }
    }

    /// The model of a symbol that is known not to be symbol 0. There are 3 symbols at least.
    #[inline]
    #[must_use]
    pub fn after_first(&self) -> Intervals<'_> {
        Intervals { counts: self, first: self.counts[0] }
    }
}

/// The symbols whose counts come after the `first` ones, as intervals: count `c` of `n` is at `c · 2^24 / n`, rounded
/// down.
#[derive(Copy, Clone, Debug)]
pub struct Intervals<'a> {
    counts: &'a Counts,
    first: u32,
}

impl Intervals<'_> {
    #[inline]
    const fn bound(&self, count: u32) -> u32 {
        let of = self.counts.total - self.first;
        (((count - self.first) as u64) << PRECISION).wrapping_div(of as u64) as u32
    }

    /// Where the interval of a symbol starts, and how long it is.
    #[inline]
    fn interval(&self, symbol: usize, before: u32) -> (u32, NonZeroU32) {
        let start = self.bound(before);
        let length = self.bound(before + self.counts.counts[symbol]) - start;
        (start, NonZeroU32::new(length).unwrap_or(NonZeroU32::MIN))
    }
}

impl EntropyModel<PRECISION> for Intervals<'_> {
    type Symbol = usize;
    type Probability = u32;
}

impl EncoderModel<PRECISION> for Intervals<'_> {
    #[inline]
    fn left_cumulative_and_probability(
        &self,
        symbol: impl std::borrow::Borrow<usize>,
    ) -> Option<(u32, NonZeroU32)> {
        let symbol = *symbol.borrow();
        Some(self.interval(symbol, self.counts.before(symbol)))
    }
}

impl DecoderModel<PRECISION> for Intervals<'_> {
    #[inline]
    fn quantile_function(&self, quantile: u32) -> (usize, u32, NonZeroU32) {
        // The last count whose bound is not beyond the quantile.
        let of = u64::from(self.counts.total - self.first);
        let count = (((u64::from(quantile) + 1) * of - 1) >> PRECISION) as u32;
        let (symbol, before) = self.counts.find(self.first + count);
        let (start, length) = self.interval(symbol, before);
        (symbol, start, length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The intervals of the symbols from `first` on follow each other, fill 2^24, and hold their quantiles.
    fn check(model: Intervals<'_>, first: usize) {
        let mut end = 0;
        for symbol in first..model.counts.counts.len() {
            let (start, length) = model.left_cumulative_and_probability(symbol).unwrap();
            assert_eq!(start, end);
            end = start + length.get();
            for quantile in [start, end - 1] {
                assert_eq!(model.quantile_function(quantile), (symbol, start, length));
            }
        }
        assert_eq!(end, 1 << PRECISION);
    }

    #[test]
    fn intervals_fill_the_unit() {
        for symbols in [3, 4, 5, 128, 1000] {
            let mut counts = Counts::new(symbols);
            for i in 0..2000 {
                counts.count(i * i % symbols);
                if i % 199 == 0 {
                    check(counts.all(), 0);
                    check(counts.after_first(), 1);
                }
            }
        }
    }

    #[test]
    fn counts_start_at_one_and_grow_by_one() {
        let mut counts = Counts::new(3);
        let starts =
            |counts: &Counts| [0, 1, 2].map(|s| counts.all().left_cumulative_and_probability(s).unwrap().0);
        assert_eq!(starts(&counts), [0, (1 << 24) / 3, (2 << 24) / 3]);
        counts.count(1);
        assert_eq!(starts(&counts), [0, 1 << 22, 3 << 22]);
    }

    #[test]
    fn counts_are_halved_before_they_exceed_the_precision() {
        let mut counts = Counts::new(3);
        while counts.total < MOST {
            counts.count(1);
        }
        check(counts.all(), 0);
        counts.count(2);
        assert_eq!(counts.counts, [1, (MOST - 2) / 2, 2]);
        assert_eq!(counts.total, MOST / 2 + 2);
        check(counts.all(), 0);
        check(counts.after_first(), 1);
    }
}
