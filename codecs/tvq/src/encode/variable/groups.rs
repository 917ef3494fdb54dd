//! What the groups of the payload `variable` take and leave, for every number of codebooks that may be kept.

use cvr_groups::{Choice, Tally, best, mean_width};
use rayon::prelude::*;

use super::cost::fixed_bits;
use super::escapes::{AllWays, Ways};
use super::rate_control::{Aim, Settled, Sum};
use crate::encode::closed_loop::Plane;
use crate::encode::kept::KeptPlane;
use crate::encode::train::book::Book;
use crate::encode::work::{Coded, Work};
use crate::stream::geometry::{GROUP, MOST_BOOKS, number, positions};

/// A group of one plane.
struct Group<'a> {
    plane: &'a Plane,
    ways: &'a Ways,
    /// Number of its table, and of the plane there.
    table: usize,
    number: usize,
    /// First block, blocks along each axis, and those of the domain.
    first: [u32; 3],
    cut: [u32; 3],
    size: [u32; 3],
    base: u32,
    mean_bits: u32,
}

/// All groups of a volume.
pub struct Groups<'a> {
    groups: Vec<Group<'a>>,
    /// By number of codebooks kept: bits of all but groups.
    fixed: Vec<f64>,
    /// By table, and by number of codebooks kept: bits of a code.
    widths: Vec<Vec<u32>>,
}

/// What one group comes to.
#[derive(Copy, Clone, Default)]
struct Count {
    error: f64,
    tally: Tally,
}

impl Group<'_> {
    /// Numbers of its blocks in the plane.
    fn blocks(&self) -> impl Iterator<Item = usize> {
        let (first, size) = (self.first, self.size);
        positions(self.cut).map(move |p| number([0, 1, 2].map(|a| first[a] + p[a]), size))
    }

    fn bits(&self, count: &Count, code_bits: u32) -> f64 {
        32.0 * f64::from(count.tally.words(self.mean_bits, code_bits, 1))
    }

    /// Squared errors of a block, by number of codes.
    fn errors(&self, block: usize) -> &[f32] {
        let stride = self.plane.books + 1;
        &self.plane.errors[block * stride..(block + 1) * stride]
    }
}

impl<'a> Groups<'a> {
    /// Those of some codes.
    #[must_use]
    pub fn of(work: &Work<'_>, coded: &'a [Vec<Coded>], ways: &'a AllWays) -> Self {
        let mut groups = Vec::new();
        for (table, (coded, domain)) in coded.iter().flatten().zip(work.domains()).enumerate() {
            let size = domain.size;
            for (number_of, plane) in coded.planes.iter().enumerate() {
                for group in positions(size.map(|s| s.div_ceil(GROUP))) {
                    let first = group.map(|b| b * GROUP);
                    let cut = [0, 1, 2].map(|a| GROUP.min(size[a] - first[a]));
                    let (base, mean_bits) = (0, 0);
                    let mut group = Group {
                        plane,
                        ways: &ways[table][number_of],
                        table,
                        number: number_of,
                        first,
                        cut,
                        size,
                        base,
                        mean_bits,
                    };
                    (group.base, group.mean_bits) = mean_width(group.blocks().map(|n| plane.means[n]));
                    groups.push(group);
                }
            }
        }
        let tables = || coded.iter().flatten();
        let most = tables().map(|c| c.books.len()).max().unwrap_or(0);
        let first = |c: &'a Coded, count: usize| c.books.iter().take(count);
        let codewords = |m| tables().flat_map(|c| first(c, m)).map(Book::size).sum::<usize>();
        let width = |c, m| first(c, m).map(Book::width).max().unwrap_or(0);
        Self {
            groups,
            fixed: (0..=most).map(|m| fixed_bits(work, m as u32, codewords(m) as f64)).collect(),
            widths: tables().map(|c| (0..=most).map(|m| width(c, m)).collect()).collect(),
        }
    }

