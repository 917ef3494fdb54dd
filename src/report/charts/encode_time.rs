//! Encoding time over quality, of one volume on one machine.

use super::super::cells::{compressed, distinct};
use super::super::chart::{Axis, Chart, LegendEntry, Line, Mark, Scale};
use super::marks::{Palette, Placed, beaten_entries, contest, failure_entries, one_per_coding};
use crate::experiment::records::record::Record;

/// Seconds to encode over the PSNR of the voxels. Cells that decode only some stages are left out: their encoding time is
/// that of the whole stream.
pub(super) fn encode_time(
    records: &[Record],
    palette: &Palette,
    volume: &str,
    device: &str,
) -> Option<Chart> {
    let measured = |r: &&Record| {
        r.psnr_db.is_some() && r.encode_seconds.is_some() && r.stages.is_none() && r.resolution == 0
    };
    let own = |r: &&Record| r.volume == volume && r.device == device && compressed(r);
    let cells = one_per_coding(&records.iter().filter(own).filter(measured).collect::<Vec<_>>());
    let x = Axis {
        infinity: Some("lossless"),
        ..Axis::new("psnr_db", "PSNR of the voxels in dB  (better →)", Scale::Linear)
    };
    let y = Axis::new("encode_seconds", "encoding, seconds  (← better)", Scale::Log);
    // Codecs differ in their rates too, which this chart does not show: settings compete within their series.
    let (mut points, mut lines) = (Vec::new(), Vec::new());
    for series in distinct(cells.iter().map(|r| palette.labels.series(r))) {
        let mark = palette.mark(&series);
        let placed = cells.iter().filter(|r| palette.labels.series(r) == series).filter_map(|record| {
            let (x, y) = (record.psnr_db?, record.encode_seconds?);
            Some(Placed { record, x, y, mark })
        });
        let placed: Vec<Placed<'_>> = placed.filter(|p| x.shows(p.x) && y.shows(p.y)).collect();
        let (own, line) = contest(records, palette, &placed, |psnr, seconds| (seconds, -psnr));
        points.extend(own);
        lines.push(Line { colour: mark.colour, ..line });
    }
    points.sort_by_key(|p| (p.mark == Mark::failure(), p.unbeaten));
    let mut legend = palette.series_entries(&cells);
    let beaten = beaten_entries(&points).into_iter();
    legend.extend(
        beaten.map(|e| LegendEntry {
            label: "grey: a setting of the same curve is at least as good".into(),
            ..e
        }),
    );
    legend.extend(failure_entries(&points));
    let description =
        format!("Seconds to encode over PSNR of the voxels, volume {volume}, run with {device}");
    (!points.is_empty()).then_some(Chart { description, x, y, lines, points, legend })
}
