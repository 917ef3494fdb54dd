//! Positions of means, indices and codewords in the two tensors.

use cvr_codebook::Quantiser;
use cvr_core::codec::Block;
use cvr_core::kit::BlockGrid;
use cvr_core::volume::{Extent, VolumeLayout};
use serde::{Deserialize, Serialize};

use crate::stage::StageParameters;

/// Voxels along an edge of a block.
pub const EDGE: u32 = 4;
/// Voxels of a block.
pub const VOXELS: u32 = 64;
/// Sub-blocks of a block.
pub const SUB_BLOCKS: u32 = 8;

/// The decode parameters in the container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Blocks along x, y, z.
    pub grid: [u32; 3],
    /// Bits of a level: 8 or 16.
    pub level_bits: u32,
    /// Highest level.
    pub top: u32,
    /// Value of level 0, in data units.
    pub offset: f32,
    /// Data units per level.
    pub step: f32,
    /// Bits of a mean: 8 or 16.
    pub mean_bits: u32,
    /// Levels per code of a mean.
    pub mean_step: u32,
    /// Bits of one value of a codeword: 8 or 16.
    pub codeword_bits: u32,
    /// Differences of sub-blocks.
    pub coarse: StageParameters,
    /// Differences of voxels.
    pub detail: StageParameters,
    /// Training of the tables. The decoder does not use it.
    pub training: TrainingRecord,
}

/// How the tables were trained, for the record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingRecord {
    /// First codebook: `pca`, `pnn`, `scalar` or `random`.
    pub initial: String,
    /// Generator that drew the training blocks.
    pub generator: String,
    /// Its seed for the first table; one more for each further table.
    pub seed: u64,
    /// Blocks that each table was trained on.
    pub blocks: Vec<u64>,
    /// Of the coarse tables.
    pub coarse: StageRecord,
    /// Of the detail tables.
    pub detail: StageRecord,
}

/// How the tables of one stage were trained.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageRecord {
    /// Rounds of refinement of each table.
    pub rounds: Vec<u32>,
}

/// Numbers of one width, packed from a word on.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Plane {
    /// First word within a frame.
    pub first: u64,
    /// Bits of a number.
    pub bits: u32,
    /// Words.
    pub words: u64,
}

/// One stage of differences.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// Codewords of each table.
    pub tables: Vec<u32>,
    /// Position of a frame's indices.
    pub plane: Plane,
    /// Values of a codeword.
    pub dimension: u32,
    /// First word of the codewords within a table.
    pub first: u64,
    /// Words of the codewords: as many as the largest table needs.
    pub words: u64,
    /// The code that adds nothing.
    pub zero: u32,
    /// Levels per code.
    pub step: u32,
}

/// Sizes that follow from layout and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Blocks over the volume.
    pub grid: BlockGrid,
    /// Values per voxel: 1 or 3.
    pub channels: u32,
    /// Values of levels.
    pub levels: Quantiser,
    /// Highest level.
    pub top: u32,
    /// Position of a frame's means. The channels of a block are adjacent.
    pub means: Plane,
    /// Levels per code of a mean.
    pub mean_step: u32,
    /// Bits of one value of a codeword.
    pub codeword_bits: u32,
    /// Differences of sub-blocks.
    pub coarse: Stage,
    /// Differences of voxels.
    pub detail: Stage,
}

/// The block that this codec codes on its own.
#[must_use]
pub fn block() -> Block {
    Block(Extent::cube(EDGE).unwrap_or(Extent::ONE))
}

impl Geometry {
    /// The geometry. `None` if the parameters are out of range or contradict the layout.
    #[must_use]
    pub fn new(layout: &VolumeLayout, parameters: &Parameters) -> Option<Self> {
        let p = parameters;
        let grid = BlockGrid::new(block(), layout.extent);
        let levels = Quantiser::of_stream(p.level_bits, p.offset, p.step)?;
        let mean_codes = matches!(p.mean_bits, 8 | 16).then(|| (1_u64 << p.mean_bits) - 1)?;
        let fits = grid.blocks().to_array() == p.grid
            && u64::from(p.top) < 1 << p.level_bits
            && levels.value(p.top).is_finite()
            && (1..=1 << 24).contains(&(u64::from(p.mean_step) * mean_codes))
            && matches!(p.codeword_bits, 8 | 16)
            && p.coarse.is_sound(p.codeword_bits, layout.frames)
            && p.detail.is_sound(p.codeword_bits, layout.frames)
            && p.coarse.tables.len() == p.detail.tables.len();
        if !fits {
            return None;
        }
        let plane = |first: u64, bits: u32, numbers: u64| {
            let words = numbers.checked_mul(bits.into())?.div_ceil(32);
            Some(Plane { first, bits, words })
        };
        let blocks = grid.blocks().voxels();
        let channels = layout.channels;
        let means = plane(0, p.mean_bits, blocks.checked_mul(channels.into())?)?;
        let lanes = u64::from(32 / p.codeword_bits);
        let stage = |of: &StageParameters, values: u32, index_first, first| {
            let dimension = values * channels;
            Some(Stage {
                tables: of.tables.clone(),
                plane: plane(index_first, of.index_bits(), blocks)?,
                dimension,
                first,
                words: (u64::from(of.largest()) * u64::from(dimension)).div_ceil(lanes),
                zero: of.zero,
                step: of.step,
            })
        };
        let coarse = stage(&p.coarse, SUB_BLOCKS, means.words, 0)?;
        let detail = stage(&p.detail, VOXELS, means.words + coarse.plane.words, coarse.words)?;
        Some(Self {
            grid,
            channels,
            levels,
            top: p.top,
            means,
            mean_step: p.mean_step,
            codeword_bits: p.codeword_bits,
            coarse,
            detail,
        })
    }

