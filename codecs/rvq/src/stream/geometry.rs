//! The decode parameters, and the sizes that follow from them.

use cvr_codebook::Quantiser;
use cvr_core::kit::BlockGrid;
use cvr_core::volume::{Extent, VolumeLayout};
use cvr_groups::{Scale, VALUE_BITS};
use serde::{Deserialize, Serialize};

use super::{
    EDGE, Entries, GREATEST_COLOURS, MOST_CODEWORDS, MOST_STAGES, Payload, RESOLUTIONS, block, decoded_mean,
};

/// The decode parameters in the container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// What a block stores.
    pub payload: Payload,
    /// Blocks along x, y, z.
    pub grid: [u32; 3],
    /// Value of sum 0, in data units.
    pub offset: f32,
    /// Data units per unit of the sum.
    pub step: f32,
    /// How the values of a codeword are stored.
    pub entries: Entries,
    /// Sets of codebooks: one for all frames, or one for each.
    pub tables: Vec<Table>,
    /// Words of the groups of each frame; none under the payload `fixed`, whose frames are equally long.
    pub frame_words: Vec<u64>,
    /// How the codebooks came about; decoding needs nothing of it.
    pub training: TrainingRecord,
}

/// One set of codebooks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Codewords of each stage.
    pub codewords: Vec<u32>,
    /// Scale of the entries of each stage: exponent in bits 0 to 4, fraction in bits 5 to 7 ([`Scale`]).
    pub scales: Vec<u8>,
    /// Codes of means count 2^`mean_shift` where a voxel has one value. Else 0, and under the payload `fixed`.
    pub mean_shift: u32,
}

/// How the codebooks were trained, for the record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingRecord {
    /// First codebook of each stage: `pca`, `pnn`, `scalar` or `random`.
    pub initial: String,
    /// Generator that drew the training blocks.
    pub generator: String,
    /// Its seed for the first table; one more for each further table.
    pub seed: u64,
    /// Sums of codewords that were kept from stage to stage.
    pub beam: usize,
    /// Blocks that each table was trained on.
    pub blocks: Vec<u64>,
    /// Rounds of joint training of each table.
    pub refinement: Vec<u32>,
}

/// Sizes that follow from layout and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// What a block stores.
    pub payload: Payload,
    /// Blocks over the volume at each resolution: as many at all.
    pub grids: [BlockGrid; RESOLUTIONS],
    /// Values per voxel: 1 or 3.
    pub channels: u32,
    /// Frames.
    pub frames: u32,
    /// Groups along each axis.
    pub groups: Extent,
    /// Words of the groups of each frame.
    pub frame_words: Vec<u64>,
    /// Sums become values.
    pub quantiser: Quantiser,
    /// How the values of a codeword are stored.
    pub entries: Entries,
    /// Codebooks of a table.
    pub stages: u32,
    /// Codewords of the largest codebook: codebooks of a table lie as far apart.
    pub codewords: u32,
    /// Bits of a code: as many as the largest codebook needs.
    pub index_bits: u32,
    /// Sets of codebooks.
    pub tables: Vec<Table>,
}

impl Geometry {
    /// The geometry, or `None` when the parameters are outside their ranges or contradict the layout.
    #[must_use]
    pub fn new(layout: &VolumeLayout, parameters: &Parameters) -> Option<Self> {
        let p = parameters;
        let at = |resolution: usize| {
            BlockGrid::new(block(resolution), layout.extent.at_resolution(resolution as u8))
        };
        let stages = p.tables.first()?.codewords.len() as u32;
        let scale_fits = |scale: &u8| Scale::of_byte((*scale).into()).fits(p.entries.code_bits());
        let table_fits = |t: &Table| {
            [t.codewords.len(), t.scales.len()] == [stages as usize; 2]
                && t.codewords.iter().all(|size| (1..=MOST_CODEWORDS).contains(size))
                && t.scales.iter().all(scale_fits)
                && t.mean_shift <= VALUE_BITS
        };
        let lengths = if p.payload == Payload::Fixed { 0 } else { layout.frames as usize };
        let fits = at(0).blocks().to_array() == p.grid
            && (1..=MOST_STAGES).contains(&stages)
            && (p.entries != Entries::Colours || layout.channels == 3)
            && (p.tables.len() == 1 || p.tables.len() == layout.frames as usize)
            && p.frame_words.len() == lengths
            && p.tables.iter().all(table_fits);
        let codewords = p.tables.iter().flat_map(|t| &t.codewords).copied().max()?;
        fits.then_some(Self {
            payload: p.payload,
            groups: at(0).blocks().blocks_of(Extent::cube(cvr_groups::EDGE).ok()?),
            frame_words: p.frame_words.clone(),
            grids: [at(0), at(1), at(2)],
            channels: layout.channels,
            frames: layout.frames,
            quantiser: Quantiser::of_stream(VALUE_BITS, p.offset, p.step)?,
            entries: p.entries,
            stages,
            codewords,
            index_bits: cvr_codebook::index_bits(codewords as usize),
            tables: p.tables.clone(),
        })
    }

