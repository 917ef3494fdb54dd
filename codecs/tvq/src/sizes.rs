//! How many codewords the codebooks of the payload `fixed` get, from training curves.

use cvr_core::codec::EncodeError;
use rayon::prelude::*;

use crate::blocks::{Domain, Sample};
use crate::encode::Work;
use crate::geometry::VOXELS;
use crate::settings::CODE_BITS;
use crate::train::{Curve, Curves, Trainer};

/// Widths at which training curves are measured.
const MEASURED: [u32; 4] = [3, 5, 7, 9];
/// Blocks on which they are measured.
const OVERVIEW: u64 = 12288;
/// Widths of a code that a stream may have beside none.
const WIDTHS: std::ops::RangeInclusive<u32> = 4..=16;
/// Numbers of codebooks are tried of which at most so many times the least error is expected: one, two and three.
const TRIED: [f64; 3] = [1.6, 1.1, 1.0];
/// The same where codevectors keep to the zones of their partition, so that none does without three codebooks for nothing.
const TRIED_CONFINED: [f64; 3] = [1.0, 1.1, 1.35];
/// With no more blocks than this every number is tried, which takes seconds, with a target or without.
const FEW_BLOCKS: f64 = 32768.0;
/// And at a rate two codebooks of which the first has such shares of the codewords: where large codebooks know most blocks by
/// heart, curves do not tell which share serves best.
const SHARES: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 0.65, 0.8];
/// Codewords for which the settings' blocks are enough to train on. Where there are fewer for each codeword, blocks that
/// trained do far better than others.
const ENOUGH_FOR: f64 = 1024.0;
/// How many times the settings' blocks train at most.
const MOST_TRAINING: f64 = 2.5;
/// Most blocks times codewords of one of fewer than three codebooks: more would train for minutes.
const MOST_PAIRS: f64 = (1_u64 << 31) as f64;

/// What is to be expected of codebooks.
#[derive(Debug)]
pub struct Plan {
    curves: Curves,
    /// Widths at which they were measured.
    measured: Vec<u32>,
    /// Smallest and largest mean of each domain, in units of sums, and its blocks.
    means: Vec<(f64, f64, f64)>,
    /// Most bits of a code that there are blocks for.
    widest: u32,
}

/// Codewords of the three codebooks, 1 where there is none, and the error (root mean square, in units of sums) that they are
/// expected to leave.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Sizes {
    pub books: [usize; 3],
    pub expected: f64,
}

/// How codewords are shared out among codebooks.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Shape {
    /// Among so many codebooks, such that least is expected to be left.
    Best(usize),
    /// Between two, of which the first has this share.
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

/// Logarithms of the parts of the error that a codebook leaves: alone, and behind others that have left `before`.
#[derive(Copy, Clone, Debug)]
struct Left {
    alone: f64,
    behind: f64,
    before: f64,
}

impl Left {
    /// The logarithm of what is left behind codebooks that have left `before`. The more codewords have taken away, the less
    /// do further ones find in common.
    fn after(&self, before: f64) -> f64 {
        let way = if self.before < 0.0 { (before / self.before).min(1.0) } else { 1.0 };
        before + self.alone + (self.behind - self.alone) * way
    }
}

impl Plan {
    pub fn measure(work: &Work<'_>) -> Result<Self, EncodeError> {
        let domains: Vec<_> = work.domains().cloned().collect();
        let seed = work.options.seed;
        let sample = Sample::draw(work.source, &domains, work.quantiser, OVERVIEW, seed, work.run)?;
        let trainer = Trainer::new(&sample, work.training(true));
        // What 38 dB leave, to begin with.
        let expected = 0.0126 * work.span / work.unit();
        let most = (sample.len() / 3).max(1).ilog2();
        let measured: Vec<u32> = MEASURED.into_iter().filter(|w| *w <= most).collect();
        let threshold = work.threshold(expected);
        let curves = trainer.curves(&measured, work.mean_shift(expected), threshold, work.run)?;
        let means = domains.iter().map(|d| means(work, d)).collect::<Result<_, _>>()?;
        // Sub-volumes are trained one by one: none has codewords for more blocks than the smallest has.
        let fewest = domains.iter().map(Domain::blocks).min().unwrap_or(1);
        let widest = fewest.max(1).ilog2().clamp(1, *WIDTHS.end());
        Ok(Self { curves, measured, means, widest })
    }

