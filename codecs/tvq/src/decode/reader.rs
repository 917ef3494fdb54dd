//! A checked stream of `tvq`: bricks on the CPU, and the data of the shader.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::LazyLock;

use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, WgslModule, check_stream};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::memory::{self, Held};
use cvr_core::volume::{BrickKey, Extent, FrameIndex, Level, ValueRange, VolumeLayout};
use cvr_groups::{Scale, part_range, snippet};

use super::check::check_frame;
use super::former::rewritten;
use super::interleave::records;
use super::{Frame, Terms};
use crate::INFO;
use crate::stream::geometry::{BOOK_WORDS, Geometry, Parameters, Payload, TABLE_HEAD, TOP, VOXELS};
use crate::stream::table::Table;
use crate::stream::{CODEBOOK, HEADS, INDEX, TABLES};

/// Words as they are fetched.
#[derive(Debug)]
enum Words {
    /// As the stream has them.
    Stream(Tensor),
    /// Written anew when the stream was opened, frame by frame.
    Anew { words: Vec<u32>, _held: Held },
}

impl Words {
    /// Words that take the place of the stream's own, and no more than these, which the file has shown to hold.
    fn anew(words: Vec<u32>, what: &str) -> Result<Self, DecodeError> {
        let bytes = size_of_val(&words[..]) as u64;
        memory::check(bytes, || what.to_owned())?;
        Ok(Self::Anew { words, _held: Held::new(bytes) })
    }

    fn get(&self) -> &[u32] {
        match self {
            Self::Stream(tensor) => tensor.words(),
            Self::Anew { words, .. } => words,
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
    /// Means and codes; under the payload `fixed` block by block.
    index: Words,
    /// Heads of groups, frame by frame; none under the payload `fixed`.
    heads: Option<Words>,
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
                let shape = [u64::from(layout.frames), geometry.frame_heads()];
                Some(Words::Stream(tensor(HEADS, &shape)?))
            }
        };
        let mut decoder = Self {
            tables: PartedTensor::open(volume, TABLES, &tables_shape)?,
            codebook: tensor(CODEBOOK, &length(0))?,
            index: Words::Stream(tensor(INDEX, &length(1))?),
            heads,
            parts,
            ranges: Vec::new(),
            agreement: geometry.quantiser.agreement(),
            layout,
            geometry,
        };
        let sets = decoder.sets()?;
        if volume.spec().stream_version < GROUPS_SINCE && decoder.geometry.payload == Payload::Variable {
            decoder.rewrite(&sets)?;
        }
        decoder.check(&sets)?;
        if decoder.geometry.payload == Payload::Fixed {
            decoder.index = Words::anew(decoder.records(&sets), "the stream's codes side by side")?;
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

    /// The tables of all sets.
    fn sets(&self) -> Result<Vec<Vec<Table>>, DecodeError> {
        (0..self.geometry.tables).map(|set| self.set_tables(set)).collect()
    }

    /// Everything that a fetch relies on, so that no later fetch reads outside.
    fn check(&self, sets: &[Vec<Table>]) -> Result<(), DecodeError> {
        for frame in 0..self.layout.frames {
            let tables = &sets[self.geometry.set_of(frame)];
            check_frame(&self.frame(FrameIndex(frame), Level::FULL), tables)
                .map_err(|problem| DecodeError::Corrupt(format!("frame {frame}: {problem}")))?;
        }
        Ok(())
    }

    /// Groups of an earlier version as groups of today, which take no more words.
    fn rewrite(&mut self, sets: &[Vec<Table>]) -> Result<(), DecodeError> {
        let (mut heads, mut index, mut lengths) = (Vec::new(), Vec::new(), Vec::new());
        for frame in 0..self.layout.frames {
            let tables = &sets[self.geometry.set_of(frame)];
            let of_frame = rewritten(&self.frame(FrameIndex(frame), Level::FULL), tables)
                .map_err(|problem| DecodeError::Corrupt(format!("frame {frame}: {problem}")))?;
            heads.extend(of_frame.0);
            lengths.push(of_frame.1.len() as u64);
            index.extend(of_frame.1);
        }
        self.parts[1] =
            parts(lengths.into_iter()).ok_or_else(|| DecodeError::Corrupt("sizes overflow".to_owned()))?;
        self.index = Words::anew(index, "the stream's groups in today's form")?;
        self.heads = Some(Words::anew(heads, "the heads of the stream's groups in today's form")?);
        Ok(())
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
        let (first, bits) = terms.rest;
        let rest = if bits == 0 { (0, 0) } else { part_range(frame.index, first, bits) };
        let begun = (terms.mean + rest.0, terms.mean + rest.1);
        terms.codes[..terms.count].iter().fold(begun, |(low, high), (book, code)| {
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
        let (frame, set, head_words) = (frame.0 as usize, g.set_of(frame.0), g.frame_heads() as usize);
        Frame {
            tables: self.tables.part(set),
            codebook: &self.codebook.words()[self.parts[0][set].clone()],
            index: &self.index.get()[self.parts[1][frame].clone()],
            heads: self.heads.as_ref().map_or(&[], |heads| &heads.get()[frame * head_words..][..head_words]),
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
        let source: &str = match g.payload {
            Payload::Fixed => FIXED,
            Payload::Variable => &VARIABLE,
        };
        let module = WgslModule::new("codecs/tvq/src/decode.wgsl", source)
            .with("grid", g.grid.blocks())
            .with("sub_blocks", g.sub_blocks)
            .with("sub_grid", g.sub_grid)
            .with("channels", g.channels)
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
            .with("unit", g.quantiser.step());
        match g.payload {
            Payload::Fixed => module,
            Payload::Variable => module.with("groups", g.groups).with("parts", 1),
        }
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

/// The version of streams since which groups have today's form.
const GROUPS_SINCE: u32 = 3;

/// The snippet of each payload.
const FIXED: &str = concat!(include_str!("../decode.wgsl"), "\n", include_str!("fixed.wgsl"));
static VARIABLE: LazyLock<String> = LazyLock::new(|| {
    snippet(INFO.id, concat!(include_str!("../decode.wgsl"), "\n", include_str!("variable.wgsl")))
});

const _: () = assert!(TOP == 65535);
