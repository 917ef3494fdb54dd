//! Positions of indices and codewords in the two tensors.

use cvr_codebook::{Quantiser, index_bits};
use cvr_core::codec::Block;
use cvr_core::kit::BlockGrid;
use cvr_core::volume::VolumeLayout;
use serde::{Deserialize, Serialize};

use crate::LONGEST;

/// Most codewords of a table.
const MOST_CODEWORDS: u32 = 1 << 16;

/// The decode parameters in the container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Size of a block in voxels.
    pub block: Block,
    /// Blocks along x, y, z.
    pub grid: [u32; 3],
    /// Bits of one value of a codeword: 8 or 16.
    pub codeword_bits: u32,
    /// Value of code 0, in data units.
    pub offset: f32,
    /// Data units per code.
    pub step: f32,
    /// Number of codewords of each table: one table for all frames, or one per frame.
    pub tables: Vec<u32>,
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
    /// Rounds of refinement of each table.
    pub rounds: Vec<u32>,
}

/// Sizes that follow from layout and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Blocks over the volume.
    pub grid: BlockGrid,
    /// Values per voxel: 1 or 3.
    pub channels: u32,
    /// How a value of a codeword is stored.
    pub quantiser: Quantiser,
    /// Codewords of each table.
    pub tables: Vec<u32>,
    /// Bits of an index, 1 to 16: as many as the largest table needs.
    pub index_bits: u32,
}

impl Geometry {
    /// The geometry. `None` if the parameters are out of range or contradict the layout.
    #[must_use]
    pub fn new(layout: &VolumeLayout, parameters: &Parameters) -> Option<Self> {
        let &Parameters { block, grid, codeword_bits, offset, step, ref tables, .. } = parameters;
        let largest = *tables.iter().max()?;
        let blocks = BlockGrid::new(block, layout.extent);
        let fits = block.0.to_array().iter().all(|a| *a <= LONGEST)
            && blocks.blocks().to_array() == grid
            && (tables.len() == 1 || tables.len() == layout.frames as usize)
            && tables.iter().all(|t| (1..=MOST_CODEWORDS).contains(t));
        fits.then_some(Self {
            grid: blocks,
            channels: layout.channels,
            quantiser: Quantiser::of_stream(codeword_bits, offset, step)?,
            tables: tables.clone(),
            index_bits: index_bits(largest as usize),
        })
    }

    /// The geometry of a stream.
    ///
    /// # Errors
    /// A sentence with the parameters, where [`Geometry::new`] has none.
    pub fn of_stream(layout: &VolumeLayout, parameters: &Parameters) -> Result<Self, String> {
        Self::new(layout, parameters).ok_or_else(|| {
            let &Parameters { block, grid, codeword_bits, offset, step, ref tables, .. } = parameters;
            format!(
                "blocks of {block} in a grid of {grid:?}, codewords of {codeword_bits} bits from {offset} in steps \
                 of {step}, {} tables for {} frames of {} voxels",
                tables.len(),
                layout.frames,
                layout.extent
            )
        })
    }

    /// Values of a codeword.
    #[must_use]
    pub const fn dimension(&self) -> u32 {
        self.grid.block().0.voxels() as u32 * self.channels
    }

    /// Binary logarithm of the codes in one word: 2 or 1.
    #[must_use]
    pub const fn lanes_log2(&self) -> u32 {
        (32 / self.quantiser.bits()).ilog2()
    }

    /// Which table decodes a frame.
    #[must_use]
    pub fn table_of(&self, frame: u32) -> usize {
        if self.tables.len() == 1 { 0 } else { frame as usize }
    }

    /// Words of one table: as many as the largest needs.
    #[must_use]
    pub fn table_words(&self) -> u64 {
        let largest = self.tables.iter().copied().max().unwrap_or(0);
        (u64::from(largest) * u64::from(self.dimension())).div_ceil(1 << self.lanes_log2())
    }

    /// Words of the indices of one frame.
    #[must_use]
    pub const fn index_words(&self) -> u64 {
        (self.grid.blocks().voxels() * self.index_bits as u64).div_ceil(32)
    }

    /// Shape of the tensor `codebook`.
    #[must_use]
    pub fn codebook_shape(&self) -> [u64; 2] {
        [self.tables.len() as u64, self.table_words()]
    }

    /// Shape of the tensor `index`.
    #[must_use]
    pub fn index_shape(&self, frames: u32) -> [u64; 2] {
        [u64::from(frames), self.index_words()]
    }

    /// Whether a shader can address one frame with 32-bit numbers of blocks and words. Codewords always fit: 65536 of
    /// 16³ RGB voxels have fewer than 2^30 values.
    #[must_use]
    pub const fn fits_a_shader(&self) -> bool {
        self.grid.blocks().voxels() <= u32::MAX as u64 && self.index_words() <= u32::MAX as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::{Extent, SampleType};

    fn parameters() -> Parameters {
        Parameters {
            block: "4".parse().unwrap(),
            grid: [4, 5, 6],
            codeword_bits: 8,
            offset: 0.0,
            step: 1.0,
            tables: vec![300],
            training: TrainingRecord {
                initial: "pca".to_owned(),
                generator: "pcg64".to_owned(),
                seed: 1,
                blocks: vec![120],
                rounds: vec![3],
            },
        }
    }

    #[test]
    fn indices_and_tables_are_packed_and_frames_are_whole_words() {
        let layout = VolumeLayout::scalar(Extent::new(13, 17, 23).unwrap(), SampleType::U8);
        let geometry = Geometry::new(&layout, &parameters()).unwrap();
        assert_eq!((geometry.index_bits, geometry.dimension()), (9, 64));
        assert_eq!(geometry.index_words(), (120 * 9_u64).div_ceil(32));
        assert_eq!(geometry.table_words(), 300 * 16);
    }

    #[test]
    fn what_contradicts_the_layout_is_refused() {
        let layout = VolumeLayout::scalar(Extent::new(13, 17, 23).unwrap(), SampleType::U8);
        let wrong: [fn(&mut Parameters); 6] = [
            |p| p.grid[0] = 5,
            |p| p.tables = vec![],
            |p| p.tables = vec![4, 4],
            |p| p.tables = vec![0],
            |p| p.tables = vec![65537],
            |p| p.codeword_bits = 12,
        ];
        for change in wrong {
            let mut parameters = parameters();
            change(&mut parameters);
            assert_eq!(Geometry::new(&layout, &parameters), None);
        }
    }
}
