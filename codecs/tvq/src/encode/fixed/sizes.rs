//! Sizes of the codebooks of the payload `fixed`, from training curves.

use cvr_core::codec::EncodeError;
use rayon::prelude::*;

use super::expected::{Expected, Left};
use crate::encode::domain::Domain;
use crate::encode::tuned::fixed::{FEW_BLOCKS, MOST_PAIRS, SHARES, TRIED, TRIED_CONFINED};
use crate::encode::work::Work;
use crate::settings::CODE_BITS;
use crate::stream::geometry::VOXELS;

/// Widths of a code that a stream may have, besides none.
const WIDTHS: std::ops::RangeInclusive<u32> = 4..=16;

/// Expected results of codebooks.
#[derive(Debug)]
pub struct Plan {
    expected: Expected,
    /// Smallest and largest mean of each domain, in units of sums, and its blocks.
    means: Vec<(f64, f64, f64)>,
    /// Widest code for which there are enough blocks.
    widest: u32,
}

/// Sizes of the three codebooks in codewords (1 means none), and the error (root mean square, in units of sums) that
/// they are expected to leave.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Sizes {
    pub books: [usize; 3],
    pub expected: f64,
}

/// How codewords are distributed over codebooks.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Shape {
    /// Over this number of codebooks, with the least expected error.
    Best(usize),
    /// Over two codebooks. The first gets this fraction.
    Split(f64),
}

/// One size of a codebook.
#[derive(Copy, Clone, Debug)]
struct Choice {
    size: usize,
    /// Bits of the codebook and of all codes.
    bits: f64,
    left: Left,
}

impl Plan {
    pub fn measure(work: &Work<'_>) -> Result<Self, EncodeError> {
        let domains: Vec<_> = work.domains().cloned().collect();
        let expected = Expected::measure(work, &domains)?;
        let means = domains.iter().map(|d| means(work, d)).collect::<Result<_, _>>()?;
        // Sub-volumes are trained separately. No table has more codewords than the smallest sub-volume has blocks.
        let fewest = domains.iter().map(Domain::blocks).min().unwrap_or(1);
        let widest = fewest.max(1).ilog2().clamp(1, *WIDTHS.end());
        Ok(Self { expected, means, widest })
    }

    /// Bits of all means.
    fn mean_bits(&self, shift: u32) -> f64 {
        let code = |mean: f64| (mean / f64::from(1_u32 << shift)).round() as u32;
        let bits = |(low, high, blocks): &(f64, f64, f64)| {
            blocks * f64::from(32 - (code(*high) - code(*low)).leading_zeros())
        };
        self.means.iter().map(bits).sum()
    }

    /// Sizes that the codebook of a partition may have, smallest first.
    fn choices(&self, work: &Work<'_>, partition: usize) -> Vec<Choice> {
        let book_bits = codeword_bits(work);
        let widths = WIDTHS.filter(|w| *w <= self.widest);
        let sizes = widths.flat_map(|w| [9, 10, 12, 14, 16].map(|parts| parts << (w - 4)));
        let of_size = |size: usize| {
            let bits = work.blocks() * f64::from(width(size)) + book_bits * size as f64;
            Choice { size, bits, left: self.expected.left(work, partition, size) }
        };
        std::iter::once(1).chain(sizes).map(of_size).collect()
    }

