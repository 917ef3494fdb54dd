//! From blocks to the codebooks of one table, partition by partition. Each is trained on the remainder of the earlier
//! ones.

use cvr_core::codec::{Cancelled, Progress};
use rayon::prelude::*;

use super::book::{Book, Population, Recipe};
use super::classify::{CLASSES, WHOLE, class_of, energies, keeps, projected, zones_of};
use super::transform::{Basis, Transform, ZONES};
use crate::encode::sample::Sample;
use crate::encode::tuned::codebooks::{AT_ONCE, LEADING_BLOCKS};
use crate::stream::geometry::{TOP, VOXELS};
use crate::stream::table::Partition;

/// What training may assume.
#[derive(Copy, Clone, Debug)]
pub struct Training {
    /// Basis of the zones.
    pub transform: Transform,
    /// Whether blocks are classified.
    pub classification: bool,
    /// Whether codevectors are confined to the zones of their partition.
    pub confined: bool,
    /// Most codebooks of the payload `variable`.
    pub most_books: u32,
    /// Settings of training for each codebook.
    pub recipe: Recipe,
}

/// The blocks of one table, with the energies of their zones.
#[derive(Debug)]
pub struct Trainer<'a> {
    /// The blocks.
    pub sample: &'a Sample,
    basis: Basis,
    energies: Vec<[f64; ZONES]>,
    /// What training may assume.
    pub training: Training,
    /// Number of tables that will have such codebooks.
    pub copies: f64,
    /// Most bits for all codebooks of all these tables. More would never be kept.
    pub most_bits: f64,
}

/// The remainder of the blocks after the codebooks so far.
#[derive(Clone, Debug)]
pub struct State {
    /// 64 values each.
    pub residuals: Vec<f32>,
    /// Squared error of each.
    pub errors: Vec<f64>,
}

fn energy(block: &[f32]) -> f64 {
    block.iter().map(|v| f64::from(*v) * f64::from(*v)).sum()
}

impl<'a> Trainer<'a> {
    /// Finds basis and energies.
    #[must_use]
    pub fn new(sample: &'a Sample, training: Training) -> Self {
        let basis = Basis::new(training.transform, &sample.values);
        let energies = sample.values.par_chunks(VOXELS).map(|block| energies(&basis, block)).collect();
        Self { sample, basis, energies, training, copies: 1.0, most_bits: f64::INFINITY }
    }

    /// Class of each block. The threshold is a root mean square in units of sums.
    #[must_use]
    pub fn classes(&self, threshold: f64) -> Vec<u8> {
        let class = |energies: &[f64; ZONES]| {
            if self.training.classification { class_of(energies, threshold) } else { WHOLE }
        };
        self.energies.iter().map(class).collect()
    }

    /// Whether the blocks are all that their one table will ever serve.
    #[must_use]
    pub fn has_all(&self) -> bool {
        self.sample.scale <= 1.0 && self.copies <= 1.0
    }

    /// Blocks less their means.
    #[must_use]
    pub fn begin(&self, mean_shift: u32) -> State {
        let mut residuals = self.sample.values.clone();
        let unit = f64::from(1_u32 << mean_shift);
        residuals.par_chunks_mut(VOXELS).for_each(|block| {
            let mean = block.iter().map(|v| f64::from(*v)).sum::<f64>() / VOXELS as f64;
            let code = (mean / unit).round().min(f64::from(TOP as u32 >> mean_shift));
            block.iter_mut().for_each(|v| *v -= (code * unit) as f32);
        });
        let errors = residuals.par_chunks(VOXELS).map(energy).collect();
        State { residuals, errors }
    }

