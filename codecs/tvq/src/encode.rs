//! The encoder: what both payloads share, from the value range to the last tensor.

use cvr_codebook::lbg::Stop;
use cvr_codebook::{Quantiser, sample};
use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::value_range;
use cvr_core::volume::{BrickSource, Extent, VolumeLayout};
use serde_json::json;

use crate::blocks::Domain;
use crate::books::{Book, Recipe};
use crate::code::{Coder, Plane};
use crate::fixed;
use crate::geometry::{
    Geometry, Parameters, Payload, VALUE_BITS, VOXELS, block, block_grid, positions, sub_blocks,
};
use crate::payload::packed_entries;
use crate::plan::{COARSE, fixed_bits, plan};
use crate::settings::{CODE_BITS, MEAN_BITS, Options, Target};
use crate::settle::Aim;
use crate::table::{BookForm, Table};
use crate::train::Training;
use crate::variable::{self, Kept};
use crate::{CODEBOOK, HEADS, INDEX, TABLES};

/// The container's header is a multiple of so many bytes.
const HEADER_BYTES: f64 = 2048.0;
/// What is in it at least, as a rule, and for each frame and set of tables.
const HEADER_USED: [f64; 3] = [1800.0, 10.0, 10.0];
/// Blocks that pay for full codebooks, without a target.
const FULL_BLOCKS: f64 = 4096.0;
/// A round of training that gains less than this part of the distortion is the last.
const GAIN: f64 = 2e-3;

/// Encodes with one set of settings.
#[derive(Debug)]
pub struct TvqEncoder {
    pub options: Options,
}

/// What every step of encoding needs to know.
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
    /// Sets of tables, and in each the domain of every sub-volume.
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

/// Everything that a stream holds beside codebooks.
#[derive(Debug)]
pub struct Written {
    /// By set and sub-volume.
    pub tables: Vec<Vec<Table>>,
    /// Codebooks of a table.
    pub books: u32,
    /// Per frame: heads and indices.
    pub frames: Vec<(Vec<u32>, Vec<u32>)>,
    /// Sentences for the user.
    pub notes: Vec<String>,
    /// For the record.
    pub training: serde_json::Value,
}

impl Encoder for TvqEncoder {
    /// Codes and errors of all blocks under the codebooks that are compared: measured at 256³ as 1.5 and 3.3 bytes a sample.
    fn scratch_bytes(&self, layout: &VolumeLayout) -> u64 {
        let per_sample = match self.options.payload {
            Payload::Fixed => 2,
            Payload::Variable => 4,
        };
        per_sample * layout.samples()
    }

    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let layout = source.layout().clone();
        let range = value_range(source, block(), run)?;
        let quantiser = Quantiser::over(range, VALUE_BITS, layout.sample.is_integer())
            .map_err(EncodeError::Unsupported)?;
        let options = self.options;
        let sets = domains(&layout, &options);
        let mut work = Work { source, run, options, layout, quantiser, span: range.span(), sets };
        if let Target::Both { rate, psnr } = options.target {
            work.options.target = Target::Psnr(psnr);
            let (coded, kept) = work.code()?;
            if work.bits(&coded, kept.as_ref()) <= rate * work.samples() {
                return work.write(&coded, kept.as_ref(), out);
            }
            work.options = Options { target: Target::Rate(rate), ..options };
        }
        let (coded, kept) = work.code()?;
        work.write(&coded, kept.as_ref(), out)
    }
}

/// Sets of tables, and in each the domain of every sub-volume.
fn domains(layout: &VolumeLayout, options: &Options) -> Vec<Vec<Domain>> {
    let grid = block_grid(layout.extent);
    let size = sub_blocks(grid, options.subvolume);
    let sub_grid = grid.blocks_of(Extent::try_from(size).unwrap_or(Extent::ONE)).to_array();
    let frames_per_set = if options.per_frame { 1 } else { layout.frames };
    let of_set = |frame: u32| {
        let of_sub = |sub: [u32; 3]| {
            let first = [0, 1, 2].map(|a| sub[a] * size[a]);
            let size = [0, 1, 2].map(|a| size[a].min(grid.to_array()[a] - first[a]));
            Domain { frames: frame..frame + frames_per_set, channels: layout.channels, first, size }
        };
        positions(sub_grid).map(of_sub).collect()
    };
    (0..layout.frames).step_by(frames_per_set as usize).map(of_set).collect()
}

