//! Means and codes of a frame of the payload `variable` into words, group by group.

use cvr_groups::{Codes, Writer, mean_width};

use crate::encode::closed_loop::Plane;
use crate::stream::geometry::{Geometry, number, positions};
use crate::stream::table::Table;
use cvr_groups::KeptPlane;

/// One frame of the payload `variable`: heads and indices, or `None` where they exceed 2^32 words. `kept[s][c]` says what
/// each block of `planes[s][c]` keeps.
#[must_use]
pub fn variable_frame(
    g: &Geometry,
    tables: &[Table],
    planes: &[&[Plane]],
    kept: &[&[KeptPlane]],
) -> Option<(Vec<u32>, Vec<u32>)> {
    let mut writer = Writer::new(1);
    for channel in 0..g.channels as usize {
        for group in positions(g.groups.to_array()) {
            let (first, size) = g.group(group);
            let sub = [0, 1, 2].map(|a| first[a] / g.sub_blocks[a]);
            let (sub_first, sub_size) = g.sub_volume(sub);
            let s = number(sub, g.sub_grid.to_array());
            let (plane, kept) = (&planes[s][channel], &kept[s][channel]);
            let block = |p: [u32; 3]| {
                let n = number([0, 1, 2].map(|a| first[a] + p[a] - sub_first[a]), sub_size);
                let codes = &plane.codes[n * plane.books..][..usize::from(kept.codes[n])];
                Codes { mean: plane.means[n], codes, escape: kept.escape(n) }
            };
            let blocks: Vec<Codes<'_>> = positions(size).map(block).collect();
            writer.push(&blocks, mean_width(blocks.iter().map(|b| b.mean)), tables[s].width)?;
        }
    }
    Some(writer.finish())
}
