//! What blocks keep under the payload `variable`.

/// What the blocks of a plane keep.
#[derive(Clone, Debug, Default)]
pub struct KeptPlane {
    /// Number of codes of each block.
    pub codes: Vec<u8>,
    /// Bits of a voxel of what is coded directly behind them; 0 where nothing is.
    pub bits: Vec<u8>,
    /// The words of that, block by block, and where those of each block end.
    pub words: Vec<u32>,
    /// See `words`.
    pub ends: Vec<usize>,
}

impl KeptPlane {
    /// Words of what is coded directly of a block; none where nothing is.
    #[must_use]
    pub fn escape(&self, block: usize) -> &[u32] {
        let begin = if block == 0 { 0 } else { self.ends[block - 1] };
        &self.words[begin..self.ends[block]]
    }
}
