//! A stream of `rvq`, checked once: bricks on the CPU, and what a shader needs.

use std::borrow::Cow;
use std::sync::LazyLock;

use cvr_codebook::pack::{code_ranges, unpack};
use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, WgslModule, check_stream};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};
use cvr_groups::{Limits, part_range, part_words, snippet};

use crate::INFO;
use crate::decode::{Frame, centred, halved};
use crate::stream::{CODEBOOK, Entries, Geometry, HEADS, INDEX, Payload, RESOLUTIONS};

/// Shader resource: the scales of a frame's table.
const SCALES: &str = "scales";

/// A stream that is read.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    geometry: Geometry,
    codes: Codes,
    tables: Vec<Table>,
    agreement: Agreement,
}

/// Codes of all frames.
#[derive(Debug)]
enum Codes {
    /// One of each stage for every block.
    Fixed(PartedTensor),
    /// Groups, and where those of each frame begin.
    Variable { heads: PartedTensor, index: Tensor, starts: Vec<usize> },
}

impl Codes {
    fn open(volume: &EncodedVolume, g: &Geometry) -> Result<Self, DecodeError> {
        if g.payload == Payload::Fixed {
            return Ok(Self::Fixed(PartedTensor::open(volume, INDEX, &g.index_shape())?));
        }
        let starts: Option<Vec<usize>> = (0..=g.frames as usize).map(|frame| g.frame_start(frame)).collect();
        let starts = starts.ok_or_else(|| DecodeError::Corrupt("sizes of frames overflow".to_owned()))?;
        let all = [starts.last().copied().unwrap_or(0) as u64];
        let index = volume.tensor_of_shape(INDEX, Element::U32, &all)?.clone();
        let heads = PartedTensor::open(volume, HEADS, &g.heads_shape())?;
        Ok(Self::Variable { heads, index, starts })
    }

    /// Heads, and words of codes or groups, of a frame.
    fn frame(&self, frame: usize) -> (&[u32], &[u32]) {
        match self {
            Self::Fixed(index) => (&[], index.part(frame)),
            Self::Variable { heads, index, starts } => {
                (heads.part(frame), &index.words()[starts[frame]..starts[frame + 1]])
            }
        }
    }
}

/// A table as decoders hold it.
#[derive(Debug)]
struct Table {
    /// Codewords of all resolutions.
    codebook: Vec<u32>,
    /// Units of the sums that an entry of each stage counts.
    units: Vec<i32>,
    /// The scales, a byte each, and the shift of means.
    scales: [u32; 5],
    /// What each codeword adds at least and at most, stage by stage. Means of its entries lie between.
    ranges: Vec<(i32, i32)>,
}

impl Table {
    fn new(g: &Geometry, table: usize, words: &[u32]) -> Self {
        let mut codebook = words.to_vec();
        for resolution in 1..RESOLUTIONS {
            let finer = if resolution == 1 { words } else { &codebook[words.len()..] };
            let coarser = halved(g, finer, resolution - 1);
            codebook.extend(coarser);
        }
        let units = g.units(table);
        let ranges = ranges(g, words, &units);
        Self { codebook, units, scales: g.packed_scales(table), ranges }
    }
}

/// What each codeword adds at least and at most.
fn ranges(g: &Geometry, words: &[u32], units: &[i32]) -> Vec<(i32, i32)> {
    let all = g.table_codewords() as usize;
    let centred_ranges: Vec<(i32, i32)> = match g.entries {
        Entries::Bits8 | Entries::Bits16 => {
            let (bits, half) = (g.entries.code_bits(), 1 << (g.entries.code_bits() - 1));
            let ranges = code_ranges(words, bits, g.dimension() as usize, all).into_iter();
            ranges.map(|(low, high)| (low as i32 - half, high as i32 - half)).collect()
        }
        Entries::Colours => {
            let size = g.codeword_entries(0) as usize;
            let of = |k: usize| {
                let entries = (k * size..(k + 1) * size).flat_map(|e| [0, 1, 2].map(|c| (e, c)));
                let codes = entries.map(|(e, c)| centred(g.entries, words, e, c));
                codes.fold((i32::MAX, i32::MIN), |(low, high), code| (low.min(code), high.max(code)))
            };
            (0..all).map(of).collect()
        }
    };
    let scaled = centred_ranges.iter().enumerate().map(|(k, (low, high))| {
        let units = units[k / g.codewords as usize];
        (low * units, high * units)
    });
    scaled.collect()
}

impl Reader {
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let geometry = Geometry::of_stream(&layout, &volume.parameters()?).map_err(DecodeError::Corrupt)?;
        let codebook = PartedTensor::open(volume, CODEBOOK, &geometry.codebook_shape())?;
        let codes = Codes::open(volume, &geometry)?;
        let tables = (0..geometry.tables.len()).map(|t| Table::new(&geometry, t, codebook.part(t))).collect();
        let agreement = geometry.quantiser.agreement();
        let reader = Self { layout, geometry, codes, tables, agreement };
        (0..reader.geometry.frames).try_for_each(|frame| reader.check(FrameIndex(frame)))?;
        Ok(reader)
    }

    /// Checks that every code names a codeword of its stage and that no group leads outside, so that no later fetch does.
    fn check(&self, frame: FrameIndex) -> Result<(), DecodeError> {
        let (g, of) = (&self.geometry, self.frame(frame, Level::FULL));
        let checked = match g.payload {
            Payload::Fixed => check_codes(&of, &g.tables[g.table_of(frame.0)].codewords),
            Payload::Variable => check_groups(&of, &g.tables[g.table_of(frame.0)].codewords),
        };
        checked.map_err(|problem| DecodeError::Corrupt(format!("frame {}: {problem}", frame.0)))
    }

    fn table(&self, frame: FrameIndex) -> &Table {
        &self.tables[self.geometry.table_of(frame.0)]
    }
}

