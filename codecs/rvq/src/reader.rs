//! A stream of `rvq`, checked once: bricks on the CPU, and what a shader needs.

use std::borrow::Cow;

use cvr_codebook::pack::{code_ranges, unpack};
use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, WgslModule, check_stream};
use cvr_core::container::EncodedVolume;
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};

use crate::INFO;
use crate::decode::{Frame, centred, halved};
use crate::stream::{BASE, CODEBOOK, Entries, Geometry, INDEX, RESOLUTIONS};

/// Shader resource: the scales of a frame's table.
const SCALES: &str = "scales";

/// A stream that is read.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    geometry: Geometry,
    index: PartedTensor,
    tables: Vec<Table>,
    agreement: Agreement,
}

/// A table as decoders hold it.
#[derive(Debug)]
struct Table {
    /// Codewords of all resolutions.
    codebook: Vec<u32>,
    /// Units of the sums that an entry of each stage counts.
    units: Vec<i32>,
    /// The scales, a byte each.
    scales: [u32; 4],
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
        let index = PartedTensor::open(volume, INDEX, &geometry.index_shape())?;
        check_codes(&geometry, &index)?;
        let tables = (0..geometry.tables.len()).map(|t| Table::new(&geometry, t, codebook.part(t))).collect();
        let agreement = geometry.quantiser.agreement();
        Ok(Self { layout, geometry, index, tables, agreement })
    }

    fn table(&self, frame: FrameIndex) -> &Table {
        &self.tables[self.geometry.table_of(frame.0)]
    }
}

/// Every code names a codeword of its stage, so that no later fetch reads what is no codeword.
fn check_codes(g: &Geometry, index: &PartedTensor) -> Result<(), DecodeError> {
    for frame in 0..g.frames {
        let sizes = &g.tables[g.table_of(frame)].codewords;
        let words = index.part(frame as usize);
        for i in 0..g.codes() as usize {
            let (code, stage) = (unpack(words, g.index_bits, i), i % g.stages as usize);
            if code >= sizes[stage] {
                return Err(DecodeError::Corrupt(format!(
                    "frame {frame}: block {:?} has the code {code} at stage {stage}, whose codebook has {} codewords",
                    g.grids[0].blocks().position(i / g.stages as usize),
                    sizes[stage]
                )));
            }
        }
    }
    Ok(())
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
        Frame {
            index: self.index.part(frame.0 as usize),
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
        frame.geometry.grids[frame.resolution].range(key.region, |block| {
            let of = |s: usize| ranges[s * self.geometry.codewords as usize + frame.code(block, s) as usize];
            let (low, high) =
                (0..frame.stages).map(of).fold((BASE, BASE), |sum, of| (sum.0 + of.0, sum.1 + of.1));
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
        let [a, b, c, d] = self.tables[0].scales;
        WgslModule::new("codecs/rvq/src/decode.wgsl", include_str!("decode.wgsl"))
            .with("grid", g.grids[0].blocks())
            .with("channels", g.channels)
            .with("all_stages", g.stages)
            .with("codewords", g.codewords)
            .with("index_bits", g.index_bits)
            .with("block_bits", g.index_bits * g.stages)
            .with("form", 2 - g.entries.lanes_log2())
            .with("firsts", g.firsts())
            .with("one_table", u32::from(g.tables.len() == 1))
            .with("scales_low", [a, b, c])
            .with("scales_high", d)
            .with("offset", g.quantiser.offset())
            .with("unit", g.quantiser.step())
    }

    fn agreement(&self) -> Agreement {
        self.agreement
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        let table = self.table(frame);
        vec![
            self.index.resource(frame.0 as usize),
            Resource { name: CODEBOOK, words: Cow::Borrowed(&table.codebook) },
            Resource { name: SCALES, words: Cow::Borrowed(&table.scales) },
        ]
    }
}
