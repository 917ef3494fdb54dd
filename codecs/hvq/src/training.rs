//! Codebooks of both stages. Each is trained on the remainder of the earlier stages, as a decoder sums them.

use std::ops::Range;

use cvr_codebook::lbg::{Stop, Trained, refine};
use cvr_codebook::settings::TrainingSettings;
use cvr_codebook::{Codebook, Quantiser, Search, Vectors};
use cvr_core::codec::{EncodeError, Progress};
use cvr_core::volume::{BrickSource, ValueRange};

use crate::blocks::{Levels, Means, sub_block_of};
use crate::geometry::{StageRecord, block};
use crate::stage::StageParameters;

/// Training stops after a round that reduces the distortion by less than this fraction.
const GAIN: f64 = 1e-3;
/// The same for the first training, whose codewords are finer than the stored ones.
const FIRST_GAIN: f64 = 1e-2;

/// The codebooks of a stage.
#[derive(Debug)]
pub struct Tables {
    /// How they are stored.
    pub parameters: StageParameters,
    /// One for all frames, or one for each. Codeword 0 adds nothing.
    pub codebooks: Vec<Codebook>,
    /// How they came about.
    pub record: StageRecord,
}

/// Source and settings of training.
pub struct Trainer<'a> {
    /// Sizes of the coarse and of the detail codebook.
    pub codewords: [u32; 2],
    pub codeword_bits: u32,
    pub with: TrainingSettings,
    pub source: &'a dyn BrickSource,
    pub levels: Levels,
    /// Frames that each table serves.
    pub served: Vec<Range<u32>>,
    pub run: &'a Progress<'a>,
}

/// The training set of a table, by its number.
type Set<'a> = dyn Fn(usize) -> Result<Vectors, EncodeError> + 'a;

impl Trainer<'_> {
    /// The tables of both stages, and the number of training blocks of each table.
    pub fn tables(&self) -> Result<([Tables; 2], Vec<u64>), EncodeError> {
        let [coarse_size, detail_size] = self.codewords.map(|size| size as usize);
        let coarse = self.stage(coarse_size, &|table| Ok(self.coarse(&self.blocks(table)?).merged()))?;
        let detail = self.stage(detail_size, &|table| {
            let blocks = self.blocks(table)?;
            Ok(self.detail(&blocks, &coarse.codebooks[table]).merged())
        })?;
        let of_frame = block().grid(self.source.layout().extent).voxels();
        let drawn = |frames: &Range<u32>| self.with.training_blocks.min(of_frame * frames.len() as u64);
        Ok(([coarse, detail], self.served.iter().map(drawn).collect()))
    }

    /// Training blocks of a table, in levels.
    fn blocks(&self, table: usize) -> Result<Vectors, EncodeError> {
        let TrainingSettings { training_blocks, draw, seed, .. } = self.with;
        let (frames, seed) = (self.served[table].clone(), seed.wrapping_add(table as u64));
        let blocks = draw.vectors(self.source, block(), frames, training_blocks, seed, self.run)?;
        Ok(self.levels.vectors(&blocks))
    }

    /// The quantised mean of each channel of a block, in levels, and the differences of its sub-blocks from it.
    fn of_block(&self, levels: &[f32]) -> (Vec<i32>, Vec<f32>) {
        let means = Means::of(levels, |_| true);
        let added = |mean: &f64| (self.levels.mean_code(*mean) * self.levels.mean_step) as i32;
        let block: Vec<i32> = means.block.iter().map(added).collect();
        let pairs = means.sub_blocks.iter().zip(block.iter().cycle());
        let differences = pairs.map(|(sub, mean)| (sub - f64::from(*mean)) as f32).collect();
        (block, differences)
    }

    /// The remainder of the sub-blocks' means after the first stage.
    fn coarse(&self, blocks: &Vectors) -> Vectors {
        let mut vectors: Option<Vectors> = None;
        for i in 0..blocks.len() {
            let (_, differences) = self.of_block(blocks.vector(i));
            vectors
                .get_or_insert_with(|| Vectors::new(differences.len()))
                .push(&differences, blocks.weight(i));
        }
        vectors.unwrap_or_else(|| Vectors::new(1))
    }

    /// The remainder of the voxels after the first two stages.
    fn detail(&self, blocks: &Vectors, coarse: &Codebook) -> Vectors {
        let nearest = Search::new(coarse, None).all(&self.coarse(blocks));
        let mut vectors = Vectors::new(blocks.dimension());
        let mut vector = Vec::with_capacity(blocks.dimension());
        for (i, nearest) in nearest.iter().enumerate() {
            let levels = blocks.vector(i);
            let (mean, _) = self.of_block(levels);
            let (channels, added) = (mean.len(), coarse.codeword(nearest.index as usize));
            vector.clear();
            for (voxel, values) in levels.chunks_exact(channels).enumerate() {
                let added = &added[sub_block_of(voxel) * channels..][..channels];
                let left = values.iter().zip(&mean).zip(added).map(|((v, m), a)| v - (*m as f32 + a));
                vector.extend(left);
            }
            vectors.push(&vector, blocks.weight(i));
        }
        vectors
    }

    /// The codebooks of one stage: first with codewords of 16 bits over the whole remainder, then with codes of the
    /// requested width over the range of these codewords. Training of a frame starts from the codebook of the frame
    /// before.
    fn stage(&self, size: usize, set: &Set<'_>) -> Result<Tables, EncodeError> {
        let (codeword_bits, iterations) = (self.codeword_bits, self.with.iterations);
        let tables = self.served.len();
        // The set of a single table is kept. Those of many frames would not fit.
        let only = if tables == 1 { Some(set(0)?) } else { None };
        let with = |table: usize, train: &mut dyn FnMut(&Vectors) -> Result<Trained, EncodeError>| match &only
        {
            Some(vectors) => train(vectors),
            None => train(&set(table)?),
        };
        let mut rough: Vec<Trained> = Vec::new();
        for table in 0..tables {
            let before = rough.last().map(|trained| trained.codebook.clone());
            rough.push(with(table, &mut |vectors| self.rough(vectors, size, table, before.as_ref()))?);
        }
        let reached = rough.iter().flat_map(|t| t.codebook.values()).copied().chain([0.0]);
        let ValueRange { min, max } = ValueRange::of(reached).unwrap_or(ValueRange { min: 0.0, max: 0.0 });
        let mut parameters = StageParameters::reaching(min.into(), max.into(), codeword_bits);
        let Some(quantiser) = parameters.quantiser(codeword_bits) else {
            let problem =
                format!("differences from {min} to {max} levels have no codes of {codeword_bits} bits");
            return Err(EncodeError::Unsupported(problem));
        };
        let (mut codebooks, mut record) = (Vec::new(), StageRecord::default());
        for (table, rough) in rough.iter().enumerate() {
            let stop = Stop { rounds: iterations - rough.rounds, gain: GAIN };
            let mut codebook = None;
            let trained = with(table, &mut |vectors| {
                let trained =
                    refine(vectors, stored(&rough.codebook, quantiser), None, size, stop, self.run)?;
                codebook = Some(with_zero(&trained.codebook, vectors, size));
                Ok(trained)
            })?;
            codebooks.extend(codebook);
            record.rounds.push(rough.rounds + trained.rounds);
        }
        parameters.tables = codebooks.iter().map(|codebook| codebook.size() as u32).collect();
        Ok(Tables { parameters, codebooks, record })
    }

    fn rough(
        &self,
        vectors: &Vectors,
        size: usize,
        table: usize,
        before: Option<&Codebook>,
    ) -> Result<Trained, EncodeError> {
        let TrainingSettings { initial, iterations, seed, .. } = self.with;
        let range = ValueRange::of(vectors.values().iter().copied().chain([0.0]));
        let range = range.unwrap_or(ValueRange { min: 0.0, max: 0.0 });
        let quantiser = Quantiser::over(range, 16, false).map_err(EncodeError::Unsupported)?;
        let first = match before {
            Some(codebook) => stored(codebook, quantiser),
            None => {
                let seed = seed.wrapping_add(table as u64);
                let codewords = initial.codewords(vectors, size, seed, self.run)?;
                Codebook::nearest_to(&codewords, vectors.dimension(), quantiser)
            }
        };
        Ok(refine(vectors, first, None, size, Stop { rounds: iterations, gain: FIRST_GAIN }, self.run)?)
    }
}

