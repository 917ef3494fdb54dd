//! The encoder: codebooks from a part of the blocks, then the codes of every block.

mod beam;
mod refine;
mod sizes;
mod stage;

use cvr_codebook::pack::BitPacker;
use cvr_codebook::{Quantiser, Vectors, sample};
use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::{BlockRow, Measured, code_frame, value_range};
use cvr_core::volume::{BrickSource, FrameIndex, VolumeLayout};
use cvr_groups::VALUE_BITS;

use crate::settings::Options;
use crate::stream::{
    BASE, CODEBOOK, Entries, Geometry, INDEX, Parameters, TOP, Table, TrainingRecord, block,
};
use beam::Coder;
use stage::Stage;

/// Encodes with one set of settings.
#[derive(Debug)]
pub struct RvqEncoder {
    pub options: Options,
}

/// A set of codebooks, and how it came about.
struct Trained {
    stages: Vec<Stage>,
    blocks: u64,
    refinement: u32,
}

impl Encoder for RvqEncoder {
    /// Training blocks, what is left of them, and one row of blocks for each thread.
    fn scratch_bytes(&self, layout: &VolumeLayout) -> u64 {
        let block = 4 * 64 * u64::from(layout.channels);
        3 * block * self.options.training.training_blocks.min(layout.samples() / 64 + 1)
    }

    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let (layout, options) = (source.layout().clone(), self.options);
        let entries = options.entries.unwrap_or(Entries::natural(layout.channels));
        let range = value_range(source, block(0), run)?;
        let quantiser = Quantiser::over(range, VALUE_BITS, layout.sample.is_integer())
            .map_err(EncodeError::Unsupported)?;
        let codewords = options.codewords.unwrap_or_else(|| sizes::automatic(&layout, options, entries));
        let mut tables = Vec::new();
        for (frames, seed) in options.training.served(layout.frames).into_iter().zip(options.training.seed..)
        {
            let draw = options.training.draw;
            let count = options.training.training_blocks;
            let mut vectors = draw.vectors(source, block(0), frames, count, seed, run)?;
            to_sums(quantiser, vectors.values_mut());
            tables.push(self.train(vectors, (codewords as usize, entries), seed, run)?);
        }
        let parameters = Parameters {
            grid: block(0).grid(layout.extent).to_array(),
            offset: quantiser.offset(),
            step: quantiser.step(),
            entries,
            tables: tables.iter().map(Trained::table).collect(),
            training: self.record(&tables),
        };
        let geometry = Geometry::of_stream(&layout, &parameters).map_err(EncodeError::Unsupported)?;
        for table in &tables {
            out.append_words(CODEBOOK, &stage::packed(&table.stages, &geometry))?;
        }
        let mut measured = Measured::NOTHING;
        for frame in 0..layout.frames {
            let stages = &tables[geometry.table_of(frame)].stages;
            let coder = Coder::new(stages, options.beam);
            measured = measured.and(encode_frame(source, &geometry, FrameIndex(frame), &coder, out, run)?);
        }
        out.shape(CODEBOOK, &geometry.codebook_shape())?;
        out.shape(INDEX, &geometry.index_shape())?;
        out.parameters_of(&parameters)?;
        Ok(EncodeReport { error_bound: Some(measured.error), notes: notes(&parameters.tables, codewords) })
    }
}

impl RvqEncoder {
    fn train(
        &self,
        vectors: Vectors,
        (size, entries): (usize, Entries),
        seed: u64,
        run: &Progress<'_>,
    ) -> Result<Trained, EncodeError> {
        let (options, blocks) = (self.options, vectors.len() as u64);
        let mut left = vectors.clone();
        let mut stages = Vec::new();
        for s in 0..options.stages {
            let stage = Stage::train(&left, (size, s == 0), entries, &options.training, seed, run)?;
            stage.subtract_nearest(&mut left);
            stages.push(stage);
        }
        drop(left);
        let refinement =
            refine::jointly(&vectors, &mut stages, entries, (options.beam, options.refinement), run)?;
        Ok(Trained { stages, blocks, refinement })
    }

