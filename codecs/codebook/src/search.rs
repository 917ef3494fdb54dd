//! The nearest codeword of a vector.
//!
//! `‖x − c‖² = ‖x‖² + (‖c‖² − 2 x·c)`: the bracket, the *score*, of many vectors and codewords is one matrix product
//! (vectors carry a component 1 more, codewords their squared norm). Its rounding is bounded; every codeword whose
//! score lies within the bound of the lowest is measured again in double precision, and of equally near codewords the
//! one of the lowest index wins. So the outcome depends neither on the blocks in which products are taken nor on the
//! processor's kernel.

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2};
use rayon::prelude::*;

use crate::distance::squared;
use crate::{Codebook, Vectors};

/// Vectors in one matrix product.
const ROWS: usize = 256;
/// Codewords in one matrix product: with [`ROWS`] vectors the scores fill 256 KiB.
const COLUMNS: usize = 256;
/// Scores that are compared at once.
const LANES: usize = 16;
/// Half the distance from 1 to the next single.
const UNIT: f64 = 1.0 / (1 << 24) as f64;

/// The codeword nearest to a vector.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Index of the codeword.
    pub index: u32,
    /// Squared distance, in data units, over the components that count.
    pub distance: f64,
}

/// A codebook made ready for many searches.
#[derive(Clone, Debug)]
pub struct Search<'a> {
    codebook: &'a Codebook,
    mask: Option<Vec<bool>>,
    /// Codewords, shifted and scaled to about −1..1 and doubled with negative sign, then the squared norm.
    operands: Vec<f32>,
    centre: f64,
    scale: f64,
    /// Largest norm of a shifted and scaled codeword.
    radius: f64,
}

impl<'a> Search<'a> {
    /// A search in which the components count that `mask` names; all, without a mask.
    ///
    /// # Panics
    /// When the codebook is empty or the mask is of another dimension.
    #[must_use]
    pub fn new(codebook: &'a Codebook, mask: Option<&[bool]>) -> Self {
        let dimension = codebook.dimension();
        assert!(codebook.size() > 0, "an empty codebook");
        assert!(mask.is_none_or(|m| m.len() == dimension), "a mask of another dimension");
        let span = f64::from(codebook.quantiser().span());
        let centre =
            codebook.values().iter().map(|v| f64::from(*v)).sum::<f64>() / codebook.values().len() as f64;
        let mut search = Self {
            codebook,
            mask: mask.map(<[bool]>::to_vec),
            operands: Vec::with_capacity(codebook.size() * (dimension + 1)),
            centre,
            scale: 1.0 / span,
            radius: 0.0,
        };
        for codeword in codebook.values().chunks_exact(dimension) {
            let mut norm = 0.0;
            for (s, &c) in codeword.iter().enumerate() {
                let c = search.shifted(c, s);
                search.operands.push(-2.0 * c);
                norm += f64::from(c) * f64::from(c);
            }
            search.operands.push(norm as f32);
            search.radius = search.radius.max(norm.sqrt());
        }
        search
    }

    /// Component `s` of a vector as the products take it: 0 where it does not count.
    fn shifted(&self, value: f32, s: usize) -> f32 {
        if self.mask.as_ref().is_some_and(|mask| !mask[s]) {
            return 0.0;
        }
        ((f64::from(value) - self.centre) * self.scale) as f32
    }

    /// The nearest codeword of every vector, in parallel.
    ///
    /// # Panics
    /// When the vectors are of another dimension.
    #[must_use]
    pub fn all(&self, vectors: &Vectors) -> Vec<Nearest> {
        assert_eq!(vectors.dimension(), self.codebook.dimension(), "vectors of another dimension");
        let blocks = vectors.values().par_chunks(ROWS * vectors.dimension());
        blocks.flat_map_iter(|rows| self.rows(rows)).collect()
    }

    /// The nearest codeword of each of some vectors that follow each other in `rows`, on this thread.
    ///
    /// # Panics
    /// When `rows` is no whole number of vectors.
    #[must_use]
    pub fn rows(&self, rows: &[f32]) -> Vec<Nearest> {
        let dimension = self.codebook.dimension();
        assert!(rows.len().is_multiple_of(dimension), "no whole number of vectors");
        rows.chunks(ROWS * dimension).flat_map(|block| self.block(block)).collect()
    }

    /// At most [`ROWS`] vectors.
    fn block(&self, rows: &[f32]) -> Vec<Nearest> {
        let dimension = self.codebook.dimension();
        let (count, width) = (rows.len() / dimension, dimension + 1);
        let mut vectors = Vec::with_capacity(count * width);
        let mut candidates = Vec::with_capacity(count);
        for row in rows.chunks_exact(dimension) {
            let mut norm = 0.0;
            for (s, &x) in row.iter().enumerate() {
                let x = self.shifted(x, s);
                norm += f64::from(x) * f64::from(x);
                vectors.push(x);
            }
            vectors.push(1.0);
            candidates.push(Candidates::new(self.margin(norm.sqrt())));
        }
        let mut scores = vec![0.0_f32; count * COLUMNS];
        for (tile, operands) in self.operands.chunks(COLUMNS * width).enumerate() {
            let columns = operands.len() / width;
            let scores = &mut scores[..count * columns];
            product(&vectors, operands, width, scores);
            for (candidates, scores) in candidates.iter_mut().zip(scores.chunks_exact(columns)) {
                candidates.take((tile * COLUMNS) as u32, scores);
            }
        }
        let decide = |(row, candidates): (&[f32], &Candidates)| self.decide(row, candidates);
        rows.chunks_exact(dimension).zip(&candidates).map(decide).collect()
    }

