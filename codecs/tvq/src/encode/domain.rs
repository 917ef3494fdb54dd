//! The blocks of one table, read from the source: voxels in units of the decoder's sums.

use std::ops::Range;

use cvr_codebook::Quantiser;
use cvr_core::codec::EncodeError;
use cvr_core::kit::BlockRow;
use cvr_core::volume::{BrickSource, FrameIndex};

use crate::stream::geometry::{VOXELS, block};

/// Blocks of some frames and all channels that share a table.
#[derive(Clone, Debug)]
pub struct Domain {
    /// Frames.
    pub frames: Range<u32>,
    /// Channels.
    pub channels: u32,
    /// First block.
    pub first: [u32; 3],
    /// Blocks along each axis.
    pub size: [u32; 3],
}

/// One row of blocks of one channel.
#[derive(Debug)]
pub struct Row {
    /// Blocks of 64 values each. Beyond the volume's border its last voxels are repeated.
    pub values: Vec<f32>,
    /// Size in voxels of the first and of the last block of the row, after the border cuts them.
    pub cuts: [[usize; 3]; 2],
}

impl Row {
    /// Size of a block in voxels, after the border cuts it.
    #[must_use]
    pub fn cut(&self, n: usize) -> [usize; 3] {
        self.cuts[usize::from((n + 1) * VOXELS == self.values.len())]
    }
}

impl Domain {
    /// Blocks of one channel of one frame.
    #[must_use]
    pub fn plane_blocks(&self) -> usize {
        self.size.map(|s| s as usize).iter().product()
    }

    /// All blocks.
    #[must_use]
    pub fn blocks(&self) -> u64 {
        self.plane_blocks() as u64 * u64::from(self.channels) * u64::from(self.frames.end - self.frames.start)
    }

    /// Reads the rows `y`, `z` of the domain, one per channel, in units of the decoder's sums.
    ///
    /// # Errors
    /// Those of the source.
    pub fn row(
        &self,
        source: &dyn BrickSource,
        quantiser: Quantiser,
        frame: u32,
        y: u32,
        z: u32,
    ) -> Result<Vec<Row>, EncodeError> {
        let (offset, scale) = (f64::from(quantiser.offset()), 1.0 / f64::from(quantiser.step()));
        self.values(source, frame, y, z, |v| ((f64::from(v) - offset) * scale) as f32)
    }

    /// Reads the rows `y`, `z` of the domain, one per channel, with `map` applied to each value.
    ///
    /// # Errors
    /// Those of the source.
    pub fn values(
        &self,
        source: &dyn BrickSource,
        frame: u32,
        y: u32,
        z: u32,
        map: impl Fn(f32) -> f32,
    ) -> Result<Vec<Row>, EncodeError> {
        let (by, bz) = (self.first[1] + y, self.first[2] + z);
        let row = BlockRow::read(source, block(), FrameIndex(frame), by, bz)?;
        let channels = self.channels as usize;
        let xs = self.first[0]..self.first[0] + self.size[0];
        let cuts = [row.cut(xs.start), row.cut(xs.end - 1)];
        let new = || Row { values: Vec::with_capacity(xs.len() * VOXELS), cuts };
        let mut rows: Vec<Row> = (0..channels).map(|_| new()).collect();
        let mut vector = Vec::with_capacity(VOXELS * channels);
        for bx in xs.clone() {
            vector.clear();
            row.append(bx, &mut vector);
            for (c, row) in rows.iter_mut().enumerate() {
                row.values.extend(vector[c..].iter().step_by(channels).map(|v| map(*v)));
            }
        }
        Ok(rows)
    }
}