    fn record(&self, tables: &[Trained]) -> TrainingRecord {
        TrainingRecord {
            initial: self.options.training.initial.name().to_owned(),
            generator: sample::GENERATOR.to_owned(),
            seed: self.options.training.seed,
            beam: self.options.beam,
            blocks: tables.iter().map(|t| t.blocks).collect(),
            refinement: tables.iter().map(|t| t.refinement).collect(),
        }
    }
}

impl Trained {
    /// As the stream states it.
    fn table(&self) -> Table {
        Table {
            codewords: self.stages.iter().map(|s| s.codebook.size() as u32).collect(),
            scales: self.stages.iter().map(|s| s.scale.byte() as u8).collect(),
        }
    }
}

/// What a user should know of codebooks that are smaller than was asked for.
fn notes(tables: &[Table], asked: u32) -> Vec<String> {
    let fewest = tables.iter().flat_map(|t| &t.codewords).copied().min().unwrap_or(0);
    let note = || {
        format!(
            "{fewest} codewords serve a stage where {asked} were asked for: the training blocks differ no more there"
        )
    };
    // One fewer is the zero vector, which training may find by itself.
    (fewest + 1 < asked).then(note).into_iter().collect()
}

/// Data units become units of sums, counted from the middle value.
fn to_sums(quantiser: Quantiser, values: &mut [f32]) {
    let (offset, scale) = (f64::from(quantiser.offset()), 1.0 / f64::from(quantiser.step()));
    values.iter_mut().for_each(|v| *v = ((f64::from(*v) - offset) * scale - f64::from(BASE)) as f32);
}

/// Appends the codes of a frame; returns the errors of its voxels.
fn encode_frame(
    source: &dyn BrickSource,
    g: &Geometry,
    frame: FrameIndex,
    coder: &Coder<'_>,
    out: &mut dyn StreamWriter,
    run: &Progress<'_>,
) -> Result<Measured, EncodeError> {
    let integers = source.layout().sample.is_integer();
    let mut packer = BitPacker::new(g.index_bits);
    let mut measured = Measured::NOTHING;
    let row = |by, bz| Ok(code_row(g, coder, &BlockRow::read(source, block(0), frame, by, bz)?, integers));
    code_frame(&g.grids[0], 1, run, row, |rows| {
        let mut words = Vec::new();
        for (codes, of_row) in rows {
            codes.into_iter().for_each(|code| packer.push(code, &mut words));
            measured = measured.and(of_row);
        }
        Ok(out.append_words(INDEX, &words)?)
    })?;
    let mut last = Vec::new();
    packer.flush(&mut last);
    out.append_words(INDEX, &last)?;
    Ok(measured)
}

/// The codes of a row of blocks, and the errors of its voxels. Blocks that the volume's border cuts are filled up: what lies
/// outside is part of the means at coarser resolutions.
fn code_row(g: &Geometry, coder: &Coder<'_>, row: &BlockRow, integers: bool) -> (Vec<u32>, Measured) {
    let (blocks, dimension) = (g.grids[0].blocks().x(), g.dimension() as usize);
    let mut samples = Vec::with_capacity(blocks as usize * dimension);
    (0..blocks).for_each(|bx| row.append(bx, &mut samples));
    let mut sums = samples.clone();
    to_sums(g.quantiser, &mut sums);
    let inside: Vec<Vec<bool>> =
        (0..blocks).map(|bx| cvr_codebook::blocks::inside(block(0), g.channels, row.cut(bx))).collect();
    let codes = coder.code(&sums, |bx| Some(&inside[bx][..]).filter(|inside| !inside.iter().all(|i| *i)));
    let mut measured = Measured::NOTHING;
    let of_blocks = samples.chunks_exact(dimension).zip(codes.chunks_exact(g.stages as usize));
    for (inside, (samples, codes)) in inside.iter().zip(of_blocks) {
        for (i, sample) in samples.iter().enumerate().filter(|(i, _)| inside[*i]) {
            let sum = coder.sum(codes, i) + BASE;
            measured.add(*sample, g.quantiser.value(sum.clamp(0, TOP) as u32), integers);
        }
    }
    (codes, measured)
}