/// Checks that every code names a codeword of its stage.
fn check_codes(frame: &Frame<'_>, sizes: &[u32]) -> Result<(), String> {
    let g = frame.geometry;
    for i in 0..g.codes() as usize {
        let (code, stage) = (unpack(frame.index, g.index_bits, i), i % g.stages as usize);
        if code >= sizes[stage] {
            return Err(format!(
                "block {:?} has the code {code} at stage {stage}, whose codebook has {} codewords",
                g.grids[0].blocks().position(i / g.stages as usize),
                sizes[stage]
            ));
        }
    }
    Ok(())
}

/// Checks that every number of every group stays within its frame and its codebooks.
fn check_groups(frame: &Frame<'_>, sizes: &[u32]) -> Result<(), String> {
    let g = frame.geometry;
    let greatest_mean = g.greatest_mean(frame.mean_shift);
    for n in 0..g.groups.voxels() as usize {
        let group = g.groups.position(n);
        let blocks = g.group(group).1.iter().product();
        let limits = Limits { blocks, code_bits: g.index_bits, codewords: sizes, greatest_mean };
        cvr_groups::check(&frame.groups(), n, &limits)
            .map_err(|problem| format!("group {group:?}: {problem}"))?;
    }
    Ok(())
}

/// What the channels of an escape add at least and at most; at coarser resolutions the means lie between.
fn rest_range(frame: &Frame<'_>, (first, bits): (u32, u32), c: u32) -> (i32, i32) {
    if bits == 0 { (0, 0) } else { part_range(frame.index, first + c * part_words(bits), bits) }
}

impl StreamReader for Reader {
    type Frame<'a> = Frame<'a>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn resolutions(&self) -> u8 {
        RESOLUTIONS as u8
    }

    fn frame(&self, frame: FrameIndex, level: Level) -> Frame<'_> {
        let table = self.table(frame);
        let (heads, index) = self.codes.frame(frame.0 as usize);
        Frame {
            index,
            heads,
            mean_shift: table.scales[4],
            codebook: &table.codebook,
            units: &table.units,
            resolution: level.resolution as usize,
            stages: usize::from(level.stages).min(self.geometry.stages as usize),
            geometry: &self.geometry,
        }
    }

    /// The sum of the ranges of the codewords of each block that the region touches, voxels outside the volume included.
    fn range(&self, key: BrickKey) -> Option<ValueRange> {
        let frame = self.frame(key.frame, key.level);
        let ranges = &self.table(key.frame).ranges;
        let g = frame.geometry;
        g.grids[frame.resolution].range(key.region, |block| {
            let terms = frame.terms(block);
            let of = |s: usize| ranges[s * g.codewords as usize + usize::from(terms.codes[s])];
            let added = (0..terms.count).map(of).fold((0, 0), |sum, of| (sum.0 + of.0, sum.1 + of.1));
            let of_channel = |c: u32| {
                let rest = rest_range(&frame, terms.rest, c);
                let base = terms.base[c as usize];
                (base + added.0 + rest.0, base + added.1 + rest.1)
            };
            let (low, high) = (0..g.channels)
                .map(of_channel)
                .fold((i32::MAX, i32::MIN), |all, of| (all.0.min(of.0), all.1.max(of.1)));
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
        let [a, b, c, d, mean_shift] = self.tables[0].scales;
        let source: &str = match g.payload {
            Payload::Fixed => FIXED,
            Payload::Variable => &VARIABLE,
        };
        let module = WgslModule::new("codecs/rvq/src/decode.wgsl", source)
            .with("grid", g.grids[0].blocks())
            .with("channels", g.channels)
            .with("all_stages", g.stages)
            .with("codewords", g.codewords)
            .with("index_bits", g.index_bits)
            .with("form", 2 - g.entries.lanes_log2())
            .with("firsts", g.firsts())
            .with("one_table", u32::from(g.tables.len() == 1))
            .with("scales_low", [a, b, c])
            .with("scales_high", d)
            .with("offset", g.quantiser.offset())
            .with("unit", g.quantiser.step());
        match g.payload {
            Payload::Fixed => module.with("block_bits", g.index_bits * g.stages),
            Payload::Variable => {
                module.with("groups", g.groups).with("parts", g.parts()).with("mean_shift", mean_shift)
            }
        }
    }

    fn agreement(&self) -> Agreement {
        self.agreement
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        let table = self.table(frame);
        let (heads, index) = self.codes.frame(frame.0 as usize);
        let resource = |name, words| Resource { name, words: Cow::Borrowed(words) };
        let mut all = vec![resource(INDEX, index)];
        if self.geometry.payload == Payload::Variable {
            all.push(resource(HEADS, heads));
        }
        all.extend([resource(CODEBOOK, &table.codebook[..]), resource(SCALES, &table.scales[..])]);
        all
    }
}

/// The snippet of each payload.
const FIXED: &str = concat!(include_str!("decode.wgsl"), "\n", include_str!("decode/fixed.wgsl"));
static VARIABLE: LazyLock<String> = LazyLock::new(|| {
    snippet(INFO.id, concat!(include_str!("decode.wgsl"), "\n", include_str!("decode/variable.wgsl")))
});
