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

/// What the search knows of a block, besides its values.
#[derive(Copy, Clone, Debug)]
pub struct About<'m> {
    /// Which values lie in the volume, where not all do.
    pub inside: Option<&'m [bool]>,
    /// What its values count from, for each channel, in units of sums.
    pub base: [i32; 3],
}

impl About<'_> {
    /// A whole block whose values count from the middle value.
    pub const WHOLE: Self = Self { inside: None, base: [BASE; 3] };
}

/// The best sum of a block after a stage.
#[derive(Copy, Clone, Debug)]
pub struct Best<'p> {
    /// Number of the block.
    pub block: usize,
    /// Its codes so far: one of each stage.
    pub codes: &'p [u16],
    /// Squared error of the values in the volume.
    pub error: f64,
}

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
fn error(values: &[f32], sum: &[f32], codeword: &[f32], about: About<'_>) -> f64 {
    let low = about.base.map(|base| -base as f32);
    let high = about.base.map(|base| (TOP - base) as f32);
    let channels = values.len() / cvr_groups::VOXELS;
    let term = |i: usize| {
        let c = if channels == 3 { i % 3 } else { 0 };
        let error = f64::from((sum[i] + codeword[i]).clamp(low[c], high[c])) - f64::from(values[i]);
        error * error
    };
    match about.inside {
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

    /// The codes of some blocks that follow each other in `rows`, block by block, on this thread.
    #[must_use]
    pub fn code<'m>(&self, rows: &[f32], about: impl Fn(usize) -> About<'m>) -> Vec<u32> {
        let (mut all, stages) = (Vec::new(), self.stages.len());
        self.follow(rows, about, -1.0, |best| {
            all.resize(all.len().max((best.block + 1) * stages), 0);
            if best.codes.len() == stages {
                let codes = best.codes.iter().map(|code| u32::from(*code));
                all[best.block * stages..][..stages].iter_mut().zip(codes).for_each(|(to, code)| *to = code);
            }
        });
        all
    }

    /// Follows some blocks that follow each other in `rows`, stage by stage, on this thread; `each` hears the best sum of each
    /// block after each stage. A block whose error is `enough` or less needs no further stage.
    pub fn follow<'m>(
        &self,
        rows: &[f32],
        about: impl Fn(usize) -> About<'m>,
        enough: f64,
        mut each: impl FnMut(Best<'_>),
    ) {
        let dimension = self.stages[0].codebook.dimension();
        for (part, rows) in rows.chunks(BLOCKS * dimension).enumerate() {
            let first = part * BLOCKS;
            self.part(
                rows,
                dimension,
                |block| about(first + block),
                enough,
                |best| {
                    each(Best { block: first + best.block, ..best });
                },
            );
        }
    }

    /// The codes of whole blocks, in parallel.
    #[must_use]
    pub fn code_all(&self, rows: &[f32]) -> Vec<u32> {
        let dimension = self.stages[0].codebook.dimension();
        let parts = rows.par_chunks(BLOCKS * dimension);
        parts.flat_map_iter(|rows| self.code(rows, |_| About::WHOLE)).collect()
    }

    /// Value `i` of the sum of a block's codewords, counted from the middle value.
    #[must_use]
    pub fn sum(&self, codes: &[u32], i: usize) -> i32 {
        let terms = self.stages.iter().zip(codes);
        terms.map(|(stage, code)| stage.codebook.codeword(*code as usize)[i] as i32).sum()
    }

    /// Adds the codewords of a block to some sums.
    pub fn add(&self, codes: &[u16], sums: &mut [i32]) {
        for (stage, code) in self.stages.iter().zip(codes) {
            let codeword = stage.codebook.codeword((*code).into());
            sums.iter_mut().zip(codeword).for_each(|(sum, c)| *sum += *c as i32);
        }
    }

    /// Follows a few blocks.
    fn part<'m>(
        &self,
        rows: &[f32],
        dimension: usize,
        about: impl Fn(usize) -> About<'m>,
        enough: f64,
        mut each: impl FnMut(Best<'_>),
    ) {
        let count = rows.len() / dimension;
        let start = |block| Path { block, codes: Codes::default(), error: f64::INFINITY };
        let mut paths: Vec<Path> = (0..count).map(start).collect();
        // Sums of integers, and what they leave: single precision holds the former without rounding.
        let (mut sums, mut left) = (vec![0.0; rows.len()], rows.to_vec());
        for (s, (stage, search)) in self.stages.iter().zip(&self.searches).enumerate() {
            // The last stage needs the best of each sum alone.
            let last = s + 1 == self.stages.len();
            let wanted = if last { 1 } else { self.beam.min(stage.codebook.size()) };
            if paths.is_empty() {
                return;
            }
            let found = search.several(&left, wanted);
            let (mut next, mut next_sums) = (Vec::with_capacity(count * self.beam), Vec::new());
            let mut first = 0;
            for of_block in paths.chunk_by(|a, b| a.block == b.block) {
                let block = of_block[0].block;
                let (values, about) = (&rows[block * dimension..][..dimension], about(block));
                let mut children: Vec<Child> = Vec::with_capacity(of_block.len() * wanted);
                for (path, parent) in (first..).zip(of_block) {
                    let sum = &sums[path * dimension..][..dimension];
                    for &Nearest { index, distance } in &found[path * wanted..][..wanted] {
                        let codeword = stage.codebook.codeword(index as usize);
                        let error = error(values, sum, codeword, about);
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
                for (n, Child { path, index, error, .. }) in children.into_iter().enumerate() {
                    let mut codes = paths[path].codes;
                    codes[s] = index as u16;
                    if n == 0 {
                        each(Best { block, codes: &codes[..=s], error });
                        if error <= enough {
                            break;
                        }
                    }
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
        let code = |beam| Coder::new(&stages, beam).code(&[14.0, 10.0], |_| About::WHOLE);
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
        assert_eq!(coder.code(&[10.0, 30.0], |_| About::WHOLE), [0, 1]);
        assert_eq!(
            coder.code(&[10.0, 30.0], |_| About { inside: Some(&[true, false][..]), ..About::WHOLE }),
            [0, 0]
        );
    }
}
