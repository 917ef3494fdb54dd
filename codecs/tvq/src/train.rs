//! From blocks to the codebooks of one table, partition by partition, each on what those before it leave.

use cvr_core::codec::{Cancelled, Progress};
use rayon::prelude::*;

use crate::blocks::Sample;
use crate::books::{Book, Population, Recipe};
use crate::classify::{CLASSES, WHOLE, class_of, energies, keeps, projected, zones_of};
use crate::geometry::{TOP, VOXELS};
use crate::table::Partition;
use crate::transform::{Basis, Transform, ZONES};

/// What training may assume.
#[derive(Copy, Clone, Debug)]
pub struct Training {
    /// Basis of the zones.
    pub transform: Transform,
    /// Whether blocks are told apart by class.
    pub classification: bool,
    /// Whether codevectors stay within the zones of their partition.
    pub confined: bool,
    /// Most codebooks of the payload `variable`.
    pub most_books: u32,
    /// How each codebook is trained.
    pub recipe: Recipe,
}

/// Blocks of one table, with their zones' energies.
#[derive(Debug)]
pub struct Trainer<'a> {
    sample: &'a Sample,
    basis: Basis,
    energies: Vec<[f64; ZONES]>,
    training: Training,
    /// Tables that will each have such codebooks.
    pub copies: f64,
    /// Bits that all codebooks of all these tables may take: more would never be kept.
    pub most_bits: f64,
}

/// What the codebooks so far leave of the blocks.
#[derive(Clone, Debug)]
pub struct State {
    /// 64 values each.
    pub residuals: Vec<f32>,
    /// Squared error of each.
    pub errors: Vec<f64>,
}

/// Codebooks of the payload `variable`, and what they do to blocks.
#[derive(Debug)]
pub struct Outcome {
    /// Codebooks.
    pub books: Vec<Book>,
    /// Weighted squared errors, in units of sums, of the blocks on which codebooks are measured: before all, and after each.
    /// Empty where nothing was to be measured.
    pub errors: Vec<f64>,
    /// Blocks that each of these stands for.
    pub scale: f64,
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
    fn has_all(&self) -> bool {
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

    /// A codebook for what is left of some blocks.
    fn book(
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
        let population = Population { vectors: &vectors, weights: &weights, classes: &classes };
        Book::train(&population, partition, size, &self.training.recipe, run)
    }

    /// Takes the nearest codeword from each of some blocks.
    fn subtract(state: &mut State, book: &Book, members: &[usize]) {
        let gathered: Vec<f32> =
            members.iter().flat_map(|i| &state.residuals[i * VOXELS..(i + 1) * VOXELS]).copied().collect();
        for (i, nearest) in members.iter().zip(book.nearest(&gathered)) {
            let codeword = book.codebook.codeword(nearest.index as usize);
            let block = &mut state.residuals[i * VOXELS..(i + 1) * VOXELS];
            block.iter_mut().zip(codeword).for_each(|(r, c)| *r -= c);
            state.errors[*i] = nearest.distance;
        }
    }

    /// One codebook of each partition, of 2^width codewords at most.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn fixed(
        &self,
        widths: [u32; 3],
        mean_shift: u32,
        threshold: f64,
        run: &Progress<'_>,
    ) -> Result<Vec<Book>, Cancelled> {
        let classes = self.classes(threshold);
        let mut state = self.begin(mean_shift);
        let all: Vec<usize> = (0..self.sample.len()).collect();
        let mut books = Vec::new();
        for (partition, width) in Partition::ALL.into_iter().zip(widths) {
            let book = self.partition(&state, &classes, partition, width, run)?;
            Self::subtract(&mut state, &book, &all);
            books.push(book);
        }
        Ok(books)
    }

    /// Whether blocks of a class train a partition's codebook. Where codevectors keep to no zones, all do: those of a class
    /// that could do without have no chapter, and take part in refining the whole.
    fn trains(&self, class: u8, partition: Partition) -> bool {
        !self.training.confined || keeps(class, partition)
    }

    /// The codebook of one partition; all blocks train it where no class keeps the partition.
    fn partition(
        &self,
        state: &State,
        classes: &[u8],
        partition: Partition,
        width: u32,
        run: &Progress<'_>,
    ) -> Result<Book, Cancelled> {
        let mut members: Vec<usize> =
            (0..classes.len()).filter(|i| self.trains(classes[*i], partition)).collect();
        if members.is_empty() {
            members = (0..classes.len()).collect();
        }
        self.book(state, classes, (&members, partition), 1 << width, run)
    }