    /// The geometry of a stream.
    ///
    /// # Errors
    /// A sentence with the parameters, where [`Geometry::new`] has none.
    pub fn of_stream(layout: &VolumeLayout, parameters: &Parameters) -> Result<Self, String> {
        Self::new(layout, parameters).ok_or_else(|| {
            let p = parameters;
            format!(
                "a grid of {:?} blocks, entries {:?}, values from {} in steps of {}, {} tables {:?} for {} frames of {} \
                 voxels with {} channels",
                p.grid,
                p.entries,
                p.offset,
                p.step,
                p.tables.len(),
                p.tables.first(),
                layout.frames,
                layout.extent,
                layout.channels
            )
        })
    }

    /// Values of a codeword.
    #[must_use]
    pub const fn dimension(&self) -> u32 {
        EDGE * EDGE * EDGE * self.channels
    }

    /// Entries of a codeword at a resolution.
    #[must_use]
    pub const fn codeword_entries(&self, resolution: usize) -> u32 {
        let edge = EDGE >> resolution;
        edge * edge * edge * self.entries.per_voxel(self.channels)
    }

    /// Which table decodes a frame.
    #[must_use]
    pub fn table_of(&self, frame: u32) -> usize {
        if self.tables.len() == 1 { 0 } else { frame as usize }
    }

    /// Codewords of a table, those included that fill codebooks up to the largest.
    #[must_use]
    pub const fn table_codewords(&self) -> u32 {
        self.stages * self.codewords
    }

    /// Words of a table's codewords at a resolution.
    #[must_use]
    pub const fn words(&self, resolution: usize) -> u64 {
        let entries = self.table_codewords() as u64 * self.codeword_entries(resolution) as u64;
        entries.div_ceil(1 << self.entries.lanes_log2())
    }

    /// First entry of the codewords at each resolution, in the words that a decoder holds: those of the stream, then the
    /// coarser ones.
    #[must_use]
    pub fn firsts(&self) -> [u32; RESOLUTIONS] {
        let lanes = self.entries.lanes_log2();
        let coarse = (self.words(0) << lanes) as u32;
        [0, coarse, coarse + ((self.words(1) as u32) << lanes)]
    }

    /// Units of the sums that an entry of each stage of a table counts.
    #[must_use]
    pub fn units(&self, table: usize) -> Vec<i32> {
        self.tables[table].scales.iter().map(|scale| Scale::of_byte((*scale).into()).units() as i32).collect()
    }

    /// The scales of a table in four words, a byte each, and the shift of its means.
    #[must_use]
    pub fn packed_scales(&self, table: usize) -> [u32; 5] {
        let mut words = [0, 0, 0, 0, self.tables[table].mean_shift];
        for (s, scale) in self.tables[table].scales.iter().enumerate() {
            words[s / 4] |= u32::from(*scale) << (8 * (s % 4));
        }
        words
    }

    /// Codes of one frame.
    #[must_use]
    pub const fn codes(&self) -> u64 {
        self.grids[0].blocks().voxels() * self.stages as u64
    }

    /// Words of the codes of one frame.
    #[must_use]
    pub const fn index_words(&self) -> u64 {
        (self.codes() * self.index_bits as u64).div_ceil(32)
    }

    /// Shape of the tensor `codebook`.
    #[must_use]
    pub fn codebook_shape(&self) -> [u64; 2] {
        [self.tables.len() as u64, self.words(0)]
    }

    /// Shape of the tensor `index` under the payload `fixed`.
    #[must_use]
    pub const fn index_shape(&self) -> [u64; 2] {
        [self.frames as u64, self.index_words()]
    }

    /// Shape of the tensor `heads`.
    #[must_use]
    pub const fn heads_shape(&self) -> [u64; 2] {
        [self.frames as u64, self.groups.voxels() * cvr_groups::HEAD_WORDS as u64]
    }