    /// A codebook for the remainder of some blocks.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn book(
        &self,
        state: &State,
        classes: &[u8],
        (members, partition): (&[usize], Partition),
        size: usize,
        run: &Progress<'_>,
    ) -> Result<Book, Cancelled> {
        let block = |i: usize| &state.residuals[i * VOXELS..(i + 1) * VOXELS];
        let vectors: Vec<f32> = if self.training.confined {
            let part = |i: &usize| {
                let zones = zones_of(partition) & CLASSES[classes[*i] as usize].zones;
                projected(&self.basis, block(*i), zones)
            };
            members.par_iter().flat_map_iter(part).collect()
        } else {
            members.iter().flat_map(|i| block(*i)).copied().collect()
        };
        let weights: Vec<f64> = members.iter().map(|i| self.sample.weights[*i]).collect();
        let classes: Vec<u8> = members.iter().map(|i| classes[*i]).collect();
        let population = Population { vectors, weights: &weights, classes: &classes };
        Book::train(population, partition, size, &self.training.recipe, run)
    }

    /// Subtracts the nearest codeword from each of some blocks.
    pub fn subtract(state: &mut State, book: &Book, members: &[usize]) {
        for members in members.chunks(AT_ONCE) {
            let gathered: Vec<f32> = members
                .iter()
                .flat_map(|i| &state.residuals[i * VOXELS..(i + 1) * VOXELS])
                .copied()
                .collect();
            for (i, nearest) in members.iter().zip(book.nearest(&gathered)) {
                let codeword = book.codebook.codeword(nearest.index as usize);
                let block = &mut state.residuals[i * VOXELS..(i + 1) * VOXELS];
                block.iter_mut().zip(codeword).for_each(|(r, c)| *r -= c);
                state.errors[*i] = nearest.distance;
            }
        }
    }

    /// One codebook of each partition, with at most these sizes.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn fixed(
        &self,
        sizes: [usize; 3],
        mean_shift: u32,
        threshold: f64,
        run: &Progress<'_>,
    ) -> Result<Vec<Book>, Cancelled> {
        let classes = self.classes(threshold);
        let mut state = self.begin(mean_shift);
        let all: Vec<usize> = (0..self.sample.len()).collect();
        let mut books = Vec::new();
        for (p, partition) in Partition::ALL.into_iter().enumerate() {
            let book = self.partition(&state, &classes, partition, sizes[p], run)?;
            if sizes[p + 1..].iter().any(|size| *size > 1) {
                Self::subtract(&mut state, &book, &all);
            }
            books.push(book);
        }
        Ok(books)
    }

    /// Whether blocks of a class train a partition's codebook. If codevectors are not confined to zones, all do.
    /// Classes that do not need the partition have no chapter; their blocks take part in refining the whole codebook.
    #[must_use]
    pub fn trains(&self, class: u8, partition: Partition) -> bool {
        !self.training.confined || keeps(class, partition)
    }

    /// The codebook of one partition. If no class keeps the partition, all blocks train it.
    fn partition(
        &self,
        state: &State,
        classes: &[u8],
        partition: Partition,
        size: usize,
        run: &Progress<'_>,
    ) -> Result<Book, Cancelled> {
        let mut members: Vec<usize> =
            (0..classes.len()).filter(|i| self.trains(classes[*i], partition)).collect();
        if members.is_empty() {
            members = (0..classes.len()).collect();
        }
        self.book(state, classes, (&members, partition), size, run)
    }

    /// Bits of a codeword in all tables that have such codebooks.
    #[must_use]
    pub fn codeword_bits(&self) -> f64 {
        VOXELS as f64 * f64::from(self.training.recipe.entry_bits) * self.copies
    }

    /// The partition with most of the remaining energy.
    #[must_use]
    pub fn leading(&self, state: &State) -> Partition {
        let every = self.sample.len().div_ceil(LEADING_BLOCKS).max(1);
        let mut sums = [0.0; 3];
        for i in (0..self.sample.len()).step_by(every) {
            let energies = energies(&self.basis, &state.residuals[i * VOXELS..(i + 1) * VOXELS]);
            for (sum, partition) in sums.iter_mut().zip(Partition::ALL) {
                let zones = zones_of(partition);
                *sum += (0..ZONES).filter(|z| zones >> z & 1 == 1).map(|z| energies[z]).sum::<f64>();
            }
        }
        let [low, band, high] = sums;
        if low >= band.max(high) {
            Partition::Low
        } else if band >= high {
            Partition::Band
        } else {
            Partition::High
        }
    }
}
