//! Cells of an earlier run that do not stand for a run of theirs, and what a user should know of them.

use std::collections::BTreeMap;

use super::names::CELLS;

/// Why a file must not replace a run of its cell.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Flaw {
    /// There is none.
    Absent,
    /// Its inputs have changed, or the cell failed. The file itself is valid.
    Outdated,
    /// It carries no digest.
    Unsealed,
    /// It is no whole record, or not as it was written.
    Damaged,
    /// It is the record of another cell, or of another device.
    OtherCell,
    /// One of its pictures or tables is missing or has changed.
    Files,
}

impl Flaw {
    /// A message for the user.
    const fn said(self) -> Option<&'static str> {
        match self {
            Self::Absent | Self::Outdated => None,
            Self::Unsealed => Some("their records carry no digest, as those of version 0.1.0"),
            Self::Damaged => Some("their records are not as they were written"),
            Self::OtherCell => Some("their records are of other cells"),
            Self::Files => Some("their pictures or tables are not as they were written"),
        }
    }
}

/// Cells of an earlier run with an unexpected flaw, by flaw.
#[derive(Clone, Debug, Default)]
pub struct Flawed(BTreeMap<Flaw, Vec<String>>);

impl Flawed {
    /// Enters the cell of this name.
    pub fn add(&mut self, flaw: Flaw, id: &str) {
        self.0.entry(flaw).or_default().push(format!("{CELLS}/{id}.json"));
    }

    /// A line for each flaw.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        self.0.iter().filter_map(|(flaw, names)| {
            let more = names.len() - 1;
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            Some(format!("{} cell(s) are run again: {} ({}{more})", names.len(), flaw.said()?, names[0]))
        })
    }
}