    /// The geometry of a stream.
    ///
    /// # Errors
    /// A sentence with the parameters, where [`Geometry::new`] has none.
    pub fn of_stream(layout: &VolumeLayout, parameters: &Parameters) -> Result<Self, String> {
        Self::new(layout, parameters).ok_or_else(|| {
            let &Parameters { grid, level_bits, top, offset, step, mean_bits, mean_step, .. } = parameters;
            let &Parameters { codeword_bits, ref coarse, ref detail, .. } = parameters;
            format!(
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
            )
        })
    }

    /// Binary logarithm of the codes in one word: 2 or 1.
    #[must_use]
    pub const fn lanes_log2(&self) -> u32 {
        (32 / self.codeword_bits).ilog2()
    }

    /// Number of tables of a stream: one for all frames, or one per frame.
    #[must_use]
    pub fn tables(&self) -> usize {
        self.coarse.tables.len()
    }

    /// Which table decodes a frame.
    #[must_use]
    pub fn table_of(&self, frame: u32) -> usize {
        if self.tables() == 1 { 0 } else { frame as usize }
    }

    /// Words of one table, over both stages.
    #[must_use]
    pub const fn table_words(&self) -> u64 {
        self.coarse.words + self.detail.words
    }

    /// Words of the means and indices of one frame.
    #[must_use]
    pub const fn index_words(&self) -> u64 {
        self.means.words + self.coarse.plane.words + self.detail.plane.words
    }

    /// Shape of the tensor `codebook`.
    #[must_use]
    pub fn codebook_shape(&self) -> [u64; 2] {
        [self.tables() as u64, self.table_words()]
    }

    /// Shape of the tensor `index`.
    #[must_use]
    pub fn index_shape(&self, frames: u32) -> [u64; 2] {
        [u64::from(frames), self.index_words()]
    }

    /// Whether a shader can address one frame with 32-bit numbers of blocks and words. Codewords always fit: 65536 of
    /// 64 RGB voxels have fewer than 2^24 values.
    #[must_use]
    pub const fn fits_a_shader(&self) -> bool {
        self.grid.blocks().voxels() * self.channels as u64 <= u32::MAX as u64
            && self.index_words() <= u32::MAX as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::SampleType;

    fn parameters() -> Parameters {
        Parameters {
            grid: [4, 5, 6],
            level_bits: 8,
            top: 255,
            offset: 0.0,
            step: 1.0,
            mean_bits: 8,
            mean_step: 1,
            codeword_bits: 8,
            coarse: StageParameters { tables: vec![20], zero: 127, step: 1 },
            detail: StageParameters { tables: vec![300], zero: 127, step: 2 },
            training: TrainingRecord {
                initial: "pca".to_owned(),
                generator: "pcg64".to_owned(),
                seed: 1,
                blocks: vec![120],
                coarse: StageRecord { rounds: vec![3] },
                detail: StageRecord { rounds: vec![4] },
            },
        }
    }

    fn layout() -> VolumeLayout {
        VolumeLayout::scalar(Extent::new(13, 17, 23).unwrap(), SampleType::U8)
    }

    #[test]
    fn planes_and_tables_are_packed_and_each_is_whole_words() {
        let geometry = Geometry::new(&layout(), &parameters()).unwrap();
        assert_eq!(geometry.means, Plane { first: 0, bits: 8, words: 30 });
        assert_eq!(geometry.coarse.plane, Plane { first: 30, bits: 5, words: (120 * 5_u64).div_ceil(32) });
        assert_eq!(geometry.detail.plane, Plane { first: 49, bits: 9, words: (120 * 9_u64).div_ceil(32) });
        assert_eq!((geometry.index_words(), geometry.table_words()), (30 + 19 + 34, 20 * 2 + 300 * 16));
        let colours = VolumeLayout { channels: 3, ..layout() };
        let geometry = Geometry::new(&colours, &parameters()).unwrap();
        assert_eq!(
            (geometry.means.words, geometry.coarse.dimension, geometry.detail.dimension),
            (90, 24, 192)
        );
    }

    #[test]
    fn what_contradicts_the_layout_is_refused() {
        let wrong: [fn(&mut Parameters); 13] = [
            |p| p.grid[0] = 5,
            |p| p.coarse.tables = vec![],
            |p| p.detail.tables = vec![4, 4],
            |p| p.detail.tables = vec![0],
            |p| p.coarse.tables = vec![65537],
            |p| p.codeword_bits = 12,
            |p| p.mean_bits = 0,
            |p| p.mean_step = 0,
            |p| p.mean_step = 1 << 20,
            |p| p.level_bits = 7,
            |p| p.top = 256,
            |p| p.detail.zero = 256,
            |p| p.coarse.step = 1 << 20,
        ];
        assert!(Geometry::new(&layout(), &parameters()).is_some());
        for (i, change) in wrong.iter().enumerate() {
            let mut parameters = parameters();
            change(&mut parameters);
            assert_eq!(Geometry::new(&layout(), &parameters), None, "change {i}");
        }
    }
}
