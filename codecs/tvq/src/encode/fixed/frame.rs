//! Writes means and codes of a frame of the payload `fixed` as words.

use cvr_groups::Bits;

use crate::encode::closed_loop::Plane;
use crate::stream::table::Table;

/// One frame of the payload `fixed`: channel by channel, sub-volume by sub-volume, the means and then the codes of each
/// codebook. `planes[s][c]` is sub-volume `s`, channel `c`.
#[must_use]
pub fn fixed_frame(tables: &[Table], planes: &[&[Plane]]) -> Vec<u32> {
    let mut words = Vec::new();
    for channel in 0..planes.first().map_or(0, |p| p.len()) {
        for (table, planes) in tables.iter().zip(planes) {
            let plane = &planes[channel];
            let mut bits = Bits::default();
            plane.means.iter().for_each(|m| bits.push(m - table.mean_base, table.width));
            for (b, book) in table.books.iter().enumerate() {
                let codes = plane.codes.iter().skip(b).step_by(plane.books.max(1));
                codes.for_each(|code| bits.push((*code).into(), book.width));
            }
            words.extend(bits.finish());
        }
    }
    // At least one word exists, even if nothing needs a bit.
    words.push(0);
    words
}
