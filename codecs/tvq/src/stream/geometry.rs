//! Decode parameters, and where blocks, sub-volumes and groups lie.

use cvr_codebook::Quantiser;
use cvr_core::codec::Block;
use cvr_core::kit::BlockGrid;
use cvr_core::volume::{Extent, VolumeLayout};
use serde::{Deserialize, Serialize};

/// Voxels along each axis of a block.
pub const EDGE: u32 = 4;
/// Voxels of a block.
pub const VOXELS: usize = 64;
/// Blocks along each axis of a group.
pub const GROUP: u32 = cvr_groups::EDGE;
/// Most codebooks of a table.
pub const MOST_BOOKS: u32 = 63;
/// Most codebooks of a table of the payload `fixed`. A block then needs at most 64 bits.
pub const FIXED_BOOKS: u32 = 3;
/// Words of the head of a group.
pub const HEAD_WORDS: u32 = cvr_groups::HEAD_WORDS;
/// Words of a table before its codebooks.
pub const TABLE_HEAD: u32 = 5;
/// Words of a codebook in its table.
pub const BOOK_WORDS: u32 = 3;
pub use cvr_groups::VALUE_BITS;

/// Largest value before it is scaled to data units.
pub const TOP: i32 = (1 << VALUE_BITS) - 1;

/// Content of a block.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Payload {
    /// A mean and one code of every codebook.
    Fixed,
    /// A mean and as many codes as the block needs, found through its group.
    Variable,
}

/// The decode parameters in the container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Content of a block.
    pub payload: Payload,
    /// Blocks along x, y, z.
    pub grid: [u32; 3],
    /// Edge of a sub-volume in voxels. 0: the whole volume is one sub-volume.
    pub subvolume: u32,
    /// Value of sum 0, in data units.
    pub offset: f32,
    /// Data units per unit of the sum.
    pub step: f32,
    /// Bits of one entry of a codebook: 8 or 16.
    pub entry_bits: u32,
    /// Codebooks of a table.
    pub books: u32,
    /// Sets of tables: one for all frames, or one for each.
    pub tables: u32,
    /// Entries of the codebooks of each set.
    pub entries: Vec<u64>,
    /// Words of the indices of each frame.
    pub frame_words: Vec<u64>,
    /// Training of the codebooks. The decoder does not use it.
    pub training: serde_json::Value,
}

/// Sizes that follow from layout and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Values per voxel: 1 or 3.
    pub channels: u32,
    /// Frames.
    pub frames: u32,
    /// Content of a block.
    pub payload: Payload,
    /// Blocks over the volume.
    pub grid: BlockGrid,
    /// Blocks along each axis of a sub-volume.
    pub sub_blocks: [u32; 3],
    /// Sub-volumes along each axis.
    pub sub_grid: Extent,
    /// Groups along each axis.
    pub groups: Extent,
    /// Sums become values.
    pub quantiser: Quantiser,
    /// Bits of one entry of a codebook: 8 or 16.
    pub entry_bits: u32,
    /// Codebooks of a table.
    pub books: u32,
    /// Sets of tables.
    pub tables: u32,
    /// Entries of the codebooks of each set.
    pub entries: Vec<u64>,
    /// Words of the indices of each frame.
    pub frame_words: Vec<u64>,
}

impl Geometry {
    /// The geometry. `None` if the parameters are out of range or contradict the layout.
    #[must_use]
    pub fn new(layout: &VolumeLayout, parameters: &Parameters) -> Option<Self> {
        let p = parameters;
        let grid = block_grid(layout.extent);
        let fits = grid.to_array() == p.grid
            && (p.subvolume == 0 || (p.subvolume.is_multiple_of(EDGE * GROUP) && p.subvolume <= 1024))
            && p.books <= if p.payload == Payload::Fixed { FIXED_BOOKS } else { MOST_BOOKS }
            && matches!(p.entry_bits, 8 | 16)
            && (p.tables == 1 || p.tables == layout.frames)
            && p.entries.len() == p.tables as usize
            && p.entries.iter().all(|&entries| entries <= u64::from(u32::MAX))
            && p.frame_words.len() == layout.frames as usize;
        if !fits {
            return None;
        }
        let sub_blocks = sub_blocks(grid, p.subvolume);
        let sub = Extent::try_from(sub_blocks).ok()?;
        Some(Self {
            channels: layout.channels,
            frames: layout.frames,
            payload: p.payload,
            grid: BlockGrid::new(block(), layout.extent),
            sub_blocks,
            sub_grid: grid.blocks_of(sub),
            groups: grid.blocks_of(Extent::cube(GROUP).ok()?),
            quantiser: Quantiser::of_stream(VALUE_BITS, p.offset, p.step)?,
            entry_bits: p.entry_bits,
            books: p.books,
            tables: p.tables,
            entries: p.entries.clone(),
            frame_words: p.frame_words.clone(),
        })
    }

