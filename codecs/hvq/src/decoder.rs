//! The decoder: bricks on the CPU, and what a shader needs.

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, Constant, ConstantValue, DecodeError, DecodedForm, Decoder, Resource, ShaderDecode,
    TexelFormat, WgslModule, check_key, check_stream, decode_region,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ReferenceFrames, Region, ValueRange, VolumeLayout};

use crate::decode::Frame;
use crate::geometry::{EDGE, Geometry, Parameters, Stage};
use crate::{CODEBOOK, INDEX, INFO};

/// Lowest and highest level that a codeword adds.
type Added = (i32, i32);

/// Decodes a stream of `hvq`.
#[derive(Debug)]
pub struct HvqDecoder {
    layout: VolumeLayout,
    geometry: Geometry,
    codebook: Tensor,
    index: Tensor,
    /// Per table, what each coarse and each detail codeword adds.
    added: Vec<[Vec<Added>; 2]>,
    /// Whether single precision holds every decoded value without rounding.
    exact: bool,
}

impl HvqDecoder {
    pub fn new(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let parameters: Parameters = volume.parameters()?;
        let geometry = Geometry::new(&layout, &parameters).ok_or_else(|| {
            let Parameters { grid, level_bits, top, offset, step, mean_bits, mean_step, .. } = parameters;
            let Parameters { codeword_bits, ref coarse, ref detail, .. } = parameters;
            DecodeError::Corrupt(format!(
                "a grid of {grid:?}, levels of {level_bits} bits to {top} from {offset} in steps of {step}, means of \
                 {mean_bits} bits in steps of {mean_step}, codewords of {codeword_bits} bits: {} coarse tables (zero \
                 {}, step {}) and {} of detail (zero {}, step {}) for {} frames of {} voxels",
                coarse.tables.len(),
                coarse.zero,
                coarse.step,
                detail.tables.len(),
                detail.zero,
                detail.step,
                layout.frames,
                layout.extent
            ))
        })?;
        let codebook = volume.tensor_of_shape(CODEBOOK, Element::U32, &geometry.codebook_shape())?.clone();
        let shape = geometry.index_shape(layout.frames);
        let index = volume.tensor_of_shape(INDEX, Element::U32, &shape)?.clone();
        let exact = geometry.levels.is_exact();
        let mut decoder = Self { layout, geometry, codebook, index, added: Vec::new(), exact };
        decoder.check_indices()?;
        decoder.added = (0..decoder.geometry.tables()).map(|table| decoder.added(table)).collect();
        Ok(decoder)
    }

    /// One frame, which exists, at a level.
    fn frame(&self, frame: FrameIndex, level: Level) -> Frame<'_> {
        fn part(tensor: &Tensor, i: usize, words: u64) -> &[u32] {
            let first = i * words as usize;
            &tensor.words()[first..first + words as usize]
        }
        let g = &self.geometry;
        Frame {
            index: part(&self.index, frame.0 as usize, g.index_words()),
            codebook: part(&self.codebook, g.table_of(frame.0), g.table_words()),
            geometry: g,
            stages: level.stages,
        }
    }

    /// Every index names a codeword of its table, so that no later fetch reads outside.
    fn check_indices(&self) -> Result<(), DecodeError> {
        let g = &self.geometry;
        for frame in (0..self.layout.frames).map(FrameIndex) {
            let part = self.frame(frame, Level::FULL);
            for (name, stage) in [("coarse", &g.coarse), ("detail", &g.detail)] {
                let size = stage.tables[g.table_of(frame.0)];
                if size == 1 << stage.plane.bits {
                    continue;
                }
                for b in 0..g.grid.voxels() as usize {
                    let index = part.number(stage.plane, b);
                    if index >= size {
                        return Err(DecodeError::Corrupt(format!(
                            "frame {}: block {b} has the {name} index {index}, its table {size} codewords",
                            frame.0
                        )));
                    }
                }
            }
        }
        Ok(())
    }

    fn added(&self, table: usize) -> [Vec<Added>; 2] {
        let g = &self.geometry;
        let words = g.table_words() as usize;
        let codebook = &self.codebook.words()[table * words..(table + 1) * words];
        let frame = Frame { index: &[], codebook, geometry: g, stages: Level::ALL_STAGES };
        let of_stage = |stage: &Stage, levels: &dyn Fn(i32) -> i32| {
            let dimension = stage.dimension as usize;
            let of_codeword = |k: usize| {
                let codes = (k * dimension..(k + 1) * dimension).map(|i| frame.code(stage.first, i));
                let (low, high) =
                    codes.fold((i32::MAX, i32::MIN), |(low, high), c| (low.min(c), high.max(c)));
                (levels(low), levels(high))
            };
            (0..stage.tables[table] as usize).map(of_codeword).collect()
        };
        [of_stage(&g.coarse, &|c| frame.coarse(c)), of_stage(&g.detail, &|c| frame.detail(c))]
    }

    /// One row of voxels from `start` on: a block's indices are fetched once.
    fn decode_row(&self, frame: &Frame<'_>, start: [u32; 3], out: &mut [f32]) {
        let channels = self.geometry.channels as usize;
        let mut p = start;
        let mut head = frame.head(p.map(|p| p / EDGE));
        for out in out.chunks_exact_mut(channels) {
            for (c, out) in out.iter_mut().enumerate() {
                *out = frame.voxel(head, p.map(|p| p % EDGE), c);
            }
            p[0] += 1;
            if p[0].is_multiple_of(EDGE) && p[0] < self.layout.extent.x() {
                head = frame.head(p.map(|p| p / EDGE));
            }
        }
    }

    /// What a block can decode to at a level.
    fn block_range(&self, frame: &Frame<'_>, added: &[Vec<Added>; 2], block: [u32; 3]) -> ValueRange {
        let g = &self.geometry;
        let [b, coarse, detail] = frame.head(block);
        let means = (0..g.channels as usize).map(|c| frame.mean(b, c));
        let (mut low, mut high) = means.fold((i32::MAX, i32::MIN), |(l, h), m| (l.min(m), h.max(m)));
        if frame.stages > 1 {
            let (below, above) = added[0][coarse / g.coarse.dimension as usize];
            (low, high) = (low + below, high + above);
        }
        if frame.stages > 2 {
            let (below, above) = added[1][detail / g.detail.dimension as usize];
            (low, high) = (low + below, high + above);
        }
        ValueRange { min: frame.value(low), max: frame.value(high) }
    }
}

