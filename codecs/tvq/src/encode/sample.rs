//! Blocks to train on, drawn by chance.

use cvr_codebook::{Quantiser, sample};
use cvr_core::codec::{EncodeError, Progress};
use cvr_core::volume::BrickSource;
use rayon::prelude::*;

use super::domain::Domain;
use crate::stream::geometry::VOXELS;

/// Rows of blocks read in one step. Progress is reported between steps.
const STEP: usize = 256;

/// Blocks to train on.
#[derive(Clone, Debug)]
pub struct Sample {
    /// 64 values each.
    pub values: Vec<f32>,
    /// Fraction of each block that lies in the volume.
    pub weights: Vec<f64>,
    /// Number of blocks that each block represents.
    pub scale: f64,
}

impl Sample {
    /// Number of blocks.
    #[must_use]
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// At most `count` randomly drawn blocks of some domains.
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
            // A row holds the blocks of all channels, channel by channel.
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
