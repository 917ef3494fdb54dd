//! A training set that contains rare blocks: it is drawn by strata of the blocks' variance.
//!
//! Most blocks of many volumes are flat, and a uniform choice holds few of the edges. Here half of the choice is spread
//! evenly over strata. The variances of a stratum's blocks differ by a factor of at most 16. Each block weighs as many
//! blocks as it represents, so the expectation of a weighted sum equals that of a uniform choice (Cochran 1977, chapter
//! 5). The volume is read twice and never held in memory.

use std::collections::BTreeMap;
use std::ops::Range;

use cvr_core::codec::{Block, EncodeError, Progress};
use cvr_core::kit::BlockRow;
use cvr_core::volume::{BrickSource, FrameIndex};
use rayon::prelude::*;

use super::training::{Wanted, read_wanted};
use crate::{Vectors, sample};

/// Strata at most: the flattest one takes all blocks below.
const MOST: usize = 8;
/// Rows of blocks read in one step. Progress is reported between steps.
const STEP: usize = 256;

/// A row of blocks, and the number of blocks of each class.
struct Counted {
    frame: FrameIndex,
    by: u32,
    bz: u32,
    classes: BTreeMap<i32, u64>,
}

/// As [`super::training_vectors`], but drawn by strata.
///
/// # Errors
/// Those of reading, and when `run` was cancelled.
pub fn stratified_training_vectors(
    source: &dyn BrickSource,
    block: Block,
    frames: Range<u32>,
    count: u64,
    seed: u64,
    run: &Progress<'_>,
) -> Result<Vectors, EncodeError> {
    let grid = block.grid(source.layout().extent);
    let lines = (0..grid.z()).flat_map(|bz| (0..grid.y()).map(move |by| (by, bz)));
    let places: Vec<(FrameIndex, u32, u32)> =
        frames.flat_map(|f| lines.clone().map(move |(by, bz)| (FrameIndex(f), by, bz))).collect();
    let mut rows: Vec<Counted> = Vec::with_capacity(places.len());
    for step in places.chunks(STEP) {
        let counted = |&(frame, by, bz): &(FrameIndex, u32, u32)| {
            let mut classes = BTreeMap::new();
            for class in row_classes(source, block, grid.x(), frame, by, bz)? {
                *classes.entry(class).or_insert(0) += 1;
            }
            Ok(Counted { frame, by, bz, classes })
        };
        let parts: Vec<Counted> = step.par_iter().map(counted).collect::<Result<_, EncodeError>>()?;
        rows.extend(parts);
        run.advance(0)?;
    }
    let top = rows.iter().filter_map(|row| row.classes.keys().next_back().copied()).max().unwrap_or(0);
    let stratum = |class: i32| MOST - 1 - ((i64::from(top) - i64::from(class)).min(MOST as i64 - 1) as usize);
    let mut sizes = [0; MOST];
    rows.iter().flat_map(|row| &row.classes).for_each(|(class, n)| sizes[stratum(*class)] += n);
    let all: u64 = sizes.iter().sum();
    let allotted = sample::allot(&sizes, count);
    // Numbers within each stratum, ascending; one more seed for each.
    let drawn: Vec<Vec<u64>> = (0..MOST)
        .map(|s| sample::choose(sizes[s], allotted[s], seed.wrapping_mul(MOST as u64).wrapping_add(s as u64)))
        .collect();
    let part = count.min(all) as f64 / all as f64;
    let weights: Vec<f64> = (0..MOST).map(|s| part * sizes[s] as f64 / allotted[s].max(1) as f64).collect();
    let mut firsts = [0_u64; MOST];
    let mut wanted = Vec::new();
    for row in rows {
        let mut ends = firsts;
        row.classes.iter().for_each(|(class, n)| ends[stratum(*class)] += n);
        wanted.push((row, std::mem::replace(&mut firsts, ends), ends));
    }
    let chosen = |(row, firsts, ends): &(Counted, [u64; MOST], [u64; MOST])| {
        let of = |s: usize| {
            let place = |end: u64| drawn[s].partition_point(|n| *n < end);
            &drawn[s][place(firsts[s])..place(ends[s])]
        };
        if (0..MOST).all(|s| of(s).is_empty()) {
            return Ok(None);
        }
        let (mut next, mut blocks) = (*firsts, Vec::new());
        let classes = row_classes(source, block, grid.x(), row.frame, row.by, row.bz)?;
        for (bx, class) in (0..).zip(classes) {
            let s = stratum(class);
            if of(s).binary_search(&next[s]).is_ok() {
                blocks.push((bx, weights[s]));
            }
            next[s] += 1;
        }
        Ok(Some(Wanted { frame: row.frame, by: row.by, bz: row.bz, blocks }))
    };
    let rows: Vec<Option<Wanted>> = wanted.par_iter().map(chosen).collect::<Result<_, EncodeError>>()?;
    let rows: Vec<Wanted> = rows.into_iter().flatten().collect();
    read_wanted(source, block, &rows, run)
}

