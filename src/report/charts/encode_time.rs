//! Encoding time over quality, of one volume on one machine.

use super::super::cells::compressed;
use super::super::chart::{Axis, Chart, Scale};
use super::marks::{Palette, Placed, beaten_entries, contest, failure_entries, one_per_coding};
use crate::experiment::record::Record;

/// Seconds to encode over the PSNR of the voxels. Of a stream that is decoded in part, encoding is that of the whole, so
/// that such cells are left out.
pub(super) fn encode_time(
    records: &[Record],
    palette: &Palette,
    volume: &str,
    device: &str,
) -> Option<Chart> {
    let measured = |r: &&Record| r.psnr_db.is_some() && r.encode_seconds.is_some() && r.stages.is_none();
    let own = |r: &&Record| r.volume == volume && r.device == device && compressed(r);
    let cells = one_per_coding(&records.iter().filter(own).filter(measured).collect::<Vec<_>>());
    let x = Axis {
        infinity: Some("lossless"),
        ..Axis::new("psnr_db", "PSNR of the voxels in dB  (better →)", Scale::Linear)
    };
    let y = Axis::new("encode_seconds", "encoding, seconds  (← better)", Scale::Log);
    let place = |record: &&'_ Record| Some((record.psnr_db?, record.encode_seconds?));
    let placed = cells.iter().filter_map(|record| {
        let (x, y) = place(record)?;
        Some(Placed { record, x, y, mark: palette.codec_mark(&record.codec) })
    });
    let placed: Vec<Placed<'_>> = placed.filter(|p| x.shows(p.x) && y.shows(p.y)).collect();
    let (points, line) = contest(records, &placed, |psnr, seconds| (seconds, -psnr));
    let mut legend = palette.codec_entries(&cells);
    legend.extend(beaten_entries(&points));
    legend.extend(failure_entries(&points));
    let description =
        format!("Seconds to encode over PSNR of the voxels, volume {volume}, run with {device}");
    (!points.is_empty()).then_some(Chart { description, x, y, lines: vec![line], points, legend })
}
