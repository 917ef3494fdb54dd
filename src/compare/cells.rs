//! Matching the cells of two runs.

use std::collections::BTreeMap;

use super::identity::Identity;
use super::side::Side;
use crate::experiment::records::record::{Record, Status};

/// The same cell in two runs.
#[derive(Copy, Clone, Debug)]
pub struct Matched<'a> {
    /// The cell of the first run.
    pub first: &'a Record,
    /// The cell of the other run.
    pub other: &'a Record,
}

/// Two runs, cell by cell.
#[derive(Clone, Debug, Default)]
pub struct Pairing<'a> {
    /// Cells that ended well in both, in the order of the first run.
    pub both: Vec<Matched<'a>>,
    /// Cells of both that failed in either.
    pub failed: Vec<Matched<'a>>,
    /// Cells of the first run alone.
    pub only_first: Vec<&'a Record>,
    /// Cells of the other run alone.
    pub only_other: Vec<&'a Record>,
}

impl<'a> Pairing<'a> {
    /// All cells, those of both runs as the first has them.
    #[must_use]
    pub fn records(&self) -> Vec<&'a Record> {
        let matched = self.both.iter().chain(&self.failed).map(|m| m.first);
        matched.chain(self.only_first.iter().chain(&self.only_other).copied()).collect()
    }
}

/// Matches the cells of two runs. Where one run has several of one identity (a volume under two names), they are matched
/// in their order.
#[must_use]
pub fn pair<'a>(first: &'a Side, other: &'a Side) -> Pairing<'a> {
    let mut waiting: BTreeMap<&Identity, Vec<&Record>> = BTreeMap::new();
    for (identity, record) in other.cells.iter().rev() {
        waiting.entry(identity).or_default().push(record);
    }
    let mut pairing = Pairing::default();
    for (identity, first) in &first.cells {
        match waiting.get_mut(identity).and_then(Vec::pop) {
            None => pairing.only_first.push(first),
            Some(other) if first.status == Status::Ok && other.status == Status::Ok => {
                pairing.both.push(Matched { first, other });
            }
            Some(other) => pairing.failed.push(Matched { first, other }),
        }
    }
    let left: Vec<&Record> = waiting.into_values().flatten().collect();
    let is_left = |record: &&Record| left.iter().any(|l| std::ptr::eq(*l, *record));
    pairing.only_other = other.cells.iter().map(|(_, record)| record).filter(is_left).collect();
    pairing
}
