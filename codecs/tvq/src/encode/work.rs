//! Data that all steps of encoding share.

use std::ops::Range;

use cvr_codebook::Quantiser;
use cvr_codebook::lbg::Stop;
use cvr_core::codec::Progress;
use cvr_core::volume::{BrickSource, Extent, VolumeLayout};

use super::closed_loop::{Coder, Plane};
use super::domain::Domain;
use super::train::book::{Book, Recipe};
use super::train::trainer::Training;
use super::tuned::codebooks::{GAIN, HEADER_BYTES, HEADER_USED, MEAN_STEP, QUICK_ROUNDS};
use crate::settings::Options;
use crate::stream::geometry::{VALUE_BITS, block_grid, positions, sub_blocks};
use cvr_groups::KeptPlane;

/// Default bits of an entry.
pub const COARSE: u32 = 8;

/// Data that every step of encoding needs.
#[derive(Clone)]
pub struct Work<'a> {
    pub source: &'a dyn BrickSource,
    pub run: &'a Progress<'a>,
    pub options: Options,
    pub layout: VolumeLayout,
    /// Sums become values.
    pub quantiser: Quantiser,
    /// max − min, in data units.
    pub span: f64,
    /// Sets of tables. Each holds the domain of every sub-volume.
    pub sets: Vec<Vec<Domain>>,
}

/// One table, and the codes of its domain.
#[derive(Debug)]
pub struct Coded {
    pub books: Vec<Book>,
    pub mean_shift: u32,
    /// Frame by frame, channel by channel.
    pub planes: Vec<Plane>,
}

/// The tables of every set, by sub-volume.
pub type Sets = Vec<Vec<Coded>>;

/// By set, sub-volume and plane: what blocks keep.
pub type Kept = Vec<Vec<Vec<KeptPlane>>>;

impl Work<'_> {
    /// Bits of an entry.
    pub fn entry_bits(&self) -> u32 {
        self.options.entry_bits.unwrap_or(COARSE)
    }

    /// The same with entries of `bits` bits.
    #[must_use]
    pub fn with_entry_bits(&self, bits: u32) -> Self {
        Self { options: Options { entry_bits: Some(bits), ..self.options }, ..self.clone() }
    }

    /// Settings of training. `quick` is for codebooks that only give an estimate.
    pub fn training(&self, quick: bool) -> Training {
        let with = self.options.training;
        let rounds = if quick { with.iterations.min(QUICK_ROUNDS) } else { with.iterations };
        let recipe = Recipe {
            initial: with.initial,
            seed: with.seed,
            chapter: Stop { rounds, gain: GAIN },
            whole: Stop { rounds: 2 * rounds, gain: GAIN },
            entry_bits: self.entry_bits(),
        };
        Training {
            transform: self.options.transform,
            classification: self.options.classification,
            confined: self.options.confined,
            most_books: self.options.codes,
            recipe,
        }
    }

    /// Data units per unit of the sums.
    pub fn unit(&self) -> f64 {
        f64::from(self.quantiser.step())
    }

    /// Samples of the volume.
    pub fn samples(&self) -> f64 {
        self.layout.samples() as f64
    }

    /// Number of blocks of the volume, over all frames and channels.
    pub fn blocks(&self) -> f64 {
        self.domains().map(|d| d.blocks() as f64).sum()
    }

    /// All domains.
    pub fn domains(&self) -> impl Iterator<Item = &Domain> {
        self.sets.iter().flatten()
    }

    /// Tables of the stream.
    pub fn tables(&self) -> f64 {
        self.domains().count() as f64
    }

    /// Approximate bits of the container's header.
    pub fn header_bits(&self) -> f64 {
        let [used, per_frame, per_set] = HEADER_USED;
        let (frames, sets) = (f64::from(self.layout.frames), self.sets.len() as f64);
        let used = used + frames * per_frame + sets * per_set;
        8.0 * HEADER_BYTES * (used / HEADER_BYTES).ceil()
    }

    /// Bits of everything except means, codes and codebooks.
    pub fn overhead(&self, books: u32) -> f64 {
        // A word after each frame, and the partly used last word of each set's codebooks.
        let ends = 64.0 * f64::from(self.layout.frames) + 32.0 * self.sets.len() as f64;
        self.header_bits() + ends + self.tables() * 32.0 * f64::from(5 + 3 * books)
    }

    /// The threshold of the classes in units of sums. `expected` if it is automatic.
    pub fn threshold(&self, expected: f64) -> f64 {
        if self.options.threshold > 0.0 { self.options.threshold / self.unit() } else { expected }
    }

    /// The step of means for an error (root mean square, in units of sums). Its own error is small compared with that.
    pub fn mean_shift(&self, expected: f64) -> u32 {
        ((MEAN_STEP * expected).max(1.0).log2().floor() as u32).min(VALUE_BITS - 2)
    }

    /// The search that codes with some codebooks.
    pub fn coder<'b>(&self, books: &'b [Book], mean_shift: u32, enough: f64) -> Coder<'b> {
        Coder {
            books,
            mean_shift,
            quantiser: self.quantiser,
            integers: self.layout.sample.is_integer(),
            enough,
            extent: self.layout.extent,
        }
    }

    /// PSNR in dB of a squared error over all samples.
    pub fn psnr(&self, error: f64) -> f64 {
        10.0 * (self.span * self.span * self.samples() / error).log10()
    }

    /// The squared error over all samples that a PSNR allows.
    pub fn error_of(&self, psnr: f64) -> f64 {
        self.span * self.span * self.samples() / 10_f64.powf(psnr / 10.0)
    }
}

/// Sets of tables. Each holds the domain of every sub-volume.
pub fn domains(layout: &VolumeLayout, options: &Options) -> Vec<Vec<Domain>> {
    let grid = block_grid(layout.extent);
    let size = sub_blocks(grid, options.subvolume);
    let sub_grid = grid.blocks_of(Extent::try_from(size).unwrap_or(Extent::ONE)).to_array();
    let of_set = |frames: Range<u32>| {
        let of_sub = |sub: [u32; 3]| {
            let first = [0, 1, 2].map(|a| sub[a] * size[a]);
            let size = [0, 1, 2].map(|a| size[a].min(grid.to_array()[a] - first[a]));
            Domain { frames: frames.clone(), channels: layout.channels, first, size }
        };
        positions(sub_grid).map(of_sub).collect()
    };
    options.training.served(layout.frames).into_iter().map(of_set).collect()
}