    /// The natural logarithm of the part of the error that is left after a partition's codebook of each of some widths,
    /// each partition after those before it, measured on blocks that did not train it; and the mean square before all.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn curves(
        &self,
        widths: &[u32],
        mean_shift: u32,
        threshold: f64,
        run: &Progress<'_>,
    ) -> Result<([Vec<f64>; 3], f64), Cancelled> {
        let classes = self.classes(threshold);
        let mut state = self.begin(mean_shift);
        let (train, test): (Vec<usize>, Vec<usize>) = (0..self.sample.len()).partition(|i| i % 3 != 2);
        let test = if test.is_empty() { train.clone() } else { test };
        let total = |state: &State| test.iter().map(|i| state.errors[*i]).sum::<f64>();
        let mean_square = total(&state) / (test.len() * VOXELS) as f64;
        let mut curves: [Vec<f64>; 3] = Default::default();
        for (curve, partition) in curves.iter_mut().zip(Partition::ALL) {
            let members: Vec<usize> =
                train.iter().copied().filter(|i| self.trains(classes[*i], partition)).collect();
            let before = total(&state);
            let mut after = None;
            for width in widths {
                if before <= 0.0 || members.is_empty() {
                    curve.push(0.0);
                    continue;
                }
                let book = self.book(&state, &classes, (&members, partition), 1 << width, run)?;
                let mut next = state.clone();
                Self::subtract(&mut next, &book, &test);
                curve.push((total(&next) / before).max(1e-9).ln());
                if *width == 7 || after.is_none() {
                    after = Some(book);
                }
            }
            if let Some(book) = after {
                let all: Vec<usize> = (0..self.sample.len()).collect();
                Self::subtract(&mut state, &book, &all);
            }
        }
        Ok((curves, mean_square))
    }

    /// Codebooks of at most 2^width codewords, as many as pay at `price` (squared error, in units of sums, per bit).
    /// With `measured` the outcome tells what they do. Where blocks are not all there are, a third of them then trains
    /// nothing, and codebooks are measured on that third alone: many codewords for few blocks then promise no more than
    /// they will keep. A codebook that has seen all blocks keeps what it shows on them.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn variable(
        &self,
        width: u32,
        price: f64,
        (mean_shift, threshold): (u32, f64),
        measured: bool,
        run: &Progress<'_>,
    ) -> Result<Outcome, Cancelled> {
        let classes = self.classes(threshold);
        let mut state = self.begin(mean_shift);
        let code_price = price * f64::from(width);
        let held_out = measured && !self.has_all() && self.sample.len() >= 6;
        let counts = |i: usize| !held_out || i % 3 == 2;
        let scale = self.sample.scale * if held_out { 3.0 } else { 1.0 };
        let weighted = |state: &State, i: usize| state.errors[i] * self.sample.weights[i];
        let shown = |state: &State| -> Vec<f64> {
            let blocks = (0..classes.len()).filter(|i| measured && counts(*i));
            blocks.map(|i| weighted(state, i)).collect()
        };
        // By codebook, and then by block.
        let mut errors = vec![shown(&state)];
        // Cost of each block at its best count of codes so far.
        let mut best: Vec<f64> = (0..classes.len()).map(|i| weighted(&state, i)).collect();
        let mut books: Vec<Book> = Vec::new();
        let mut bits = 0.0;
        let mut partition = Partition::Low;
        while (books.len() as u32) < self.training.most_books {
            partition = partition.max(self.leading(&state));
            let open = |i: &usize| {
                self.trains(classes[*i], partition) && state.errors[*i] * PART_GAINED > code_price
            };
            let members: Vec<usize> = (0..classes.len()).filter(open).collect();
            let blocks = members.len() as f64 * self.sample.scale / self.copies;
            let size = (1_usize << width).min((blocks / FEWEST_BLOCKS) as usize);
            if size < 2 {
                break;
            }
            let taught: Vec<usize> = members.iter().copied().filter(|i| !held_out || i % 3 != 2).collect();
            if taught.is_empty() {
                break;
            }
            let book = self.book(&state, &classes, (&taught, partition), size, run)?;
            Self::subtract(&mut state, &book, &members);
            let count = books.len() as u32 + 1;
            let mut gain = 0.0;
            for &i in &members {
                let cost = weighted(&state, i) + code_price * f64::from(count);
                if cost < best[i] {
                    gain += if counts(i) { best[i] - cost } else { 0.0 };
                    best[i] = cost;
                }
            }
            let book_bits = (book.size() * VOXELS) as f64 * f64::from(self.training.recipe.entry_bits);
            bits += book_bits * self.copies;
            if gain * scale <= price * book_bits * self.copies || bits > self.most_bits {
                break;
            }
            books.push(book);
            errors.push(shown(&state));
        }
        let blocks = errors.first().map_or(0, Vec::len);
        let errors = (0..blocks).flat_map(|i| errors.iter().map(move |of_book| of_book[i])).collect();
        Ok(Outcome { books, errors, scale })
    }

    /// The partition in which most of what is left lies.
    fn leading(&self, state: &State) -> Partition {
        const ENOUGH: usize = 2048;
        let every = self.sample.len().div_ceil(ENOUGH).max(1);
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

/// Part of a block's error that a code takes away, as a rule: blocks of which not even that would pay are not trained on.
const PART_GAINED: f64 = 0.35;
/// A codebook has no more codewords than one for so many blocks.
const FEWEST_BLOCKS: f64 = 4.0;
