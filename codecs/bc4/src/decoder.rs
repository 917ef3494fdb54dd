//! The decoder: bricks on the CPU, and what a shader or a texture unit needs.

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, BlockFormat, BlockTexture, Constant, ConstantValue, DecodeError, DecodedForm, Decoder,
    Resource, ShaderDecode, TexelFormat, WgslModule, check_key, check_stream, decode_region,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ReferenceFrames, Region, ValueRange, VolumeLayout};

use crate::block::{EDGE, Ends, PARTS};
use crate::decode::{Frame, PART, index, level, value};
use crate::scale::Parameters;
use crate::{BLOCKS, Geometry, INFO, Scale};

/// Texels of 16 bits for each part of a code: as many as fit.
const TEXELS_PER_PART: u32 = 65535 / (255 * PARTS);

/// Decodes a stream of `bc4`.
#[derive(Debug)]
pub struct Bc4Decoder {
    layout: VolumeLayout,
    geometry: Geometry,
    range: ValueRange,
    scale: Scale,
    blocks: Tensor,
}

impl Bc4Decoder {
    pub fn new(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let Parameters { range } = volume.parameters()?;
        let ordered = range.min.is_finite() && range.max.is_finite() && range.min <= range.max;
        let scale = Scale::over(range);
        if !ordered || !scale.step.is_finite() {
            return Err(DecodeError::Corrupt(format!("a value range of {} to {}", range.min, range.max)));
        }
        let geometry = Geometry::new(&layout);
        let shape = geometry.shape(layout.frames);
        let blocks = volume.tensor_of_shape(BLOCKS, Element::U32, &shape)?.clone();
        Ok(Self { layout, geometry, range, scale, blocks })
    }

    /// One frame, which exists.
    fn frame(&self, frame: FrameIndex) -> Frame<'_> {
        Frame { blocks: self.words(frame), geometry: &self.geometry, scale: &self.scale }
    }

    fn words(&self, frame: FrameIndex) -> &[u32] {
        let words = self.geometry.frame_words() as usize;
        &self.blocks.words()[frame.0 as usize * words..][..words]
    }

    /// Lowest and highest value that a block can hold by its indices.
    fn range_of(&self, words: [u32; 2]) -> ValueRange {
        let ends = Ends([words[0] as u8, (words[0] >> 8) as u8]);
        let extremes = (0..16).fold([false; 2], |[low, high], texel| {
            let index = index(words, texel);
            [low | (index == 6), high | (index == 7)]
        });
        let of = |index| value(&self.scale, level(words, index));
        let (a, b) = (of(0), of(1));
        let mut range = ValueRange { min: a.min(b), max: a.max(b) };
        for (index, used) in [6, 7].into_iter().zip(extremes) {
            if used && ends.has_extremes() {
                let extreme = of(index);
                range = range.union(ValueRange { min: extreme, max: extreme });
            }
        }
        range
    }
}

impl Decoder for Bc4Decoder {
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
        let row = |start, out: &mut [f32]| frame.row(start, out);
        let (fetch, cell) = (|p| frame.fetch(p), |p, q| frame.fetch_cell(p, q));
        decode_region(key.region, self.layout.channels, out, fetch, cell, row);
        Ok(())
    }

    /// Of the blocks that the region touches, and the value of code 0: what rounding makes of `offset + step · code` is
    /// no larger than the two allow.
    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        check_key(&self.layout, key).ok()?;
        let frame = self.frame(key.frame);
        let (origin, extent) = (key.region.origin, key.region.extent.to_array());
        let from = origin.map(|o| o / EDGE * EDGE);
        let to: [u32; 3] = std::array::from_fn(|a| origin[a] + extent[a]);
        let mut range = ValueRange { min: self.scale.offset, max: self.scale.offset };
        for z in origin[2]..to[2] {
            for c in 0..self.geometry.channels {
                for y in (from[1]..to[1]).step_by(EDGE as usize) {
                    for x in (from[0]..to[0]).step_by(EDGE as usize) {
                        range = range.union(self.range_of(frame.block([x, y, z], c)));
                    }
                }
            }
        }
        Some(range)
    }

    fn decoded_form(&self) -> DecodedForm {
        // A constant volume has no range to scale texels over.
        if self.scale.step == 0.0 {
            return DecodedForm::FLOAT32;
        }
        // A whole number of texels for each seventh and each fifth of a code.
        let per_code = f64::from(TEXELS_PER_PART * PARTS);
        let scale = (f64::from(self.scale.step) * 65535.0 / per_code) as f32;
        DecodedForm { format: TexelFormat::Unorm16, scale, offset: self.scale.offset }
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.geometry.fits_a_shader().then_some(self as &dyn ShaderDecode)
    }

    fn block_texture(&self, frame: FrameIndex, level: Level) -> Option<BlockTexture<'_>> {
        let whole = BrickKey { frame, level, region: Region::whole(self.layout.extent) };
        check_key(&self.layout, whole).is_ok().then(|| BlockTexture {
            format: BlockFormat::Bc4,
            words: Cow::Borrowed(self.words(frame)),
            scale: self.range.span() as f32,
            offset: self.scale.offset,
        })
    }
}

impl ShaderDecode for Bc4Decoder {
    fn module(&self) -> WgslModule<'_> {
        let u32 = |name, value| Constant { name, value: ConstantValue::U32(value) };
        let f32 = |name, value| Constant { name, value: ConstantValue::F32(value) };
        let [columns, rows] = self.geometry.grid;
        let grid = ConstantValue::Vec3U32([columns, rows, self.layout.extent.z()]);
        WgslModule {
            file: "codecs/bc4/src/decode.wgsl",
            source: include_str!("decode.wgsl"),
            constants: vec![
                Constant { name: "grid", value: grid },
                u32("channels", self.geometry.channels),
                f32("offset", self.scale.offset),
                f32("step", self.scale.step),
                f32("high", self.scale.high),
                f32("part", PART),
            ],
        }
    }

    /// Of the product of three factors and the sum, a fused multiply-add or another order saves or adds two roundings,
    /// each half a unit of at most twice the magnitude; twice that.
    fn agreement(&self) -> Agreement {
        Agreement::Ulp(4)
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        if frame.0 >= self.layout.frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {}", frame.0, self.layout.frames)));
        }
        Ok(vec![Resource { name: BLOCKS, words: Cow::Borrowed(self.words(frame)) }])
    }
}
