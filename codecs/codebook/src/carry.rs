//! Nearest codewords carried from round to round. The result equals that of a [`Search`], but bounds make most of the
//! search unnecessary.
//!
//! For every vector three things are known: its former nearest codeword, the distance `u` to that codeword's new place,
//! and a lower bound `l` of the distances to all other codewords (Hamerly 2010). With the distances between codewords,
//!
//! * a codeword farther than 2u from the vector's own cannot be nearer (Elkan 2003, lemma 1);
//! * each codeword within 2u has moved by at most the largest move of *these*: while `u < l − that`, none of them is
//!   nearer. Codewords that moved far, or are new, affect only the cells around them.
//!
//! The remaining vectors are scored cell by cell ([`crate::scores`]), in coordinates relative to the cell's codeword,
//! and only against the codewords within 2u. Distances are small there, and so is the rounding bound. Bounds are
//! widened by [`SLACK`], far beyond the rounding of a sum in double precision. Bounds never decide ties.

use rayon::prelude::*;

use crate::cells::Cells;
use crate::distance::squared;
use crate::scores::{ROWS, margin, place_of, product, two_lowest};
use crate::wide::wide;
use crate::{Codebook, Nearest, Search, Vectors};

/// Relative width added to bounds.
const SLACK: f64 = 1e-9;
/// Cells whose codewords are compared with all others in one matrix product.
const CELLS: usize = 16;
/// Scores of one matrix product: 256 KiB.
const SCORES: usize = 1 << 16;
/// Least number of vectors in a matrix product, even if scores of many codewords then fill more.
const LEAST_ROWS: usize = 32;

/// The fate of a codeword of the former round.
#[derive(Copy, Clone, Debug)]
pub struct Step {
    /// Its index now.
    pub index: u32,
    /// Whether it stands elsewhere.
    pub moved: bool,
}

/// Knowledge about one vector.
#[derive(Copy, Clone, Debug)]
struct Known {
    nearest: Nearest,
    /// All other codewords are at least this far.
    others: f64,
}

/// Knowledge about all vectors.
#[derive(Clone, Debug)]
pub struct Carried {
    /// Codeword and squared distance.
    pub nearest: Vec<Nearest>,
    /// All other codewords are at least this far.
    others: Vec<f64>,
}

/// Codewords about another one.
struct Reach {
    /// Those within the reach, ascending, the one in the middle left out.
    within: Vec<u32>,
    /// No other codeword is nearer to the one in the middle.
    closest: f64,
    /// None beyond the reach is nearer.
    beyond: f64,
    /// The largest move of the codewords within reach.
    drift: f64,
}

/// A vector that bounds leave open.
struct Open {
    /// Its place in the cell.
    place: usize,
    vector: u32,
    /// Distance from the cell's codeword, widened.
    distance: f64,
    square: f64,
}

/// One round's codewords.
pub struct Round<'a> {
    vectors: &'a Vectors,
    search: Search<'a>,
    codebook: &'a Codebook,
    /// The move of each codeword. Infinity for a new one.
    moves: &'a [f64],
}

impl Carried {
    /// From a search over all codewords.
    pub fn searched(vectors: &Vectors, codebook: &Codebook) -> Self {
        let nearest = Search::new(codebook, None).all(vectors);
        Self { others: vec![0.0; nearest.len()], nearest }
    }

    /// From any codeword for each vector. Near ones save time.
    pub fn guessed(vectors: &Vectors, codebook: &Codebook, indices: &[u32]) -> Self {
        let nearest = indices.iter().map(|index| Nearest { index: *index, distance: 0.0 }).collect();
        let mut carried = Self { nearest, others: vec![0.0; indices.len()] };
        let cells = Cells::new(&carried.nearest, codebook.size());
        let steps: Vec<Step> = (0..codebook.size() as u32).map(|index| Step { index, moved: true }).collect();
        carried.advance(vectors, &cells, codebook, &steps, &vec![f64::INFINITY; codebook.size()]);
        carried
    }

