//! The nearest codeword of a vector.
//!
//! Scores in single precision propose codewords ([`crate::scores`]). Every codeword that could be the nearest, given
//! the rounding, is measured again in double precision. Of equally near codewords the lowest index wins. So the result
//! depends neither on the blocks of the products nor on the processor.

use rayon::prelude::*;

use crate::distance::squared;
use crate::scores::{COLUMNS, Candidates, ROWS, margin, product};
use crate::wide::wide;
use crate::{Codebook, Vectors};

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
    /// Codewords, shifted and scaled to about −1..1, times −2, followed by the squared norm.
    operands: Vec<f32>,
    centre: f64,
    scale: f64,
    /// Largest norm of a shifted and scaled codeword.
    radius: f64,
}

impl<'a> Search<'a> {
    /// A search over the components in `mask`, or over all without a mask.
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

    /// Data units per unit of the shifted and scaled codewords.
    pub(crate) fn span(&self) -> f64 {
        1.0 / self.scale
    }

    /// Squared distances from some codewords to all, in rows, in units of [`Self::span`]. They are lower bounds, and
    /// too small only by rounding.
    pub(crate) fn apart(&self, some: &[u32]) -> Vec<f32> {
        let (size, width) = (self.codebook.size(), self.codebook.dimension() + 1);
        let mut vectors = Vec::with_capacity(some.len() * width);
        let mut norms = Vec::with_capacity(some.len());
        for &k in some {
            let operand = &self.operands[k as usize * width..][..width];
            vectors.extend(operand[..width - 1].iter().map(|o| -0.5 * o));
            vectors.push(1.0);
            norms.push(operand[width - 1]);
        }
        let mut squares = vec![0.0; some.len() * size];
        if !some.is_empty() {
            product(&vectors, &self.operands, width, &mut squares);
        }
        for (row, norm) in squares.chunks_exact_mut(size).zip(norms) {
            let less = norm - self.margin(f64::from(norm).sqrt());
            row.iter_mut().for_each(|square| *square = (*square + less).max(0.0));
        }
        squares
    }

    /// Component `s` of a vector for the products. 0 if the mask excludes it.
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

    /// The nearest codeword of each vector in `rows` (concatenated), on this thread.
    ///
    /// # Panics
    /// When `rows` is no whole number of vectors.
    #[must_use]
    pub fn rows(&self, rows: &[f32]) -> Vec<Nearest> {
        let mut nearest = Vec::with_capacity(rows.len() / self.codebook.dimension());
        self.nearest(rows, 1, &mut nearest);
        nearest
    }

    /// The `count` nearest codewords of each of some vectors that follow each other in `rows`, on this thread: nearest first,
    /// of equally near ones the first; all of a codebook that has no more. Those of a vector follow those of the one before.
    ///
    /// # Panics
    /// When `rows` is no whole number of vectors, or `count` is zero.
    #[must_use]
    pub fn several(&self, rows: &[f32], count: usize) -> Vec<Nearest> {
        assert!(count > 0, "no codeword is wanted");
        let count = count.min(self.codebook.size());
        let mut nearest = Vec::with_capacity(rows.len() / self.codebook.dimension() * count);
        self.nearest(rows, count, &mut nearest);
        nearest
    }

    fn nearest(&self, rows: &[f32], count: usize, nearest: &mut Vec<Nearest>) {
        let dimension = self.codebook.dimension();
        assert!(rows.len().is_multiple_of(dimension), "no whole number of vectors");
        let mut candidates = vec![Candidates::new(count); ROWS.min(rows.len() / dimension)];
        rows.chunks(ROWS * dimension).for_each(|block| self.block(block, &mut candidates, nearest));
    }

    /// Appends a vector as the products take it, with a component 1 behind it; returns its norm.
    fn append(&self, row: &[f32], vectors: &mut Vec<f32>) -> f64 {
        wide(|| {
            let first = vectors.len();
            let (centre, scale) = (self.centre, self.scale);
            vectors.extend(row.iter().map(|x| ((f64::from(*x) - centre) * scale) as f32));
            let own = &mut vectors[first..];
            if let Some(mask) = &self.mask {
                own.iter_mut().zip(mask).filter(|(_, counts)| !**counts).for_each(|(x, _)| *x = 0.0);
            }
            let mut squares = [0.0; 8];
            for part in own.chunks(8) {
                squares.iter_mut().zip(part).for_each(|(sum, x)| *sum += f64::from(*x) * f64::from(*x));
            }
            vectors.push(1.0);
            squares.iter().sum::<f64>().sqrt()
        })
    }

