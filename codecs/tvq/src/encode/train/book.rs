//! One global codebook: the zero vector, then a chapter for each class with a code in its partition.

use cvr_codebook::lbg::{Stop, refine};
use cvr_codebook::{Codebook, Initial, Nearest, Quantiser, Search, Training, Vectors, train};
use cvr_core::codec::{Cancelled, Progress};
use cvr_groups::Scale;
use rayon::prelude::*;

use super::classify::{CLASSES, keeps};
use super::shares::shares;
use crate::stream::geometry::VOXELS;
use crate::stream::table::Partition;

/// A codebook of inverse transforms, in units of the decoder's sums.
#[derive(Clone, Debug)]
pub struct Book {
    /// Where it belongs.
    pub partition: Partition,
    /// What entries count.
    pub scale: Scale,
    /// Codewords; the first is the zero vector.
    pub codebook: Codebook,
    /// Codewords of each class, without the zero vector.
    pub chapters: [u32; CLASSES.len()],
}

/// How codebooks are trained.
#[derive(Copy, Clone, Debug)]
pub struct Recipe {
    /// The first codebook.
    pub initial: Initial,
    /// What chance decides.
    pub seed: u64,
    /// Refinement of each chapter.
    pub chapter: Stop,
    /// Refinement of the whole codebook.
    pub whole: Stop,
    /// Bits of an entry: 8 or 16.
    pub entry_bits: u32,
}

/// The training set of a codebook.
#[derive(Debug)]
pub struct Population<'a> {
    /// Blocks, 64 values each.
    pub vectors: Vec<f32>,
    /// Weight of each.
    pub weights: &'a [f64],
    /// Class of each.
    pub classes: &'a [u8],
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest, v| largest.max(v.abs()))
}

impl Book {
    /// The zero vector alone.
    #[must_use]
    pub fn zero(partition: Partition, bits: u32) -> Self {
        let (quantiser, scale) = Quantiser::of_entries(bits, 0.0);
        let codebook = Codebook::nearest_to(&[0.0; VOXELS], VOXELS, quantiser);
        Self { partition, scale, codebook, chapters: [0; CLASSES.len()] }
    }

    /// At most `size` codewords for a population.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn train(
        population: Population<'_>,
        partition: Partition,
        size: usize,
        recipe: &Recipe,
        run: &Progress<'_>,
    ) -> Result<Self, Cancelled> {
        let Population { vectors, weights, classes } = population;
        let greatest = largest(vectors.iter().map(|v| f64::from(*v)));
        if size <= 1 || greatest == 0.0 {
            return Ok(Self::zero(partition, recipe.entry_bits));
        }
        let (fine, _) = Quantiser::of_entries(16, greatest);
        let mut counts = [0; CLASSES.len()];
        classes.iter().for_each(|class| counts[*class as usize] += 1);
        let mut parts = counts.map(|count| Vectors::with_room_for(count, VOXELS));
        let mut energies = [0.0; CLASSES.len()];
        for ((vector, weight), class) in vectors.chunks_exact(VOXELS).zip(weights).zip(classes) {
            parts[*class as usize].push(vector, *weight);
            let energy: f64 = vector.iter().map(|v| f64::from(*v) * f64::from(*v)).sum();
            energies[*class as usize] += weight * energy;
        }
        // Training vectors need the memory of several volumes. So copies are dropped as early as possible.
        drop(vectors);
        let kept = |class: usize| keeps(class as u8, partition);
        if (0..CLASSES.len()).any(|class| kept(class) && energies[class] > 0.0) {
            energies.iter_mut().enumerate().filter(|(class, _)| !kept(*class)).for_each(|(_, e)| *e = 0.0);
        }
        let mut words: Vec<f64> = vec![0.0; VOXELS];
        let mut chapters = [0; CLASSES.len()];
        for (class, size) in shares(&energies, &counts, size - 1, VOXELS).into_iter().enumerate() {
            if size > 0 {
                let (initial, stop) = (recipe.initial, recipe.chapter);
                let training = Training { size, quantiser: fine, initial, seed: recipe.seed, stop };
                let trained = train(&parts[class], &training, run)?.codebook;
                words.extend(trained.values().iter().map(|v| f64::from(*v)));
                chapters[class] = trained.size() as u32;
            }
        }
        let (quantiser, scale) = Quantiser::of_entries(recipe.entry_bits, largest(words.iter().copied()));
        let mut all = Vectors::with_room_for(counts.iter().sum(), VOXELS);
        parts.into_iter().for_each(|part| all.append(&part));
        let first = Codebook::nearest_to(&words[VOXELS..], VOXELS, quantiser);
        let refined = refine(&all, first, None, size - 1, recipe.whole, run)?.codebook;
        let values = refined.values().iter().map(|v| f64::from(*v));
        let words: Vec<f64> = std::iter::repeat_n(0.0, VOXELS).chain(values).collect();
        Ok(Self { partition, scale, codebook: Codebook::nearest_to(&words, VOXELS, quantiser), chapters })
    }

    /// Codewords of each class that has any, by its name.
    #[must_use]
    pub fn named_chapters(&self) -> Vec<(&'static str, u32)> {
        let named = CLASSES.iter().zip(self.chapters).filter(|(_, size)| *size > 0);
        named.map(|(class, size)| (class.name, size)).collect()
    }

    /// Codewords.
    #[must_use]
    pub fn size(&self) -> usize {
        self.codebook.size()
    }

    /// Bits of a code. 0 if there is one codeword.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.size().next_power_of_two().trailing_zeros()
    }

    /// The nearest codeword of each of some blocks, in parallel.
    #[must_use]
    pub fn nearest(&self, blocks: &[f32]) -> Vec<Nearest> {
        let search = Search::new(&self.codebook, None);
        blocks.par_chunks(256 * VOXELS).flat_map_iter(|rows| search.rows(rows)).collect()
    }
}