    /// Nearest codewords after a round. `cells` are the cells of the former codebook. `steps` gives the fate of each
    /// former codeword with members. `moves` holds the move of each codeword of `codebook`. Returns which codewords
    /// lost or won a vector.
    pub fn advance(
        &mut self,
        vectors: &Vectors,
        cells: &Cells,
        codebook: &Codebook,
        steps: &[Step],
        moves: &[f64],
    ) -> Vec<bool> {
        let round = Round { vectors, search: Search::new(codebook, None), codebook, moves };
        let batch = |first: usize| {
            let old: Vec<usize> =
                (first..steps.len().min(first + CELLS)).filter(|k| !cells.members(*k).is_empty()).collect();
            let middles: Vec<u32> = old.iter().map(|k| steps[*k].index).collect();
            let apart = round.search.apart(&middles);
            let rows = apart.chunks_exact(codebook.size());
            let mut scratch = Scratch::default();
            let of_cell = |(k, apart): (&usize, &[f32])| {
                (*k, round.cell(self, cells.members(*k), steps[*k], apart, &mut scratch))
            };
            old.iter().zip(rows).map(of_cell).collect::<Vec<_>>()
        };
        let firsts: Vec<usize> = (0..steps.len()).step_by(CELLS).collect();
        let done: Vec<_> = firsts.into_par_iter().map(batch).collect();
        let mut changed = vec![false; codebook.size()];
        for (k, found) in done.into_iter().flatten() {
            for (&i, Known { nearest, others }) in cells.members(k).iter().zip(found) {
                if nearest.index != steps[k].index {
                    changed[nearest.index as usize] = true;
                    changed[steps[k].index as usize] = true;
                }
                self.nearest[i as usize] = nearest;
                self.others[i as usize] = others;
            }
        }
        changed
    }
}

impl Round<'_> {
    /// The members of a cell: nearest codewords, and lower bounds of the distances to the others.
    fn cell(
        &self,
        carried: &Carried,
        members: &[u32],
        step: Step,
        apart: &[f32],
        scratch: &mut Scratch,
    ) -> Vec<Known> {
        let own = self.codebook.codeword(step.index as usize);
        let mut squares = vec![0.0; members.len()];
        wide(|| {
            for (square, &i) in squares.iter_mut().zip(members) {
                *square = if step.moved {
                    squared(self.vectors.vector(i as usize), own, None)
                } else {
                    carried.nearest[i as usize].distance
                };
            }
        });
        let farthest = squares.iter().fold(0.0, |a: f64, b| a.max(*b)).sqrt() * (1.0 + SLACK);
        let reach = self.reach(step.index, apart, 2.0 * farthest);
        let mut found = Vec::with_capacity(members.len());
        let mut open = Vec::new();
        for (place, (&vector, &square)) in members.iter().zip(&squares).enumerate() {
            let distance = square.sqrt() * (1.0 + SLACK);
            let kept = carried.others[vector as usize] * (1.0 - SLACK) - reach.drift * (1.0 + SLACK);
            let others = kept.max(reach.closest - distance);
            if distance >= others {
                open.push(Open { place, vector, distance, square });
            }
            let nearest = Nearest { index: step.index, distance: square };
            found.push(Known { nearest, others: others.min(reach.beyond - distance) });
        }
        if open.len() > 2 * ROWS {
            // Sorted by distance, so that a block of vectors needs no larger radius than necessary.
            open.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.place.cmp(&b.place)));
        }
        let mut settled = Vec::with_capacity(open.len());
        if open.len() > 8 * ROWS {
            let block = |scratch: &mut Scratch, open: &[Open]| {
                let mut settled = Vec::with_capacity(open.len());
                self.block(step.index, open, apart, scratch, &mut settled);
                settled
            };
            settled.par_extend(open.par_chunks(ROWS).map_init(Scratch::default, block).flatten_iter());
        } else {
            open.chunks(ROWS).for_each(|open| self.block(step.index, open, apart, scratch, &mut settled));
        }
        for (open, settled) in open.iter().zip(settled) {
            found[open.place] = settled;
        }
        found
    }

    /// `apart` are squared distances between codewords, in spans. They are lower bounds.
    fn reach(&self, middle: u32, apart: &[f32], radius: f64) -> Reach {
        let span = self.search.span();
        let limit = (radius / span).powi(2) * (1.0 + 1e-6);
        let limit = if limit < f64::from(f32::MAX) { limit as f32 } else { f32::MAX };
        wide(|| {
            let (mut within, mut drift) = (Vec::new(), 0.0_f64);
            let (mut closest, mut beyond) = (f32::INFINITY, f32::INFINITY);
            for (first, chunk) in (0..).step_by(16).zip(apart.chunks(16)) {
                let least = chunk.iter().fold(f32::INFINITY, |a, b| if *b < a { *b } else { a });
                if least > limit {
                    beyond = if least < beyond { least } else { beyond };
                    continue;
                }
                for (c, &square) in (first..).zip(chunk) {
                    if square > limit {
                        beyond = beyond.min(square);
                    } else if c != middle {
                        within.push(c);
                        closest = closest.min(square);
                        drift = drift.max(self.moves[c as usize]);
                    }
                }
            }
            let distance = |square: f32| f64::from(square).sqrt() * span * (1.0 - SLACK);
            Reach { within, closest: distance(closest), beyond: distance(beyond), drift }
        })
    }

    /// At most [`ROWS`] members of one cell that bounds do not decide.
    fn block(
        &self,
        middle: u32,
        open: &[Open],
        apart: &[f32],
        scratch: &mut Scratch,
        found: &mut Vec<Known>,
    ) {
        let farthest = open.iter().fold(0.0, |a: f64, o| a.max(o.distance));
        let reach = self.reach(middle, apart, 2.0 * farthest);
        let mut indices = reach.within;
        indices.insert(indices.partition_point(|c| *c < middle), middle);
        let scale = if farthest > 0.0 { 1.0 / farthest } else { 1.0 };
        let own = self.codebook.codeword(middle as usize);
        let width = own.len() + 1;
        let Scratch { operands, rows, scores } = scratch;
        let radius = wide(|| local_codewords(self.codebook, &indices, own, scale, operands));
        // As many vectors in a product as keep the scores near.
        for open in open.chunks((SCORES / indices.len()).clamp(LEAST_ROWS, ROWS)) {
            wide(|| local_vectors(self.vectors, open, own, scale, rows));
            if scores.len() < open.len() * indices.len() {
                scores.resize(open.len() * indices.len(), 0.0);
            }
            let scores = &mut scores[..open.len() * indices.len()];
            product(rows, operands, width, scores);
            wide(|| {
                for (o, scores) in open.iter().zip(scores.chunks_exact(indices.len())) {
                    let margin = margin(own.len(), o.distance * scale, radius);
                    let (nearest, others) = self.settle(o, &indices, middle, scores, margin);
                    let own = o.square * scale * scale * (1.0 - SLACK);
                    let others = (f64::from(others) + own).max(0.0).sqrt() / scale * (1.0 - SLACK);
                    found.push(Known { nearest, others: others.min(reach.beyond - o.distance) });
                }
            });
        }
    }

    /// The nearest codeword, and a lower bound of the scores of all others.
    #[inline(always)]
    fn settle(&self, o: &Open, indices: &[u32], middle: u32, scores: &[f32], margin: f32) -> (Nearest, f32) {
        let [lowest, second] = two_lowest(scores);
        let limit = lowest + margin;
        let measure = |index: u32| {
            let distance = if index == middle {
                o.square
            } else {
                let codeword = self.codebook.codeword(index as usize);
                squared(self.vectors.vector(o.vector as usize), codeword, None)
            };
            Nearest { index, distance }
        };
        if second > limit
            && let Some(place) = place_of(scores, lowest)
        {
            return (measure(indices[place]), second - margin);
        }
        let candidates = indices.iter().zip(scores).filter(|(_, score)| **score <= limit);
        let nearer = |best: Nearest, (index, _): (&u32, &f32)| {
            let other = measure(*index);
            if other.distance < best.distance { other } else { best }
        };
        let none = Nearest { index: middle, distance: f64::INFINITY };
        (candidates.fold(none, nearer), lowest - margin)
    }
}

