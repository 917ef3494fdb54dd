//! The charts of the report, from records.

use super::cells::{Baseline, View, blends, cell_name, codec_name, compressed, distinct, ok, site_rank};
use super::chart::{Axis, Chart, Colour, LegendEntry, Line, Mark, Point, Scale, Shape};
use super::number::{decibels, fixed, short};
use super::pareto;
use crate::experiment::record::Record;

/// Which colour and shape a codec has throughout the report.
#[derive(Debug)]
pub(super) struct Palette {
    codecs: Vec<String>,
    /// Codecs and sites.
    series: Vec<(String, String)>,
}

impl Palette {
    /// The uncompressed codec comes first whether it is there or not, so that codecs keep their colours.
    pub(super) fn new(records: &[Record]) -> Self {
        let compressed = records.iter().filter(|r| compressed(r)).map(|r| r.codec.clone());
        let codecs = distinct(std::iter::once("raw".to_owned()).chain(compressed));
        Self { codecs, series: distinct(records.iter().map(|r| (r.codec.clone(), r.site.clone()))) }
    }

    fn index(&self, codec: &str) -> usize {
        self.codecs.iter().position(|c| c == codec).unwrap_or(0)
    }

    fn colour(&self, codec: &str) -> Colour {
        Colour::Series(self.index(codec))
    }

    fn codec_mark(&self, codec: &str) -> Mark {
        Mark::filled(Shape::series(self.index(codec)), self.colour(codec))
    }

    /// The mark of a codec at a site.
    pub(super) fn series_mark(&self, record: &Record) -> Mark {
        let at = self.series.iter().position(|(codec, site)| *codec == record.codec && *site == record.site);
        Mark::filled(Shape::series(at.unwrap_or(0)), self.colour(&record.codec))
    }
}

/// What a point of a rate chart shows.
fn title(record: &Record) -> String {
    let mut title = format!(
        "{}\n{} bits per voxel, PSNR {}, picture {}, SSIM {}",
        cell_name(record),
        short(record.bits_per_voxel),
        decibels(record.psnr_db),
        decibels(record.image_psnr_db),
        fixed(record.image_ssim, 4)
    );
    if record.relative_frame_time.is_some() {
        title += &format!(
            "\nframe {} ms (IQR {}), {} × the baseline",
            short(record.frame_ms),
            short(record.frame_ms_iqr),
            short(record.relative_frame_time)
        );
    }
    if !ok(record) {
        title += &format!("\nFAILED: {}", record.error.as_deref().unwrap_or("no reason given"));
    }
    title
}

fn rate_axis(records: &[&Record]) -> Axis {
    let rates = || records.iter().filter_map(|r| r.bits_per_voxel).filter(|b| *b > 0.0 && b.is_finite());
    let (low, high) = (rates().fold(f64::INFINITY, f64::min), rates().fold(0.0, f64::max));
    // Raw samples beside codes of a fraction of a bit need a logarithm; two bits beside four do not.
    let wide = high > 10.0 * low;
    let label = "bits per voxel, whole file  (← better)";
    if wide {
        Axis::new("bits_per_voxel", label, Scale::Log)
    } else {
        Axis { include: vec![0.0], ..Axis::new("bits_per_voxel", label, Scale::Linear) }
    }
}

