//! Speed against accuracy, of one volume on one device: frames, and decoding.

use super::super::cells::{Baseline, View, blends, compressed, ok};
use super::super::chart::{Axis, Chart, Colour, Line, Mark, Point, Scale, Shape};
use super::super::pareto;
use super::Drawing;
use super::marks::{
    Palette, Placed, baseline_entries, baseline_mark, beaten_entries, contest, failure_entries,
    filled_and_hollow, filter_entries, number, one_per_coding, site_entries, title,
};
use crate::experiment::records::record::Record;
use crate::report::figure::Sheet;

/// Relative frame time over the PSNR of the picture, with the cells that none beats.
pub(super) fn frame_time(records: &[Record], palette: &Palette, view: &View, device: &str) -> Option<Chart> {
    let measured = |r: &&Record| r.relative_frame_time.is_some() && r.image_psnr_db.is_some();
    let on = |r: &&Record| View::of(r) == *view && r.device == device;
    let cells: Vec<&Record> = records.iter().filter(on).filter(measured).collect();
    let x = Axis {
        infinity: Some("identical"),
        ..Axis::new("image_psnr_db", "PSNR of the picture in dB  (better →)", Scale::Linear)
    };
    let y = Axis {
        include: vec![1.0],
        ..Axis::new("relative_frame_time", "frame time ÷ baseline A  (← better)", Scale::Log)
    };
    let front = pareto::of_view(records, view, device);
    let point = |record: &&Record| {
        let mark = match Baseline::of(record) {
            _ if !ok(record) => Mark::failure(),
            Some(baseline) => baseline_mark(baseline),
            None => {
                let beaten = compressed(record) && !front.contains(record);
                Mark { filled: blends(record), faint: beaten, ..palette.site_mark(record) }
            }
        };
        let unbeaten = front.iter().any(|f| std::ptr::eq(*f, *record));
        let (x, y) = (record.image_psnr_db?, record.relative_frame_time?);
        let (title, cell) = (title(record, palette), Some(number(records, record)));
        Some(Point { x, y, mark, title, cell, unbeaten })
    };
    let mut points: Vec<Point> = cells.iter().filter_map(point).collect();
    if points.is_empty() {
        return None;
    }
    // On top: what wins, then what speed is measured by, then what must not be overlooked.
    points.sort_by_key(|p| {
        (p.mark == Mark::failure(), matches!(p.mark.shape, Shape::Letter(_)), !p.mark.faint)
    });

    let front_points = front.iter().filter_map(|r| Some((r.image_psnr_db?, r.relative_frame_time?)));
    let mut lines = vec![Line { points: front_points.collect(), colour: Colour::Ink, dashed: false }];
    let finite = || points.iter().map(|p| p.x).filter(|x| x.is_finite());
    if let Some(low) = finite().reduce(f64::min) {
        let high = points.iter().map(|p| p.x).fold(low, f64::max);
        lines.push(Line { points: vec![(low, 1.0), (high, 1.0)], colour: Colour::Ink, dashed: true });
    }

    let mut legend = site_entries(palette, &cells);
    legend.extend(filter_entries(&cells, Shape::Circle));
    legend.extend(baseline_entries(&cells));
    legend.extend(beaten_entries(&points));
    legend.extend(failure_entries(&points));
    let description = format!(
        "Relative frame time over PSNR of the picture, volume {}, {}, on {device}; {} of {} cells are not beaten",
        view.volume,
        view.name(),
        front.len(),
        points.len()
    );
    Some(Chart { description, x, y, lines, points, legend })
}

/// Voxels decoded per second over the PSNR of the voxels: on the CPU, and by the device into a texture.
pub(super) fn decode_rate(
    records: &[Record],
    palette: &Palette,
    volume: &str,
    device: &str,
) -> Option<Drawing> {
    let own = |r: &&Record| r.volume == volume && r.device == device && compressed(r) && r.psnr_db.is_some();
    let own: Vec<&Record> = records.iter().filter(own).collect();
    let mut drawing = Drawing {
        chart: Chart {
            description: format!(
                "Voxels decoded per second over PSNR of the voxels, volume {volume}, on {device}"
            ),
            x: Axis {
                infinity: Some("lossless"),
                ..Axis::new("psnr_db", "PSNR of the voxels in dB  (better →)", Scale::Linear)
            },
            y: Axis::new(
                "decode_voxels_per_second",
                "decoded, million voxels per second  (better →)",
                Scale::Log,
            ),
            lines: Vec::new(),
            points: Vec::new(),
            legend: Vec::new(),
        },
        sheet: Some(Sheet::new(&[
            "volume",
            "codec",
            "settings",
            "stages",
            "device",
            "decoded_by",
            "psnr_db",
            "voxels_per_second",
            "unbeaten",
            "series",
            "resolution",
        ])),
    };
    let mut shown = Vec::new();
    for (by, rate) in [("cpu", cpu_rate as fn(&Record) -> Option<f64>), ("device", device_rate)] {
        let cells = one_per_coding(&own.iter().copied().filter(|r| rate(r).is_some()).collect::<Vec<_>>());
        let placed = cells.iter().filter_map(|r| {
            let mark = Mark { filled: by == "device", ..palette.mark_of(r) };
            Some(Placed { record: r, x: r.psnr_db?, y: rate(r)? / 1e6, mark })
        });
        let placed: Vec<Placed<'_>> =
            placed.filter(|p| drawing.chart.x.shows(p.x) && drawing.chart.y.shows(p.y)).collect();
        let (mut points, line) = contest(records, palette, &placed, |psnr, rate| (-rate, -psnr));
        for point in &mut points {
            point.title += &format!("\ndecoded by the {by}: {:.4} million voxels per second", point.y);
            let Some(r) = point.cell.and_then(|cell| records.get(cell)) else { continue };
            let stages = r.stages.map(|s| s.to_string()).unwrap_or_default();
            let values = [point.x.to_string(), (1e6 * point.y).to_string(), point.unbeaten.to_string()];
            let names = [volume, &r.codec, &r.settings, &stages, device, by].map(str::to_owned);
            let last = [palette.labels.series(r), r.resolution.to_string()];
            drawing.row(names.into_iter().chain(values).chain(last));
        }
        drawing.chart.points.extend(points);
        drawing.chart.lines.push(Line { dashed: by == "cpu", ..line });
        shown.extend(placed.iter().map(|p| p.record));
    }
    let chart = &mut drawing.chart;
    chart.legend = palette.series_entries(&shown);
    chart.legend.extend(filled_and_hollow(
        Shape::Circle,
        "by the device, into a texture",
        "by the CPU (dashed)",
    ));
    chart.legend.extend(beaten_entries(&chart.points));
    chart.legend.extend(failure_entries(&chart.points));
    (!chart.points.is_empty()).then_some(drawing)
}

fn cpu_rate(r: &Record) -> Option<f64> {
    r.decode_voxels_per_second
}

/// Voxels of one frame over the time in which the device decodes it.
fn device_rate(r: &Record) -> Option<f64> {
    Some(r.voxels as f64 / f64::from(r.frames.max(1)) / (r.device_decode_ms? / 1000.0))
}
