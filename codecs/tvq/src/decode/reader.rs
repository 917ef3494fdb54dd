//! A checked stream of `tvq`: bricks on the CPU, and the data of the shader.

use std::borrow::Cow;
use std::ops::Range;

use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, WgslModule, check_stream};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::memory::{self, Held};
use cvr_core::volume::{BrickKey, Extent, FrameIndex, Level, ValueRange, VolumeLayout};

use super::check::check_frame;
use super::interleave::records;
use super::{Frame, Terms};
use crate::INFO;
use crate::stream::geometry::{BOOK_WORDS, Geometry, Parameters, Payload, TABLE_HEAD, TOP, VOXELS};
use crate::stream::scale::Scale;
use crate::stream::table::Table;
use crate::stream::{CODEBOOK, HEADS, INDEX, TABLES};

/// Means and codes in fetch order.
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

/// A stream that is read.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    geometry: Geometry,
    tables: PartedTensor,
    codebook: Tensor,
    index: Index,
    heads: Option<PartedTensor>,
    /// Words of the codebooks of each set, and of the indices of each frame.
    parts: [Vec<Range<usize>>; 2],
    /// Per set and codeword, the least and largest of its sums. The index is the first entry divided by the entries of
    /// a codeword.
    ranges: Vec<Vec<(i32, i32)>>,
    agreement: Agreement,
}

/// Adjacent ranges of these lengths. `None` if they overflow.
fn parts(lengths: impl Iterator<Item = u64>) -> Option<Vec<Range<usize>>> {
    let mut at = 0_usize;
    let part = |length: u64| {
        let begin = at;
        at = at.checked_add(usize::try_from(length).ok()?)?;
        Some(begin..at)
    };
    lengths.map(part).collect()
}

impl Reader {
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
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
            Payload::Variable => {
                Some(PartedTensor::open(volume, HEADS, &[u64::from(layout.frames), geometry.frame_heads()])?)
            }
        };
        let mut decoder = Self {
            tables: PartedTensor::open(volume, TABLES, &tables_shape)?,
            codebook: tensor(CODEBOOK, &length(0))?,
            index: Index::Stream(tensor(INDEX, &length(1))?),
            heads,
            parts,
            ranges: Vec::new(),
            agreement: geometry.quantiser.agreement(),
            layout,
            geometry,
        };
        let tables = decoder.check()?;
        if decoder.geometry.payload == Payload::Fixed {
            // As many words as the stream has. The file is proven to hold them.
            let bytes = size_of_val(decoder.index.words()) as u64;
            memory::check(bytes, || "the stream's codes side by side".to_owned())?;
            decoder.index = Index::Records { words: decoder.records(&tables), _held: Held::new(bytes) };
        }
        decoder.ranges = (0..decoder.geometry.tables).map(|set| decoder.codeword_ranges(set)).collect();
        Ok(decoder)
    }

    /// The tables of a set.
    fn set_tables(&self, set: u32) -> Result<Vec<Table>, DecodeError> {
        let g = &self.geometry;
        let entries = g.entries[set as usize];
        let words = self.tables.part(set as usize);
        let tables = words.chunks_exact(g.table_words() as usize).map(|table| Table::read(table, g, entries));
        tables.collect::<Result<_, String>>().map_err(DecodeError::Corrupt)
    }

    /// Checks everything that a fetch relies on, so that no later fetch reads outside. Returns the tables of all sets.
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

    /// The indices of all frames, reordered block by block. No frame changes its number of words.
    fn records(&self, sets: &[Vec<Table>]) -> Vec<u32> {
        let of_frame = |frame| {
            let words =
                records(&self.frame(FrameIndex(frame), Level::FULL), &sets[self.geometry.set_of(frame)]);
            let length = self.parts[1][frame as usize].len();
            words.into_iter().chain(std::iter::repeat(0)).take(length)
        };
        (0..self.layout.frames).flat_map(of_frame).collect()
    }

    /// The ranges of a set's codewords, by first entry divided by the entries of a codeword.
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
}

impl StreamReader for Reader {
    type Frame<'a> = Frame<'a>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn frame(&self, frame: FrameIndex, level: Level) -> Frame<'_> {
        let g = &self.geometry;
        let (frame, set) = (frame.0 as usize, g.set_of(frame.0));
        Frame {
            tables: self.tables.part(set),
            codebook: &self.codebook.words()[self.parts[0][set].clone()],
            index: &self.index.words()[self.parts[1][frame].clone()],
            heads: self.heads.as_ref().map_or(&[], |heads| heads.part(frame)),
            stages: level.stages.into(),
            geometry: g,
        }
    }

    /// The range over the blocks that the region touches, including voxels outside the volume: the sum of the bounds of
    /// their terms.
    fn range(&self, key: BrickKey) -> Option<ValueRange> {
        let frame = self.frame(key.frame, key.level);
        let set = self.geometry.set_of(key.frame.0);
        self.geometry.grid.range(key.region, |block| {
            let of_channel = |c| self.sum_range(&frame, &frame.terms(block, c), set);
            let (low, high) = (0..self.layout.channels)
                .map(of_channel)
                .fold((i32::MAX, i32::MIN), |(low, high), (l, h)| (low.min(l), high.max(h)));
            ValueRange { min: frame.value(low), max: frame.value(high) }
        })
    }

    /// A texel is the sum itself.
    fn decoded_form(&self) -> DecodedForm {
        self.geometry.quantiser.decoded_form()
    }

    fn fits_a_shader(&self) -> bool {
        self.geometry.fits_a_shader()
    }

    fn module(&self) -> WgslModule<'_> {
        let g = &self.geometry;
        // Data that is equal for all blocks of all frames becomes constants instead of loads from a buffer.
        let one_table = g.tables == 1 && g.sub_grid == Extent::ONE;
        let words = if one_table { self.tables.words() } else { &[] };
        let word = |i: u32| words.get(i as usize).copied().unwrap_or(0);
        let of_books = |i: u32| [0, 1, 2].map(|b| word(TABLE_HEAD + BOOK_WORDS * b + i));
        WgslModule::new("codecs/tvq/src/decode.wgsl", include_str!("../decode.wgsl"))
            .with("grid", g.grid.blocks())
            .with("sub_blocks", g.sub_blocks)
            .with("sub_grid", g.sub_grid)
            .with("bricks", g.bricks)
            .with("channels", g.channels)
            .with("variable", u32::from(g.payload == Payload::Variable))
            .with("books", g.books)
            .with("table_words", TABLE_HEAD + BOOK_WORDS * g.books)
            .with("entry_bits", g.entry_bits)
            .with("lanes_log2", g.lanes_log2())
            .with("one_table", u32::from(one_table))
            .with("one_means", [word(0), word(1), word(2)])
            .with("one_planes", [word(3), word(4), 0])
            .with("one_firsts", of_books(0))
            .with("one_forms", of_books(2))
            .with("offset", g.quantiser.offset())
            .with("unit", g.quantiser.step())
    }

    /// Sums are sums of integers, so only the last expression rounds.
    fn agreement(&self) -> Agreement {
        self.agreement
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        let Frame { tables, codebook, index, heads, .. } = self.frame(frame, Level::FULL);
        let resource = |name, words| Resource { name, words: Cow::Borrowed(words) };
        vec![
            resource(TABLES, tables),
            resource(CODEBOOK, codebook),
            resource(INDEX, index),
            resource(HEADS, heads),
        ]
    }
}

const _: () = assert!(TOP == 65535);
