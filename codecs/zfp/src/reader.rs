//! A checked stream of `zfp`: bricks on the CPU, and the data of the shader.

use cvr_core::codec::{Agreement, DecodeError, Resource, WgslModule, check_stream};
use cvr_core::container::EncodedVolume;
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};

use crate::decode::Frame;
use crate::geometry::{Geometry, Parameters};
use crate::{BLOCKS, INFO};

/// A stream that is read.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    geometry: Geometry,
    range: ValueRange,
    blocks: PartedTensor,
}

impl Reader {
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let parameters: Parameters = volume.parameters()?;
        let geometry = Geometry::new(&layout, &parameters).ok_or_else(|| {
            let Parameters { block_bits, grid, range } = parameters;
            DecodeError::Corrupt(format!(
                "blocks of {block_bits} bits in a grid of {grid:?} for {} voxels, decoded to {} … {}",
                layout.extent, range.min, range.max
            ))
        })?;
        let blocks = PartedTensor::open(volume, BLOCKS, &geometry.shape(layout.frames))?;
        Ok(Self { layout, geometry, range: parameters.range, blocks })
    }
}

impl StreamReader for Reader {
    type Frame<'a> = Frame<'a>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn frame(&self, frame: FrameIndex, _level: Level) -> Frame<'_> {
        Frame { words: self.blocks.part(frame.0 as usize), geometry: &self.geometry }
    }

    /// The range of the whole volume. The range of a block is known only after decoding.
    fn range(&self, _key: BrickKey) -> Option<ValueRange> {
        Some(self.range)
    }

    fn fits_a_shader(&self) -> bool {
        self.geometry.fits_a_shader()
    }

    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        WgslModule::new("codecs/zfp/src/decode.wgsl", include_str!("decode.wgsl"))
            .with("grid", g.grid.blocks())
            .with("channels", g.channels)
            // Fits wherever there is a shader.
            .with("channel_words", g.channel_words() as u32)
            .with("block_bits", g.block_bits)
    }

    /// Integers up to the last step, which assembles the bits of a single.
    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        vec![self.blocks.resource(frame.0 as usize)]
    }
}

#[cfg(test)]
mod tests {
    use crate::lift::COLUMNS;

    /// The order of the coefficients exists twice: as a table, and written out in the shader.
    #[test]
    fn the_shader_takes_the_columns_of_the_table() {
        let source = include_str!("decode.wgsl");
        for (i, places) in COLUMNS.iter().enumerate() {
            let [a, b, c, d] =
                places.map(|p| format!("c[{}].{}", p / 4, ["x", "y", "z", "w"][p as usize % 4]));
            let line = format!("out.columns[{i}] = zfp_column(vec4<u32>({a}, {b}, {c}, {d}));");
            assert!(source.contains(&line), "{line}");
        }
    }
}