    /// How far the scores of two codewords may lie apart while rounding alone decides which is lower. A sum of n
    /// products is off by at most n·u·Σ|products|, whatever the order and fused or not (Higham 2002, section 3.1);
    /// operands and norm are rounded once more.
    fn margin(&self, norm: f64) -> f32 {
        let terms = (self.codebook.dimension() + 6) as f64;
        let products = self.radius * (2.0 * norm + self.radius);
        (2.2 * UNIT * terms * products) as f32
    }

    fn decide(&self, row: &[f32], candidates: &Candidates) -> Nearest {
        let mut best = Nearest { index: 0, distance: f64::INFINITY };
        for &(index, score) in &candidates.list {
            if score > candidates.lowest + candidates.margin {
                continue;
            }
            let distance = squared(row, self.codebook.codeword(index as usize), self.mask.as_deref());
            if distance < best.distance {
                best = Nearest { index, distance };
            }
        }
        best
    }
}

/// `scores = vectors · operandsᵀ`, all in rows.
fn product(vectors: &[f32], operands: &[f32], width: usize, scores: &mut [f32]) {
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

/// The codewords that may be nearest, in ascending order.
struct Candidates {
    lowest: f32,
    margin: f32,
    list: Vec<(u32, f32)>,
}

impl Candidates {
    const fn new(margin: f32) -> Self {
        Self { lowest: f32::INFINITY, margin, list: Vec::new() }
    }

    /// The scores of the codewords from `first` on.
    fn take(&mut self, first: u32, scores: &[f32]) {
        let lowest = lowest(scores);
        if lowest > self.lowest + self.margin {
            return;
        }
        if lowest < self.lowest {
            self.lowest = lowest;
            let limit = lowest + self.margin;
            self.list.retain(|(_, score)| *score <= limit);
        }
        let limit = self.lowest + self.margin;
        for (first, scores) in (first..).step_by(LANES).zip(scores.chunks(LANES)) {
            // Without a branch, so that a chunk is one comparison: hardly any holds a candidate.
            if scores.iter().fold(false, |any, score| any | (*score <= limit)) {
                let near = (first..).zip(scores).filter(|(_, score)| **score <= limit);
                self.list.extend(near.map(|(index, score)| (index, *score)));
            }
        }
    }
}

/// The lowest of some scores, in lanes that a compiler turns into vector instructions.
fn lowest(scores: &[f32]) -> f32 {
    let lower = |a: f32, b: f32| if b < a { b } else { a };
    let mut lanes = [f32::INFINITY; LANES];
    let chunks = scores.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for (lane, score) in lanes.iter_mut().zip(chunk) {
            *lane = lower(*lane, *score);
        }
    }
    lanes.iter().chain(rest).fold(f32::INFINITY, |a, b| lower(a, *b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Quantiser;
    use cvr_core::volume::ValueRange;
    use proptest::prelude::*;

    fn by_hand(codebook: &Codebook, row: &[f32], mask: Option<&[bool]>) -> Nearest {
        let mut best = Nearest { index: 0, distance: f64::INFINITY };
        for k in 0..codebook.size() {
            let distance = squared(row, codebook.codeword(k), mask);
            if distance < best.distance {
                best = Nearest { index: k as u32, distance };
            }
        }
        best
    }

    fn hashed(i: usize, seed: u32) -> f64 {
        let mut h = (i as u32 ^ seed).wrapping_mul(0x9e37_79b9);
        h = (h ^ (h >> 15)).wrapping_mul(0x85eb_ca6b);
        f64::from(h ^ (h >> 13)) / f64::from(u32::MAX)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
        /// Small integers give many ties, a large offset many scores that rounding cannot tell apart.
        #[test]
        fn the_search_finds_what_a_search_by_hand_finds(
            dimension in 1_usize..20,
            size in 1_usize..600,
            count in 1_usize..300,
            levels in prop_oneof![Just(3.0), Just(40.0), Just(1e6)],
            offset in prop_oneof![Just(0.0_f32), Just(-1e6), Just(1e30)],
            masked: bool,
            seed: u32,
        ) {
            let range = ValueRange { min: offset, max: (f64::from(offset) * 1.5 + 256.0) as f32 };
            let range = ValueRange { min: range.min.min(range.max), max: range.max.max(range.min) };
            let value = |i: usize, seed| {
                f64::from(range.min) + range.span() * (hashed(i, seed) * levels).floor() / levels
            };
            let quantiser = Quantiser::over(range, 16, false).unwrap();
            let words: Vec<f64> = (0..size * dimension).map(|i| value(i, seed)).collect();
            let codebook = Codebook::nearest_to(&words, dimension, quantiser);
            let rows: Vec<f32> = (0..count * dimension).map(|i| value(i, !seed) as f32).collect();
            let mask: Vec<bool> = (0..dimension).map(|s| hashed(s, seed) < 0.7).collect();
            let mask = masked.then_some(&mask[..]);
            let found = Search::new(&codebook, mask).all(&Vectors::of_rows(dimension, rows.clone()));
            for (row, found) in rows.chunks_exact(dimension).zip(found) {
                prop_assert_eq!(found, by_hand(&codebook, row, mask));
            }
        }
    }

    #[test]
    fn of_equally_near_codewords_the_first_wins() {
        let range = ValueRange { min: 0.0, max: 255.0 };
        let quantiser = Quantiser::over(range, 8, true).unwrap();
        let codebook = Codebook::nearest_to(&[9.0, 11.0, 7.0], 1, quantiser);
        let found = Search::new(&codebook, None).rows(&[10.0, 8.0, 7.0]);
        let indices: Vec<u32> = found.iter().map(|n| n.index).collect();
        assert_eq!(indices, [0, 0, 2]);
        assert_eq!(found[0].distance, 1.0);
    }
}
