//! The groups of the payload `variable`, for the plan of what each block keeps.

use cvr_groups::{Candidate, CodedBlocks, Plan, Plane as Placed, Ways};

use super::cost::fixed_bits;
use super::escapes::AllWays;
use crate::encode::closed_loop::Plane;
use crate::encode::domain::Domain;
use crate::encode::train::book::Book;
use crate::encode::work::{Coded, Work};

/// The blocks of a plane, and the ways to escape them.
#[derive(Copy, Clone, Debug)]
pub struct Blocks<'a> {
    plane: &'a Plane,
    ways: &'a Ways,
}

impl CodedBlocks for Blocks<'_> {
    fn books(&self) -> usize {
        self.plane.books
    }

    #[inline]
    fn mean(&self, block: usize) -> u32 {
        self.plane.means[block]
    }

    #[inline]
    fn error(&self, block: usize, codes: usize) -> f64 {
        self.plane.errors[block * (self.plane.books + 1) + codes].into()
    }

    #[inline]
    fn ways(&self, block: usize) -> &[Candidate] {
        self.ways.of(block)
    }
}

/// The groups of some codes.
#[must_use]
pub fn groups<'a>(work: &Work<'_>, coded: &'a [Vec<Coded>], ways: &'a AllWays) -> Plan<Blocks<'a>> {
    let tables = || coded.iter().flatten();
    let of_table = |(table, (coded, domain)): (usize, (&'a Coded, &Domain))| {
        let size = domain.size;
        let placed = move |(number, plane): (usize, &'a Plane)| {
            let blocks = Blocks { plane, ways: &ways[table][number] };
            Placed { blocks, size, table, number }
        };
        coded.planes.iter().enumerate().map(placed)
    };
    let planes = tables().zip(work.domains()).enumerate().flat_map(of_table);
    let most = tables().map(|c| c.books.len()).max().unwrap_or(0);
    let first = |c: &'a Coded, count: usize| c.books.iter().take(count);
    let codewords = |m| tables().flat_map(|c| first(c, m)).map(Book::size).sum::<usize>();
    let width = |c, m| first(c, m).map(Book::width).max().unwrap_or(0);
    let fixed = (0..=most).map(|m| fixed_bits(work, m as u32, codewords(m) as f64)).collect();
    let widths = tables().map(|c| (0..=most).map(|m| width(c, m)).collect()).collect();
    Plan::new(planes, fixed, widths, 1)
}
