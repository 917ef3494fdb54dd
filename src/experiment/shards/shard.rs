//! Shards: the cells of an experiment, distributed over several runs.

use std::fmt;
use std::str::FromStr;

use cvr_core::pipeline::Cell;

/// One of several shares of an experiment, written `1/4`.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Shard {
    /// The cells of this share, in their order.
    ///
    /// Groups of one volume, codec and settings are distributed in turn and never split, so no stream is encoded in two
    /// shards. All shards together hold each cell once. If there are fewer groups than shards, some are empty.
    #[must_use]
    pub fn select(&self, cells: Vec<Cell>) -> Vec<Cell> {
        let mut group = 0;
        let mut last: Option<Cell> = None;
        let mut mine = |cell: &Cell| {
            if last.as_ref().is_some_and(|last| !same_group(last, cell)) {
                group += 1;
            }
            last = Some(cell.clone());
            group % self.count == self.index
        };
        cells.into_iter().filter(|cell| mine(cell)).collect()
    }
}

/// Whether two cells share an encoded stream.
#[must_use]
pub fn same_group(a: &Cell, b: &Cell) -> bool {
    a.volume == b.volume && a.codec == b.codec && a.settings == b.settings
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let help = || format!("`{text}`: write which shard of how many, as 1/4");
        let (index, count) = text.split_once('/').ok_or_else(help)?;
        let index: usize = index.parse().map_err(|_| help())?;
        let count: usize = count.parse().map_err(|_| help())?;
        if index == 0 || index > count {
            return Err(format!("`{text}`: shards count from 1 to {count}"));
        }
        Ok(Self { index: index - 1, count })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index + 1, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::codec::{Settings, Site};
    use cvr_core::render::Filter;

    fn cells() -> Vec<Cell> {
        let mut cells = Vec::new();
        for volume in ["a", "b", "c"] {
            for codec in ["raw", "s3dc"] {
                for site in Site::ALL {
                    cells.push(Cell {
                        volume: volume.to_owned(),
                        codec: codec.to_owned(),
                        settings: Settings::default(),
                        scene: "s".to_owned(),
                        renderer: "r".to_owned(),
                        site,
                        filter: Filter::Linear,
                        skipping: false,
                        stages: None,
                        resolution: 0,
                    });
                }
            }
        }
        cells
    }

    #[test]
    fn shards_are_disjoint_whole_and_hold_everything() {
        let all = cells();
        for count in 1..=9 {
            let shares: Vec<Vec<Cell>> = (1..=count)
                .map(|i| format!("{i}/{count}").parse::<Shard>().unwrap().select(all.clone()))
                .collect();
            assert_eq!(shares.iter().map(Vec::len).sum::<usize>(), all.len());
            for cell in &all {
                let holds = |share: &&Vec<Cell>| share.contains(cell);
                assert_eq!(shares.iter().filter(holds).count(), 1, "{}", cell.id());
                let of_group = |share: &&Vec<Cell>| share.iter().any(|c| same_group(c, cell));
                assert_eq!(shares.iter().filter(of_group).count(), 1, "{} is split", cell.id());
            }
            let (most, least) = (shares.iter().map(Vec::len).max(), shares.iter().map(Vec::len).min());
            assert!(most.unwrap() - least.unwrap() <= Site::ALL.len(), "dealt out evenly");
        }
    }

    #[test]
    fn only_shards_that_exist_can_be_named() {
        assert_eq!("2/3".parse::<Shard>().unwrap().to_string(), "2/3");
        for wrong in ["", "1", "0/2", "3/2", "1/0", "-1/2", "a/b", "1/2/3", "1.5/2"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