/// Points of several codecs over bits per voxel, and a line along the best of each codec.
fn rate_chart(
    description: String,
    y: Axis,
    palette: &Palette,
    records: &[Record],
    cells: &[&Record],
    value: impl Fn(&Record) -> Option<f64>,
    mark: impl Fn(&Record) -> Mark,
) -> Chart {
    let x = rate_axis(cells);
    let place = |r: &Record| Some((r.bits_per_voxel?, value(r)?)).filter(|(a, b)| x.shows(*a) && y.shows(*b));
    let mut lines = Vec::new();
    let mut best: Vec<&Record> = Vec::new();
    for codec in distinct(cells.iter().map(|r| r.codec.clone())) {
        let own = cells.iter().filter(|r| r.codec == codec && ok(r));
        let own: Vec<(&Record, (f64, f64))> = own.filter_map(|r| Some((*r, place(r)?))).collect();
        let costs: Vec<(f64, f64)> = own.iter().map(|(_, (rate, value))| (*rate, -value)).collect();
        let front = pareto::front(&costs);
        best.extend(front.iter().map(|i| own[*i].0));
        let points = front.into_iter().map(|i| own[i].1).collect();
        lines.push(Line { points, colour: palette.colour(&codec), dashed: false });
    }
    let point = |r: &&Record| {
        let (x, y) = place(r)?;
        let mark = if ok(r) { mark(r) } else { Mark::failure() };
        let unbeaten = best.iter().any(|b| std::ptr::eq(*b, *r));
        Some(Point { x, y, mark, title: title(r), cell: number(records, r), unbeaten })
    };
    let mut points: Vec<Point> = cells.iter().filter_map(point).collect();
    points.sort_by_key(|p| p.mark == Mark::failure());
    let mut legend: Vec<LegendEntry> = distinct(cells.iter().map(|r| r.codec.clone()))
        .into_iter()
        .map(|codec| LegendEntry { mark: palette.codec_mark(&codec), label: codec })
        .collect();
    if points.iter().any(|p| p.mark == Mark::failure()) {
        legend.push(failure_entry());
    }
    Chart { description, x, y, lines, points, legend }
}

/// A record's number among all.
fn number(records: &[Record], record: &Record) -> usize {
    records.iter().position(|r| std::ptr::eq(r, record)).unwrap_or(0)
}

pub(super) fn failure_entry() -> LegendEntry {
    LegendEntry { mark: Mark::failure(), label: "failed".to_owned() }
}

/// PSNR of the voxels over bits per voxel. Sites, filters and scenes do not change the voxels, so each codec and
/// setting appears once: failed only if all its cells are.
pub(super) fn voxel_psnr(records: &[Record], palette: &Palette, volume: &str) -> Option<Chart> {
    let mut cells: Vec<&Record> = Vec::new();
    let own =
        || records.iter().filter(|r| r.volume == volume && r.psnr_db.is_some() && r.bits_per_voxel.is_some());
    for name in distinct(own().map(codec_name)) {
        let same = || own().filter(|r| codec_name(r) == name);
        cells.extend(same().find(|r| ok(r)).or_else(|| same().next()));
    }
    let y = Axis {
        infinity: Some("lossless"),
        ..Axis::new("psnr_db", "PSNR of the voxels in dB  (better →)", Scale::Linear)
    };
    let description = format!("PSNR of the voxels over bits per voxel, volume {volume}");
    let chart =
        rate_chart(description, y, palette, records, &cells, |r| r.psnr_db, |r| palette.codec_mark(&r.codec));
    (!chart.points.is_empty()).then_some(chart)
}

/// SSIM of the picture over bits per voxel. One site stands for all, the same for every filter.
pub(super) fn picture_ssim(records: &[Record], palette: &Palette, view: &View) -> Option<Chart> {
    let mut cells: Vec<&Record> = Vec::new();
    let own = || {
        let measured = |r: &&Record| r.image_ssim.is_some() && r.bits_per_voxel.is_some();
        records.iter().filter(|r| View::of(r) == *view).filter(measured)
    };
    for key in distinct(own().map(|r| (codec_name(r), blends(r)))) {
        let same = own().filter(|r| (codec_name(r), blends(r)) == key);
        cells.extend(same.min_by_key(|r| (!ok(r), site_rank(&r.site))));
    }
    let y = Axis {
        limit: Some(1.0),
        ..Axis::new("image_ssim", "SSIM of the picture  (better →)", Scale::Linear)
    };
    let description =
        format!("SSIM of the picture over bits per voxel, volume {}, {}", view.volume, view.name());
    let mark = |r: &Record| Mark { filled: blends(r), ..palette.codec_mark(&r.codec) };
    let mut chart = rate_chart(description, y, palette, records, &cells, |r| r.image_ssim, mark);
    chart.legend.extend(filter_entries(&cells, Shape::Circle));
    (!chart.points.is_empty()).then_some(chart)
}

/// What filled and hollow mean, where both occur.
pub(super) fn filter_entries(cells: &[&Record], shape: Shape) -> Vec<LegendEntry> {
    let both = cells.iter().any(|r| blends(r)) && cells.iter().any(|r| !blends(r));
    let entry = |filled, label: &str| {
        let mark = Mark { filled, ..Mark::filled(shape, Colour::Ink) };
        LegendEntry { mark, label: label.to_owned() }
    };
    if both { vec![entry(true, "linear filter"), entry(false, "nearest")] } else { Vec::new() }
}

