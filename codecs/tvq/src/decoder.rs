//! The decoder: bricks on the CPU, and what a shader needs.

use std::borrow::Cow;
use std::ops::Range;

use cvr_core::codec::{
    Agreement, Constant, ConstantValue, DecodeError, DecodedForm, Decoder, Resource, ShaderDecode,
    TexelFormat, WgslModule, check_key, check_stream, decode_region,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::memory::{self, Held};
use cvr_core::volume::{BrickKey, Extent, FrameIndex, Level, ReferenceFrames, ValueRange, VolumeLayout};

use crate::check::check_frame;
use crate::decode::{Frame, Terms, place};
use crate::geometry::{BOOK_WORDS, EDGE, Geometry, Parameters, Payload, TABLE_HEAD, TOP, VOXELS};
use crate::records::records;
use crate::scale::Scale;
use crate::table::Table;
use crate::{CODEBOOK, HEADS, INDEX, INFO, TABLES};

/// Means and codes, as they are fetched.
#[derive(Debug)]
enum Index {
    /// As the stream has them.
    Stream(Tensor),
    /// Block by block: see [`records`].
    Records { words: Vec<u32>, _held: Held },
}

impl Index {
    fn words(&self) -> &[u32] {
        match self {
            Self::Stream(tensor) => tensor.words(),
            Self::Records { words, .. } => words,
        }
    }
}

/// Decodes a stream of `tvq`.
#[derive(Debug)]
pub struct TvqDecoder {
    layout: VolumeLayout,
    geometry: Geometry,
    tables: Tensor,
    codebook: Tensor,
    index: Index,
    heads: Option<Tensor>,
    /// Words of the codebooks of each set, and of the indices of each frame.
    parts: [Vec<Range<usize>>; 2],
    /// Per set and entry of a codebook's codeword: the least and the largest of its sums.
    ranges: Vec<Vec<(i32, i32)>>,
    /// Whether single precision holds every decoded value without rounding.
    exact: bool,
}

/// Ranges one after the other, of these lengths; `None` where they overflow.
fn parts(lengths: impl Iterator<Item = u64>) -> Option<Vec<Range<usize>>> {
    let mut at = 0_usize;
    let part = |length: u64| {
        let begin = at;
        at = at.checked_add(usize::try_from(length).ok()?)?;
        Some(begin..at)
    };
    lengths.map(part).collect()
}

impl TvqDecoder {
    pub fn new(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let parameters: Parameters = volume.parameters()?;
        let geometry = Geometry::new(&layout, &parameters).ok_or_else(|| {
            let Parameters { grid, subvolume, books, entry_bits, .. } = parameters;
            DecodeError::Corrupt(format!(
                "a grid of {grid:?} blocks in sub-volumes of {subvolume}, {books} codebooks and entries of {entry_bits} bits for {} frames of {} voxels",
                layout.frames, layout.extent
            ))
        })?;
        let overflow = || DecodeError::Corrupt("sizes overflow".to_owned());
        let set_words = parts((0..geometry.tables as usize).map(|set| geometry.codebook_words(set)));
        let frame_words = parts(geometry.frame_words.iter().copied());
        let parts = [set_words.ok_or_else(overflow)?, frame_words.ok_or_else(overflow)?];
        let length = |i: usize| vec![parts[i].last().map_or(0, |part| part.end) as u64];
        let tensor = |name, shape: &[u64]| {
            Ok::<_, DecodeError>(volume.tensor_of_shape(name, Element::U32, shape)?.clone())
        };
        let table_count = geometry.sub_grid.voxels();
        let tables_shape = [u64::from(geometry.tables), table_count, u64::from(geometry.table_words())];
        let heads = match geometry.payload {
            Payload::Fixed => None,
            Payload::Variable => Some(tensor(HEADS, &[u64::from(layout.frames), geometry.frame_heads()])?),
        };
        let mut decoder = Self {
            tables: tensor(TABLES, &tables_shape)?,
            codebook: tensor(CODEBOOK, &length(0))?,
            index: Index::Stream(tensor(INDEX, &length(1))?),
            heads,
            parts,
            ranges: Vec::new(),
            exact: geometry.quantiser.is_exact(),
            layout,
            geometry,
        };
        let tables = decoder.check()?;
        if decoder.geometry.payload == Payload::Fixed {
            // As many words as the stream has, which the file has shown to hold.
            let bytes = size_of_val(decoder.index.words()) as u64;
            memory::check(bytes, || "the stream's codes side by side".to_owned())?;
            decoder.index = Index::Records { words: decoder.records(&tables), _held: Held::new(bytes) };
        }
        decoder.ranges = (0..decoder.geometry.tables).map(|set| decoder.codeword_ranges(set)).collect();
        Ok(decoder)
    }

    /// One frame, which exists.
    fn frame(&self, frame: FrameIndex, level: Level) -> Frame<'_> {
        let g = &self.geometry;
        let (frame, set) = (frame.0 as usize, g.set_of(frame.0));
        let words = g.sub_grid.voxels() as usize * g.table_words() as usize;
        let heads = g.frame_heads() as usize;
        Frame {
            tables: &self.tables.words()[set * words..(set + 1) * words],
            codebook: &self.codebook.words()[self.parts[0][set].clone()],
            index: &self.index.words()[self.parts[1][frame].clone()],
            heads: self.heads.as_ref().map_or(&[], |h| &h.words()[frame * heads..(frame + 1) * heads]),
            stages: level.stages.into(),
            geometry: g,
        }
    }

    /// The tables of a set.
    fn set_tables(&self, set: u32) -> Result<Vec<Table>, DecodeError> {
        let g = &self.geometry;
        let words = g.table_words() as usize;
        let set_words = g.sub_grid.voxels() as usize * words;
        let part = &self.tables.words()[set as usize * set_words..(set as usize + 1) * set_words];
        let entries = g.entries[set as usize];
        let tables = part.chunks_exact(words).map(|table| Table::read(table, g, entries));
        tables.collect::<Result<_, String>>().map_err(DecodeError::Corrupt)
    }

    /// Everything that a fetch relies on, so that no later fetch reads outside. The tables of all sets.
    fn check(&self) -> Result<Vec<Vec<Table>>, DecodeError> {
        let sets = (0..self.geometry.tables).map(|set| self.set_tables(set));
        let sets = sets.collect::<Result<Vec<_>, _>>()?;
        for frame in 0..self.layout.frames {
            let tables = &sets[self.geometry.set_of(frame)];
            check_frame(&self.frame(FrameIndex(frame), Level::FULL), tables)
                .map_err(|problem| DecodeError::Corrupt(format!("frame {frame}: {problem}")))?;
        }
        Ok(sets)
    }

    /// The indices of all frames, block by block. Each frame has as many words as before.
    fn records(&self, sets: &[Vec<Table>]) -> Vec<u32> {
        let of_frame = |frame| {
            let words =
                records(&self.frame(FrameIndex(frame), Level::FULL), &sets[self.geometry.set_of(frame)]);
            let length = self.parts[1][frame as usize].len();
            words.into_iter().chain(std::iter::repeat(0)).take(length)
        };
        (0..self.layout.frames).flat_map(of_frame).collect()
    }

    /// Of each codeword of a set, by its first entry divided by the entries of a codeword.
    fn codeword_ranges(&self, set: u32) -> Vec<(i32, i32)> {
        let frame = self.frame(FrameIndex(if self.geometry.tables == 1 { 0 } else { set }), Level::FULL);
        let of_codeword = |k: usize| {
            let entries = (k * VOXELS..(k + 1) * VOXELS).map(|i| frame.entry(i));
            entries.fold((i32::MAX, i32::MIN), |(low, high), e| (low.min(e), high.max(e)))
        };
        (0..self.geometry.entries[set as usize] as usize / VOXELS).map(of_codeword).collect()
    }

    /// Bounds of the sums of a block.
    fn sum_range(&self, frame: &Frame<'_>, terms: &Terms, set: usize) -> (i32, i32) {
        terms.codes[..terms.count].iter().fold((terms.mean, terms.mean), |(low, high), (book, code)| {
            let form = frame.tables[*book as usize + 2];
            let first = frame.tables[*book as usize] as usize / VOXELS;
            let (least, largest) = self.ranges[set][first + *code as usize];
            let scale = Scale::of_form(form).units() as i32;
            (low + least * scale, high + largest * scale)
        })
    }

    /// One row of voxels from `start` on: what a block is the sum of is fetched once per block.
    fn decode_row(&self, frame: &Frame<'_>, start: [u32; 3], out: &mut [f32]) {
        let channels = self.geometry.channels as usize;
        let (mut p, mut rest) = (start, out);
        while !rest.is_empty() {
            let block = p.map(|p| p / EDGE);
            let inside = [0, 1, 2].map(|a| p[a] - block[a] * EDGE);
            let run = ((EDGE - inside[0]) as usize).min(rest.len() / channels);
            let (part, later) = rest.split_at_mut(run * channels);
            for c in 0..channels {
                let terms = frame.terms(block, c as u32);
                let first = place(inside);
                for (x, out) in part[c..].iter_mut().step_by(channels).enumerate() {
                    *out = frame.value(frame.sum(&terms, first + x));
                }
            }
            p[0] += run as u32;
            rest = later;
        }
    }
}