impl Work<'_> {
    /// Codebooks and codes, and how many codes each block keeps. Entries have as many bits as suits these from then on.
    fn code(&mut self) -> Result<(Sets, Option<Kept>), EncodeError> {
        match self.options.payload {
            Payload::Fixed => Ok((fixed::encode(self)?, None)),
            Payload::Variable => {
                let plan = plan(self)?;
                self.options.entry_bits = Some(plan.entry_bits);
                variable::encode(self, plan).map(|(coded, kept)| (coded, Some(kept)))
            }
        }
    }

    /// Bits of an entry.
    pub fn entry_bits(&self) -> u32 {
        self.options.entry_bits.unwrap_or(COARSE)
    }

    /// The same with entries of so many bits.
    #[must_use]
    pub fn with_entry_bits(&self, bits: u32) -> Self {
        Self { options: Options { entry_bits: Some(bits), ..self.options }, ..self.clone() }
    }

    /// Bits of the whole file, about.
    fn bits(&self, coded: &[Vec<Coded>], kept: Option<&Kept>) -> f64 {
        match kept {
            None => fixed::bits(self, coded) + self.overhead(3),
            Some(kept) => variable::bits(self, coded, kept),
        }
    }

    /// How codebooks are trained; `quick` for those that only tell what is to be expected.
    pub fn training(&self, quick: bool) -> Training {
        let rounds = if quick { self.options.iterations.min(2) } else { self.options.iterations };
        let recipe = Recipe {
            initial: self.options.initial,
            seed: self.options.seed,
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

    /// Blocks of the volume, those of all frames and channels.
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

    /// Bits of the container's header, about.
    fn header_bits(&self) -> f64 {
        let [used, per_frame, per_set] = HEADER_USED;
        let (frames, sets) = (f64::from(self.layout.frames), self.sets.len() as f64);
        let used = used + frames * per_frame + sets * per_set;
        8.0 * HEADER_BYTES * (used / HEADER_BYTES).ceil()
    }

    /// Bits of everything but means, codes and codebooks.
    pub fn overhead(&self, books: u32) -> f64 {
        // A word behind each frame, and a last word of each set's codebooks that is not full.
        let ends = 64.0 * f64::from(self.layout.frames) + 32.0 * self.sets.len() as f64;
        self.header_bits() + ends + self.tables() * 32.0 * f64::from(5 + 3 * books)
    }

    /// The threshold of the classes in units of sums; `expected` where it is automatic.
    pub fn threshold(&self, expected: f64) -> f64 {
        if self.options.threshold > 0.0 { self.options.threshold / self.unit() } else { expected }
    }

    /// The step of means that suits an error (root mean square, in units of sums): what it adds is small beside that.
    pub fn mean_shift(&self, expected: f64) -> u32 {
        ((0.4 * expected).max(1.0).log2().floor() as u32).min(VALUE_BITS - 2)
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

    /// What the payload `variable` is to reach; errors in data units.
    pub fn aim(&self) -> Aim {
        match self.options.target {
            Target::Rate(rate) => Aim::Bits(rate * self.samples()),
            Target::Psnr(psnr) | Target::Both { psnr, .. } => Aim::Error(self.error_of(psnr)),
            Target::Codes => {
                let [codes, means, books] = self.default_bits();
                Aim::Bits(codes + means + books + fixed_bits(self, 3, 0.0))
            }
        }
    }

    /// Without a target: bits of codes, of means and of codebooks. Blocks pay for a codebook: 256 codewords of each partition
    /// where there are blocks enough, and fewer in proportion where there are not. With tables and heads these are no more
    /// than half of the uncompressed volume.
    pub fn default_bits(&self) -> [f64; 3] {
        let (blocks, tables) = (self.blocks(), self.tables());
        let share = (blocks / tables / FULL_BLOCKS).min(1.0);
        let codewords = f64::from(CODE_BITS << 5) * share * tables;
        let books = codewords * VOXELS as f64 * f64::from(self.entry_bits());
        let bits = [f64::from(CODE_BITS) * blocks, f64::from(MEAN_BITS) * blocks, books];
        let raw = 8.0 * self.samples() * self.layout.sample.bytes() as f64;
        let beside = fixed_bits(self, 3, 0.0) - self.header_bits();
        let part = (0.5 * raw - beside) / bits.iter().sum::<f64>();
        bits.map(|bits| bits * part.clamp(0.0, 1.0))
    }

    /// Codebooks, tables and frames into tensors.
    fn write(
        &self,
        coded: &[Vec<Coded>],
        kept: Option<&Kept>,
        out: &mut dyn StreamWriter,
    ) -> Result<EncodeReport, EncodeError> {
        let written = match kept {
            None => fixed::written(self, coded),
            Some(kept) => variable::written(self, coded, kept)?,
        };
        let mut entries = Vec::new();
        let mut codebooks = Vec::new();
        for set in coded {
            let codes =
                || set.iter().flat_map(|c| &c.books).flat_map(|book| book.codebook.codes().iter().copied());
            entries.push(codes().count() as u64);
            codebooks.push(packed_entries(codes(), self.entry_bits()));
        }
        let parameters = Parameters {
            payload: self.options.payload,
            grid: block_grid(self.layout.extent).to_array(),
            subvolume: self.options.subvolume,
            offset: self.quantiser.offset(),
            step: self.quantiser.step(),
            entry_bits: self.entry_bits(),
            books: written.books,
            tables: self.sets.len() as u32,
            entries,
            frame_words: written.frames.iter().map(|f| f.1.len() as u64).collect(),
            training: written.training,
        };
        let Some(geometry) = Geometry::new(&self.layout, &parameters) else {
            return Err(EncodeError::Unsupported("sizes are outside the stream's ranges".to_owned()));
        };
        for (tables, codebook) in written.tables.iter().zip(&codebooks) {
            for table in tables {
                out.append_words(TABLES, &table.words())?;
            }
            out.append_words(CODEBOOK, codebook)?;
        }
        for (heads, index) in &written.frames {
            if self.options.payload == Payload::Variable {
                out.append_words(HEADS, heads)?;
            }
            out.append_words(INDEX, index)?;
        }
        let sub_volumes = geometry.sub_grid.voxels();
        out.shape(TABLES, &[self.sets.len() as u64, sub_volumes, geometry.table_words().into()])?;
        if self.options.payload == Payload::Variable {
            out.shape(HEADS, &[self.layout.frames.into(), geometry.frame_heads()])?;
        }
        out.parameters_of(&parameters)?;
        let error_bound = self.worst(coded, kept)?;
        Ok(EncodeReport { error_bound: Some(error_bound), notes: written.notes })
    }

    /// The largest error of a sample, integers rounded.
    fn worst(&self, coded: &[Vec<Coded>], kept: Option<&Kept>) -> Result<f64, EncodeError> {
        let mut worst = 0.0_f64;
        for (s, (set, domains)) in coded.iter().zip(&self.sets).enumerate() {
            for (d, (coded, domain)) in set.iter().zip(domains).enumerate() {
                let coder = self.coder(&coded.books, coded.mean_shift, 0.0);
                let kept = kept.map(|kept| &kept[s][d][..]);
                worst = worst.max(coder.worst(self.source, domain, &coded.planes, kept, self.run)?);
            }
        }
        Ok(worst)
    }

    /// What goes into the record of every stream.
    pub fn record(&self, coded: &[Vec<Coded>], payload: &serde_json::Value) -> serde_json::Value {
        let codewords: usize = coded.iter().flatten().flat_map(|c| &c.books).map(Book::size).sum();
        json!({
            "initial": self.options.initial.name(),
            "generator": sample::GENERATOR,
            "seed": self.options.seed,
            "codewords": codewords,
            "payload": payload,
        })
    }
}

/// Forms of the codebooks of a table that begin at entry `first`; with a width of their own each, or none.
pub fn forms(books: &[Book], first: &mut u32, widths: bool) -> Vec<BookForm> {
    let form = |book: &Book| {
        let size = book.size() as u32;
        let begin = *first;
        *first += size * VOXELS as u32;
        BookForm {
            first: begin,
            size,
            width: if widths { book.width() } else { 0 },
            scale: book.scale,
            partition: book.partition,
        }
    };
    books.iter().map(form).collect()
}
