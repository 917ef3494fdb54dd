//! Scores of vectors and codewords in single precision: one matrix product, with a bound of its rounding.
//!
//! `‖x − c‖² = ‖x‖² + (‖c‖² − 2 x·c)`: the bracket is the *score*. Vectors get an additional component 1, codewords
//! their squared norm. Codewords whose score lies within the bound of the lowest are *candidates*. One of them is the
//! nearest. Distances in double precision select it.

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2};

use crate::wide::wide;

/// Vectors in one matrix product.
pub const ROWS: usize = 256;
/// Codewords in one matrix product. With [`ROWS`] vectors the scores fill 256 KiB.
pub const COLUMNS: usize = 256;
/// Scores that are compared at once.
const LANES: usize = 16;
/// Half the distance from 1 to the next single.
const UNIT: f64 = 1.0 / (1 << 24) as f64;

/// Largest difference of two codewords' scores that rounding alone can cause, for vectors and codewords of these norms.
/// A sum of n products has an error of at most n·u·Σ|products|, in any order, fused or not (Higham 2002, section 3.1).
/// Operands and norm are rounded once more.
pub fn margin(dimension: usize, norm: f64, radius: f64) -> f32 {
    let terms = (dimension + 6) as f64;
    let products = radius * (2.0 * norm + radius);
    (2.2 * UNIT * terms * products) as f32
}

/// `scores = vectors · operandsᵀ`. All matrices have rows of `width` numbers.
pub fn product(vectors: &[f32], operands: &[f32], width: usize, scores: &mut [f32]) {
    let (rows, columns) = (vectors.len() / width, operands.len() / width);
    let views = (
        ArrayView2::from_shape((rows, width), vectors),
        ArrayView2::from_shape((columns, width), operands),
        ArrayViewMut2::from_shape((rows, columns), scores),
    );
    if let (Ok(vectors), Ok(operands), Ok(mut scores)) = views {
        general_mat_mul(1.0, &vectors, &operands.t(), 0.0, &mut scores);
    } else {
        unreachable!("the shapes follow from the lengths");
    }
}

/// The codewords that may be among the nearest to one vector, in ascending order.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// The lowest scores so far, as many as codewords are wanted, ascending.
    lowest: Vec<f32>,
    margin: f32,
    list: Vec<(u32, f32)>,
}

impl Candidates {
    /// Of which `count` codewords are wanted.
    pub fn new(count: usize) -> Self {
        Self { lowest: vec![f32::INFINITY; count], margin: 0.0, list: Vec::new() }
    }

    /// Those of another vector, none yet; `margin` is that of the vector.
    pub fn begin(&mut self, margin: f32) {
        self.lowest.fill(f32::INFINITY);
        self.list.clear();
        self.margin = margin;
    }

    /// How many codewords are wanted.
    pub const fn wanted(&self) -> usize {
        self.lowest.len()
    }

    /// The score above which no codeword is a candidate.
    fn limit(&self) -> f32 {
        self.lowest.last().copied().unwrap_or(f32::NEG_INFINITY) + self.margin
    }

    /// Keeps a score if it is among the lowest.
    fn keep(&mut self, score: f32) {
        let place = self.lowest.partition_point(|low| *low <= score);
        if place < self.lowest.len() {
            self.lowest[place..].rotate_right(1);
            self.lowest[place] = score;
        }
    }

    /// Adds the scores of the codewords from `first` on.
    pub fn take(&mut self, first: u32, scores: &[f32]) {
        wide(|| {
            let [lowest, _] = two_lowest(scores);
            let mut limit = self.limit();
            if lowest > limit {
                return;
            }
            // Where one is wanted, the limit is known before the scores are looked at one by one.
            let one = self.lowest.len() == 1;
            if one && lowest < self.lowest[0] {
                self.lowest[0] = lowest;
                limit = self.limit();
            }
            for (first, scores) in (first..).step_by(LANES).zip(scores.chunks(LANES)) {
                // Without branches, so that a chunk is one comparison. Few chunks contain a candidate.
                if scores.iter().fold(false, |any, score| any | (*score <= limit)) {
                    for (index, &score) in (first..).zip(scores) {
                        if score <= limit {
                            self.list.push((index, score));
                            if !one {
                                self.keep(score);
                                limit = self.limit();
                            }
                        }
                    }
                }
            }
            self.list.retain(|(_, score)| *score <= limit);
        });
    }

    /// Indices of the candidates, ascending.
    pub fn indices(&self) -> impl Iterator<Item = u32> {
        let limit = self.limit();
        self.list.iter().filter(move |(_, score)| *score <= limit).map(|(index, _)| *index)
    }
}

#[inline(always)]
fn lower(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
fn higher(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The two lowest scores, in lanes that the compiler vectorises.
#[inline(always)]
pub fn two_lowest(scores: &[f32]) -> [f32; 2] {
    let (mut first, mut second) = ([f32::INFINITY; LANES], [f32::INFINITY; LANES]);
    let chunks = scores.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for ((a, b), score) in first.iter_mut().zip(&mut second).zip(chunk) {
            *b = lower(*b, higher(*a, *score));
            *a = lower(*a, *score);
        }
    }
    let mut two = [f32::INFINITY; 2];
    for score in first.iter().chain(&second).chain(rest) {
        two = [lower(two[0], *score), lower(two[1], higher(two[0], *score))];
    }
    two
}

/// The first position of a score.
#[inline(always)]
pub fn place_of(scores: &[f32], wanted: f32) -> Option<usize> {
    for (first, chunk) in (0..).step_by(LANES).zip(scores.chunks(LANES)) {
        if chunk.iter().fold(false, |any, score| any | (*score == wanted)) {
            return chunk.iter().position(|score| *score == wanted).map(|place| first + place);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_lowest_are_those_of_a_sorted_list() {
        for count in 1..100_usize {
            let mut scores: Vec<f32> = (0..count).map(|i| ((i * 7919) % 101) as f32 / 8.0).collect();
            let [first, second] = two_lowest(&scores);
            scores.sort_by(f32::total_cmp);
            assert_eq!(first, scores[0]);
            assert_eq!(second, scores.get(1).copied().unwrap_or(f32::INFINITY));
        }
    }

    #[test]
    fn candidates_are_all_that_rounding_may_confuse() {
        let mut candidates = Candidates::new(1);
        candidates.begin(0.5);
        candidates.take(0, &[3.0, 1.4, 9.0]);
        candidates.take(3, &[1.0, 1.6, 1.5]);
        assert_eq!(candidates.indices().collect::<Vec<_>>(), [1, 3, 5]);
        candidates.take(6, &[0.2]);
        assert_eq!(candidates.indices().collect::<Vec<_>>(), [6]);
        let mut two = Candidates::new(2);
        two.begin(0.5);
        two.take(0, &[3.0, 1.4, 9.0]);
        assert_eq!(two.indices().collect::<Vec<_>>(), [0, 1]);
        two.take(3, &[1.0, 2.0, 1.9]);
        assert_eq!(two.indices().collect::<Vec<_>>(), [1, 3, 5]);
    }
}