impl Decoder for TvqDecoder {
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

    /// Of the blocks that the region touches, voxels outside the volume included: the sum of the bounds of their terms.
    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        check_key(&self.layout, key).ok()?;
        let frame = self.frame(key.frame, key.level);
        let set = self.geometry.set_of(key.frame.0);
        let (origin, extent) = (key.region.origin, key.region.extent.to_array());
        let from = origin.map(|o| o / EDGE);
        let count = [0, 1, 2].map(|a| (origin[a] + extent[a] - 1) / EDGE + 1 - from[a]);
        let mut range: Option<(i32, i32)> = None;
        for p in crate::geometry::positions(count) {
            for c in 0..self.layout.channels {
                let terms = frame.terms([0, 1, 2].map(|a| from[a] + p[a]), c);
                let (low, high) = self.sum_range(&frame, &terms, set);
                range = Some(range.map_or((low, high), |(l, h)| (l.min(low), h.max(high))));
            }
        }
        range.map(|(low, high)| ValueRange { min: frame.value(low), max: frame.value(high) })
    }

    /// A texel is the sum itself.
    fn decoded_form(&self) -> DecodedForm {
        let quantiser = self.geometry.quantiser;
        DecodedForm { format: TexelFormat::Unorm16, scale: quantiser.span(), offset: quantiser.offset() }
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        self.geometry.fits_a_shader().then_some(self as &dyn ShaderDecode)
    }
}

