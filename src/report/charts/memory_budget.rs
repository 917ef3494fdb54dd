//! The best picture for a given amount of memory on the device, and its frame time. Pictures count and not voxels: a scene
//! does not show all voxels.

use super::super::cells::{Baseline, View, blends, shown};
use super::super::chart::{Axis, Chart, Colour, Line, Mark, Point, Scale, Shape};
use super::super::number::short;
use super::super::pareto;
use super::Drawing;
use super::marks::{
    Palette, baseline_entries, baseline_mark, beaten_entries, filter_entries, number, site_entries, title,
};
use crate::experiment::records::record::Record;
use crate::report::figure::Sheet;

const MIB: f64 = 1_048_576.0;

/// Bytes that the device needs for a cell: the maximum over drawing and decoding.
fn memory(record: &Record) -> Option<f64> {
    let bytes = record.resident_bytes?.max(record.device_decode_bytes.unwrap_or(0));
    (bytes > 0).then_some(bytes as f64)
}

/// The best picture over the memory that there is: a line of steps, each at a cell that no other beats.
pub(super) fn best_picture(
    records: &[Record],
    palette: &Palette,
    view: &View,
    device: &str,
) -> Option<Drawing> {
    let cells = cells(records, view, device);
    let best = best(&cells);
    let y = Axis {
        infinity: Some("identical"),
        ..Axis::new("image_psnr_db", "best PSNR of the picture in dB  (better →)", Scale::Linear)
    };
    let point = |cell: &(&Record, f64, f64)| {
        let (record, memory, psnr) = *cell;
        let unbeaten = best.iter().any(|b| std::ptr::eq(b.0, record));
        let mark = Mark { faint: !unbeaten, ..mark(palette, record) };
        Point {
            x: memory / MIB,
            y: psnr,
            mark,
            title: told(record, palette, memory),
            cell: Some(number(records, record)),
            unbeaten,
        }
    };
    let mut points: Vec<Point> = cells.iter().map(point).filter(|p| y.shows(p.y)).collect();
    points.sort_by_key(|p| p.unbeaten);
    let most = cells.iter().map(|c| c.1).fold(0.0, f64::max) / MIB;
    let steps = steps(&best.iter().map(|(_, memory, psnr)| (memory / MIB, *psnr)).collect::<Vec<_>>(), most);
    let lines = vec![Line { points: steps, colour: Colour::Ink, dashed: false }];
    let records_of: Vec<&Record> = cells.iter().map(|c| c.0).collect();
    let mut legend = site_entries(palette, &records_of);
    legend.extend(filter_entries(&records_of, Shape::Circle));
    legend.extend(baseline_entries(&records_of));
    legend.extend(beaten_entries(&points));
    let description = format!(
        "Best PSNR of the picture over memory on the device, volume {}, {}, on {device}",
        view.volume,
        view.name()
    );
    let chart = Chart { description, x: axis(), y, lines, points, legend };
    (!chart.points.is_empty()).then(|| Drawing { chart, sheet: Some(sheet(&best, palette, view, device)) })
}

