//! The decoder: bricks on the CPU, and what a shader needs.

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, Constant, ConstantValue, DecodeError, DecodedForm, Decoder, Resource, ShaderDecode,
    TexelFormat, WgslModule, check_key, check_stream, decode_region,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::volume::{BrickKey, FrameIndex, ReferenceFrames, Region, ValueRange, VolumeLayout};

use crate::decode::{Frame, split};
use crate::geometry::{Geometry, Parameters};
use crate::{CODEBOOK, INDEX, INFO};

/// Decodes a stream of `vq`.
#[derive(Debug)]
pub struct VqDecoder {
    layout: VolumeLayout,
    geometry: Geometry,
    codebook: Tensor,
    index: Tensor,
    /// Per table, the range of each codeword.
    ranges: Vec<Vec<ValueRange>>,
    /// Whether single precision holds every decoded value without rounding.
    exact: bool,
}

impl VqDecoder {
    pub fn new(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let parameters: Parameters = volume.parameters()?;
        let geometry = Geometry::new(&layout, &parameters).ok_or_else(|| {
            let Parameters { block, grid, codeword_bits, offset, step, ref tables, .. } = parameters;
            DecodeError::Corrupt(format!(
                "blocks of {block} in a grid of {grid:?}, codewords of {codeword_bits} bits from {offset} in steps \
                 of {step}, {} tables for {} frames of {} voxels",
                tables.len(),
                layout.frames,
                layout.extent
            ))
        })?;
        let codebook = volume.tensor_of_shape(CODEBOOK, Element::U32, &geometry.codebook_shape())?.clone();
        let shape = geometry.index_shape(layout.frames);
        let index = volume.tensor_of_shape(INDEX, Element::U32, &shape)?.clone();
        let exact = geometry.quantiser.is_exact();
        let mut decoder = Self { layout, geometry, codebook, index, ranges: Vec::new(), exact };
        decoder.check_indices()?;
        decoder.ranges =
            (0..decoder.geometry.tables.len()).map(|table| decoder.codeword_ranges(table)).collect();
        Ok(decoder)
    }

    /// One frame, which exists.
    fn frame(&self, frame: FrameIndex) -> Frame<'_> {
        fn part(tensor: &Tensor, i: usize, words: u64) -> &[u32] {
            let first = i * words as usize;
            &tensor.words()[first..first + words as usize]
        }
        let g = &self.geometry;
        Frame {
            index: part(&self.index, frame.0 as usize, g.index_words()),
            codebook: part(&self.codebook, g.table_of(frame.0), g.table_words()),
            geometry: g,
        }
    }

    /// Every index names a codeword of its table, so that no later fetch reads outside.
    fn check_indices(&self) -> Result<(), DecodeError> {
        let g = &self.geometry;
        for frame in (0..self.layout.frames).map(FrameIndex) {
            let size = g.tables[g.table_of(frame.0)];
            if size == 1 << g.index_bits {
                continue;
            }
            let part = self.frame(frame);
            for block in blocks(Region::whole(g.grid)) {
                let index = part.index_of(block);
                if index >= size {
                    return Err(DecodeError::Corrupt(format!(
                        "frame {}: block {block:?} has the index {index}, its table {size} codewords",
                        frame.0
                    )));
                }
            }
        }
        Ok(())
    }

    fn codeword_ranges(&self, table: usize) -> Vec<ValueRange> {
        let g = &self.geometry;
        let words = g.table_words() as usize;
        let codebook = &self.codebook.words()[table * words..(table + 1) * words];
        let frame = Frame { index: &[], codebook, geometry: g };
        let dimension = g.dimension() as usize;
        let of_codeword = |k: usize| {
            let codes = (k * dimension..(k + 1) * dimension).map(|i| frame.code(i));
            let (low, high) = codes.fold((u32::MAX, 0), |(low, high), c| (low.min(c), high.max(c)));
            ValueRange { min: frame.value(low), max: frame.value(high) }
        };
        (0..g.tables[table] as usize).map(of_codeword).collect()
    }

    /// One row of voxels from `start` on: the index is fetched once per block.
    fn decode_row(&self, frame: &Frame<'_>, start: [u32; 3], out: &mut [f32]) {
        let g = &self.geometry;
        let (width, channels) = (g.block.0.x(), g.channels as usize);
        let (mut p, mut rest) = (start, out);
        while !rest.is_empty() {
            let (block, inside) = split(g, p);
            let run = ((width - inside[0]) as usize * channels).min(rest.len());
            let (part, later) = rest.split_at_mut(run);
            let first = frame.codeword(block) + frame.place(inside);
            for (i, out) in (first..).zip(part) {
                *out = frame.value(frame.code(i));
            }
            p[0] += width - inside[0];
            rest = later;
        }
    }
}

