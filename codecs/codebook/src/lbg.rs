//! LBG (Linde, Buzo and Gray 1980). Codewords are quantised in every round, so vectors choose among the codewords that
//! the decoder uses.

use cvr_core::codec::{Cancelled, Progress};
use std::collections::HashMap;

use rayon::prelude::*;

use crate::carry::{Carried, Step};
use crate::cells::Cells;
use crate::distance::squared;
use crate::{Codebook, Nearest, Vectors};

/// When to stop.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Stop {
    /// Rounds, at most.
    pub rounds: u32,
    /// Training stops after a round that lowers the distortion by at most this fraction.
    pub gain: f64,
}

/// What training yields.
#[derive(Clone, Debug)]
pub struct Trained {
    /// The codewords. Each is nearest to some training vector.
    pub codebook: Codebook,
    /// Weighted squared distance of the training vectors to their nearest codewords.
    pub distortion: f64,
    /// Number of rounds.
    pub rounds: u32,
}

/// Moves every codeword to the mean of its nearest vectors, round after round. Codewords without vectors are dropped.
/// They are replaced, up to `size`, by the farthest vector of each cell of largest distortion, if a codeword there
/// would be nearer. The distortion never rises. `cells` may give a codeword of `first` near each vector. It saves time
/// and does not change the result.
///
/// # Errors
/// When `run` was cancelled.
///
/// # Panics
/// When there are no vectors or no codewords, or their dimensions differ.
pub fn refine(
    vectors: &Vectors,
    first: Codebook,
    cells: Option<&[u32]>,
    size: usize,
    stop: Stop,
    run: &Progress<'_>,
) -> Result<Trained, Cancelled> {
    assert!(!vectors.is_empty(), "no vectors to train on");
    let mut codebook = first;
    let mut carried = match cells {
        Some(cells) => Carried::guessed(vectors, &codebook, cells),
        None => Carried::searched(vectors, &codebook),
    };
    let mut changed = vec![true; codebook.size()];
    let mut before: Option<f64> = None;
    for round in 0.. {
        run.advance(0)?;
        let nearest = &carried.nearest;
        let cells = Cells::new(nearest, codebook.size());
        let distortions: Vec<f64> =
            (0..codebook.size()).into_par_iter().map(|k| cells.distortion(k, vectors, nearest)).collect();
        let distortion: f64 = distortions.iter().sum();
        let settled = before.is_some_and(|before| before - distortion <= stop.gain * before);
        if round >= stop.rounds || distortion == 0.0 || settled {
            let codebook = codebook.kept(|k| !cells.members(k).is_empty());
            return Ok(Trained { codebook, distortion, rounds: round });
        }
        before = Some(distortion);
        let mut moved = Moved::new(&codebook, &cells, vectors, &changed);
        fill(&mut moved.codebook, size, vectors, nearest, &cells, &distortions);
        codebook = moved.codebook;
        moved.moves.resize(codebook.size(), f64::INFINITY);
        changed = carried.advance(vectors, &cells, &codebook, &moved.steps, &moved.moves);
        moved.united.iter().for_each(|k| changed[*k as usize] = true);
    }
    unreachable!("a round returns")
}

/// Codewords moved to the means of their cells.
struct Moved {
    codebook: Codebook,
    /// The fate of each former codeword. Undefined for one without members.
    steps: Vec<Step>,
    /// The move of each codeword.
    moves: Vec<f64>,
    /// Codewords that took over another one's vectors.
    united: Vec<u32>,
}

impl Moved {
    /// A codeword moves if its cell `changed`. Equal codewords become one, at the place of the first.
    fn new(codebook: &Codebook, cells: &Cells, vectors: &Vectors, changed: &[bool]) -> Self {
        let quantiser = codebook.quantiser();
        let codes = |k: usize| {
            if cells.members(k).is_empty() {
                return None;
            }
            let code = |mean: f64| quantiser.code(mean);
            Some(if changed[k] {
                cells.mean(k, vectors).into_iter().map(code).collect()
            } else {
                codebook.codes_of(k).to_vec()
            })
        };
        let all: Vec<Option<Vec<u16>>> = (0..codebook.size()).into_par_iter().map(codes).collect();
        let mut moved = Self {
            codebook: codebook.kept(|_| false),
            steps: Vec::with_capacity(all.len()),
            moves: Vec::new(),
            united: Vec::new(),
        };
        let mut places: HashMap<Vec<u16>, u32> = HashMap::with_capacity(all.len());
        for (k, codes) in all.into_iter().enumerate() {
            let Some(codes) = codes else {
                moved.steps.push(Step { index: 0, moved: true });
                continue;
            };
            let next = moved.moves.len() as u32;
            let has_moved = codes != codebook.codes_of(k);
            let index = *places.entry(codes).or_insert_with_key(|codes| {
                moved.codebook.push(codes);
                moved.moves.push(0.0);
                next
            });
            if index != next {
                moved.united.push(index);
            }
            if has_moved {
                let way = squared(codebook.codeword(k), moved.codebook.codeword(index as usize), None).sqrt();
                moved.moves[index as usize] = moved.moves[index as usize].max(way);
            }
            moved.steps.push(Step { index, moved: has_moved });
        }
        moved
    }
}

