//! A checked stream of `s3dc`: bricks on the CPU, and the data of the shader.

use cvr_core::codec::{Agreement, DecodeError, Resource, WgslModule, check_stream};
use cvr_core::container::EncodedVolume;
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};

use crate::decode::Frame;
use crate::geometry::{Geometry, Parameters};
use crate::{INDEX, INFO, MINMAX};

/// A stream that is read.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    geometry: Geometry,
    minmax: PartedTensor,
    index: PartedTensor,
}

impl Reader {
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let Parameters { block, index_bits } = volume.parameters()?;
        let geometry = Geometry::new(&layout, block, index_bits)
            .ok_or_else(|| DecodeError::Corrupt(format!("block {block} with {index_bits} index bits")))?;
        let minmax = PartedTensor::open(volume, MINMAX, &geometry.minmax_shape(layout.frames))?;
        // The values of a block are finite if both endpoints and their difference are. Encoders write only such blocks.
        let is_range = |ends: &[u32]| {
            let [low, high] = [ends[0], ends[1]].map(f32::from_bits);
            low <= high && (high - low).is_finite()
        };
        if !geometry.endpoint.is_integer()
            && let Some(entry) = minmax.words().chunks_exact(2).position(|ends| !is_range(ends))
        {
            return Err(DecodeError::Corrupt(format!("entry {entry} of `{MINMAX}` is no finite range")));
        }
        let index = PartedTensor::open(volume, INDEX, &geometry.index_shape(layout.frames))?;
        Ok(Self { layout, geometry, minmax, index })
    }
}

impl StreamReader for Reader {
    type Frame<'a> = Frame<'a>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn frame(&self, frame: FrameIndex, _level: Level) -> Frame<'_> {
        let (minmax, index) = (self.minmax.part(frame.0 as usize), self.index.part(frame.0 as usize));
        Frame { minmax, index, geometry: &self.geometry }
    }

    /// The range over the blocks that the region touches.
    fn range(&self, key: BrickKey) -> Option<ValueRange> {
        let frame = self.frame(key.frame, key.level);
        self.geometry.grid.range(key.region, |block| frame.range(block))
    }

    fn fits_a_shader(&self) -> bool {
        self.geometry.fits_a_shader()
    }

    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        WgslModule::new("codecs/s3dc/src/decode.wgsl", include_str!("decode.wgsl"))
            .with("block", g.grid.block())
            .with("grid", g.grid.blocks())
            .with("height", g.grid.volume().y())
            .with("channels", g.channels)
            .with("index_bits", g.index_bits)
            .with("row_words", g.row_words as u32)
            .with("endpoint_bits", g.endpoint.bits)
            .with("signed", u32::from(g.endpoint.signed))
            .with("reciprocal", g.reciprocal)
    }

    /// A fused multiply-add differs by at most 2 ulp of the block's largest magnitude. A compiler that also reorders
    /// the two products adds at most 2 more.
    fn agreement(&self) -> Agreement {
        Agreement::Ulp(4)
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        let number = frame.0 as usize;
        vec![self.minmax.resource(number), self.index.resource(number)]
    }
}