/// Positions in a box, x fastest.
fn blocks(region: Region) -> impl Iterator<Item = [u32; 3]> {
    let width = region.extent.x();
    region.rows().flat_map(move |[x, y, z]| (x..x + width).map(move |x| [x, y, z]))
}

impl Decoder for VqDecoder {
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
        let frame = self.frame(key.frame);
        let row = |start, out: &mut [f32]| self.decode_row(&frame, start, out);
        let (fetch, cell) = (|p| frame.fetch(p), |p, q| frame.fetch_cell(p, q));
        decode_region(key.region, self.layout.channels, out, fetch, cell, row);
        Ok(())
    }

    /// Of the codewords of the blocks that the region touches, voxels outside the volume included.
    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        check_key(&self.layout, key).ok()?;
        let frame = self.frame(key.frame);
        let ranges = &self.ranges[self.geometry.table_of(key.frame.0)];
        let size = self.geometry.block.0.to_array();
        let (origin, extent) = (key.region.origin, key.region.extent.to_array());
        let from = [0, 1, 2].map(|a| origin[a] / size[a]);
        let count = [0, 1, 2].map(|a| (origin[a] + extent[a] - 1) / size[a] + 1 - from[a]);
        let touched = Region { origin: from, extent: count.try_into().ok()? };
        blocks(touched).map(|block| ranges[frame.index_of(block) as usize]).reduce(ValueRange::union)
    }

    /// A texel is the code itself.
    fn decoded_form(&self) -> DecodedForm {
        let quantiser = self.geometry.quantiser;
        let format = if quantiser.bits() == 8 { TexelFormat::Unorm8 } else { TexelFormat::Unorm16 };
        DecodedForm { format, scale: quantiser.span(), offset: quantiser.offset() }
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.geometry.fits_a_shader().then_some(self as &dyn ShaderDecode)
    }
}

impl ShaderDecode for VqDecoder {
    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        let u32 = |name, value| Constant { name, value: ConstantValue::U32(value) };
        let f32 = |name, value| Constant { name, value: ConstantValue::F32(value) };
        let vec3 = |name, value| Constant { name, value: ConstantValue::Vec3U32(value) };
        WgslModule {
            file: "codecs/vq/src/decode.wgsl",
            source: include_str!("decode.wgsl"),
            constants: vec![
                vec3("block", g.block.0.to_array()),
                vec3("grid", g.grid.to_array()),
                u32("channels", g.channels),
                u32("dimension", g.dimension()),
                u32("index_bits", g.index_bits),
                u32("codeword_bits", g.quantiser.bits()),
                u32("lanes_log2", g.lanes_log2()),
                f32("offset", g.quantiser.offset()),
                f32("step", g.quantiser.step()),
            ],
        }
    }

    /// The product is exact and the sum rounded once, so that a fused multiply-add changes nothing. Where values are
    /// rounded, a texel that holds the code decodes by a sum of its own and may meet the neighbouring number.
    fn agreement(&self) -> Agreement {
        if self.exact { Agreement::Exact } else { Agreement::Ulp(1) }
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        if frame.0 >= self.layout.frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {}", frame.0, self.layout.frames)));
        }
        let Frame { index, codebook, .. } = self.frame(frame);
        Ok(vec![
            Resource { name: INDEX, words: Cow::Borrowed(index) },
            Resource { name: CODEBOOK, words: Cow::Borrowed(codebook) },
        ])
    }
}
