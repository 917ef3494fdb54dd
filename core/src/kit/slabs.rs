//! Coding a frame slab by slab, the rows of blocks of a slab in parallel.

use rayon::prelude::*;

use super::BlockGrid;
use crate::codec::{EncodeError, Progress};

/// Codes the rows of blocks of a frame (`row(by, bz)`) in parallel. Hands the rows of each slab to `each` in order (y
/// fastest). A slab is as many layers of blocks as cover `slab_voxels` along z, at least one. Progress counts the
/// voxels of a slab after `each` took it. The result does not depend on the number of threads.
///
/// # Errors
/// If `row` or `each` fails, or if `run` was cancelled.
pub fn code_frame<R: Send>(
    grid: &BlockGrid,
    slab_voxels: u32,
    run: &Progress<'_>,
    row: impl Fn(u32, u32) -> Result<R, EncodeError> + Sync,
    mut each: impl FnMut(Vec<R>) -> Result<(), EncodeError>,
) -> Result<(), EncodeError> {
    let [width, height, depth] = grid.volume().to_array();
    let [_, rows, layers] = grid.blocks().to_array();
    let at_once = (slab_voxels / grid.block().0.z()).max(1);
    for first in (0..layers).step_by(at_once as usize) {
        let end = layers.min(first + at_once);
        let all: Vec<(u32, u32)> = (first..end).flat_map(|bz| (0..rows).map(move |by| (by, bz))).collect();
        each(all.into_par_iter().map(|(by, bz)| row(by, bz)).collect::<Result<_, _>>()?)?;
        let slices = depth.min(end * grid.block().0.z()) - first * grid.block().0.z();
        run.advance(u64::from(slices) * u64::from(width) * u64::from(height))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::volume::Extent;

    #[test]
    fn every_row_comes_once_in_order_and_every_voxel_counts() {
        let grid = BlockGrid::new("4x4x2".parse().unwrap(), Extent::new(9, 10, 7).unwrap());
        for (slab_voxels, slabs) in [(0, 4), (2, 4), (4, 2), (100, 1)] {
            let done = AtomicU64::new(0);
            let run = Progress::new(|voxels| _ = done.fetch_add(voxels, Ordering::Relaxed), None);
            let (mut rows, mut count) = (Vec::new(), 0);
            code_frame(
                &grid,
                slab_voxels,
                &run,
                |by, bz| Ok([by, bz]),
                |slab| {
                    rows.extend(slab);
                    count += 1;
                    Ok(())
                },
            )
            .unwrap();
            let expected = (0..4).flat_map(|bz| (0..3).map(move |by| [by, bz]));
            assert!(rows.into_iter().eq(expected));
            assert_eq!((count, done.load(Ordering::Relaxed)), (slabs, grid.volume().voxels()));
        }
    }
}