/// A codebook under another quantiser.
fn stored(codebook: &Codebook, quantiser: Quantiser) -> Codebook {
    let values: Vec<f64> = codebook.values().iter().map(|v| f64::from(*v)).collect();
    Codebook::nearest_to(&values, codebook.dimension(), quantiser)
}

/// The same codebook, with a codeword that adds nothing at index 0, so that a stage never makes a block worse. In a
/// full codebook it replaces the codeword whose vectors lose least.
fn with_zero(codebook: &Codebook, vectors: &Vectors, size: usize) -> Codebook {
    let norm = |k: usize| codebook.codeword(k).iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
    let zero = (0..codebook.size()).find(|k| codebook.codeword(*k).iter().all(|v| *v == 0.0));
    let left_out = match zero {
        Some(zero) => Some(zero),
        None if codebook.size() < size => None,
        None => {
            let mut losses = vec![0.0; codebook.size()];
            for (i, nearest) in Search::new(codebook, None).all(vectors).iter().enumerate() {
                losses[nearest.index as usize] += vectors.weight(i);
            }
            losses.iter_mut().enumerate().for_each(|(k, loss)| *loss *= norm(k));
            (0..losses.len()).min_by(|a, b| losses[*a].total_cmp(&losses[*b]))
        }
    };
    let dimension = codebook.dimension();
    let mut values = vec![0.0; dimension];
    for k in (0..codebook.size()).filter(|k| Some(*k) != left_out) {
        values.extend(codebook.codeword(k).iter().map(|v| f64::from(*v)));
    }
    Codebook::nearest_to(&values, dimension, codebook.quantiser())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codebook(values: &[f64]) -> Codebook {
        let stage = StageParameters::reaching(-100.0, 100.0, 8);
        Codebook::nearest_to(values, 1, stage.quantiser(8).unwrap())
    }

    #[test]
    fn nothing_comes_first_in_place_of_what_serves_least() {
        let mut vectors = Vectors::new(1);
        for (value, weight) in [(-50.0, 1.0), (3.0, 5.0), (60.0, 1.0)] {
            vectors.push(&[value], weight);
        }
        let values = |size, own: &[f64]| with_zero(&codebook(own), &vectors, size).values().to_vec();
        assert_eq!(values(3, &[-50.0, 3.0, 60.0]), [0.0, -50.0, 60.0]);
        assert_eq!(values(4, &[-50.0, 3.0, 60.0]), [0.0, -50.0, 3.0, 60.0]);
        assert_eq!(values(3, &[-50.0, 0.0, 60.0]), [0.0, -50.0, 60.0]);
        assert_eq!(values(1, &[3.0]), [0.0]);
    }
}
