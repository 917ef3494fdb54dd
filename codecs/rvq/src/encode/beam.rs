//! Codes of blocks: of all sums of one codeword of each stage, the nearest that a beam finds.
//!
//! The paper takes the codeword nearest to what is left, stage by stage. A beam keeps the nearest few sums from stage to stage
//! (M-search, Jelinek and Anderson 1971): what a codeword leaves decides how well the next stage fits.
//!
//! No stage raises the error of a block: the zero vector is among the codewords of every stage but the first.

use cvr_codebook::{Nearest, Search};
use rayon::prelude::*;

use super::stage::Stage;
use crate::stream::{BASE, MOST_STAGES, TOP};

/// Blocks whose sums one thread follows at a time.
const BLOCKS: usize = 64;

/// A search over all stages.
#[derive(Debug)]
pub struct Coder<'a> {
    stages: &'a [Stage],
    searches: Vec<Search<'a>>,
    beam: usize,
}

/// Codes of the stages so far.
type Codes = [u16; MOST_STAGES as usize];

/// A sum of codewords of the stages so far.
#[derive(Copy, Clone)]
struct Path {
    /// Number of its block.
    block: usize,
    codes: Codes,
    /// Squared error of the values in the volume that it decodes to.
    error: f64,
}

/// A sum with one more codeword.
struct Child {
    /// Number of the sum that it was.
    path: usize,
    index: u32,
    /// Squared error of all values.
    distance: f64,
    error: f64,
}

/// Squared error of the values in the volume that a sum with one more codeword decodes to.
fn error(values: &[f32], sum: &[f32], codeword: &[f32], inside: Option<&[bool]>) -> f64 {
    let (low, high) = (-BASE as f32, (TOP - BASE) as f32);
    let term = |i: usize| {
        let error = f64::from((sum[i] + codeword[i]).clamp(low, high)) - f64::from(values[i]);
        error * error
    };
    match inside {
        None => (0..values.len()).map(term).sum(),
        Some(inside) => (0..values.len()).filter(|i| inside[*i]).map(term).sum(),
    }
}

impl<'a> Coder<'a> {
    /// A search that keeps `beam` sums of each block.
    #[must_use]
    pub fn new(stages: &'a [Stage], beam: usize) -> Self {
        let searches = stages.iter().map(|stage| Search::new(&stage.codebook, None)).collect();
        Self { stages, searches, beam }
    }

