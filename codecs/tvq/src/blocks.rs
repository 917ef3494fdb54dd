//! The blocks that one table serves, read from the source: voxels in units of the decoder's sums.

use std::ops::Range;

use cvr_codebook::{Quantiser, sample};
use cvr_core::codec::{EncodeError, Progress};
use cvr_core::kit::BlockRow;
use cvr_core::volume::{BrickSource, FrameIndex};
use rayon::prelude::*;

use crate::geometry::{VOXELS, block};

/// Rows of blocks that one step reads, between two looks at the progress.
const STEP: usize = 256;

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
    /// Blocks, 64 values each; beyond the volume's border its last voxels are repeated.
    pub values: Vec<f32>,
    /// Voxels that there are of the first block of the row, and of the last.
    pub cuts: [[usize; 3]; 2],
}

impl Row {
    /// Voxels that there are of a block.
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

    /// Reads the row `y`, `z` of the domain, in units of the decoder's sums: one for each channel.
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

    /// Reads the row `y`, `z` of the domain, each value through `map`: one for each channel.
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

/// Blocks to train on.
#[derive(Clone, Debug)]
pub struct Sample {
    /// 64 values each.
    pub values: Vec<f32>,
    /// Part of each that lies in the volume.
    pub weights: Vec<f64>,
    /// Blocks that each stands for.
    pub scale: f64,
}

impl Sample {
    /// Number of blocks.
    #[must_use]
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// At most `count` blocks of some domains, drawn by chance.
    ///
    /// # Errors
    /// Those of reading, and when `run` was cancelled.
    pub fn draw(
        source: &dyn BrickSource,
        domains: &[Domain],
        quantiser: Quantiser,
        count: u64,
        seed: u64,
        run: &Progress<'_>,
    ) -> Result<Self, EncodeError> {
        let all: u64 = domains.iter().map(Domain::blocks).sum();
        let mut chosen = sample::choose(all, count, seed).into_iter().peekable();
        let mut sample = Self { values: Vec::new(), weights: Vec::new(), scale: 1.0 };
        let mut before = 0;
        for domain in domains {
            // A row holds the blocks of all channels: channel by channel.
            let [width, height, depth] = domain.size.map(u64::from);
            let row_blocks = width * u64::from(domain.channels);
            let mut wanted: Vec<(u64, Vec<usize>)> = Vec::new();
            while let Some(n) = chosen.next_if(|n| *n < before + domain.blocks()) {
                let (row, place) = ((n - before) / row_blocks, ((n - before) % row_blocks) as usize);
                match wanted.last_mut() {
                    Some((last, places)) if *last == row => places.push(place),
                    _ => wanted.push((row, vec![place])),
                }
            }
            before += domain.blocks();
            for step in wanted.chunks(STEP) {
                let read = |(row, places): &(u64, Vec<usize>)| {
                    let (y, z) = ((row % height) as u32, (row / height % depth) as u32);
                    let frame = domain.frames.start + (row / height / depth) as u32;
                    let rows = domain.row(source, quantiser, frame, y, z)?;
                    let (mut values, mut weights) = (Vec::new(), Vec::new());
                    for place in places {
                        let (row, n) = (&rows[place / width as usize], place % width as usize);
                        values.extend_from_slice(&row.values[n * VOXELS..(n + 1) * VOXELS]);
                        weights.push(row.cut(n).iter().product::<usize>() as f64 / VOXELS as f64);
                    }
                    Ok((values, weights))
                };
                let parts: Vec<(Vec<f32>, Vec<f64>)> =
                    step.par_iter().map(read).collect::<Result<_, EncodeError>>()?;
                for (values, weights) in parts {
                    sample.values.extend(values);
                    sample.weights.extend(weights);
                }
                run.advance(0)?;
            }
        }
        sample.scale = all as f64 / sample.len().max(1) as f64;
        Ok(sample)
    }
}