/// Memory that one block leaves to the next.
#[derive(Default)]
struct Scratch {
    operands: Vec<f32>,
    rows: Vec<f32>,
    scores: Vec<f32>,
}

/// Codewords relative to another one, times −2, followed by the squared norm. Returns the largest norm.
#[inline(always)]
fn local_codewords(
    codebook: &Codebook,
    indices: &[u32],
    own: &[f32],
    scale: f64,
    operands: &mut Vec<f32>,
) -> f64 {
    let width = own.len() + 1;
    let mut largest = 0.0_f64;
    operands.resize(indices.len() * width, 0.0);
    for (operand, index) in operands.chunks_exact_mut(width).zip(indices) {
        let codeword = codebook.codeword(*index as usize);
        for ((o, c), m) in operand.iter_mut().zip(codeword).zip(own) {
            *o = ((f64::from(*c) - f64::from(*m)) * scale) as f32;
        }
        let norm = squared_norm(&operand[..own.len()]);
        operand.iter_mut().for_each(|o| *o *= -2.0);
        operand[own.len()] = norm as f32;
        largest = largest.max(norm);
    }
    largest.sqrt()
}

/// Vectors about a codeword, then 1.
#[inline(always)]
fn local_vectors(vectors: &Vectors, open: &[Open], own: &[f32], scale: f64, rows: &mut Vec<f32>) {
    let width = own.len() + 1;
    rows.resize(open.len() * width, 0.0);
    for (row, o) in rows.chunks_exact_mut(width).zip(open) {
        for ((r, x), m) in row.iter_mut().zip(vectors.vector(o.vector as usize)).zip(own) {
            *r = ((f64::from(*x) - f64::from(*m)) * scale) as f32;
        }
        row[own.len()] = 1.0;
    }
}

/// `Σ v²` in double precision, in lanes.
#[inline(always)]
fn squared_norm(v: &[f32]) -> f64 {
    let mut lanes = [0.0; 8];
    let chunks = v.chunks_exact(8);
    let rest: f64 = chunks.remainder().iter().map(|x| f64::from(*x) * f64::from(*x)).sum();
    for chunk in chunks {
        for (lane, x) in lanes.iter_mut().zip(chunk) {
            *lane += f64::from(*x) * f64::from(*x);
        }
    }
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests;