    /// The sizes of codebooks of a shape within `budget`, for all codes and codebooks, and the means if `with_means`.
    /// No codebooks if even the smallest exceed it.
    pub fn sizes(&self, work: &Work<'_>, budget: f64, with_means: bool, shape: Shape) -> Sizes {
        if let Some(books) = given(work) {
            return Sizes { books, expected: self.expected.of(work, books) };
        }
        let mut choices = [0, 1, 2].map(|p| self.choices(work, p));
        if let Shape::Best(count) = shape {
            for (p, choices) in choices.iter_mut().enumerate() {
                // The first choice is to have no codebook.
                choices.retain(|c| {
                    (c.size > 1) == (p < count) && (count == 3 || c.size as f64 * work.blocks() <= MOST_PAIRS)
                });
            }
        }
        let mut found = Sizes { books: [1; 3], expected: self.expected.of(work, [1; 3]) };
        for _ in 0..3 {
            let means = if with_means { self.mean_bits(work.mean_shift(found.expected)) } else { 0.0 };
            let mut books = match shape {
                Shape::Best(_) => best(&choices, budget - means).unwrap_or([1; 3]),
                Shape::Split(share) => self.split(work, share, budget - means),
            };
            self.fill(work, &mut books, budget - means);
            found = Sizes { books, expected: self.expected.of(work, books) };
        }
        found
    }

    /// The largest two codebooks within `budget`. The first has a fraction `share` of the codewords.
    fn split(&self, work: &Work<'_>, share: f64, budget: f64) -> [usize; 3] {
        let most = 1 << self.widest;
        let of = |all: usize| {
            let first = ((all as f64 * share).round() as usize).clamp(1, most);
            [first, (all - first).clamp(1, most), 1]
        };
        // The least number beyond the budget: bits grow with codewords.
        let (mut within, mut beyond) = (2, 2 * most + 1);
        while beyond - within > 1 {
            let middle = usize::midpoint(within, beyond);
            *(if self.bits(work, &of(middle)) <= budget { &mut within } else { &mut beyond }) = middle;
        }
        of(within)
    }

    /// Bits of codebooks and of all their codes.
    fn bits(&self, work: &Work<'_>, books: &[usize; 3]) -> f64 {
        let book_bits = codeword_bits(work);
        let of_book = |size: &usize| work.blocks() * f64::from(width(*size)) + book_bits * *size as f64;
        books.iter().map(of_book).sum()
    }

    /// Three codes of 8 bits, as in the paper, if there are enough blocks to pay for their codebooks.
    pub fn three_of_eight_bits(&self, work: &Work<'_>) -> Option<Sizes> {
        let books = [1 << (CODE_BITS / 3); 3];
        let many = given(work).is_none() && work.blocks() / work.tables() > FEW_BLOCKS;
        many.then(|| Sizes { books, expected: self.expected.of(work, books) })
    }

    /// Numbers of codebooks that are worth a try within a budget. Expectations of few large codebooks are less certain.
    pub fn counts(&self, work: &Work<'_>, budget: f64, with_means: bool) -> Vec<Shape> {
        if given(work).is_some() {
            return vec![Shape::Best(3)];
        }
        let shapes = [1, 2, 3].map(Shape::Best);
        let expected = shapes.map(|shape| self.sizes(work, budget, with_means, shape).expected);
        let least = expected.iter().copied().fold(f64::INFINITY, f64::min);
        let tried = if work.options.confined { TRIED_CONFINED } else { TRIED };
        let worth = |i: usize| work.blocks() <= FEW_BLOCKS || expected[i] <= least * tried[i];
        (0..3).filter(|i| worth(*i)).map(|i| shapes[i]).collect()
    }

    /// The same at a rate.
    pub fn shapes(&self, work: &Work<'_>, budget: f64) -> Vec<Shape> {
        let mut shapes = self.counts(work, budget, true);
        if shapes.len() > 1 && work.blocks() <= FEW_BLOCKS && !work.options.confined {
            shapes.extend(SHARES.map(Shape::Split));
        }
        shapes
    }

    /// Spends the rest of a budget on codewords that need no further bit per code, most of them in the largest
    /// codebook.
    fn fill(&self, work: &Work<'_>, books: &mut [usize; 3], budget: f64) {
        let mut order = [0, 1, 2];
        order.sort_by_key(|p| std::cmp::Reverse(books[*p]));
        for p in order.into_iter().filter(|p| books[*p] > 1).collect::<Vec<_>>() {
            let spare = ((budget - self.bits(work, books)) / codeword_bits(work)).max(0.0) as usize;
            books[p] += spare.min((1 << width(books[p])) - books[p]);
        }
    }
}

