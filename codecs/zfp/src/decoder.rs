//! The decoder: bricks on the CPU, and what a shader needs.

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, Constant, ConstantValue, DecodeError, Decoder, Resource, ShaderDecode, WgslModule, check_key,
    check_stream,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::volume::{BrickKey, FrameIndex, ReferenceFrames, Region, ValueRange, VolumeLayout};

use crate::decode::Frame;
use crate::geometry::{EDGE, Geometry, Parameters};
use crate::{BLOCKS, INFO};

/// Decodes a stream of `zfp`.
#[derive(Debug)]
pub struct ZfpDecoder {
    layout: VolumeLayout,
    geometry: Geometry,
    range: ValueRange,
    blocks: Tensor,
}

impl ZfpDecoder {
    pub fn new(volume: &EncodedVolume) -> Result<Self, DecodeError> {
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
        let shape = geometry.shape(layout.frames);
        let blocks = volume.tensor_of_shape(BLOCKS, Element::U32, &shape)?.clone();
        Ok(Self { layout, geometry, range: parameters.range, blocks })
    }

    /// One frame, which exists.
    fn frame(&self, frame: FrameIndex) -> Frame<'_> {
        let words = self.geometry.channels as usize * self.geometry.channel_words() as usize;
        let first = frame.0 as usize * words;
        Frame { words: &self.blocks.words()[first..first + words], geometry: &self.geometry }
    }
}

/// What a block and a region have in common along one axis: voxels from the first on, up to the second.
fn overlap(block: u32, origin: u32, length: u32) -> std::ops::Range<u32> {
    origin.max(block * EDGE)..(origin + length).min((block + 1) * EDGE)
}

/// Decodes every block that a region touches once.
fn decode_blocks(frame: &Frame<'_>, region: Region, out: &mut [f32]) {
    let Region { origin, extent } = region;
    let size = extent.to_array();
    let channels = frame.geometry.channels as usize;
    let touched = |a: usize| origin[a] / EDGE..(origin[a] + size[a]).div_ceil(EDGE);
    for bz in touched(2) {
        for by in touched(1) {
            for bx in touched(0) {
                let [xs, ys, zs] = [(bx, 0), (by, 1), (bz, 2)].map(|(b, a)| overlap(b, origin[a], size[a]));
                for c in 0..channels {
                    let values = frame.block([bx, by, bz], c as u32).values();
                    for z in zs.clone() {
                        for y in ys.clone() {
                            let row = ((z % EDGE) * EDGE + y % EDGE) * EDGE;
                            let at = extent.index([xs.start - origin[0], y - origin[1], z - origin[2]]);
                            let to = out[at * channels + c..].iter_mut().step_by(channels);
                            let from = &values[(row + xs.start % EDGE) as usize..][..xs.len()];
                            to.zip(from).for_each(|(to, from)| *to = *from);
                        }
                    }
                }
            }
        }
    }
}

impl Decoder for ZfpDecoder {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        _references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        check_key(&self.layout, key)?;
        let (frame, channels) = (self.frame(key.frame), self.layout.channels as usize);
        let Region { origin, extent } = key.region;
        assert_eq!(out.len() as u64, extent.voxels() * channels as u64, "output of the wrong size");
        match extent.to_array() {
            [1, 1, 1] => out.copy_from_slice(&frame.fetch(origin)[..channels]),
            [2, 2, 2] => {
                let corners = frame.fetch_cell(origin, origin.map(|o| o + 1));
                for (out, corner) in out.chunks_exact_mut(channels).zip(corners) {
                    out.copy_from_slice(&corner[..channels]);
                }
            }
            _ => decode_blocks(&frame, key.region, out),
        }
        Ok(())
    }

    /// Of the whole volume: of a block, only decoding tells.
    fn value_range(&self, _key: BrickKey) -> Option<ValueRange> {
        Some(self.range)
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.geometry.fits_a_shader().then_some(self as &dyn ShaderDecode)
    }
}

impl ShaderDecode for ZfpDecoder {
    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        let u32 = |name, value| Constant { name, value: ConstantValue::U32(value) };
        WgslModule {
            file: "codecs/zfp/src/decode.wgsl",
            source: include_str!("decode.wgsl"),
            constants: vec![
                Constant { name: "grid", value: ConstantValue::Vec3U32(g.grid.to_array()) },
                u32("channels", g.channels),
                // Fits wherever there is a shader.
                u32("channel_words", g.channel_words() as u32),
                u32("block_bits", g.block_bits),
            ],
        }
    }

    /// Integers to the last step, which puts together the bits of a single.
    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        if frame.0 >= self.layout.frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {}", frame.0, self.layout.frames)));
        }
        Ok(vec![Resource { name: BLOCKS, words: Cow::Borrowed(self.frame(frame).words) }])
    }
}

#[cfg(test)]
mod tests {
    use crate::lift::COLUMNS;

    /// The order of the coefficients stands twice: as a table, and written out.
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
