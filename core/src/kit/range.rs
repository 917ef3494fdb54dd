//! The range of a volume before it is encoded.

use rayon::prelude::*;

use super::{BlockGrid, BlockRow};
use crate::codec::{Block, EncodeError, Progress};
use crate::volume::{BrickSource, FrameIndex, ValueRange};

/// The range of all values of the source, read in rows of blocks.
///
/// # Errors
/// If reading fails, or if `run` was cancelled.
pub fn value_range(
    source: &dyn BrickSource,
    block: Block,
    run: &Progress<'_>,
) -> Result<ValueRange, EncodeError> {
    let layout = source.layout();
    let grid = BlockGrid::new(block, layout.extent).blocks();
    let mut range: Option<ValueRange> = None;
    for frame in (0..layout.frames).map(FrameIndex) {
        for bz in 0..grid.z() {
            let of_row = |by| {
                let row = BlockRow::read(source, block, frame, by, bz)?;
                Ok(ValueRange::of(row.values().iter().copied()))
            };
            let parts = (0..grid.y()).into_par_iter().map(of_row);
            let parts: Vec<Option<ValueRange>> = parts.collect::<Result<_, EncodeError>>()?;
            range = parts.into_iter().flatten().chain(range).reduce(ValueRange::union);
            // Nothing is coded yet.
            run.advance(0)?;
        }
    }
    Ok(range.unwrap_or(ValueRange { min: 0.0, max: 0.0 }))
}