impl ShaderDecode for TvqDecoder {
    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        let u32 = |name, value| Constant { name, value: ConstantValue::U32(value) };
        let f32 = |name, value| Constant { name, value: ConstantValue::F32(value) };
        let vec3 = |name, value| Constant { name, value: ConstantValue::Vec3U32(value) };
        // What is the same for all blocks of all frames is no load from a buffer.
        let one_table = g.tables == 1 && g.sub_grid == Extent::ONE;
        let words = if one_table { &self.tables.words()[..g.table_words() as usize] } else { &[] };
        let word = |i: u32| words.get(i as usize).copied().unwrap_or(0);
        let of_books = |i: u32| [0, 1, 2].map(|b| word(TABLE_HEAD + BOOK_WORDS * b + i));
        WgslModule {
            file: "codecs/tvq/src/decode.wgsl",
            source: include_str!("decode.wgsl"),
            constants: vec![
                vec3("grid", g.grid.to_array()),
                vec3("sub_blocks", g.sub_blocks),
                vec3("sub_grid", g.sub_grid.to_array()),
                vec3("bricks", g.bricks.to_array()),
                u32("channels", g.channels),
                u32("variable", u32::from(g.payload == Payload::Variable)),
                u32("books", g.books),
                u32("table_words", TABLE_HEAD + BOOK_WORDS * g.books),
                u32("entry_bits", g.entry_bits),
                u32("lanes_log2", g.lanes_log2()),
                u32("one_table", u32::from(one_table)),
                vec3("one_means", [word(0), word(1), word(2)]),
                vec3("one_planes", [word(3), word(4), 0]),
                vec3("one_firsts", of_books(0)),
                vec3("one_forms", of_books(2)),
                f32("offset", g.quantiser.offset()),
                f32("unit", g.quantiser.step()),
            ],
        }
    }

    /// The sum is one of integers, its product with the step exact, and the last sum rounded once, fused or not. Where
    /// values are rounded, a texel that holds the sum decodes by a sum of its own and may meet the neighbouring number.
    fn agreement(&self) -> Agreement {
        if self.exact { Agreement::Exact } else { Agreement::Ulp(1) }
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        if frame.0 >= self.layout.frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {}", frame.0, self.layout.frames)));
        }
        let Frame { tables, codebook, index, heads, .. } = self.frame(frame, Level::FULL);
        Ok(vec![
            Resource { name: TABLES, words: Cow::Borrowed(tables) },
            Resource { name: CODEBOOK, words: Cow::Borrowed(codebook) },
            Resource { name: INDEX, words: Cow::Borrowed(index) },
            Resource { name: HEADS, words: Cow::Borrowed(heads) },
        ])
    }
}

const _: () = assert!(TOP == 65535);