    /// Words of the groups before those of a frame. `None` where they overflow.
    #[must_use]
    pub fn frame_start(&self, frame: usize) -> Option<usize> {
        let words = self.frame_words.iter().take(frame);
        words.copied().try_fold(0_u64, u64::checked_add).and_then(|sum| usize::try_from(sum).ok())
    }

    /// Parts of an escape: one for each channel.
    #[must_use]
    pub const fn parts(&self) -> u32 {
        self.channels
    }

    /// Greatest code of a mean that a group's bits may reach: sums stay within 32 bits.
    #[must_use]
    pub const fn greatest_mean(&self, mean_shift: u32) -> u32 {
        if self.channels == 3 { GREATEST_COLOURS } else { (2 << VALUE_BITS) >> mean_shift }
    }

    /// What a mean's code stands for, for each channel.
    #[must_use]
    #[inline]
    pub const fn mean(&self, mean_shift: u32, code: u32) -> [i32; 3] {
        decoded_mean(self.channels, mean_shift, code)
    }

    /// Blocks of a group: its first block, and how many there are along each axis.
    #[must_use]
    pub fn group(&self, group: [u32; 3]) -> ([u32; 3], [u32; 3]) {
        let grid = self.grids[0].blocks().to_array();
        let first = group.map(|b| b * cvr_groups::EDGE);
        (first, [0, 1, 2].map(|a| cvr_groups::EDGE.min(grid[a] - first[a])))
    }

    /// Whether a shader, which counts codes and entries in 32 bits, can address one frame.
    #[must_use]
    pub fn fits_a_shader(&self) -> bool {
        let entries: u64 = (0..RESOLUTIONS).map(|r| self.words(r) << self.entries.lanes_log2()).sum();
        let most = u64::from(u32::MAX);
        let groups = self.heads_shape()[1].max(self.frame_words.iter().copied().max().unwrap_or(0));
        self.codes() <= most && entries <= most && groups <= most
    }
}

const _: () = assert!(MOST_STAGES <= 16, "scales of all stages are four words");

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::SampleType;

    fn parameters() -> Parameters {
        Parameters {
            payload: Payload::Fixed,
            grid: [4, 5, 6],
            offset: 0.0,
            step: 1.0,
            entries: Entries::Bits8,
            tables: vec![Table { codewords: vec![300, 200], scales: vec![0, 1], mean_shift: 0 }],
            frame_words: vec![],
            training: TrainingRecord {
                initial: "pca".to_owned(),
                generator: "pcg64".to_owned(),
                seed: 1,
                beam: 1,
                blocks: vec![120],
                refinement: vec![0],
            },
        }
    }

    fn layout() -> VolumeLayout {
        VolumeLayout::scalar(Extent::new(13, 17, 23).unwrap(), SampleType::U8)
    }

    #[test]
    fn codes_and_codewords_are_packed() {
        let g = Geometry::new(&layout(), &parameters()).unwrap();
        assert_eq!((g.stages, g.index_bits, g.dimension()), (2, 9, 64));
        assert_eq!(g.index_words(), (120 * 2 * 9_u64).div_ceil(32));
        assert_eq!([0, 1, 2].map(|r| g.words(r)), [600 * 16, 600 * 2, 150]);
        assert_eq!(g.firsts(), [0, 600 * 64, 600 * 72]);
        assert_eq!(g.grids.map(|grid| grid.blocks().to_array()), [[4, 5, 6]; 3]);
        let rgb = VolumeLayout { channels: 3, ..layout() };
        let colours = Parameters { entries: Entries::Colours, ..parameters() };
        let g = Geometry::new(&rgb, &colours).unwrap();
        assert_eq!([0, 1, 2].map(|r| g.words(r)), [600 * 64, 600 * 8, 600]);
    }

    #[test]
    fn what_contradicts_the_layout_is_refused() {
        let wrong: [fn(&mut Parameters); 10] = [
            |p| p.grid[0] = 5,
            |p| p.tables.clear(),
            |p| p.tables.push(p.tables[0].clone()),
            |p| p.tables[0].codewords[1] = 0,
            |p| p.tables[0].codewords[1] = 65537,
            |p| p.tables[0].scales.truncate(1),
            |p| p.tables[0].scales[0] = 31,
            |p| p.entries = Entries::Colours,
            |p| p.tables[0].mean_shift = 17,
            |p| p.frame_words.push(7),
        ];
        for change in wrong {
            let mut parameters = parameters();
            change(&mut parameters);
            assert_eq!(Geometry::new(&layout(), &parameters), None);
        }
    }
}