    /// The logarithm of the part of the error that so many codewords leave on a curve, between and beyond what was
    /// measured. Blocks that train a codebook have less left than others, the more so the fewer there are for a codeword:
    /// what both have left is about as far from what endless blocks would have, and that distance is measured too.
    fn on(&self, work: &Work<'_>, curve: &Curve, size: usize) -> f64 {
        if size == 1 {
            return 0.0;
        }
        let measured = || self.measured.iter().map(|w| f64::from(*w)).zip(&curve.left);
        let middle =
            along(measured().map(|(w, [own, other])| (w, 0.5 * (own + other))), (size as f64).log2());
        let apart = measured().map(|(w, [own, other])| (w.exp2() / self.curves.trained, 0.5 * (other - own)));
        let blocks = work.blocks() / work.tables();
        let training = training_blocks(work, size).min(blocks);
        let apart = along(apart, size as f64 / training).max(0.0);
        let share = training / blocks;
        middle + (share * (-apart).exp() + (1.0 - share) * apart.exp()).ln()
    }

    /// What so many codewords leave in a partition, with nothing before them and behind others.
    fn left(&self, work: &Work<'_>, partition: usize, size: usize) -> Left {
        let (first, curve) = (&self.curves.of[0], &self.curves.of[partition]);
        let behind = self.on(work, curve, size);
        // With nothing before it any codebook does what the first does, if it keeps to no zones.
        let alone = if work.options.confined { behind } else { self.on(work, first, size) };
        Left { alone, behind, before: curve.before }
    }

    /// Bits of all means.
    fn mean_bits(&self, shift: u32) -> f64 {
        let code = |mean: f64| (mean / f64::from(1_u32 << shift)).round() as u32;
        let bits = |(low, high, blocks): &(f64, f64, f64)| {
            blocks * f64::from(32 - (code(*high) - code(*low)).leading_zeros())
        };
        self.means.iter().map(bits).sum()
    }

    fn expected(&self, work: &Work<'_>, books: [usize; 3]) -> f64 {
        let left = [0, 1, 2].map(|p| self.left(work, p, books[p]));
        (self.curves.mean_square * left.into_iter().fold(0.0, |before, left| left.after(before)).exp())
            .sqrt()
            .max(0.5)
    }

    /// Sizes that the codebook of a partition may have, smallest first.
    fn choices(&self, work: &Work<'_>, partition: usize) -> Vec<Choice> {
        let book_bits = codeword_bits(work);
        let widths = WIDTHS.filter(|w| *w <= self.widest);
        let sizes = widths.flat_map(|w| [9, 10, 12, 14, 16].map(|parts| parts << (w - 4)));
        let of_size = |size: usize| {
            let bits = work.blocks() * f64::from(width(size)) + book_bits * size as f64;
            Choice { size, bits, left: self.left(work, partition, size) }
        };
        std::iter::once(1).chain(sizes).map(of_size).collect()
    }