/// Relative frame time over the PSNR of the picture, with the cells that none beats.
pub(super) fn frame_time(records: &[Record], palette: &Palette, view: &View) -> Option<Chart> {
    let cells: Vec<&Record> = records
        .iter()
        .filter(|r| View::of(r) == *view && r.relative_frame_time.is_some() && r.image_psnr_db.is_some())
        .collect();
    let x = Axis {
        infinity: Some("identical"),
        ..Axis::new("image_psnr_db", "PSNR of the picture in dB  (better →)", Scale::Linear)
    };
    let y = Axis {
        include: vec![1.0],
        ..Axis::new("relative_frame_time", "frame time ÷ baseline A  (← better)", Scale::Log)
    };
    let front = pareto::of_view(records, view);
    let series = distinct(cells.iter().map(|r| (r.codec.clone(), r.site.clone())));
    let mut points = Vec::new();
    for record in &cells {
        let (Some(px), Some(py)) = (record.image_psnr_db, record.relative_frame_time) else { continue };
        let baseline = Baseline::of(record).filter(|_| ok(record));
        let mark = match baseline {
            _ if !ok(record) => Mark::failure(),
            Some(baseline) => {
                Mark { filled: false, ..Mark::filled(Shape::Letter(baseline.letter()), Colour::Ink) }
            }
            None => {
                let mark = palette.series_mark(record);
                let beaten = compressed(record) && !front.contains(record);
                Mark { filled: blends(record), faint: beaten, ..mark }
            }
        };
        let unbeaten = front.iter().any(|f| std::ptr::eq(*f, *record));
        let cell = number(records, record);
        points.push(Point { x: px, y: py, mark, title: title(record), cell, unbeaten });
    }
    if points.is_empty() {
        return None;
    }
    // On top: what wins, then what speed is measured by, then what must not be overlooked.
    points.sort_by_key(|p| {
        (p.mark == Mark::failure(), matches!(p.mark.shape, Shape::Letter(_)), !p.mark.faint)
    });

    let has = |mark: fn(&Record) -> Option<Baseline>, wanted| {
        cells.iter().any(|r| ok(r) && mark(r) == Some(wanted))
    };
    let front_points = front.iter().filter_map(|r| Some((r.image_psnr_db?, r.relative_frame_time?)));
    let mut lines = vec![Line { points: front_points.collect(), colour: Colour::Ink, dashed: false }];
    let finite = || points.iter().map(|p| p.x).filter(|x| x.is_finite());
    if let Some(low) = finite().reduce(f64::min) {
        let high = points.iter().map(|p| p.x).fold(low, f64::max);
        lines.push(Line { points: vec![(low, 1.0), (high, 1.0)], colour: Colour::Ink, dashed: true });
    }

    let shown = |codec: &str, site: &str| {
        let plain = |r: &&&Record| r.codec == codec && r.site == site && ok(r) && Baseline::of(r).is_none();
        cells.iter().find(plain).copied()
    };
    let mut legend: Vec<LegendEntry> = series
        .iter()
        .filter_map(|(codec, site)| {
            let mark = palette.series_mark(shown(codec, site)?);
            Some(LegendEntry { mark, label: format!("{codec}, {site}") })
        })
        .collect();
    legend.extend(filter_entries(&cells, Shape::Circle));
    for baseline in [Baseline::Texture, Baseline::Buffer] {
        if has(Baseline::of, baseline) {
            let mark = Mark { filled: false, ..Mark::filled(Shape::Letter(baseline.letter()), Colour::Ink) };
            legend.push(LegendEntry { mark, label: baseline.label().to_owned() });
        }
    }
    if points.iter().any(|p| p.mark == Mark::failure()) {
        legend.push(failure_entry());
    }
    let description = format!(
        "Relative frame time over PSNR of the picture, volume {}, {}; {} of {} cells are not beaten",
        view.volume,
        view.name(),
        front.len(),
        points.len()
    );
    Some(Chart { description, x, y, lines, points, legend })
}