    /// The codes of some blocks that follow each other in `rows`, block by block, on this thread. `inside` says which values
    /// of a block lie in the volume, where not all do.
    #[must_use]
    pub fn code<'m>(&self, rows: &[f32], inside: impl Fn(usize) -> Option<&'m [bool]>) -> Vec<u32> {
        let dimension = self.stages[0].codebook.dimension();
        let parts = rows.chunks(BLOCKS * dimension).enumerate();
        let coded =
            parts.flat_map(|(part, rows)| self.part(rows, dimension, |block| inside(part * BLOCKS + block)));
        coded.flat_map(|codes| self.of_stages(codes)).collect()
    }

    /// The codes of whole blocks, in parallel.
    #[must_use]
    pub fn code_all(&self, rows: &[f32]) -> Vec<u32> {
        let dimension = self.stages[0].codebook.dimension();
        let parts = rows.par_chunks(BLOCKS * dimension);
        let coded = parts.flat_map_iter(|rows| self.part(rows, dimension, |_| None));
        coded.flat_map_iter(|codes| self.of_stages(codes)).collect()
    }

    fn of_stages(&self, codes: Codes) -> impl Iterator<Item = u32> + use<> {
        codes.into_iter().take(self.stages.len()).map(u32::from)
    }

    /// Value `i` of the sum of a block's codewords, counted from the middle value.
    #[must_use]
    pub fn sum(&self, codes: &[u32], i: usize) -> i32 {
        let terms = self.stages.iter().zip(codes);
        terms.map(|(stage, code)| stage.codebook.codeword(*code as usize)[i] as i32).sum()
    }

    /// The codes of each of a few blocks.
    fn part<'m>(
        &self,
        rows: &[f32],
        dimension: usize,
        inside: impl Fn(usize) -> Option<&'m [bool]>,
    ) -> Vec<Codes> {
        let count = rows.len() / dimension;
        let start = |block| Path { block, codes: Codes::default(), error: f64::INFINITY };
        let mut paths: Vec<Path> = (0..count).map(start).collect();
        // Sums of integers, and what they leave: single precision holds the former without rounding.
        let (mut sums, mut left) = (vec![0.0; rows.len()], rows.to_vec());
        for (s, (stage, search)) in self.stages.iter().zip(&self.searches).enumerate() {
            // The last stage needs the best of each sum alone.
            let last = s + 1 == self.stages.len();
            let wanted = if last { 1 } else { self.beam.min(stage.codebook.size()) };
            let found = search.several(&left, wanted);
            let (mut next, mut next_sums) = (Vec::with_capacity(count * self.beam), Vec::new());
            let mut first = 0;
            for of_block in paths.chunk_by(|a, b| a.block == b.block) {
                let block = of_block[0].block;
                let (values, inside) = (&rows[block * dimension..][..dimension], inside(block));
                let mut children: Vec<Child> = Vec::with_capacity(of_block.len() * wanted);
                for (path, parent) in (first..).zip(of_block) {
                    let sum = &sums[path * dimension..][..dimension];
                    for &Nearest { index, distance } in &found[path * wanted..][..wanted] {
                        let codeword = stage.codebook.codeword(index as usize);
                        let error = error(values, sum, codeword, inside);
                        if error <= parent.error {
                            children.push(Child { path, index, distance, error });
                        }
                    }
                }
                if children.is_empty() {
                    // Values outside, or outside the range, have chosen: the zero vector leaves what there is.
                    let (path, parent) = (first, of_block[0]);
                    children.push(Child { path, index: 0, distance: parent.error, error: parent.error });
                }
                // Stable, so that of equally near sums the first comes first.
                children.sort_by(|a, b| a.distance.total_cmp(&b.distance));
                children.truncate(if last { 1 } else { self.beam });
                first += of_block.len();
                for Child { path, index, error, .. } in children {
                    let mut codes = paths[path].codes;
                    codes[s] = index as u16;
                    next.push(Path { block, codes, error });
                    if !last {
                        let codeword = stage.codebook.codeword(index as usize);
                        next_sums.extend(
                            sums[path * dimension..][..dimension].iter().zip(codeword).map(|(s, c)| s + c),
                        );
                    }
                }
            }
            (paths, sums) = (next, next_sums);
            left.clear();
            for (path, sum) in paths.iter().zip(sums.chunks_exact(dimension)) {
                left.extend(rows[path.block * dimension..][..dimension].iter().zip(sum).map(|(v, s)| v - s));
            }
        }
        paths.into_iter().map(|path| path.codes).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Entries;

    /// The nearest first codeword leaves what the second stage cannot fit.
    #[test]
    fn a_beam_finds_a_sum_that_the_nearest_codeword_misses() {
        let stages =
            [Stage::of(&[10.0, 20.0], 1, Entries::Bits16), Stage::of(&[0.0, -6.0], 1, Entries::Bits16)];
        let code = |beam| Coder::new(&stages, beam).code(&[14.0, 10.0], |_| None);
        assert_eq!(code(1), [0, 0, 0, 0]);
        assert_eq!(code(2), [1, 1, 0, 0]);
        assert_eq!(Coder::new(&stages, 2).sum(&[1, 1], 0), 14);
        assert_eq!(Coder::new(&stages, 8).code_all(&[14.0, 10.0]), code(2));
    }

    /// The second stage fits the value outside, at the cost of the one inside.
    #[test]
    fn no_stage_raises_the_error_in_the_volume() {
        let stages = [
            Stage::of(&[10.0, 10.0], 2, Entries::Bits16),
            Stage::of(&[0.0, 0.0, 3.0, 20.0], 2, Entries::Bits16),
        ];
        let coder = Coder::new(&stages, 2);
        assert_eq!(coder.code(&[10.0, 30.0], |_| None), [0, 1]);
        assert_eq!(coder.code(&[10.0, 30.0], |_| Some(&[true, false][..])), [0, 0]);
    }
}