    /// By number of codebooks kept: bits of everything and squared error, where every block keeps what pays at a price in
    /// data units.
    #[must_use]
    pub fn sums(&self, price: f64) -> Vec<Sum> {
        let counts = self.fixed.len();
        let prices: Vec<Vec<f64>> =
            self.widths.iter().map(|w| w.iter().map(|w| price * f64::from(*w)).collect()).collect();
        let of_some = |groups: &[Group<'_>]| {
            let mut sums = vec![Sum::default(); counts];
            for group in groups {
                // A table may have fewer codebooks than another.
                let own = group.plane.books + 1;
                let mut found = [Count::default(); MOST_BOOKS as usize + 1];
                for block in group.blocks() {
                    let errors = group.errors(block);
                    let at_base = group.plane.means[block] == group.base;
                    let ways = (group.ways.of(block), price, 1);
                    best(
                        |n| errors[n].into(),
                        &prices[group.table][..own],
                        ways,
                        |m, kept| {
                            found[m].error += kept.error;
                            found[m].tally.add(at_base, kept.codes.into(), kept.escape());
                        },
                    );
                }
                for (m, sum) in sums.iter_mut().enumerate() {
                    let found = &found[m.min(own - 1)];
                    sum.bits += group.bits(found, self.widths[group.table][m]);
                    sum.error += found.error;
                }
            }
            sums
        };
        // Parts of a size that does not depend on the machine: sums are rounded in one order.
        let parts: Vec<Vec<Sum>> = self.groups.par_chunks(256).map(of_some).collect();
        let mut sums: Vec<Sum> = self.fixed.iter().map(|bits| Sum { bits: *bits, error: 0.0 }).collect();
        for part in parts {
            for (sum, part) in sums.iter_mut().zip(part) {
                sum.bits += part.bits;
                sum.error += part.error;
            }
        }
        sums
    }

    /// What a group comes to at a price, where the first `books` codebooks are kept; `each` hears what each block keeps.
    fn at(&self, group: &Group<'_>, books: usize, price: f64, mut each: impl FnMut(usize, Choice)) -> Sum {
        let books = books.min(group.plane.books);
        let width = self.widths[group.table][books];
        let prices = vec![price * f64::from(width); books + 1];
        let mut found = Count::default();
        for block in group.blocks() {
            let errors = group.errors(block);
            let mut kept = Choice { codes: 0, bits: 0, error: 0.0 };
            best(|n| errors[n].into(), &prices, (group.ways.of(block), price, 1), |_, choice| kept = choice);
            let at_base = group.plane.means[block] == group.base;
            found.tally.add(at_base, kept.codes.into(), kept.escape());
            found.error += kept.error;
            each(block, kept);
        }
        Sum { bits: group.bits(&found, width), error: found.error }
    }

    /// What blocks keep, by table and plane, and what that comes to. Many blocks change at the very price that meets the aim, where errors
    /// are integers: groups take what the price beyond it buys, one after the other, as long as the aim is met.
    #[must_use]
    pub fn kept(&self, aim: Aim, settled: &Settled) -> (Vec<Vec<KeptPlane>>, Sum) {
        let of_group = |group: &Group<'_>| {
            [settled.price, settled.missed].map(|price| self.at(group, settled.books, price, |_, _| {}))
        };
        let sums: Vec<[Sum; 2]> = self.groups.par_iter().map(of_group).collect();
        let mut sum = Sum { bits: self.fixed[settled.books], error: 0.0 };
        for [of_group, _] in &sums {
            sum.bits += of_group.bits;
            sum.error += of_group.error;
        }
        let mut planes: Vec<Vec<KeptPlane>> = Vec::new();
        for (group, [met, missed]) in self.groups.iter().zip(sums) {
            let changed =
                Sum { bits: sum.bits + missed.bits - met.bits, error: sum.error + missed.error - met.error };
            let price = if aim.met(sum) && aim.met(changed) {
                sum = changed;
                settled.missed
            } else {
                settled.price
            };
            planes.resize_with(planes.len().max(group.table + 1), Vec::new);
            let of_table = &mut planes[group.table];
            of_table.resize_with(of_table.len().max(group.number + 1), KeptPlane::default);
            let plane = &mut of_table[group.number];
            let blocks = group.size.iter().product::<u32>() as usize;
            plane.codes.resize(blocks, 0);
            plane.bits.resize(blocks, 0);
            self.at(group, settled.books, price, |block, kept| {
                (plane.codes[block], plane.bits[block]) = (kept.codes, kept.bits);
            });
        }
        (planes, sum)
    }
}