    /// The set of tables that decodes a frame.
    #[must_use]
    pub fn set_of(&self, frame: u32) -> usize {
        if self.tables == 1 { 0 } else { frame as usize }
    }

    /// Words of a table.
    #[must_use]
    pub const fn table_words(&self) -> u32 {
        TABLE_HEAD + BOOK_WORDS * self.books
    }

    /// Words of the codebooks of a set: at least one.
    #[must_use]
    pub fn codebook_words(&self, set: usize) -> u64 {
        (self.entries[set] * u64::from(self.entry_bits)).div_ceil(32).max(1)
    }

    /// Binary logarithm of the entries in one word: 2 or 1.
    #[must_use]
    pub const fn lanes_log2(&self) -> u32 {
        (32 / self.entry_bits).ilog2()
    }

    /// Words of the heads of one frame. 0 for the payload `fixed`.
    #[must_use]
    pub const fn frame_heads(&self) -> u64 {
        match self.payload {
            Payload::Fixed => 0,
            Payload::Variable => self.groups.voxels() * self.channels as u64 * HEAD_WORDS as u64,
        }
    }

    /// Blocks of a sub-volume: its first block, and the number along each axis.
    #[must_use]
    pub fn sub_volume(&self, sub: [u32; 3]) -> ([u32; 3], [u32; 3]) {
        let (grid, size) = (self.grid.blocks().to_array(), self.sub_blocks);
        let first = [0, 1, 2].map(|a| sub[a] * size[a]);
        (first, [0, 1, 2].map(|a| size[a].min(grid[a] - first[a])))
    }

    /// Blocks of a group: its first block, and how many there are along each axis.
    #[must_use]
    pub fn group(&self, group: [u32; 3]) -> ([u32; 3], [u32; 3]) {
        let grid = self.grid.blocks().to_array();
        let first = group.map(|b| b * GROUP);
        (first, [0, 1, 2].map(|a| GROUP.min(grid[a] - first[a])))
    }

    /// Whether a shader can address one frame with 32-bit numbers of words, and of bits in a sub-volume.
    #[must_use]
    pub fn fits_a_shader(&self) -> bool {
        let most = u64::from(u32::MAX);
        self.grid.blocks().voxels() <= most / 64
            && self.frame_words.iter().all(|words| *words <= most)
            && self.frame_heads() <= most
            && self.entries.iter().all(|entries| *entries <= most)
            && self.sub_grid.voxels() * u64::from(self.table_words()) <= most
    }
}

/// The block of the codec.
#[must_use]
pub fn block() -> Block {
    Block(Extent::cube(EDGE).unwrap_or(Extent::ONE))
}

/// Blocks along each axis, edge blocks cut.
#[must_use]
pub fn block_grid(extent: Extent) -> Extent {
    block().grid(extent)
}

/// Blocks along each axis of a sub-volume of `subvolume` voxels. 0 means the whole volume.
#[must_use]
pub fn sub_blocks(grid: Extent, subvolume: u32) -> [u32; 3] {
    let size = subvolume / EDGE;
    grid.to_array().map(|g| if size == 0 { g } else { size.min(g) })
}

/// The number of a position in a box of `size`, x fastest.
#[must_use]
#[inline]
pub fn number(p: [u32; 3], size: [u32; 3]) -> usize {
    (p[2] as usize * size[1] as usize + p[1] as usize) * size[0] as usize + p[0] as usize
}

/// Positions in a box of `size`, x fastest.
pub fn positions(size: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let [x, y, z] = size;
    (0..z).flat_map(move |z| (0..y).flat_map(move |y| (0..x).map(move |x| [x, y, z])))
}
