//! What groups take and leave, for every number of codebooks that may be kept.

use rayon::prelude::*;

use crate::bits::mean_width;
use crate::choice::{Candidate, Choice, best};
use crate::kept::KeptPlane;
use crate::rate_control::{Aim, Settled, Sum};
use crate::tally::Tally;
use crate::{EDGE, MOST_PLANES};

/// Groups that one thread adds up at a time.
const PART: usize = 256;
/// Most codes of a block, and none.
const COUNTS: usize = 1 << MOST_PLANES;

/// Coded blocks of one channel of a frame, or of all channels together. Blocks are counted x fastest.
pub trait CodedBlocks: Copy + Send + Sync {
    /// Codebooks.
    fn books(&self) -> usize;
    /// Code of the mean of a block.
    fn mean(&self, block: usize) -> u32;
    /// Squared error of a block after so many codes, from none to one of each codebook.
    fn error(&self, block: usize, codes: usize) -> f64;
    /// Ways to escape a block.
    fn ways(&self, block: usize) -> &[Candidate];
}

/// Coded blocks, and where they belong.
#[derive(Copy, Clone, Debug)]
pub struct Plane<C> {
    /// The blocks.
    pub blocks: C,
    /// Blocks along each axis.
    pub size: [u32; 3],
    /// Number of the table.
    pub table: usize,
    /// Number of the plane among those of the table.
    pub number: usize,
}

/// A group of one plane.
#[derive(Debug)]
struct Group<C> {
    plane: Plane<C>,
    /// First block, and blocks along each axis.
    first: [u32; 3],
    cut: [u32; 3],
    base: u32,
    mean_bits: u32,
}

/// All groups of a volume.
#[derive(Debug)]
pub struct Plan<C> {
    groups: Vec<Group<C>>,
    fixed: Vec<f64>,
    widths: Vec<Vec<u32>>,
    parts: u32,
}

/// Positions in a box of `size`, x fastest.
fn positions(size: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let [x, y, z] = size;
    (0..z).flat_map(move |z| (0..y).flat_map(move |y| (0..x).map(move |x| [x, y, z])))
}

/// What one group comes to.
#[derive(Copy, Clone, Default)]
struct Count {
    error: f64,
    tally: Tally,
}

impl<C: CodedBlocks> Group<C> {
    fn of(plane: Plane<C>, group: [u32; 3]) -> Self {
        let first = group.map(|b| b * EDGE);
        let cut = [0, 1, 2].map(|a| EDGE.min(plane.size[a] - first[a]));
        let mut group = Self { plane, first, cut, base: 0, mean_bits: 0 };
        (group.base, group.mean_bits) = mean_width(group.blocks().map(|n| plane.blocks.mean(n)));
        group
    }

    /// Numbers of its blocks in the plane.
    fn blocks(&self) -> impl Iterator<Item = usize> + use<C> {
        let (first, [x, y, _]) = (self.first, self.plane.size);
        positions(self.cut).map(move |p| {
            let [a, b, c] = [0, 1, 2].map(|axis| (first[axis] + p[axis]) as usize);
            (c * y as usize + b) * x as usize + a
        })
    }

    fn at_base(&self, block: usize) -> bool {
        self.plane.blocks.mean(block) == self.base
    }
}

impl<C: CodedBlocks> Plan<C> {
    /// Of some planes. By number of codebooks kept: `fixed` are the bits of all but groups, and `widths` those of a code, by table.
    /// Escapes have so many parts.
    #[must_use]
    pub fn new(
        planes: impl Iterator<Item = Plane<C>>,
        fixed: Vec<f64>,
        widths: Vec<Vec<u32>>,
        parts: u32,
    ) -> Self {
        let of_plane = |plane: Plane<C>| {
            positions(plane.size.map(|s| s.div_ceil(EDGE))).map(move |group| Group::of(plane, group))
        };
        Self { groups: planes.flat_map(of_plane).collect(), fixed, widths, parts }
    }

    fn bits(&self, group: &Group<C>, count: &Count, code_bits: u32) -> f64 {
        32.0 * f64::from(count.tally.words(group.mean_bits, code_bits, self.parts))
    }

    /// By number of codebooks kept: bits of everything and squared error, where every block keeps what pays at a price in
    /// data units.
    #[must_use]
    pub fn sums(&self, price: f64) -> Vec<Sum> {
        let counts = self.fixed.len();
        let prices: Vec<Vec<f64>> =
            self.widths.iter().map(|w| w.iter().map(|w| price * f64::from(*w)).collect()).collect();
        let of_some = |groups: &[Group<C>]| {
            let mut sums = vec![Sum::default(); counts];
            for group in groups {
                // A table may have fewer codebooks than another.
                let (blocks, own) = (&group.plane.blocks, group.plane.blocks.books() + 1);
                let mut found = [Count::default(); COUNTS];
                for block in group.blocks() {
                    let at_base = group.at_base(block);
                    let ways = (blocks.ways(block), price, self.parts);
                    best(
                        |n| blocks.error(block, n),
                        &prices[group.plane.table][..own],
                        ways,
                        |m, kept| {
                            found[m].error += kept.error;
                            found[m].tally.add(at_base, kept.codes.into(), kept.escape());
                        },
                    );
                }
                for (m, sum) in sums.iter_mut().enumerate() {
                    let found = &found[m.min(own - 1)];
                    sum.bits += self.bits(group, found, self.widths[group.plane.table][m]);
                    sum.error += found.error;
                }
            }
            sums
        };
        // Parts of a size that does not depend on the machine: sums are rounded in one order.
        let parts: Vec<Vec<Sum>> = self.groups.par_chunks(PART).map(of_some).collect();
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
    fn at(&self, group: &Group<C>, books: usize, price: f64, mut each: impl FnMut(usize, Choice)) -> Sum {
        let blocks = &group.plane.blocks;
        let books = books.min(blocks.books());
        let width = self.widths[group.plane.table][books];
        let prices = vec![price * f64::from(width); books + 1];
        let mut found = Count::default();
        for block in group.blocks() {
            let mut kept = Choice { codes: 0, bits: 0, error: 0.0 };
            let ways = (blocks.ways(block), price, self.parts);
            best(|n| blocks.error(block, n), &prices, ways, |_, choice| kept = choice);
            found.tally.add(group.at_base(block), kept.codes.into(), kept.escape());
            found.error += kept.error;
            each(block, kept);
        }
        Sum { bits: self.bits(group, &found, width), error: found.error }
    }

    /// What blocks keep, by table and plane, and what that comes to. Many blocks change at the very price that meets the aim, where errors
    /// are integers: groups take what the price beyond it buys, one after the other, as long as the aim is met.
    #[must_use]
    pub fn kept(&self, aim: Aim, settled: &Settled) -> (Vec<Vec<KeptPlane>>, Sum) {
        let of_group = |group: &Group<C>| {
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
            let Plane { table, number, size, .. } = group.plane;
            planes.resize_with(planes.len().max(table + 1), Vec::new);
            let of_table = &mut planes[table];
            of_table.resize_with(of_table.len().max(number + 1), KeptPlane::default);
            let plane = &mut of_table[number];
            let blocks = size.iter().product::<u32>() as usize;
            plane.codes.resize(blocks, 0);
            plane.bits.resize(blocks, 0);
            self.at(group, settled.books, price, |block, kept| {
                (plane.codes[block], plane.bits[block]) = (kept.codes, kept.bits);
            });
        }
        (planes, sum)
    }
}
