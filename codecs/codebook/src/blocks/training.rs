//! The training set of a table: randomly drawn blocks of all frames that the table serves.

use std::ops::Range;

use cvr_core::codec::{Block, EncodeError, Progress};
use cvr_core::kit::BlockRow;
use cvr_core::volume::{BrickSource, FrameIndex};
use rayon::prelude::*;

use crate::{Vectors, sample};

/// Rows of blocks read in one step. Progress is reported between steps.
const STEP: usize = 256;

/// A row of blocks, and the wanted ones among them.
pub(super) struct Wanted {
    pub frame: FrameIndex,
    pub by: u32,
    pub bz: u32,
    /// Position along x, and the weight of a whole block there.
    pub blocks: Vec<(u32, f64)>,
}

/// At most `count` blocks of the frames `frames`, as vectors. A block cut by the volume's border is padded with its
/// last voxels. Its weight is the fraction of it that lies in the volume.
///
/// # Errors
/// Those of reading, and when `run` was cancelled.
pub fn training_vectors(
    source: &dyn BrickSource,
    block: Block,
    frames: Range<u32>,
    count: u64,
    seed: u64,
    run: &Progress<'_>,
) -> Result<Vectors, EncodeError> {
    let layout = source.layout();
    let [gx, gy, gz] = block.grid(layout.extent).to_array().map(u64::from);
    let all = gx * gy * gz * u64::from(frames.end - frames.start);
    let mut rows: Vec<Wanted> = Vec::new();
    for chosen in sample::choose(all, count, seed) {
        let (bx, row) = ((chosen % gx) as u32, chosen / gx);
        let (by, bz) = ((row % gy) as u32, (row / gy % gz) as u32);
        let frame = FrameIndex(frames.start + (row / gy / gz) as u32);
        match rows.last_mut() {
            Some(last) if (last.frame, last.by, last.bz) == (frame, by, bz) => last.blocks.push((bx, 1.0)),
            _ => rows.push(Wanted { frame, by, bz, blocks: vec![(bx, 1.0)] }),
        }
    }
    read_wanted(source, block, &rows, run)
}

/// The blocks of some rows, in order.
pub(super) fn read_wanted(
    source: &dyn BrickSource,
    block: Block,
    rows: &[Wanted],
    run: &Progress<'_>,
) -> Result<Vectors, EncodeError> {
    let dimension = block.0.voxels() as usize * source.layout().channels as usize;
    let mut vectors = Vectors::new(dimension);
    for step in rows.chunks(STEP) {
        let read = |row: &Wanted| row_vectors(source, block, row, dimension);
        let parts: Vec<Vectors> = step.par_iter().map(read).collect::<Result<_, _>>()?;
        parts.iter().for_each(|part| vectors.append(part));
        run.advance(0)?;
    }
    Ok(vectors)
}

fn row_vectors(
    source: &dyn BrickSource,
    block: Block,
    wanted: &Wanted,
    dimension: usize,
) -> Result<Vectors, EncodeError> {
    let row = BlockRow::read(source, block, wanted.frame, wanted.by, wanted.bz)?;
    let mut vectors = Vectors::new(dimension);
    let mut vector = Vec::with_capacity(dimension);
    for &(bx, weight) in &wanted.blocks {
        vector.clear();
        row.append(bx, &mut vector);
        let inside: usize = row.cut(bx).iter().product();
        vectors.push(&vector, weight * inside as f64 / block.0.voxels() as f64);
    }
    Ok(vectors)
}