/// The class of each block of a row: the binary exponent of its variance, divided by four. Flat blocks are in the
/// lowest class.
fn row_classes(
    source: &dyn BrickSource,
    block: Block,
    blocks: u32,
    frame: FrameIndex,
    by: u32,
    bz: u32,
) -> Result<Vec<i32>, EncodeError> {
    let row = BlockRow::read(source, block, frame, by, bz)?;
    let mut vector = Vec::new();
    let class = |bx| {
        vector.clear();
        row.append(bx, &mut vector);
        let mean = vector.iter().map(|v| f64::from(*v)).sum::<f64>() / vector.len() as f64;
        let variance =
            vector.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / vector.len() as f64;
        let exponent = ((variance.to_bits() >> 52) & 0x7ff) as i32;
        exponent.div_euclid(4)
    };
    Ok((0..blocks).map(class).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::{DenseVolume, Extent, SampleType, Samples, VolumeLayout};

    /// Flat, except for ten blocks of 2³ with an edge. The border cuts the last of them.
    fn volume() -> DenseVolume {
        let extent = Extent::new(39, 40, 40).unwrap();
        let layout = VolumeLayout::scalar(extent, SampleType::U8);
        let mut samples = vec![7_u8; layout.samples() as usize];
        for i in 0..10_usize {
            samples[(4 * i * 40 + 4 * i) * 39 + 38 - 4 * i] = 200;
        }
        DenseVolume::new(layout, Samples::U8(samples)).unwrap()
    }

    #[test]
    fn rare_blocks_are_there_and_weights_make_up_for_them() {
        let (volume, block): (_, Block) = (volume(), "2".parse().unwrap());
        let draw = |count, seed| {
            stratified_training_vectors(&volume, block, 0..1, count, seed, &Progress::silent()).unwrap()
        };
        let vectors = draw(100, 1);
        assert_eq!(vectors.len(), 100);
        let edges: Vec<usize> = (0..100).filter(|i| vectors.vector(*i).contains(&200.0)).collect();
        assert_eq!(edges.len(), 10, "all of ten blocks in 8000");
        let whole: Vec<f64> = edges.iter().map(|i| vectors.weight(*i) * 80.0).collect();
        assert!(whole.iter().all(|w| (w - 1.0).abs() < 1e-9 || (w - 0.5).abs() < 1e-9), "{whole:?}");
        // 7600 whole blocks and 400 halves have on average the weight of 100 of them.
        let expected = 100.0 * 7800.0 / 8000.0;
        assert!((vectors.total_weight() - expected).abs() < 3.0, "{}", vectors.total_weight());
        assert_eq!(draw(100, 1), draw(100, 1));
        let all =
            super::super::training_vectors(&volume, block, 0..1, 1 << 20, 1, &Progress::silent()).unwrap();
        assert_eq!(draw(1 << 20, 1), all, "all blocks are all blocks");
    }
}
