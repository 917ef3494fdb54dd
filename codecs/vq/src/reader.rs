//! A checked stream of `vq`: bricks on the CPU, and the data of the shader.

use cvr_codebook::pack::{code_ranges, first_beyond};
use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, WgslModule, check_stream};
use cvr_core::container::EncodedVolume;
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};

use crate::decode::Frame;
use crate::geometry::Geometry;
use crate::{CODEBOOK, INDEX, INFO};

/// A stream that is read.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    geometry: Geometry,
    codebook: PartedTensor,
    index: PartedTensor,
    /// Per table, the least and largest code of each codeword.
    ranges: Vec<Vec<(u32, u32)>>,
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
        let (bits, dimension) = (geometry.quantiser.bits(), geometry.dimension() as usize);
        let tables = geometry.tables.iter().enumerate();
        let ranges = tables.map(|(t, size)| code_ranges(codebook.part(t), bits, dimension, *size as usize));
        let agreement = geometry.quantiser.agreement();
        Ok(Self { ranges: ranges.collect(), layout, geometry, codebook, index, agreement })
    }
}

/// Checks that every index names a codeword of its table, so that no later fetch reads outside.
fn check_indices(layout: &VolumeLayout, g: &Geometry, index: &PartedTensor) -> Result<(), DecodeError> {
    for frame in 0..layout.frames {
        let size = g.tables[g.table_of(frame)];
        let (words, blocks) = (index.part(frame as usize), g.grid.blocks());
        if let Some((b, index)) = first_beyond(words, g.index_bits, blocks.voxels() as usize, size) {
            return Err(DecodeError::Corrupt(format!(
                "frame {frame}: block {:?} has the index {index}, its table {size} codewords",
                blocks.position(b)
            )));
        }
    }
    Ok(())
}

impl StreamReader for Reader {
    type Frame<'a> = Frame<'a>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn frame(&self, frame: FrameIndex, _level: Level) -> Frame<'_> {
        let codebook = self.codebook.part(self.geometry.table_of(frame.0));
        Frame { index: self.index.part(frame.0 as usize), codebook, geometry: &self.geometry }
    }

    /// The range over the codewords of the blocks that the region touches, including voxels outside the volume.
    fn range(&self, key: BrickKey) -> Option<ValueRange> {
        let frame = self.frame(key.frame, key.level);
        let ranges = &self.ranges[self.geometry.table_of(key.frame.0)];
        self.geometry.grid.range(key.region, |block| {
            let (low, high) = ranges[frame.index_of(block) as usize];
            ValueRange { min: frame.value(low), max: frame.value(high) }
        })
    }

    /// A texel is the code itself.
    fn decoded_form(&self) -> DecodedForm {
        self.geometry.quantiser.decoded_form()
    }

    fn fits_a_shader(&self) -> bool {
        self.geometry.fits_a_shader()
    }

    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        WgslModule::new("codecs/vq/src/decode.wgsl", include_str!("decode.wgsl"))
            .with("block", g.grid.block())
            .with("grid", g.grid.blocks())
            .with("channels", g.channels)
            .with("dimension", g.dimension())
            .with("index_bits", g.index_bits)
            .with("codeword_bits", g.quantiser.bits())
            .with("lanes_log2", g.lanes_log2())
            .with("offset", g.quantiser.offset())
            .with("step", g.quantiser.step())
    }

    fn agreement(&self) -> Agreement {
        self.agreement
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        let table = self.geometry.table_of(frame.0);
        vec![self.index.resource(frame.0 as usize), self.codebook.resource(table)]
    }
}
