//! Joint training: each codebook once more, on what *all* others leave.
//!
//! The greedy pass trains a stage on what those before it leave, and no stage knows those behind it. Here each codeword moves
//! to the mean of what the codewords of all other stages leave of its blocks, which is the least squared error for these
//! codes; then all blocks are coded anew (Chan, Gupta and Gersho 1992, joint codebook optimisation).

use cvr_codebook::{Cells, Vectors};
use cvr_core::codec::{Cancelled, Progress};
use rayon::prelude::*;

use super::stage::{Stage, subtract};
use crate::stream::Entries;

/// A round that lowers the distortion by less than this part of it is the last.
const GAIN: f64 = 1e-3;

/// Codes of the training blocks under some codebooks.
struct Coded {
    codes: Vec<u32>,
    /// What is left of each block.
    left: Vectors,
    /// Weighted squared error of all blocks.
    distortion: f64,
}

impl Coded {
    fn of(vectors: &Vectors, stages: &[Stage], codes: Vec<u32>) -> Self {
        let mut left = vectors.clone();
        let dimension = vectors.dimension();
        let rows = left.values_mut().par_chunks_exact_mut(dimension);
        rows.zip(codes.par_chunks_exact(stages.len())).for_each(|(row, codes)| {
            for (stage, code) in stages.iter().zip(codes) {
                subtract(row, stage.codebook.codeword(*code as usize));
            }
        });
        let square = |i: usize| left.vector(i).iter().map(|v| f64::from(*v) * f64::from(*v)).sum::<f64>();
        let distortion = (0..left.len()).map(|i| left.weight(i) * square(i)).sum();
        Self { codes, left, distortion }
    }
}

/// Trains all stages together for at most `rounds` rounds, as long as they gain; returns the rounds that did. `code` finds the
/// codes of all vectors under some codebooks. Stages from `zero` on have the zero vector as codeword 0, which stays.
///
/// # Errors
/// When `run` was cancelled.
pub fn jointly(
    vectors: &Vectors,
    stages: &mut Vec<Stage>,
    entries: Entries,
    (rounds, zero): (u32, usize),
    run: &Progress<'_>,
    code: impl Fn(&[Stage]) -> Vec<u32>,
) -> Result<u32, Cancelled> {
    if rounds == 0 || stages.len() <= 1 {
        return Ok(0);
    }
    let mut coded = Coded::of(vectors, stages, code(stages));
    for round in 0..rounds {
        run.advance(0)?;
        let before = coded.distortion;
        let moved = moved(stages, coded, entries, zero);
        coded = Coded::of(vectors, &moved, code(&moved));
        // Codes of a beam are not the best that there are, and codewords are rounded: a round may lose.
        if coded.distortion >= before {
            return Ok(round);
        }
        *stages = moved;
        if before - coded.distortion <= GAIN * before {
            return Ok(round + 1);
        }
    }
    Ok(rounds)
}

/// The stages with each codeword at the mean of what all other stages leave of its blocks.
fn moved(stages: &[Stage], coded: Coded, entries: Entries, zero: usize) -> Vec<Stage> {
    let mut moved = Vec::with_capacity(stages.len());
    let Coded { codes, mut left, .. } = coded;
    let dimension = left.dimension();
    for (s, stage) in stages.iter().enumerate() {
        let of_stage = codes.iter().skip(s).step_by(stages.len()).copied();
        let cells = Cells::of(of_stage.clone(), stage.codebook.size());
        let codeword = |k: usize| {
            let old = stage.codebook.codeword(k).iter().map(|v| f64::from(*v));
            if cells.members(k).is_empty() || (s >= zero && k == 0) {
                return old.collect::<Vec<_>>();
            }
            old.zip(cells.mean(k, &left)).map(|(old, left)| old + left).collect()
        };
        let values: Vec<f64> = (0..stage.codebook.size()).into_par_iter().flat_map_iter(codeword).collect();
        let new = Stage::of(&values, dimension, entries);
        let of_stage: Vec<u32> = of_stage.collect();
        let rows = left.values_mut().par_chunks_exact_mut(dimension);
        rows.zip(&of_stage).for_each(|(row, code)| {
            let (old, new) = (stage.codebook.codeword(*code as usize), new.codebook.codeword(*code as usize));
            row.iter_mut().zip(old.iter().zip(new)).for_each(|(v, (old, new))| *v += old - new);
        });
        moved.push(new);
    }
    moved
}
