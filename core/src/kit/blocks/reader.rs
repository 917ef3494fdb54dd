//! Reading a stream of a codec of blocks.

use rayon::prelude::*;

use super::{BLOCKS, BlockCodec};
use crate::codec::{Agreement, BlockTexture, DecodeError, DecodedForm, Resource, WgslModule, check_stream};
use crate::container::EncodedVolume;
use crate::kit::{BlockFrame, BlockGrid, PartedTensor, StreamReader};
use crate::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};

/// The part of the shader that the kit adds. `kit_` stands for the codec's prefix.
const FETCH: &str = include_str!("fetch.wgsl");

/// A stream that is read.
#[derive(Debug)]
pub struct Reader<C> {
    codec: C,
    layout: VolumeLayout,
    grid: BlockGrid,
    records: PartedTensor,
    /// The snippet, followed by the part that the kit adds.
    source: String,
}

impl<C: BlockCodec> Reader<C> {
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, C::INFO)?;
        let (codec, layout) = (C::from_stream(volume)?, volume.spec().layout.clone());
        let grid = BlockGrid::new(codec.block(), layout.extent);
        let [columns, rows, layers] = grid.blocks().to_array().map(u64::from);
        let row_words = columns * codec.record_words() as u64;
        let [frames, channels] = [layout.frames, layout.channels].map(u64::from);
        let records = PartedTensor::open(volume, BLOCKS, &[frames, layers, channels, rows, row_words])?;
        let all = records.words().par_chunks_exact(codec.record_words());
        if let Some(record) = all.position_first(|record| !codec.is_sound(record)) {
            return Err(DecodeError::Corrupt(format!("record {record} of `{BLOCKS}` decodes to no numbers")));
        }
        let (id, text) = (C::INFO.id, C::SNIPPET.1);
        let added = if text.contains(&format!("fn {id}_fetch(")) { "" } else { FETCH };
        let source = format!("{text}{}", added.replace("kit_", &format!("{id}_")));
        Ok(Self { codec, layout, grid, records, source })
    }
}

/// One frame of a stream.
#[derive(Debug)]
pub struct Frame<'a, C> {
    codec: &'a C,
    words: &'a [u32],
    grid: &'a BlockGrid,
    channels: usize,
}

impl<C: BlockCodec> Frame<'_, C> {
    /// The record of channel `c` of the block whose first record begins at `head`.
    #[inline]
    fn record(&self, head: usize, c: usize) -> &[u32] {
        let [columns, rows, _] = self.grid.blocks().to_array();
        let words = self.codec.record_words();
        &self.words[head + c * columns as usize * rows as usize * words..][..words]
    }
}

impl<C: BlockCodec> BlockFrame for Frame<'_, C> {
    /// First word of the record of the first channel.
    type Head = usize;

    fn grid(&self) -> &BlockGrid {
        self.grid
    }

    fn channels(&self) -> usize {
        self.channels
    }

    #[inline]
    fn head(&self, block: [u32; 3]) -> usize {
        let [columns, rows, _] = self.grid.blocks().to_array().map(|n| n as usize);
        let [x, y, z] = block.map(|b| b as usize);
        ((z * self.channels * rows + y) * columns + x) * self.codec.record_words()
    }

    #[inline]
    fn voxel(&self, head: usize, inside: [u32; 3], c: usize) -> f32 {
        self.codec.decode(self.record(head, c), self.grid.place(inside))
    }
}

impl<C: BlockCodec> StreamReader for Reader<C> {
    type Frame<'a> = Frame<'a, C>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn frame(&self, frame: FrameIndex, _level: Level) -> Frame<'_, C> {
        let words = self.records.part(frame.0 as usize);
        Frame { codec: &self.codec, words, grid: &self.grid, channels: self.layout.channels as usize }
    }

    /// The range over all channels of the blocks that the region touches.
    fn range(&self, key: BrickKey) -> Option<ValueRange> {
        let frame = self.frame(key.frame, key.level);
        self.grid.range(key.region, |block| {
            let head = frame.head(block);
            let rest = (1..frame.channels).map(|c| self.codec.range(frame.record(head, c)));
            rest.fold(self.codec.range(frame.record(head, 0)), ValueRange::union)
        })
    }

    fn decoded_form(&self) -> DecodedForm {
        self.codec.decoded_form()
    }

    fn block_texture(&self, frame: FrameIndex, _level: Level) -> Option<BlockTexture<'_>> {
        self.codec.block_texture(self.records.part(frame.0 as usize))
    }

    /// A shader counts words in 32 bits.
    fn fits_a_shader(&self) -> bool {
        self.records.part(0).len() as u64 <= u64::from(u32::MAX)
    }

    fn module(&self) -> WgslModule<'_> {
        let mut module = WgslModule::new(C::SNIPPET.0, &self.source)
            .with("block", self.grid.block())
            .with("grid", self.grid.blocks())
            .with("channels", self.layout.channels)
            .with("record_words", self.codec.record_words() as u32);
        module.constants.extend(self.codec.constants());
        module
    }

    fn agreement(&self) -> Agreement {
        self.codec.agreement()
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        vec![self.records.resource(frame.0 as usize)]
    }
}
