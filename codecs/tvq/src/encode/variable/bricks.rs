//! Bits and errors of the bricks of the payload `variable`, for every number of kept codebooks.

use rayon::prelude::*;

use super::cost::fixed_bits;
use super::frame::{brick_words, count_bits};
use super::rate_control::{Sum, best_counts};
use crate::encode::closed_loop::Plane;
use crate::encode::train::book::Book;
use crate::encode::work::{Coded, Work};
use crate::stream::bits::mean_width;
use crate::stream::geometry::{BRICK, MOST_BOOKS, number, positions};

/// A brick of one plane.
struct Brick<'a> {
    plane: &'a Plane,
    /// Number of its table, and of the plane there.
    table: usize,
    number: usize,
    /// First block, blocks along each axis, and blocks along each axis of the domain.
    first: [u32; 3],
    cut: [u32; 3],
    size: [u32; 3],
    mean_bits: u32,
}

/// All bricks of a volume.
pub struct Bricks<'a> {
    bricks: Vec<Brick<'a>>,
    /// Bits of everything except bricks, by number of kept codebooks.
    fixed: Vec<f64>,
    /// Bits of a code, by table and number of kept codebooks.
    widths: Vec<Vec<u32>>,
}

/// Bits and error of one brick.
#[derive(Copy, Clone, Default)]
struct Count {
    error: f64,
    codes: u32,
    most: u8,
}

impl Brick<'_> {
    /// Numbers of its blocks in the plane.
    fn blocks(&self) -> impl Iterator<Item = usize> {
        let (first, size) = (self.first, self.size);
        positions(self.cut).map(move |p| number([0, 1, 2].map(|a| first[a] + p[a]), size))
    }

    fn bits(&self, count: Count, width: u32) -> f64 {
        let planes = count_bits(std::iter::once(count.most));
        32.0 * f64::from(brick_words(planes, self.mean_bits, count.codes, width))
    }

    /// Squared errors of a block, by number of codes.
    fn errors(&self, block: usize) -> &[f32] {
        let stride = self.plane.books + 1;
        &self.plane.errors[block * stride..(block + 1) * stride]
    }
}

impl<'a> Bricks<'a> {
    /// Those of some codes.
    #[must_use]
    pub fn of(work: &Work<'_>, coded: &'a [Vec<Coded>]) -> Self {
        let mut bricks = Vec::new();
        for (table, (coded, domain)) in coded.iter().flatten().zip(work.domains()).enumerate() {
            let size = domain.size;
            for (number_of, plane) in coded.planes.iter().enumerate() {
                for brick in positions(size.map(|s| s.div_ceil(BRICK))) {
                    let first = brick.map(|b| b * BRICK);
                    let cut = [0, 1, 2].map(|a| BRICK.min(size[a] - first[a]));
                    let mut brick = Brick { plane, table, number: number_of, first, cut, size, mean_bits: 0 };
                    let means: Vec<u32> = brick.blocks().map(|n| plane.means[n]).collect();
                    brick.mean_bits = mean_width(&means).1 * means.len() as u32;
                    bricks.push(brick);
                }
            }
        }
        let tables = || coded.iter().flatten();
        let most = tables().map(|c| c.books.len()).max().unwrap_or(0);
        let first = |c: &'a Coded, count: usize| c.books.iter().take(count);
        let codewords = |m| tables().flat_map(|c| first(c, m)).map(Book::size).sum::<usize>();
        let width = |c, m| first(c, m).map(Book::width).max().unwrap_or(0);
        Self {
            bricks,
            fixed: (0..=most).map(|m| fixed_bits(work, m as u32, codewords(m) as f64)).collect(),
            widths: tables().map(|c| (0..=most).map(|m| width(c, m)).collect()).collect(),
        }
    }

    /// Bits of everything and squared error, by number of kept codebooks, if every block keeps the codes that pay at
    /// `price` (in data units).
    #[must_use]
    pub fn sums(&self, price: f64) -> Vec<Sum> {
        let counts = self.fixed.len();
        let prices: Vec<Vec<f64>> =
            self.widths.iter().map(|w| w.iter().map(|w| price * f64::from(*w)).collect()).collect();
        let of_some = |bricks: &[Brick<'_>]| {
            let mut sums = vec![Sum::default(); counts];
            for brick in bricks {
                // A table may have fewer codebooks than another.
                let own = brick.plane.books + 1;
                let mut found = [Count::default(); MOST_BOOKS as usize + 1];
                for block in brick.blocks() {
                    let errors = brick.errors(block);
                    best_counts(
                        |n| errors[n].into(),
                        &prices[brick.table][..own],
                        |m, kept, error| {
                            found[m].error += error;
                            found[m].codes += kept as u32;
                            found[m].most = found[m].most.max(kept as u8);
                        },
                    );
                }
                for (m, sum) in sums.iter_mut().enumerate() {
                    let found = found[m.min(own - 1)];
                    sum.bits += brick.bits(found, self.widths[brick.table][m]);
                    sum.error += found.error;
                }
            }
            sums
        };
        // Parts of a fixed size, so that sums are rounded in the same order on every machine.
        let parts: Vec<Vec<Sum>> = self.bricks.par_chunks(256).map(of_some).collect();
        let mut sums: Vec<Sum> = self.fixed.iter().map(|bits| Sum { bits: *bits, error: 0.0 }).collect();
        for part in parts {
            for (sum, part) in sums.iter_mut().zip(part) {
                sum.bits += part.bits;
                sum.error += part.error;
            }
        }
        sums
    }

    /// The same if all codebooks are kept, for the given number of codes by table, plane and block.
    #[must_use]
    pub fn sum_of(&self, kept: &[&Vec<Vec<u8>>]) -> Sum {
        let mut sum = Sum { bits: self.fixed.last().copied().unwrap_or(0.0), error: 0.0 };
        for brick in &self.bricks {
            let kept = &kept[brick.table][brick.number];
            let mut found = Count::default();
            for block in brick.blocks() {
                found.error += f64::from(brick.errors(block)[usize::from(kept[block])]);
                found.codes += u32::from(kept[block]);
                found.most = found.most.max(kept[block]);
            }
            sum.bits += brick.bits(found, self.widths[brick.table].last().copied().unwrap_or(0));
            sum.error += found.error;
        }
        sum
    }
}