/// Bits of a codeword in all tables.
fn codeword_bits(work: &Work<'_>) -> f64 {
    f64::from(VOXELS as u32 * work.entry_bits()) * work.tables()
}

/// Bits of a code for `size` codewords.
const fn width(size: usize) -> u32 {
    size.next_power_of_two().trailing_zeros()
}

/// Smallest and largest mean of a domain's blocks, in units of sums, and how many there are.
fn means(work: &Work<'_>, domain: &Domain) -> Result<(f64, f64, f64), EncodeError> {
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for frame in domain.frames.clone() {
        for z in 0..domain.size[2] {
            let of_row = |y| {
                let rows = domain.row(work.source, work.quantiser, frame, y, z)?;
                let blocks = rows.iter().flat_map(|row| row.values.chunks_exact(VOXELS));
                let mean = |block: &[f32]| block.iter().map(|v| f64::from(*v)).sum::<f64>() / VOXELS as f64;
                Ok(blocks.map(mean).fold((f64::INFINITY, 0.0_f64), |(l, h), m| (l.min(m), h.max(m))))
            };
            let rows: Vec<(f64, f64)> =
                (0..domain.size[1]).into_par_iter().map(of_row).collect::<Result<_, EncodeError>>()?;
            (low, high) = rows.into_iter().fold((low, high), |(l, h), (a, b)| (l.min(a), h.max(b)));
        }
        work.run.advance(0)?;
    }
    Ok((low.min(high), high, domain.blocks() as f64))
}

/// Sizes that the settings give.
pub fn given(work: &Work<'_>) -> Option<[usize; 3]> {
    let of_width = (work.options.index_bits > 0).then(|| [1 << work.options.index_bits; 3]);
    work.options.sizes.or(of_width)
}

/// One size per codebook, with the least sum of expected errors, and a sum of bits of at most `budget`. The choices of
/// each codebook are ordered by bits.
fn best([low, band, high]: &[Vec<Choice>; 3], budget: f64) -> Option<[usize; 3]> {
    let mut best: Option<(f64, [usize; 3])> = None;
    for a in low {
        for b in band {
            let left = b.left.after(a.left.after(0.0));
            for c in high.iter().take_while(|c| a.bits + b.bits + c.bits <= budget) {
                let left = c.left.after(left);
                if best.is_none_or(|best| left < best.0) {
                    best = Some((left, [a.size, b.size, c.size]));
                }
            }
        }
    }
    best.map(|best| best.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Choices of 1, 2, 4, … codewords. Each bit leaves the same fraction.
    fn choices(part: f64, behind: f64) -> Vec<Choice> {
        let choice = |w: u32| {
            let width = f64::from(w);
            let left = Left { alone: part * width, behind: behind * width, before: -2.0 };
            Choice { size: 1 << w, bits: 10.0 * width + 0.1 * width.exp2(), left }
        };
        (0..10).map(choice).collect()
    }

    #[test]
    fn the_best_sizes_are_within_the_budget_and_leave_least() {
        let all = [choices(-0.3, -0.3), choices(-0.29, -0.2), choices(-0.1, -0.1)];
        let sizes = |budget| best(&all, budget).unwrap();
        let bits = |sizes: [usize; 3]| -> f64 {
            let of = |p: usize| all[p].iter().find(|c| c.size == sizes[p]).unwrap().bits;
            (0..3).map(of).sum()
        };
        // Five bits and their codewords. The last codebook pays least; the second pays less the more the first has
        // removed.
        assert_eq!(sizes(53.5), [32, 1, 1]);
        assert_eq!(sizes(53.0), [16, 2, 1]);
        assert_eq!(sizes(41.9), [16, 1, 1]);
        for budget in [1.0, 30.0, 90.0, 200.0] {
            assert!(bits(sizes(budget)) <= budget);
        }
        assert!(best(&all, 0.2).is_none(), "three codewords take more");
    }
}
