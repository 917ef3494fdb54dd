//! Quality over bits per voxel, of one volume.

use super::super::cells::{View, blends, distinct, ok, site_rank};
use super::super::chart::{Axis, Chart, Line, Mark, Point, Scale, Shape};
use super::super::pareto;
use super::marks::{Palette, failure_entries, filter_entries, number, one_per_coding, title};
use crate::experiment::records::labels::full_coding;
use crate::experiment::records::record::Record;

/// The axis of rates: logarithmic where they span more than a decade.
pub(super) fn rate_axis(rates: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = rates
        .filter(|b| *b > 0.0 && b.is_finite())
        .fold((f64::INFINITY, 0.0f64), |(low, high), b| (low.min(b), high.max(b)));
    // Raw samples beside codes of a fraction of a bit need a logarithm; two bits beside four do not.
    let wide = high > 10.0 * low;
    let label = "bits per voxel, whole file  (← better)";
    if wide {
        Axis::new("bits_per_voxel", label, Scale::Log)
    } else {
        Axis { include: vec![0.0], ..Axis::new("bits_per_voxel", label, Scale::Linear) }
    }
}

/// Points of several series over bits per voxel, and a line along the best of each.
fn rate_chart(
    description: String,
    y: Axis,
    palette: &Palette,
    records: &[Record],
    cells: &[&Record],
    value: impl Fn(&Record) -> Option<f64>,
    mark: impl Fn(&Record) -> Mark,
) -> Chart {
    let x = rate_axis(cells.iter().filter_map(|r| r.bits_per_voxel));
    let place = |r: &Record| Some((r.bits_per_voxel?, value(r)?)).filter(|(a, b)| x.shows(*a) && y.shows(*b));
    let mut lines = Vec::new();
    let mut best: Vec<&Record> = Vec::new();
    for series in distinct(cells.iter().map(|r| palette.labels.series(r))) {
        let own = cells.iter().filter(|r| palette.labels.series(r) == series && ok(r));
        let own: Vec<(&Record, (f64, f64))> = own.filter_map(|r| Some((*r, place(r)?))).collect();
        let costs: Vec<(f64, f64)> = own.iter().map(|(_, (rate, value))| (*rate, -value)).collect();
        let front = pareto::front(&costs);
        best.extend(front.iter().map(|i| own[*i].0));
        let points = front.into_iter().map(|i| own[i].1).collect();
        lines.push(Line { points, colour: palette.colour(&series), dashed: false });
    }
    let point = |r: &&Record| {
        let (x, y) = place(r)?;
        let mark = if ok(r) { mark(r) } else { Mark::failure() };
        let unbeaten = best.iter().any(|b| std::ptr::eq(*b, *r));
        Some(Point { x, y, mark, title: title(r, palette), cell: Some(number(records, r)), unbeaten })
    };
    let mut points: Vec<Point> = cells.iter().filter_map(point).collect();
    points.sort_by_key(|p| p.mark == Mark::failure());
    let mut legend = palette.series_entries(cells);
    legend.extend(failure_entries(&points));
    Chart { description, x, y, lines, points, legend }
}

/// PSNR of the voxels over bits per voxel. Sites, filters and scenes do not change the voxels, so each codec and
/// setting appears once: failed only if all its cells are.
pub(super) fn voxel_psnr(records: &[Record], palette: &Palette, volume: &str) -> Option<Chart> {
    let measured = |r: &&Record| r.volume == volume && r.psnr_db.is_some() && r.bits_per_voxel.is_some();
    let cells = one_per_coding(&records.iter().filter(measured).collect::<Vec<_>>());
    let y = Axis {
        infinity: Some("lossless"),
        ..Axis::new("psnr_db", "PSNR of the voxels in dB  (better →)", Scale::Linear)
    };
    let description = format!("PSNR of the voxels over bits per voxel, volume {volume}");
    let chart = rate_chart(description, y, palette, records, &cells, |r| r.psnr_db, |r| palette.mark_of(r));
    (!chart.points.is_empty()).then_some(chart)
}

/// SSIM of the picture over bits per voxel. One site represents all, the same for every filter.
pub(super) fn picture_ssim(records: &[Record], palette: &Palette, view: &View) -> Option<Chart> {
    let mut cells: Vec<&Record> = Vec::new();
    let own = || {
        let measured = |r: &&Record| r.image_ssim.is_some() && r.bits_per_voxel.is_some();
        records.iter().filter(|r| View::of(r) == *view).filter(measured)
    };
    for key in distinct(own().map(|r| (full_coding(r), blends(r)))) {
        let same = own().filter(|r| (full_coding(r), blends(r)) == key);
        cells.extend(same.min_by_key(|r| (!ok(r), site_rank(&r.site))));
    }
    let y = Axis {
        limit: Some(1.0),
        ..Axis::new("image_ssim", "SSIM of the picture  (better →)", Scale::Linear)
    };
    let description =
        format!("SSIM of the picture over bits per voxel, volume {}, {}", view.volume, view.name());
    let mark = |r: &Record| Mark { filled: blends(r), ..palette.mark_of(r) };
    let mut chart = rate_chart(description, y, palette, records, &cells, |r| r.image_ssim, mark);
    chart.legend.extend(filter_entries(&cells, Shape::Circle));
    (!chart.points.is_empty()).then_some(chart)
}
