//! Encoding with a codec of blocks: rows of blocks run in parallel, and each record is decoded to measure the error.

use super::{BLOCKS, BlockCodec};
use crate::codec::{EncodeError, EncodeReport, Encoder, Progress, Settings};
use crate::container::StreamWriter;
use crate::kit::{BlockGrid, BlockRow, Measured, code_frame};
use crate::volume::{BrickSource, FrameIndex};

/// Slices coded at a time, at least. With flat blocks this still leaves enough rows for all threads.
const SLAB: u32 = 16;

/// Encodes with one codec.
#[derive(Debug)]
pub struct BlockEncoder<C> {
    pub codec: C,
    pub settings: Settings,
}

/// The records of a row of blocks, channel after channel.
type Row = Vec<u32>;

impl<C: BlockCodec> Encoder for BlockEncoder<C> {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        self.codec.measure(source, run)?;
        let (layout, block) = (source.layout(), self.codec.block());
        let (grid, channels) = (BlockGrid::new(block, layout.extent), layout.channels as usize);
        let [columns, rows, layers] = grid.blocks().to_array();
        let row_words = columns as usize * self.codec.record_words();
        let mut measured = Measured::NOTHING;
        for frame in (0..layout.frames).map(FrameIndex) {
            let row = |by, bz| {
                let voxels = BlockRow::read(source, block, frame, by, bz)?;
                Ok(self.row(&grid, channels, &voxels, layout.sample.is_integer()))
            };
            code_frame(&grid, SLAB, run, row, |slab: Vec<(Row, Measured)>| {
                measured = slab.iter().fold(measured, |all, (_, row)| all.and(*row));
                for layer in slab.chunks(rows as usize) {
                    for c in 0..channels {
                        for (words, _) in layer {
                            out.append_words(BLOCKS, &words[c * row_words..(c + 1) * row_words])?;
                        }
                    }
                }
                Ok(())
            })?;
        }
        let [frames, channels] = [layout.frames, layout.channels].map(u64::from);
        out.shape(BLOCKS, &[frames, layers.into(), channels, rows.into(), row_words as u64])?;
        match self.codec.parameters() {
            Some(parameters) => out.parameters(parameters),
            None => out.parameters_of(&self.settings)?,
        }
        Ok(EncodeReport { error_bound: Some(measured.error), notes: Vec::new() })
    }
}

impl<C: BlockCodec> BlockEncoder<C> {
    fn row(&self, grid: &BlockGrid, channels: usize, row: &BlockRow, integers: bool) -> (Row, Measured) {
        let (columns, record_words) = (grid.blocks().x() as usize, self.codec.record_words());
        let voxels = grid.block().0.voxels() as usize;
        let mut words = vec![0; channels * columns * record_words];
        let mut measured = Measured::NOTHING;
        let (mut vector, mut values) = (Vec::with_capacity(voxels * channels), Vec::with_capacity(voxels));
        for bx in 0..columns {
            let cut = row.cut(bx as u32);
            vector.clear();
            row.append(bx as u32, &mut vector);
            for c in 0..channels {
                values.clear();
                values.extend(vector[c..].iter().step_by(channels));
                let record = &mut words[(c * columns + bx) * record_words..][..record_words];
                self.codec.encode(&values, record);
                for (i, value) in values.iter().enumerate() {
                    let inside = grid.block().0.position(i);
                    if inside.iter().zip(cut).all(|(i, there)| (*i as usize) < there) {
                        measured.add(*value, self.codec.decode(record, i), integers);
                    }
                }
            }
        }
        (words, measured)
    }
}