/// The frame time of the cell with the best picture, over the memory that there is.
pub(super) fn its_frame_time(
    records: &[Record],
    palette: &Palette,
    view: &View,
    device: &str,
) -> Option<Chart> {
    let cells = cells(records, view, device);
    let best = best(&cells);
    let y = Axis {
        include: vec![1.0],
        ..Axis::new("relative_frame_time", "its frame time ÷ baseline A  (← better)", Scale::Log)
    };
    let timed = |cell: &&(&Record, f64, f64)| cell.0.relative_frame_time.is_some_and(|time| y.shows(time));
    let point = |&(record, memory, _): &(&Record, f64, f64)| {
        let y = record.relative_frame_time?;
        let cell = Some(number(records, record));
        let title = told(record, palette, memory);
        Some(Point { x: memory / MIB, y, mark: mark(palette, record), title, cell, unbeaten: true })
    };
    let points: Vec<Point> = best.iter().filter(timed).filter_map(point).collect();
    let most = cells.iter().map(|c| c.1).fold(0.0, f64::max) / MIB;
    // Budgets at which the best cell was not timed leave a gap.
    let mut lines = Vec::new();
    for (i, cell) in best.iter().enumerate().filter(|(_, cell)| timed(cell)) {
        let Some(time) = cell.0.relative_frame_time else { continue };
        let next = best.get(i + 1);
        let mut points = vec![(cell.1 / MIB, time), (next.map_or(most, |n| n.1 / MIB), time)];
        if let Some((next, later)) =
            next.filter(timed).and_then(|n| Some((n.1 / MIB, n.0.relative_frame_time?)))
        {
            points.push((next, later));
        }
        lines.push(Line { points, colour: Colour::Ink, dashed: false });
    }
    let shown: Vec<&Record> = best.iter().filter(timed).map(|c| c.0).collect();
    let mut legend = site_entries(palette, &shown);
    legend.extend(filter_entries(&shown, Shape::Circle));
    legend.extend(baseline_entries(&shown));
    let description = format!(
        "Frame time of the best picture over memory on the device, volume {}, {}, on {device}",
        view.volume,
        view.name()
    );
    (!points.is_empty()).then_some(Chart { description, x: axis(), y, lines, points, legend })
}

fn axis() -> Axis {
    Axis::new("memory_mib", "memory on the device, MiB  (← better)", Scale::Log)
}

fn mark(palette: &Palette, record: &Record) -> Mark {
    let plain = || Mark { filled: blends(record), ..palette.site_mark(record) };
    Baseline::of(record).map_or_else(plain, baseline_mark)
}

fn told(record: &Record, palette: &Palette, memory: f64) -> String {
    format!("{}\nfits into {} MiB", title(record, palette), short(Some(memory / MIB)))
}

/// Cells that ended well with their memory in bytes and the PSNR of their picture. The uncompressed compete too.
fn cells<'a>(records: &'a [Record], view: &View, device: &str) -> Vec<(&'a Record, f64, f64)> {
    let own = |r: &&Record| shown(r) && View::of(r) == *view && r.device == device;
    let measured = |r: &'a Record| Some((r, memory(r)?, r.image_psnr_db.filter(|p| !p.is_nan())?));
    records.iter().filter(own).filter_map(measured).collect()
}

/// The cells that no other beats in memory and picture, from the least memory on; of equal ones the fastest.
fn best<'a>(cells: &[(&'a Record, f64, f64)]) -> Vec<(&'a Record, f64, f64)> {
    let mut cells = cells.to_vec();
    let time = |r: &Record| r.relative_frame_time.unwrap_or(f64::INFINITY);
    cells.sort_by(|a, b| time(a.0).total_cmp(&time(b.0)));
    let costs: Vec<(f64, f64)> = cells.iter().map(|(_, memory, psnr)| (*memory, -psnr)).collect();
    pareto::front(&costs).into_iter().map(|i| cells[i]).collect()
}

/// A step curve: each value holds up to the next, the last one up to `end`.
fn steps(points: &[(f64, f64)], end: f64) -> Vec<(f64, f64)> {
    let mut line = Vec::new();
    for (i, (x, y)) in points.iter().enumerate() {
        line.extend([(*x, *y), (points.get(i + 1).map_or(end, |next| next.0), *y)]);
    }
    line
}