/// Fills the codebook up to `size` with vectors far from their codewords, one per cell, cells of largest distortion
/// first.
fn fill(
    codebook: &mut Codebook,
    size: usize,
    vectors: &Vectors,
    nearest: &[Nearest],
    cells: &Cells,
    distortions: &[f64],
) {
    let missing = size.saturating_sub(codebook.size());
    if missing == 0 {
        return;
    }
    let mut worst: Vec<usize> = (0..distortions.len()).filter(|k| distortions[*k] > 0.0).collect();
    worst.sort_by(|a, b| distortions[*b].total_cmp(&distortions[*a]).then(a.cmp(b)));
    let quantiser = codebook.quantiser();
    for k in worst.into_iter().take(missing) {
        let Some(i) = cells.worst(k, vectors, nearest) else { continue };
        let vector = vectors.vector(i);
        let codes: Vec<u16> = vector.iter().map(|x| quantiser.code((*x).into())).collect();
        let values: Vec<f32> = codes.iter().map(|c| quantiser.value((*c).into())).collect();
        if squared(vector, &values, None) < nearest[i].distance {
            codebook.push(&codes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Quantiser, Search};
    use cvr_core::volume::ValueRange;

    const STOP: Stop = Stop { rounds: 100, gain: 0.0 };

    fn bytes() -> Quantiser {
        Quantiser::over(ValueRange { min: 0.0, max: 255.0 }, 8, true).unwrap()
    }

    fn noise(count: usize, dimension: usize) -> Vectors {
        let value = |i: usize| ((i as u32).wrapping_mul(0x9e37_79b9) >> 24) as f32;
        Vectors::of_rows(dimension, (0..count * dimension).map(value).collect())
    }

    #[test]
    fn more_rounds_never_raise_the_distortion() {
        let vectors = noise(3000, 3);
        let first = Codebook::nearest_to(&[10.0; 3], 3, bytes());
        let mut before = f64::INFINITY;
        for rounds in 0..12 {
            let stop = Stop { rounds, gain: 0.0 };
            let trained = refine(&vectors, first.clone(), None, 64, stop, &Progress::silent()).unwrap();
            assert!(trained.distortion <= before, "round {rounds}: {} after {before}", trained.distortion);
            before = trained.distortion;
        }
    }

    #[test]
    fn it_ends_with_the_round_that_gains_too_little() {
        let vectors = noise(3000, 3);
        let first = Codebook::nearest_to(&[10.0, 20.0, 30.0, 200.0, 100.0, 50.0], 3, bytes());
        let rounds = |gain| {
            let stop = Stop { rounds: 1000, gain };
            refine(&vectors, first.clone(), None, 64, stop, &Progress::silent()).unwrap().rounds
        };
        assert_eq!(rounds(1.0), 1, "no round gains all");
        let (hundredth, thousandth, nothing) = (rounds(1e-2), rounds(1e-3), rounds(0.0));
        assert!(1 < hundredth && hundredth < thousandth && thousandth <= nothing && nothing < 1000);
    }

    #[test]
    fn what_it_reports_is_the_distortion_of_what_it_returns() {
        let vectors = noise(1000, 4);
        let first = Codebook::nearest_to(&[100.0, 7.0, 90.0, 30.0, 1.0, 2.0, 3.0, 4.0], 4, bytes());
        let trained = refine(&vectors, first, None, 40, STOP, &Progress::silent()).unwrap();
        assert_eq!(trained.codebook.size(), 40);
        let nearest = Search::new(&trained.codebook, None).all(&vectors);
        let distortion: f64 = nearest.iter().map(|n| n.distance).sum();
        assert!((distortion - trained.distortion).abs() <= 1e-9 * distortion);
        for k in 0..40 {
            assert!(nearest.iter().any(|n| n.index == k), "codeword {k} is of no use");
        }
    }

    #[test]
    fn codewords_of_no_use_become_vectors_that_need_one() {
        let vectors = Vectors::of_rows(1, vec![1.0, 2.0, 101.0, 103.0]);
        let first = Codebook::nearest_to(&[0.0, 250.0, 240.0], 1, bytes());
        let trained = refine(&vectors, first, None, 4, STOP, &Progress::silent()).unwrap();
        assert_eq!(trained.distortion, 0.0);
        assert_eq!(trained.codebook.size(), 4);
    }

    #[test]
    fn a_codebook_is_no_larger_than_its_levels_allow() {
        // 200 vectors between two levels of the quantiser: 2 codewords serve as well as 200.
        let quantiser = Quantiser::over(ValueRange { min: 0.0, max: 255.0 }, 8, true).unwrap();
        let vectors = Vectors::of_rows(1, (0..200).map(|i| 7.0 + i as f32 / 200.0).collect());
        let first = Codebook::nearest_to(&[7.5], 1, quantiser);
        let trained = refine(&vectors, first, None, 200, STOP, &Progress::silent()).unwrap();
        assert!(trained.codebook.size() <= 2, "{} codewords", trained.codebook.size());
    }

    #[test]
    fn weights_pull_the_mean() {
        let mut vectors = Vectors::new(1);
        vectors.push(&[0.0], 3.0);
        vectors.push(&[100.0], 1.0);
        let first = Codebook::nearest_to(&[9.0], 1, bytes());
        let trained = refine(&vectors, first, None, 1, STOP, &Progress::silent()).unwrap();
        assert_eq!(trained.codebook.values(), [25.0]);
    }

    #[test]
    fn a_cancelled_run_stops() {
        let flag = std::sync::atomic::AtomicBool::new(true);
        let run = Progress::new(|_| {}, Some(&flag));
        let first = Codebook::nearest_to(&[9.0], 1, bytes());
        assert!(refine(&noise(9, 1), first, None, 1, STOP, &run).is_err());
    }
}
