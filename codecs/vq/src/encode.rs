//! The encoder: trains a codebook on some of the blocks, then finds the nearest codeword of every block.

use cvr_codebook::blocks::{cuts, inside};
use cvr_codebook::lbg::Stop;
use cvr_codebook::pack::BitPacker;
use cvr_codebook::settings::TrainingSettings;
use cvr_codebook::{Codebook, Quantiser, Search, Training, sample, train};
use cvr_core::codec::{Block, EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::{BlockRow, code_frame, value_range};
use cvr_core::volume::{BrickSource, FrameIndex};

use crate::geometry::{Geometry, Parameters, TrainingRecord};
use crate::{CODEBOOK, INDEX};

/// Training stops after a round that reduces the distortion by less than this fraction.
const GAIN: f64 = 1e-3;

/// Encodes with one set of settings.
#[derive(Debug)]
pub struct VqEncoder {
    pub block: Block,
    pub codewords: u32,
    pub codeword_bits: u32,
    pub training: TrainingSettings,
}

impl Encoder for VqEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let (layout, with) = (source.layout().clone(), self.training);
        let range = value_range(source, self.block, run)?;
        let quantiser = Quantiser::over(range, self.codeword_bits, layout.sample.is_integer())
            .map_err(EncodeError::Unsupported)?;
        let mut record = TrainingRecord {
            initial: with.initial.name().to_owned(),
            generator: sample::GENERATOR.to_owned(),
            seed: with.seed,
            blocks: Vec::new(),
            rounds: Vec::new(),
        };
        let mut tables = Vec::new();
        for (frames, seed) in with.served(layout.frames).into_iter().zip(with.seed..) {
            let vectors = with.draw.vectors(source, self.block, frames, with.training_blocks, seed, run)?;
            let trained = train(&vectors, &self.training(quantiser, seed), run)?;
            record.blocks.push(vectors.len() as u64);
            record.rounds.push(trained.rounds);
            tables.push(trained.codebook);
        }
        let parameters = Parameters {
            block: self.block,
            grid: self.block.grid(layout.extent).to_array(),
            codeword_bits: self.codeword_bits,
            offset: quantiser.offset(),
            step: quantiser.step(),
            tables: tables.iter().map(|t| t.size() as u32).collect(),
            training: record,
        };
        let Some(geometry) = Geometry::new(&layout, &parameters) else {
            let problem = format!("a block of {} is outside the settings' ranges", self.block);
            return Err(EncodeError::Unsupported(problem));
        };
        for table in &tables {
            out.append_words(CODEBOOK, &table_words(table, &geometry))?;
        }
        let mut error_bound = 0.0_f64;
        for frame in (0..layout.frames).map(FrameIndex) {
            let table = &tables[geometry.table_of(frame.0)];
            let error = encode_frame(source, &geometry, frame, table, out, run)?;
            error_bound = error_bound.max(error);
        }
        out.shape(CODEBOOK, &geometry.codebook_shape())?;
        out.shape(INDEX, &geometry.index_shape(layout.frames))?;
        out.parameters_of(&parameters)?;
        Ok(EncodeReport { error_bound: Some(error_bound), notes: self.notes(&parameters.tables) })
    }
}

impl VqEncoder {
    fn training(&self, quantiser: Quantiser, seed: u64) -> Training {
        Training {
            size: self.codewords as usize,
            quantiser,
            initial: self.training.initial,
            seed,
            stop: Stop { rounds: self.training.iterations, gain: GAIN },
        }
    }

    fn notes(&self, tables: &[u32]) -> Vec<String> {
        let fewest = tables.iter().copied().min().unwrap_or(0);
        let note = || {
            format!(
                "{fewest} codewords serve where {} were asked for: the training blocks tell no more apart",
                self.codewords
            )
        };
        (fewest < self.codewords).then(note).into_iter().collect()
    }
}

/// A table as words, padded with zeros to the length of the largest.
fn table_words(table: &Codebook, geometry: &Geometry) -> Vec<u32> {
    let mut words = table.packed();
    words.resize(geometry.table_words() as usize, 0);
    words
}

/// Appends the indices of a frame. Returns the largest error of a voxel, integers rounded.
fn encode_frame(
    source: &dyn BrickSource,
    g: &Geometry,
    frame: FrameIndex,
    table: &Codebook,
    out: &mut dyn StreamWriter,
    run: &Progress<'_>,
) -> Result<f64, EncodeError> {
    let searches = Searches::new(g, table, source.layout().sample.is_integer());
    let mut packer = BitPacker::new(g.index_bits);
    let mut worst = 0.0_f64;
    let row = |by, bz| Ok(searches.row(&BlockRow::read(source, g.grid.block(), frame, by, bz)?));
    code_frame(&g.grid, 1, run, row, |rows| {
        let mut words = Vec::new();
        for (indices, error) in rows {
            indices.into_iter().for_each(|index| packer.push(index, &mut words));
            worst = worst.max(error);
        }
        Ok(out.append_words(INDEX, &words)?)
    })?;
    let mut last = Vec::new();
    packer.flush(&mut last);
    out.append_words(INDEX, &last)?;
    Ok(worst)
}

/// One search for whole blocks, and one for each way in which the border cuts blocks.
struct Searches<'a> {
    geometry: &'a Geometry,
    table: &'a Codebook,
    integers: bool,
    /// Size of a cut block in voxels, the components that it keeps, and the search among them.
    cuts: Vec<([usize; 3], Vec<bool>, Search<'a>)>,
}

impl<'a> Searches<'a> {
    fn new(geometry: &'a Geometry, table: &'a Codebook, integers: bool) -> Self {
        let of_cut = |cut| {
            let mask = inside(geometry.grid.block(), geometry.channels, cut);
            let all = mask.iter().all(|inside| *inside);
            let search = Search::new(table, (!all).then_some(&mask[..]));
            (cut, mask, search)
        };
        let cuts = cuts(geometry.grid.block(), geometry.grid.volume()).into_iter().map(of_cut).collect();
        Self { geometry, table, integers, cuts }
    }

    /// The indices of a row of blocks, and the largest error of a voxel.
    fn row(&self, row: &BlockRow) -> (Vec<u32>, f64) {
        let blocks = self.geometry.grid.blocks().x();
        let last = row.cut(blocks - 1);
        let (mut indices, mut worst) = (Vec::with_capacity(blocks as usize), 0.0_f64);
        let whole = if last == row.cut(0) { blocks } else { blocks - 1 };
        for part in [0..whole, whole..blocks] {
            let Some(cut) = part.clone().next().map(|bx| row.cut(bx)) else { continue };
            let Some((_, mask, search)) = self.cuts.iter().find(|c| c.0 == cut) else { continue };
            let mut vectors = Vec::with_capacity(part.len() * self.table.dimension());
            part.for_each(|bx| row.append(bx, &mut vectors));
            let nearest = search.rows(&vectors);
            for (vector, nearest) in vectors.chunks_exact(self.table.dimension()).zip(nearest) {
                indices.push(nearest.index);
                let codeword = self.table.codeword(nearest.index as usize);
                for ((v, c), _) in vector.iter().zip(codeword).zip(mask).filter(|(_, inside)| **inside) {
                    let shown = if self.integers { c.round() } else { *c };
                    worst = worst.max((f64::from(shown) - f64::from(*v)).abs());
                }
            }
        }
        (indices, worst)
    }
}