/// The best cell for each power of two, from the first that any cell fits into to the first that all fit into.
fn sheet(best: &[(&Record, f64, f64)], palette: &Palette, view: &View, device: &str) -> Sheet {
    let mut sheet = Sheet::new(&[
        "budget_bytes",
        "volume",
        "scene",
        "renderer",
        "device",
        "codec",
        "settings",
        "site",
        "filter",
        "skipping",
        "stages",
        "memory_bytes",
        "image_psnr_db",
        "relative_frame_time",
        "frame_ms",
        "series",
        "resolution",
    ]);
    let (Some(first), Some(last)) = (best.first(), best.last()) else { return sheet };
    let mut budget = 1u64;
    loop {
        let fits = best.iter().rev().find(|(_, memory, _)| *memory <= budget as f64);
        if let Some((r, memory, psnr)) = fits.filter(|_| budget as f64 >= first.1) {
            let number = |v: Option<f64>| v.map(|v| v.to_string()).unwrap_or_default();
            let stages = r.stages.map(|s| s.to_string()).unwrap_or_default();
            let words = [
                &view.volume,
                &view.scene,
                &view.renderer,
                device,
                &r.codec,
                &r.settings,
                &r.site,
                &r.filter,
            ];
            let words = words.map(str::to_owned);
            let more = [r.skipping.to_string(), stages, memory.to_string(), psnr.to_string()];
            let times = [number(r.relative_frame_time), number(r.frame_ms)];
            let row = [budget.to_string()].into_iter().chain(words).chain(more).chain(times);
            sheet.row(row.chain([palette.labels.series(r), r.resolution.to_string()]));
        }
        if budget as f64 >= last.1 || budget > u64::MAX / 2 {
            return sheet;
        }
        budget *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::tests::record;

    fn cell(codec: &str, bytes: u64, meanwhile: Option<u64>, psnr: f64, time: f64) -> Record {
        Record {
            resident_bytes: Some(bytes),
            device_decode_bytes: meanwhile,
            image_psnr_db: Some(psnr),
            relative_frame_time: Some(time),
            device: "gpu".into(),
            site: "inline".into(),
            filter: "linear".into(),
            ..record("v", codec)
        }
    }

    #[test]
    fn each_budget_has_its_best_cell_and_what_decodes_must_fit_meanwhile() {
        let records = [
            cell("raw", 16 << 20, None, f64::INFINITY, 1.0),
            cell("s3dc", 4 << 20, None, 45.0, 3.0),
            cell("tvq", 1 << 20, None, 38.0, 5.0),
            cell("tvq", 1 << 20, None, 38.0, 4.0),
            cell("vq", 2 << 20, Some(20 << 20), 50.0, 1.0),
            cell("hvq", 3 << 20, None, 30.0, 2.0),
            Record { device: "other".into(), ..cell("hvq", 1, None, 99.0, 1.0) },
        ];
        let view = View::of(&records[0]);
        let cells = cells(&records, &view, "gpu");
        let best = best(&cells);
        let names: Vec<&str> = best.iter().map(|c| c.0.codec.as_str()).collect();
        assert_eq!(names, ["tvq", "s3dc", "raw"]);
        assert_eq!(best[0].0.relative_frame_time, Some(4.0), "of equal ones the fastest");
        let palette = Palette::new(&records);
        let rows = sheet(&best, &palette, &view, "gpu").rows;
        let told: Vec<(&str, &str)> = rows.iter().map(|r| (r[0].as_str(), r[5].as_str())).collect();
        let mib = [1u64, 2, 4, 8, 16].map(|m| (m << 20).to_string());
        let codecs = ["tvq", "tvq", "s3dc", "s3dc", "raw"];
        assert_eq!(told, mib.iter().map(String::as_str).zip(codecs).collect::<Vec<_>>());
        let line = steps(&[(1.0, 38.0), (4.0, 45.0)], 16.0);
        assert_eq!(line, [(1.0, 38.0), (4.0, 38.0), (4.0, 45.0), (16.0, 45.0)]);
        let chart = best_picture(&records, &palette, &view, "gpu").unwrap().chart;
        assert_eq!(chart.points.iter().filter(|p| p.unbeaten).count(), 3);
        assert_eq!(chart.points.iter().filter(|p| p.mark.faint).count(), 3);
        let times = its_frame_time(&records, &palette, &view, "gpu").unwrap();
        assert_eq!(times.points.len(), 3);
        assert_eq!(best_picture(&records, &palette, &view, "elsewhere").map(|_| ()), None);
    }
}