/// Positions in a box, x fastest.
fn blocks(region: Region) -> impl Iterator<Item = [u32; 3]> {
    let width = region.extent.x();
    region.rows().flat_map(move |[x, y, z]| (x..x + width).map(move |x| [x, y, z]))
}

impl Decoder for HvqDecoder {
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
        let frame = self.frame(key.frame, key.level);
        let row = |start, out: &mut [f32]| self.decode_row(&frame, start, out);
        let (fetch, cell) = (|p| frame.fetch(p), |p, q| frame.fetch_cell(p, q));
        decode_region(key.region, self.layout.channels, out, fetch, cell, row);
        Ok(())
    }

    /// Of the blocks that the region touches: their means, and what their codewords add at the lowest and the highest.
    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        check_key(&self.layout, key).ok()?;
        let frame = self.frame(key.frame, key.level);
        let added = &self.added[self.geometry.table_of(key.frame.0)];
        let (origin, extent) = (key.region.origin, key.region.extent.to_array());
        let from = origin.map(|o| o / EDGE);
        let count = [0, 1, 2].map(|a| (origin[a] + extent[a] - 1) / EDGE + 1 - from[a]);
        let touched = Region { origin: from, extent: count.try_into().ok()? };
        blocks(touched).map(|block| self.block_range(&frame, added, block)).reduce(ValueRange::union)
    }

    /// A texel is the level itself.
    fn decoded_form(&self) -> DecodedForm {
        let levels = self.geometry.levels;
        let format = if levels.bits() == 8 { TexelFormat::Unorm8 } else { TexelFormat::Unorm16 };
        DecodedForm { format, scale: levels.span(), offset: levels.offset() }
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.geometry.fits_a_shader().then_some(self as &dyn ShaderDecode)
    }
}

impl ShaderDecode for HvqDecoder {
    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        let u32 = |name, value| Constant { name, value: ConstantValue::U32(value) };
        let f32 = |name, value| Constant { name, value: ConstantValue::F32(value) };
        WgslModule {
            file: "codecs/hvq/src/decode.wgsl",
            source: include_str!("decode.wgsl"),
            constants: vec![
                Constant { name: "grid", value: ConstantValue::Vec3U32(g.grid.to_array()) },
                u32("channels", g.channels),
                u32("top", g.top),
                f32("offset", g.levels.offset()),
                f32("step", g.levels.step()),
                u32("codeword_bits", g.codeword_bits),
                u32("lanes_log2", g.lanes_log2()),
                u32("mean_bits", g.means.bits),
                u32("mean_step", g.mean_step),
                u32("coarse_bits", g.coarse.plane.bits),
                u32("coarse_plane", g.coarse.plane.first as u32),
                u32("coarse_dimension", g.coarse.dimension),
                u32("coarse_zero", g.coarse.zero),
                u32("coarse_step", g.coarse.step),
                u32("detail_bits", g.detail.plane.bits),
                u32("detail_plane", g.detail.plane.first as u32),
                u32("detail_dimension", g.detail.dimension),
                u32("detail_zero", g.detail.zero),
                u32("detail_step", g.detail.step),
                u32("detail_first", g.detail.first as u32),
            ],
        }
    }

    /// Levels are integers; the product is exact and the sum rounded once, so that a fused multiply-add changes nothing.
    /// Where values are rounded, a texel that holds the level decodes by a sum of its own and may meet the neighbouring
    /// number.
    fn agreement(&self) -> Agreement {
        if self.exact { Agreement::Exact } else { Agreement::Ulp(1) }
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        if frame.0 >= self.layout.frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {}", frame.0, self.layout.frames)));
        }
        let Frame { index, codebook, .. } = self.frame(frame, Level::FULL);
        Ok(vec![
            Resource { name: INDEX, words: Cow::Borrowed(index) },
            Resource { name: CODEBOOK, words: Cow::Borrowed(codebook) },
        ])
    }
}
