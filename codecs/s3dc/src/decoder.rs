//! The decoder: bricks on the CPU, and what a shader needs.

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, Constant, ConstantValue, DecodeError, Decoder, Resource, ShaderDecode, WgslModule, check_key,
    check_stream, decode_region,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::volume::{BrickKey, FrameIndex, ReferenceFrames, ValueRange, VolumeLayout};

use crate::decode::Frame;
use crate::geometry::{Geometry, Parameters};
use crate::{INDEX, INFO, MINMAX};

/// Decodes a stream of `s3dc`.
#[derive(Debug)]
pub struct S3dcDecoder {
    layout: VolumeLayout,
    geometry: Geometry,
    minmax: Tensor,
    index: Tensor,
}

impl S3dcDecoder {
    pub fn new(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let Parameters { block, index_bits } = volume.parameters()?;
        let geometry = Geometry::new(&layout, block, index_bits)
            .ok_or_else(|| DecodeError::Corrupt(format!("block {block} with {index_bits} index bits")))?;
        let shape = geometry.minmax_shape(layout.frames);
        let minmax = volume.tensor_of_shape(MINMAX, Element::U32, &shape)?.clone();
        // A row of values is finite where both ends and the way between them are: no encoder writes anything else.
        let is_range = |ends: &[u32]| {
            let [low, high] = [ends[0], ends[1]].map(f32::from_bits);
            low <= high && (high - low).is_finite()
        };
        if !geometry.endpoint.is_integer()
            && let Some(entry) = minmax.words().chunks_exact(2).position(|ends| !is_range(ends))
        {
            return Err(DecodeError::Corrupt(format!("entry {entry} of `{MINMAX}` is no finite range")));
        }
        let shape = geometry.index_shape(layout.frames);
        let index = volume.tensor_of_shape(INDEX, Element::U32, &shape)?.clone();
        Ok(Self { layout, geometry, minmax, index })
    }

    /// One frame, which exists.
    fn frame(&self, frame: FrameIndex) -> Frame<'_> {
        fn part(tensor: &Tensor, frame: FrameIndex, words: u64) -> &[u32] {
            let first = frame.0 as usize * words as usize;
            &tensor.words()[first..first + words as usize]
        }
        Frame {
            minmax: part(&self.minmax, frame, self.geometry.minmax_words()),
            index: part(&self.index, frame, self.geometry.index_words()),
            geometry: &self.geometry,
        }
    }

    /// One row of voxels from `start` on: endpoints are fetched once per block and channel.
    fn decode_row(&self, frame: &Frame<'_>, start: [u32; 3], out: &mut [f32]) {
        let g = &self.geometry;
        let channels = g.channels as usize;
        let [bx, by, bz] = g.block.0.to_array();
        let row = frame.row(start[1], start[2]);
        let levels = g.levels();
        let (mut x, mut rest) = (start[0], out);
        while !rest.is_empty() {
            let block = x / bx;
            let run = (((block + 1) * bx - x) as usize * channels).min(rest.len());
            let (part, later) = rest.split_at_mut(run);
            let entry = frame.entry([block, start[1] / by, start[2] / bz]);
            let first = x as usize * channels;
            for c in 0..channels {
                let ends = frame.endpoints(entry + c);
                for (k, out) in part.iter_mut().enumerate().skip(c).step_by(channels) {
                    let bit = (first + k) * g.index_bits as usize;
                    *out = frame.value(ends, (frame.index[row + (bit >> 5)] >> (bit & 31)) & levels);
                }
            }
            x = (block + 1) * bx;
            rest = later;
        }
    }
}

impl Decoder for S3dcDecoder {
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

    /// Of the blocks that the region touches.
    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        check_key(&self.layout, key).ok()?;
        let frame = self.frame(key.frame);
        let block = self.geometry.block.0.to_array();
        let (origin, extent) = (key.region.origin, key.region.extent.to_array());
        let from = [0, 1, 2].map(|a| origin[a] / block[a]);
        let to = [0, 1, 2].map(|a| (origin[a] + extent[a] - 1) / block[a]);
        let mut range: Option<ValueRange> = None;
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                let row = frame.entry([from[0], y, z])
                    ..frame.entry([to[0], y, z]) + self.geometry.channels as usize;
                for entry in row {
                    let [min, max] = frame.endpoints(entry);
                    let block = ValueRange { min, max };
                    range = Some(range.map_or(block, |r| r.union(block)));
                }
            }
        }
        range
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.geometry.fits_a_shader().then_some(self as &dyn ShaderDecode)
    }
}

impl ShaderDecode for S3dcDecoder {
    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        let u32 = |name, value| Constant { name, value: ConstantValue::U32(value) };
        let vec3 = |name, value| Constant { name, value: ConstantValue::Vec3U32(value) };
        WgslModule {
            file: "codecs/s3dc/src/decode.wgsl",
            source: include_str!("decode.wgsl"),
            constants: vec![
                vec3("block", g.block.0.to_array()),
                vec3("grid", g.grid.to_array()),
                u32("height", g.extent.y()),
                u32("channels", g.channels),
                u32("index_bits", g.index_bits),
                u32("row_words", g.row_words as u32),
                u32("endpoint_bits", g.endpoint.bits),
                u32("signed", u32::from(g.endpoint.signed)),
                Constant { name: "reciprocal", value: ConstantValue::F32(g.reciprocal) },
            ],
        }
    }

    /// A fused multiply-add differs by at most 2 ulp of the block's largest magnitude; a compiler that also takes
    /// the two products in another order, by at most 2 more.
    fn agreement(&self) -> Agreement {
        Agreement::Ulp(4)
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        if frame.0 >= self.layout.frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {}", frame.0, self.layout.frames)));
        }
        let Frame { minmax, index, .. } = self.frame(frame);
        Ok(vec![
            Resource { name: MINMAX, words: Cow::Borrowed(minmax) },
            Resource { name: INDEX, words: Cow::Borrowed(index) },
        ])
    }
}