    /// The sizes of codebooks of some shape within `budget` for all codes and codebooks, and with `with_means` the means; no
    /// codebook where not even the smallest are within it.
    pub fn sizes(&self, work: &Work<'_>, budget: f64, with_means: bool, shape: Shape) -> Sizes {
        if let Some(books) = given(work) {
            return Sizes { books, expected: self.expected(work, books) };
        }
        let mut choices = [0, 1, 2].map(|p| self.choices(work, p));
        if let Shape::Best(count) = shape {
            for (p, choices) in choices.iter_mut().enumerate() {
                // The first choice is no codebook.
                choices.retain(|c| {
                    (c.size > 1) == (p < count) && (count == 3 || c.size as f64 * work.blocks() <= MOST_PAIRS)
                });
            }
        }
        let mut found = Sizes { books: [1; 3], expected: self.expected(work, [1; 3]) };
        for _ in 0..3 {
            let means = if with_means { self.mean_bits(work.mean_shift(found.expected)) } else { 0.0 };
            let mut books = match shape {
                Shape::Best(_) => best(&choices, budget - means).unwrap_or([1; 3]),
                Shape::Split(share) => self.split(work, share, budget - means),
            };
            self.fill(work, &mut books, budget - means);
            found = Sizes { books, expected: self.expected(work, books) };
        }
        found
    }

    /// The most codewords of two codebooks within `budget` of which the first has a share.
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

    /// Three codes of 8 bits, as in the paper, where there are blocks enough to pay for their codebooks.
    pub fn three_of_eight_bits(&self, work: &Work<'_>) -> Option<Sizes> {
        let books = [1 << (CODE_BITS / 3); 3];
        let many = given(work).is_none() && work.blocks() / work.tables() > FEW_BLOCKS;
        many.then(|| Sizes { books, expected: self.expected(work, books) })
    }

    /// How many codebooks are worth a try within a budget. What is expected of few large ones is less sure.
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

    /// Spends what is left of a budget on codewords that take no further bit of a code, most where there are most.
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

/// Bits of a code of so many codewords.
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

/// The value at `x` on the line through the origin and some points in the order of their places, straight beyond the last.
fn along(points: impl Iterator<Item = (f64, f64)>, x: f64) -> f64 {
    let points: Vec<(f64, f64)> = std::iter::once((0.0, 0.0)).chain(points).collect();
    let after = points.iter().position(|p| p.0 >= x).unwrap_or(points.len() - 1).max(1);
    let (Some(a), Some(b)) = (points.get(after - 1), points.get(after)) else { return 0.0 };
    a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0)
}

/// Blocks that train a table whose largest codebook has so many codewords.
pub fn training_blocks(work: &Work<'_>, size: usize) -> f64 {
    (work.options.training_blocks as f64 * (size as f64 / ENOUGH_FOR).clamp(1.0, MOST_TRAINING)).floor()
}

/// Sizes that the settings give.
pub fn given(work: &Work<'_>) -> Option<[usize; 3]> {
    let of_width = (work.options.index_bits > 0).then(|| [1 << work.options.index_bits; 3]);
    work.options.sizes.or(of_width)
}

/// One size for each codebook such that the sum of what they leave is least and that of their bits at most `budget`.
/// The choices of each have their bits in order.
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

    #[test]
    fn a_line_through_points_goes_on_beyond_them() {
        let points = [(2.0, 4.0), (4.0, 5.0)];
        let at = |x| along(points.into_iter(), x);
        assert_eq!([0.0, 1.0, 2.0, 3.0, 6.0].map(at), [0.0, 2.0, 4.0, 4.5, 6.0]);
        assert_eq!(along(std::iter::empty(), 3.0), 0.0);
    }

    /// Choices of 1, 2, 4, … codewords of which each bit leaves the same part.
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
        // Five bits and their codewords; the last codebook pays least, the second less the more the first has done.
        assert_eq!(sizes(53.5), [32, 1, 1]);
        assert_eq!(sizes(53.0), [16, 2, 1]);
        assert_eq!(sizes(41.9), [16, 1, 1]);
        for budget in [1.0, 30.0, 90.0, 200.0] {
            assert!(bits(sizes(budget)) <= budget);
        }
        assert!(best(&all, 0.2).is_none(), "three codewords take more");
    }

    #[test]
    fn codebooks_do_less_behind_others() {
        let left = Left { alone: -1.0, behind: -0.5, before: -2.0 };
        assert_eq!(
            [0.0, -1.0, -2.0, -3.0].map(|before| left.after(before) - before),
            [-1.0, -0.75, -0.5, -0.5]
        );
    }
}
