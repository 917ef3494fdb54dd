//! Grows the codebooks of the payload `variable`, one after another. For each codebook the caller tries some sizes and
//! keeps one, until no codebook is worth its bits.

use cvr_core::codec::{Cancelled, Progress};

use crate::encode::train::book::Book;
use crate::encode::train::trainer::{State, Trainer};
use crate::encode::tuned::growth::{FEWEST_BLOCKS, HALVINGS, LEAST_HALF, PART_GAINED};
use crate::stream::table::Partition;
use cvr_groups::Expected;

/// A list of codebooks that grows.
pub struct Growth<'t, 'a> {
    trainer: &'t Trainer<'a>,
    classes: Vec<u8>,
    state: State,
    /// Squared error, in units of sums, that a code is worth.
    code_price: f64,
    /// Whether errors are measured, and whether on a third of the blocks that does not train.
    measured: bool,
    held_out: bool,
    expected: Expected,
    partition: Partition,
    books: Vec<Book>,
}

/// Blocks for which another codebook would pay.
pub struct Open {
    members: Vec<usize>,
    taught: Vec<usize>,
    /// Codewords that they are enough for.
    pub most: usize,
}

/// A codebook that may be added.
pub struct Candidate {
    pub book: Book,
    state: State,
}

impl Candidate {
    /// Bits of the codebook in all tables that have one.
    pub fn bits(&self, trainer: &Trainer<'_>) -> f64 {
        trainer.codeword_bits() * self.book.size() as f64
    }
}

impl<'t, 'a> Growth<'t, 'a> {
    /// An empty list. A code is worth `code_price`. With `measured`, errors are measured. If not all blocks are used, a
    /// third of them does not train, and errors are measured on that third: many codewords for few blocks then look no
    /// better than they are. With all blocks, errors are measured on the training blocks.
    #[must_use]
    pub fn new(
        trainer: &'t Trainer<'a>,
        code_price: f64,
        (mean_shift, threshold): (u32, f64),
        measured: bool,
        expected: Expected,
    ) -> Self {
        let classes = trainer.classes(threshold);
        let held_out = measured && !trainer.has_all() && classes.len() >= 6;
        let state = trainer.begin(mean_shift);
        let (partition, books) = (Partition::Low, Vec::new());
        Self { trainer, classes, state, code_price, measured, held_out, expected, partition, books }
    }

    /// Number of blocks that each measured block represents.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.trainer.sample.scale * if self.held_out { 3.0 } else { 1.0 }
    }

    /// Codebooks so far.
    #[must_use]
    pub fn books(&self) -> &[Book] {
        &self.books
    }

    /// The same, for good.
    #[must_use]
    pub fn into_books(self) -> Vec<Book> {
        self.books
    }

    fn counts(&self, i: usize) -> bool {
        !self.held_out || i % 3 == 2
    }

    fn weighted(&self, state: &State, i: usize) -> f64 {
        state.errors[i] * self.trainer.sample.weights[i]
    }

    /// What is left of a block, or what it costs to code that directly.
    fn cost(&self, state: &State, i: usize, price: f64) -> f64 {
        let error = self.weighted(state, i);
        self.expected.direct(error, price).map_or(error, |direct| direct.cost)
    }

    fn shown(&self, state: &State) -> Vec<f64> {
        let blocks = (0..self.classes.len()).filter(|i| self.measured && self.counts(*i));
        blocks.map(|i| self.weighted(state, i)).collect()
    }

    /// Weighted squared errors, in units of sums, of the blocks on which codebooks are measured.
    #[must_use]
    pub fn errors(&self) -> Vec<f64> {
        self.shown(&self.state)
    }

    /// The same after another codebook.
    #[must_use]
    pub fn errors_with(&self, candidate: &Candidate) -> Vec<f64> {
        self.shown(&candidate.state)
    }

    /// The blocks for which another codebook would pay, if there are enough for one.
    pub fn open(&mut self) -> Option<Open> {
        let trainer = self.trainer;
        if self.books.len() as u32 >= trainer.training.most_books {
            return None;
        }
        self.partition = self.partition.max(trainer.leading(&self.state));
        let open = |i: &usize| {
            trainer.trains(self.classes[*i], self.partition)
                && self.state.errors[*i] * PART_GAINED > self.code_price
        };
        let members: Vec<usize> = (0..self.classes.len()).filter(open).collect();
        let blocks = members.len() as f64 * trainer.sample.scale / trainer.copies;
        let taught: Vec<usize> = members.iter().copied().filter(|i| !self.held_out || i % 3 != 2).collect();
        let most = (blocks / FEWEST_BLOCKS) as usize;
        (most >= 2 && !taught.is_empty()).then_some(Open { members, taught, most })
    }

    /// A codebook of at most `size` codewords for such blocks.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn candidate(&self, open: &Open, size: usize, run: &Progress<'_>) -> Result<Candidate, Cancelled> {
        let of = (&open.taught[..], self.partition);
        let book = self.trainer.book(&self.state, &self.classes, of, size.min(open.most), run)?;
        let mut state = self.state.clone();
        Trainer::subtract(&mut state, &book, &open.members);
        Ok(Candidate { book, state })
    }

    /// Takes a codebook for good.
    pub fn push(&mut self, candidate: Candidate) {
        self.books.push(candidate.book);
        self.state = candidate.state;
    }

    /// Adds codebooks of these sizes, as far as there are blocks for them.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn of_sizes(&mut self, sizes: &[usize], run: &Progress<'_>) -> Result<(), Cancelled> {
        for size in sizes {
            let Some(open) = self.open() else { break };
            let candidate = self.candidate(&open, *size, run)?;
            self.push(candidate);
        }
        Ok(())
    }

    /// Adds codebooks of at most `size` codewords while they pay at `price` (squared error, in units of sums, per bit).
    /// A codebook that does not pay is halved before the list ends. Returns the errors before all and after each.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn at_price(
        &mut self,
        mut size: usize,
        price: f64,
        run: &Progress<'_>,
    ) -> Result<Vec<Vec<f64>>, Cancelled> {
        let trainer = self.trainer;
        let mut errors = vec![self.errors()];
        // Cost of each block at its best count of codes so far.
        let mut best: Vec<f64> = (0..self.classes.len()).map(|i| self.cost(&self.state, i, price)).collect();
        let mut bits = 0.0;
        let mut halvings = 0;
        while let Some(open) = self.open() {
            let left = (trainer.most_bits - bits) / trainer.codeword_bits();
            let fits = if left < size as f64 { left as usize } else { size };
            if fits.min(open.most) < 2 {
                break;
            }
            let candidate = self.candidate(&open, fits, run)?;
            let count = self.books.len() as u32 + 1;
            let cost = |i: usize| self.cost(&candidate.state, i, price) + self.code_price * f64::from(count);
            let counted = open.members.iter().filter(|i| self.counts(**i));
            let gain: f64 = counted.map(|i| (best[*i] - cost(*i)).max(0.0)).sum();
            let book_bits = candidate.bits(trainer);
            if gain * self.scale() <= price * book_bits {
                size = candidate.book.size() / 2;
                halvings += 1;
                if halvings > HALVINGS || size < LEAST_HALF {
                    break;
                }
                continue;
            }
            for &i in &open.members {
                best[i] = best[i].min(cost(i));
            }
            bits += book_bits;
            errors.push(self.errors_with(&candidate));
            self.push(candidate);
        }
        Ok(errors)
    }
}
