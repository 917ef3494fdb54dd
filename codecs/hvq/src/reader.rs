//! A checked stream of `hvq`: bricks on the CPU, and the data of the shader.

use cvr_codebook::pack::{code_ranges, first_beyond};
use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, WgslModule, check_stream};
use cvr_core::container::EncodedVolume;
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};

use crate::decode::Frame;
use crate::geometry::{Geometry, Stage};
use crate::{CODEBOOK, INDEX, INFO};

/// Least and largest code of each codeword.
type Ranges = Vec<(u32, u32)>;

/// A stream that is read.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    geometry: Geometry,
    codebook: PartedTensor,
    index: PartedTensor,
    /// Per table, the ranges of the coarse and of the detail codewords.
    ranges: Vec<[Ranges; 2]>,
    agreement: Agreement,
}

impl Reader {
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let geometry = Geometry::of_stream(&layout, &volume.parameters()?).map_err(DecodeError::Corrupt)?;
        let codebook = PartedTensor::open(volume, CODEBOOK, &geometry.codebook_shape())?;
        let index = PartedTensor::open(volume, INDEX, &geometry.index_shape(layout.frames))?;
        check_indices(&layout, &geometry, &index)?;
        let of_stage = |table: usize, stage: &Stage| {
            let (words, dimension) =
                (&codebook.part(table)[stage.first as usize..], stage.dimension as usize);
            code_ranges(words, geometry.codeword_bits, dimension, stage.tables[table] as usize)
        };
        let of_table = |table| [of_stage(table, &geometry.coarse), of_stage(table, &geometry.detail)];
        let ranges = (0..geometry.tables()).map(of_table).collect();
        let agreement = geometry.levels.agreement();
        Ok(Self { layout, geometry, codebook, index, ranges, agreement })
    }
}

/// Checks that every index names a codeword of its table, so that no later fetch reads outside.
fn check_indices(layout: &VolumeLayout, g: &Geometry, index: &PartedTensor) -> Result<(), DecodeError> {
    for frame in 0..layout.frames {
        for (name, stage) in [("coarse", &g.coarse), ("detail", &g.detail)] {
            let size = stage.tables[g.table_of(frame)];
            let words = &index.part(frame as usize)[stage.plane.first as usize..];
            let blocks = g.grid.blocks().voxels() as usize;
            if let Some((b, index)) = first_beyond(words, stage.plane.bits, blocks, size) {
                return Err(DecodeError::Corrupt(format!(
                    "frame {frame}: block {b} has the {name} index {index}, its table {size} codewords"
                )));
            }
        }
    }
    Ok(())
}

/// The range of a block: its means, plus the lowest and highest codes of its codewords.
fn block_range(frame: &Frame<'_>, ranges: &[Ranges; 2], block: [u32; 3]) -> ValueRange {
    let g = frame.geometry;
    let [b, coarse, detail] = frame.head_of(block);
    let means = (0..g.channels as usize).map(|c| frame.mean(b, c));
    let (mut low, mut high) = means.fold((i32::MAX, i32::MIN), |(l, h), m| (l.min(m), h.max(m)));
    if frame.stages > 1 {
        let (below, above) = ranges[0][coarse / g.coarse.dimension as usize];
        (low, high) = (low + frame.coarse(below as i32), high + frame.coarse(above as i32));
    }
    if frame.stages > 2 {
        let (below, above) = ranges[1][detail / g.detail.dimension as usize];
        (low, high) = (low + frame.detail(below as i32), high + frame.detail(above as i32));
    }
    ValueRange { min: frame.value(low), max: frame.value(high) }
}

impl StreamReader for Reader {
    type Frame<'a> = Frame<'a>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn frame(&self, frame: FrameIndex, level: Level) -> Frame<'_> {
        Frame {
            index: self.index.part(frame.0 as usize),
            codebook: self.codebook.part(self.geometry.table_of(frame.0)),
            geometry: &self.geometry,
            stages: level.stages,
        }
    }

    /// The range over the blocks that the region touches.
    fn range(&self, key: BrickKey) -> Option<ValueRange> {
        let frame = self.frame(key.frame, key.level);
        let ranges = &self.ranges[self.geometry.table_of(key.frame.0)];
        self.geometry.grid.range(key.region, |block| block_range(&frame, ranges, block))
    }

    /// A texel is the level itself.
    fn decoded_form(&self) -> DecodedForm {
        self.geometry.levels.decoded_form()
    }

    fn fits_a_shader(&self) -> bool {
        self.geometry.fits_a_shader()
    }

    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        WgslModule::new("codecs/hvq/src/decode.wgsl", include_str!("decode.wgsl"))
            .with("grid", g.grid.blocks())
            .with("channels", g.channels)
            .with("top", g.top)
            .with("offset", g.levels.offset())
            .with("step", g.levels.step())
            .with("codeword_bits", g.codeword_bits)
            .with("lanes_log2", g.lanes_log2())
            .with("mean_bits", g.means.bits)
            .with("mean_step", g.mean_step)
            .with("coarse_bits", g.coarse.plane.bits)
            .with("coarse_plane", g.coarse.plane.first as u32)
            .with("coarse_dimension", g.coarse.dimension)
            .with("coarse_zero", g.coarse.zero)
            .with("coarse_step", g.coarse.step)
            .with("detail_bits", g.detail.plane.bits)
            .with("detail_plane", g.detail.plane.first as u32)
            .with("detail_dimension", g.detail.dimension)
            .with("detail_zero", g.detail.zero)
            .with("detail_step", g.detail.step)
            .with("detail_first", g.detail.first as u32)
    }

    /// Levels are integers, so that only the last expression rounds.
    fn agreement(&self) -> Agreement {
        self.agreement
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        let table = self.geometry.table_of(frame.0);
        vec![self.index.resource(frame.0 as usize), self.codebook.resource(table)]
    }
}