    /// At most [`ROWS`] vectors.
    fn block(&self, rows: &[f32], candidates: &mut [Candidates], nearest: &mut Vec<Nearest>) {
        let dimension = self.codebook.dimension();
        let (count, width) = (rows.len() / dimension, dimension + 1);
        let mut vectors = Vec::with_capacity(count * width);
        for (row, candidates) in rows.chunks_exact(dimension).zip(candidates.iter_mut()) {
            candidates.begin(self.margin(self.append(row, &mut vectors)));
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
        wide(|| self.settle(rows, candidates, nearest));
    }

    /// Appends the nearest of the candidates of each vector.
    #[inline(always)]
    fn settle(&self, rows: &[f32], candidates: &[Candidates], nearest: &mut Vec<Nearest>) {
        for (row, candidates) in rows.chunks_exact(self.codebook.dimension()).zip(candidates) {
            if candidates.wanted() == 1 {
                nearest.push(self.decide(row, candidates));
            } else {
                let mut all: Vec<Nearest> =
                    candidates.indices().map(|index| self.measured(row, index)).collect();
                // Stable, so that of equally near ones the first comes first.
                all.sort_by(|a, b| a.distance.total_cmp(&b.distance));
                nearest.extend(&all[..candidates.wanted()]);
            }
        }
    }

    fn margin(&self, norm: f64) -> f32 {
        margin(self.codebook.dimension(), norm, self.radius)
    }

    /// A codeword with its distance in double precision.
    #[inline(always)]
    fn measured(&self, row: &[f32], index: u32) -> Nearest {
        let distance = squared(row, self.codebook.codeword(index as usize), self.mask.as_deref());
        Nearest { index, distance }
    }

    #[inline(always)]
    fn decide(&self, row: &[f32], candidates: &Candidates) -> Nearest {
        let all = candidates.indices().map(|index| self.measured(row, index));
        let none = Nearest { index: 0, distance: f64::INFINITY };
        all.fold(none, |best, next| if next.distance < best.distance { next } else { best })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Quantiser;
    use cvr_core::volume::ValueRange;
    use proptest::prelude::*;

    /// All codewords, nearest first.
    fn by_hand(codebook: &Codebook, row: &[f32], mask: Option<&[bool]>) -> Vec<Nearest> {
        let measured =
            |k: usize| Nearest { index: k as u32, distance: squared(row, codebook.codeword(k), mask) };
        let mut all: Vec<Nearest> = (0..codebook.size()).map(measured).collect();
        all.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        all
    }

    fn hashed(i: usize, seed: u32) -> f64 {
        let mut h = (i as u32 ^ seed).wrapping_mul(0x9e37_79b9);
        h = (h ^ (h >> 15)).wrapping_mul(0x85eb_ca6b);
        f64::from(h ^ (h >> 13)) / f64::from(u32::MAX)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
        /// Small integers give many ties. A large offset gives many scores that rounding makes equal.
        #[test]
        fn the_search_finds_what_a_search_by_hand_finds(
            dimension in 1_usize..20,
            size in 1_usize..600,
            count in 1_usize..300,
            levels in prop_oneof![Just(3.0), Just(40.0), Just(1e6)],
            offset in prop_oneof![Just(0.0_f32), Just(-1e6), Just(1e30)],
            masked: bool,
            wanted in 2_usize..9,
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
                prop_assert_eq!(found, by_hand(&codebook, row, mask)[0]);
            }
            let several = Search::new(&codebook, mask).several(&rows, wanted);
            for (row, found) in rows.chunks_exact(dimension).zip(several.chunks_exact(wanted.min(codebook.size()))) {
                prop_assert_eq!(found, &by_hand(&codebook, row, mask)[..found.len()]);
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
