//! The encoder: codebooks from a part of the blocks, then the codes of every block.

mod beam;
mod fixed;
mod refine;
mod sizes;
mod stage;
mod variable;

use cvr_codebook::{Quantiser, Vectors, sample};
use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::{Measured, value_range};
use cvr_core::volume::{BrickSource, FrameIndex, VolumeLayout};
use cvr_groups::VALUE_BITS;

use crate::settings::Options;
use crate::stream::{
    BASE, CODEBOOK, Entries, Geometry, INDEX, Parameters, Payload, Table, TrainingRecord, block,
};
use beam::Coder;
use fixed::encode_frame;
use stage::Stage;

/// Codes, errors and escapes of a block under the payload `variable`, as measured on bonsai at half a bit.
const CODED_BYTES: u64 = 320;

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
    /// Training blocks, what is left of them, and one row of blocks for each thread; under the payload `variable` the codes and
    /// errors of all blocks.
    fn scratch_bytes(&self, layout: &VolumeLayout) -> u64 {
        let block = 4 * 64 * u64::from(layout.channels);
        let blocks = layout.samples() / (64 * u64::from(layout.channels)) + 1;
        let coded = if self.options.payload == Payload::Variable { CODED_BYTES * blocks } else { 0 };
        3 * block * self.options.training.training_blocks.min(blocks) + coded
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
        if options.payload == Payload::Variable {
            return variable::encode(self, (source, out, run), (quantiser, range), entries);
        }
        let codewords = options.codewords.unwrap_or_else(|| sizes::automatic(&layout, options, entries));
        let mut tables = Vec::new();
        for (frames, seed) in options.training.served(layout.frames).into_iter().zip(options.training.seed..)
        {
            let draw = options.training.draw;
            let count = options.training.training_blocks;
            let mut vectors = draw.vectors(source, block(0), frames, count, seed, run)?;
            to_sums(quantiser, BASE, vectors.values_mut());
            tables.push(self.train(vectors, (codewords as usize, entries), seed, run)?);
        }
        // Tables of a stream have one number of stages.
        let most = tables.iter().map(|t| t.stages.len()).max().unwrap_or(1);
        for table in &mut tables {
            let dimension = table.stages[0].codebook.dimension();
            table.stages.resize_with(most, || Stage::zero(dimension, entries));
        }
        let parameters = Parameters {
            payload: Payload::Fixed,
            frame_words: Vec::new(),
            grid: block(0).grid(layout.extent).to_array(),
            offset: quantiser.offset(),
            step: quantiser.step(),
            entries,
            tables: tables.iter().map(Trained::table).collect(),
            training: self.record(
                tables.iter().map(|t| t.blocks).collect(),
                tables.iter().map(|t| t.refinement).collect(),
            ),
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
        Ok(EncodeReport {
            error_bound: Some(measured.error),
            notes: notes(&parameters.tables, options.stages, codewords),
        })
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
            // The stages before leave nothing that a codebook could learn.
            if s > 0 && stage.codebook.size() == 1 {
                break;
            }
            stage.subtract_nearest(&mut left);
            stages.push(stage);
        }
        drop(left);
        let refinement =
            refine::jointly(&vectors, &mut stages, entries, (options.refinement, 1), run, |stages| {
                Coder::new(stages, options.beam).code_all(vectors.values())
            })?;
        Ok(Trained { stages, blocks, refinement })
    }

    fn record(&self, blocks: Vec<u64>, refinement: Vec<u32>) -> TrainingRecord {
        TrainingRecord {
            initial: self.options.training.initial.name().to_owned(),
            generator: sample::GENERATOR.to_owned(),
            seed: self.options.training.seed,
            beam: self.options.beam,
            blocks,
            refinement,
        }
    }
}

impl Trained {
    /// As the stream states it.
    fn table(&self) -> Table {
        Table {
            codewords: self.stages.iter().map(|s| s.codebook.size() as u32).collect(),
            scales: self.stages.iter().map(|s| s.scale.byte() as u8).collect(),
            mean_shift: 0,
        }
    }
}

/// What a user should know of codebooks that are fewer or smaller than was asked for.
fn notes(tables: &[Table], stages: u32, asked: u32) -> Vec<String> {
    let most = tables.iter().map(|t| t.codewords.len()).max().unwrap_or(0) as u32;
    let fewest = tables.iter().flat_map(|t| &t.codewords).copied().min().unwrap_or(0);
    let mut notes = Vec::new();
    if most < stages {
        notes
            .push(format!("{most} of {stages} stages are stored: they leave nothing of the training blocks"));
    }
    // One fewer is the zero vector, which training may find by itself.
    if fewest + 1 < asked {
        notes.push(format!(
            "{fewest} codewords serve a stage where {asked} were asked for: the training blocks differ no more there"
        ));
    }
    notes
}

/// Data units become units of sums, counted from `base`.
fn to_sums(quantiser: Quantiser, base: i32, values: &mut [f32]) {
    let (offset, scale) = (f64::from(quantiser.offset()), 1.0 / f64::from(quantiser.step()));
    values.iter_mut().for_each(|v| *v = ((f64::from(*v) - offset) * scale - f64::from(base)) as f32);
}
