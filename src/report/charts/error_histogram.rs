//! How many samples are wrong by how much, for one setting of each curve at about the same rate.

use std::collections::BTreeMap;
use std::path::{Component, Path};

use super::super::cells::{compressed, distinct, ok};
use super::super::chart::{Axis, Chart, LegendEntry, Line, Point, Scale};
use super::super::number::short;
use super::super::pareto;
use super::Drawing;
use super::marks::{Palette, number, one_per_coding, title};
use crate::experiment::files::names::ERRORS;
use crate::experiment::measured::error_histogram::Row;
use crate::experiment::records::labels::full_coding;
use crate::experiment::records::provenance::{Provenance, VolumeProvenance};
use crate::experiment::records::record::Record;
use crate::report::figure::Sheet;

/// Rates that count as the same: the highest over the lowest.
const SAME_RATE: f64 = 1.25;
/// Bins that a chart has at most, so that lines can be followed.
const MOST_BINS: f64 = 128.0;
/// Marks along a line, about.
const MARKS: i64 = 12;

/// A series by its name, and a setting of it.
type Setting<'a> = (String, &'a Record);

/// A curve's setting, and its samples by bin of the chart.
struct Shown<'a> {
    series: String,
    record: &'a Record,
    bins: BTreeMap<i64, u64>,
    infinite: u64,
    samples: u64,
}

/// Shares of the samples over their error relative to the range of the volume. With the chart comes what was chosen, in
/// words. Nothing is drawn where no curve has a histogram that can be read.
pub(super) fn error_histogram(
    dir: &Path,
    records: &[Record],
    palette: &Palette,
    provenance: &Provenance,
    volume: &str,
) -> Option<(Drawing, String)> {
    let of_volume = provenance.volumes.iter().find(|v| v.name == volume)?;
    let range =
        Some(of_volume.range[1] - of_volume.range[0]).filter(|range| *range > 0.0 && range.is_finite())?;
    let own: Vec<&Record> = records.iter().filter(|r| r.volume == volume && ok(r) && compressed(r)).collect();
    let candidates = on_curves(&one_per_coding(&own), palette);
    let ([low, high], chosen) = same_rate(&candidates)?;
    let read: Vec<(String, &Record, Vec<Row>)> =
        chosen.into_iter().filter_map(|(series, r)| Some((series, r, read(dir, r)?))).collect();
    let width = width(read.iter().flat_map(|(_, _, rows)| rows))?;
    let shown: Vec<Shown<'_>> =
        read.into_iter().map(|(series, r, rows)| binned(series, r, &rows, width)).collect();
    let all = distinct(own.iter().map(|r| palette.labels.series(r)));
    let left_out: Vec<String> =
        all.into_iter().filter(|s| shown.iter().all(|own| own.series != *s)).collect();
    let mut note = format!(
        "One setting of each curve, between {} and {} bits per voxel, where most curves have one. Bins of {} data units ({} of \
         the range).",
        short(Some(low)),
        short(Some(high)),
        short(Some(width)),
        short(Some(width / range)),
    );
    if !left_out.is_empty() {
        note += &format!(" Left out, without a lossy setting or a histogram there: {}.", left_out.join(", "));
    }
    for own in shown.iter().filter(|own| own.infinite > 0) {
        note += &format!(" {} samples of {} are not numbers.", own.infinite, own.series);
    }
    let drawing = draw(records, palette, of_volume, (width, range), &shown);
    (!drawing.chart.points.is_empty()).then_some((drawing, note))
}

/// The settings that no other of their curve beats, lossless ones left out.
fn on_curves<'a>(cells: &[&'a Record], palette: &Palette) -> Vec<Setting<'a>> {
    let lossy =
        |r: &&&Record| r.psnr_db.is_some_and(f64::is_finite) && r.bits_per_voxel.is_some_and(|b| b > 0.0);
    let mut all = Vec::new();
    for series in distinct(cells.iter().map(|r| palette.labels.series(r))) {
        let own: Vec<&Record> =
            cells.iter().filter(lossy).copied().filter(|r| palette.labels.series(r) == series).collect();
        let cost = |r: &&Record| (r.bits_per_voxel.unwrap_or(f64::NAN), -r.psnr_db.unwrap_or(f64::NAN));
        let front = pareto::front(&own.iter().map(cost).collect::<Vec<_>>());
        all.extend(front.into_iter().map(|i| (series.clone(), own[i])));
    }
    all
}

/// The rates, no further apart than [`SAME_RATE`], at which most curves have a setting, and of each curve the one that is
/// nearest to their middle. Of equal numbers of curves the lowest rates count.
fn same_rate<'a>(cells: &[Setting<'a>]) -> Option<([f64; 2], Vec<Setting<'a>>)> {
    let rate = |r: &Record| r.bits_per_voxel.unwrap_or(f64::NAN);
    let mut best: Option<(f64, usize)> = None;
    let mut rates: Vec<f64> = cells.iter().map(|(_, r)| rate(r)).collect();
    rates.sort_by(f64::total_cmp);
    let within = |low: f64, r: &Record| rate(r) >= low && rate(r) <= low * SAME_RATE;
    for low in rates {
        let series = cells.iter().filter(|(_, r)| within(low, r)).map(|(series, _)| series.clone());
        let count = distinct(series).len();
        if best.is_none_or(|(_, most)| count > most) {
            best = Some((low, count));
        }
    }
    let (low, _) = best?;
    let middle = low * SAME_RATE.sqrt();
    let away = |r: &Record| (rate(r) / middle).ln().abs();
    let nearest = |series: String| {
        let own = cells.iter().filter(|(name, r)| *name == series && within(low, r));
        own.min_by(|a, b| away(a.1).total_cmp(&away(b.1))).cloned()
    };
    let names = distinct(cells.iter().map(|(series, _)| series.clone()));
    let chosen: Vec<Setting<'_>> = names.into_iter().filter_map(nearest).collect();
    let rates = || chosen.iter().map(|(_, r)| rate(r));
    Some(([rates().fold(f64::INFINITY, f64::min), rates().fold(0.0, f64::max)], chosen))
}

/// The rows of a record's histogram. `None` if there is no such file. Only files below the report are read, because a
/// record is data.
fn read(dir: &Path, record: &Record) -> Option<Vec<Row>> {
    let path = Path::new(record.error_histogram.as_deref()?);
    let below = path.starts_with(ERRORS) && path.components().all(|c| matches!(c, Component::Normal(_)));
    let text = std::fs::read(below.then(|| dir.join(path))?).ok()?;
    let mut reader = csv::Reader::from_reader(text.as_slice());
    let rows: Vec<Row> = reader.deserialize().collect::<Result<_, _>>().ok()?;
    let usable = |row: &Row| !row.from.is_finite() || row.below > row.from;
    (!rows.is_empty() && rows.iter().all(usable)).then_some(rows)
}

/// Width of the chart's bins: the widest of the files' (which are apart by powers of two), doubled until all errors have a bin.
fn width<'a>(rows: impl Iterator<Item = &'a Row>) -> Option<f64> {
    let finite: Vec<&Row> = rows.filter(|row| row.from.is_finite()).collect();
    let mut width = finite.iter().map(|row| row.below - row.from).reduce(f64::max)?;
    let reach = |width: f64| {
        let low = finite.iter().map(|row| (row.from / width).floor()).fold(f64::INFINITY, f64::min);
        let high = finite.iter().map(|row| (row.from / width).floor()).fold(f64::NEG_INFINITY, f64::max);
        high - low + 1.0
    };
    while reach(width) > MOST_BINS {
        width *= 2.0;
    }
    Some(width)
}

/// Adds up the rows of a histogram in bins of this width. One bin begins at 0.
fn binned<'a>(series: String, record: &'a Record, rows: &[Row], width: f64) -> Shown<'a> {
    let mut shown = Shown { series, record, bins: BTreeMap::new(), infinite: 0, samples: 0 };
    for row in rows {
        shown.samples += row.samples;
        if row.from.is_finite() {
            *shown.bins.entry((row.from / width).floor() as i64).or_default() += row.samples;
        } else {
            shown.infinite += row.samples;
        }
    }
    shown.bins.retain(|_, samples| *samples > 0);
    shown
}

/// The middle of a bin relative to the range. Of integers it is the middle of those that lie in the bin.
fn middle(bin: i64, (width, range): (f64, f64), integers: bool) -> f64 {
    let inside = if integers { (width - 1.0).max(0.0) } else { width };
    (bin as f64 * width + inside / 2.0) / range
}

fn draw(
    records: &[Record],
    palette: &Palette,
    volume: &VolumeProvenance,
    scale: (f64, f64),
    shown: &[Shown<'_>],
) -> Drawing {
    let integers = !volume.dtype.starts_with('f');
    let mut sheet = Sheet::new(&[
        "volume",
        "series",
        "codec",
        "settings",
        "stages",
        "bits_per_voxel",
        "from",
        "below",
        "error_over_range",
        "samples",
        "share",
        "resolution",
    ]);
    let (mut lines, mut points, mut legend) = (Vec::new(), Vec::new(), Vec::new());
    let ends = |of: fn(&BTreeMap<i64, u64>) -> Option<i64>| shown.iter().filter_map(move |own| of(&own.bins));
    let first = ends(|bins| bins.keys().next().copied()).min().unwrap_or(0);
    let last = ends(|bins| bins.keys().next_back().copied()).max().unwrap_or(0);
    let every = ((last - first) / MARKS).max(1);
    for own in shown {
        let Shown { series, record, bins, samples, .. } = own;
        let mark = palette.mark(series);
        let rate = short(record.bits_per_voxel);
        let label = format!("{}, {rate} bits per voxel", palette.labels.coding(record));
        legend.push(LegendEntry { mark, label: label.clone() });
        let mut line: Vec<(f64, f64)> = Vec::new();
        for (bin, count) in bins {
            let (x, share) = (middle(*bin, scale, integers), *count as f64 / *samples as f64);
            // An empty bin has no logarithm: the line ends before it, and another begins behind.
            if !line.is_empty() && !bins.contains_key(&(bin - 1)) {
                lines.push(Line { points: std::mem::take(&mut line), colour: mark.colour, dashed: false });
            }
            line.push((x, share));
            let alone = !bins.contains_key(&(bin - 1)) && !bins.contains_key(&(bin + 1));
            if bin.rem_euclid(every) == 0 || alone {
                let [from, below] = [*bin, bin + 1].map(|k| k as f64 * scale.0);
                let title = format!(
                    "{}\nerrors from {} to below {}: {} of the samples",
                    title(record, palette),
                    short(Some(from)),
                    short(Some(below)),
                    short(Some(share))
                );
                let cell = Some(number(records, record));
                points.push(Point { x, y: share, mark, title, cell, unbeaten: false });
            }
            let stages = record.stages.map(|s| s.to_string()).unwrap_or_default();
            let rate = record.bits_per_voxel.map(|b| b.to_string()).unwrap_or_default();
            let words =
                [&volume.name, series, &record.codec, &record.settings, &stages, &rate].map(Clone::clone);
            let ends = [*bin, bin + 1].map(|k| (k as f64 * scale.0).to_string());
            sheet.row(words.into_iter().chain(ends).chain([
                x.to_string(),
                count.to_string(),
                share.to_string(),
                record.resolution.to_string(),
            ]));
        }
        lines.push(Line { points: line, colour: mark.colour, dashed: false });
    }
    let names: Vec<String> = shown.iter().map(|own| full_coding(own.record)).collect();
    let chart = Chart {
        description: format!("Errors of the voxels, volume {}, of {}", volume.name, names.join("; ")),
        x: Axis::new("error_over_range", "error ÷ range of the volume  (decoded − original)", Scale::Linear),
        y: Axis::new("share", "share of the samples in a bin", Scale::Log),
        lines,
        points,
        legend,
    };
    Drawing { chart, sheet: Some(sheet) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::files::write_results::rows_to_csv;
    use crate::experiment::records::record::tests::record;

    fn setting(codec: &str, rate: f64, psnr: f64) -> Record {
        Record {
            settings: format!("rate={rate}"),
            bits_per_voxel: Some(rate),
            psnr_db: Some(psnr),
            error_histogram: Some(format!("{ERRORS}/{codec}-{rate}.csv")),
            ..record("v", codec)
        }
    }

    fn rows(width: f64, samples: &[(i64, u64)]) -> Vec<Row> {
        let all: u64 = samples.iter().map(|s| s.1).sum();
        let row = |(k, n): &(i64, u64)| Row {
            from: *k as f64 * width,
            below: (k + 1) as f64 * width,
            samples: *n,
            share: *n as f64 / all as f64,
        };
        samples.iter().map(row).collect()
    }

    #[test]
    fn the_rate_is_that_at_which_most_curves_have_a_setting() {
        let records = [
            setting("vq", 1.0, 30.0),
            setting("vq", 2.0, 40.0),
            setting("hvq", 0.9, 31.0),
            setting("hvq", 2.1, 41.0),
            setting("tvq", 2.2, 45.0),
            setting("tvq", 2.3, 44.0),
            setting("zfp", 2.6, 44.0),
            setting("s3dc", 2.0, f64::INFINITY),
        ];
        let palette = Palette::new(&records);
        let all: Vec<&Record> = records.iter().collect();
        let candidates = on_curves(&all, &palette);
        assert_eq!(candidates.len(), 6, "neither what is beaten nor what is lossless");
        let (ends, chosen) = same_rate(&candidates).unwrap();
        let told: Vec<(&str, f64)> =
            chosen.iter().map(|(series, r)| (series.as_str(), r.bits_per_voxel.unwrap())).collect();
        assert_eq!(told, [("vq", 2.0), ("hvq", 2.1), ("tvq", 2.2)]);
        assert_eq!(ends, [2.0, 2.2]);
        assert!(same_rate(&[]).is_none());
    }

    #[test]
    fn histograms_of_several_widths_meet_in_the_widest_and_gaps_break_lines() {
        let folder = tempfile::tempdir().unwrap();
        let dir = &folder.path().join("inner");
        std::fs::create_dir_all(dir.join(ERRORS)).unwrap();
        let records = [
            Record { error_histogram: Some(format!("{ERRORS}/a.csv")), ..setting("vq", 1.0, 30.0) },
            Record { error_histogram: Some(format!("{ERRORS}/b.csv")), ..setting("hvq", 1.1, 30.0) },
            Record { error_histogram: Some("../secret.csv".into()), ..setting("tvq", 1.1, 30.0) },
        ];
        let write = |path: &Path, rows: &[Row]| std::fs::write(path, rows_to_csv(rows).unwrap()).unwrap();
        write(&dir.join("errors/a.csv"), &rows(1.0, &[(-3, 1), (-1, 2), (0, 90), (1, 5), (4, 2)]));
        let mut endless = rows(2.0, &[(-1, 10), (0, 80), (1, 9)]);
        endless.push(Row { from: f64::INFINITY, below: f64::INFINITY, samples: 1, share: 0.01 });
        write(&dir.join("errors/b.csv"), &endless);
        write(&folder.path().join("secret.csv"), &rows(1.0, &[(0, 1)]));
        let volume = VolumeProvenance {
            name: "v".into(),
            dtype: "u8".into(),
            range: [0.0, 200.0],
            ..VolumeProvenance::default()
        };
        let provenance = Provenance { volumes: vec![volume], ..Provenance::default() };
        let palette = Palette::new(&records);
        let (drawing, note) = error_histogram(dir, &records, &palette, &provenance, "v").unwrap();
        assert!(note.contains("Left out, without a lossy setting or a histogram there: tvq."), "{note}");
        assert!(
            note.ends_with("1 samples of hvq are not numbers.") && note.contains("Bins of 2.00"),
            "{note}"
        );
        let rows = drawing.sheet.unwrap().rows;
        // For vq, in bins of two: −4..−2, −2..0, 0..2, 4..6.
        let told: Vec<(&str, &str, &str)> = rows
            .iter()
            .filter(|r| r[1] == "vq")
            .map(|r| (r[6].as_str(), r[8].as_str(), r[10].as_str()))
            .collect();
        let expected = [
            ("-4", "-0.0175", "0.01"),
            ("-2", "-0.0075", "0.02"),
            ("0", "0.0025", "0.95"),
            ("4", "0.0225", "0.02"),
        ];
        assert_eq!(told, expected);
        let hvq: Vec<&str> = rows.iter().filter(|r| r[1] == "hvq").map(|r| r[10].as_str()).collect();
        assert_eq!(hvq, ["0.1", "0.8", "0.09"], "endless errors count among the samples");
        let lengths: Vec<usize> = drawing.chart.lines.iter().map(|line| line.points.len()).collect();
        assert_eq!(lengths, [3, 1, 3], "no line over the empty bin from 2 to 4");
        assert_eq!(drawing.chart.legend[0].label, "vq, 1.00 bits per voxel");

        assert!(error_histogram(dir, &records, &palette, &Provenance::default(), "v").is_none(), "no range");
        let elsewhere = dir.join("elsewhere");
        assert!(error_histogram(&elsewhere, &records, &palette, &provenance, "v").is_none(), "no files");
    }

    #[test]
    fn wide_errors_have_wider_bins() {
        let rows = rows(1.0, &[(-200, 1), (0, 5), (200, 1)]);
        assert_eq!(width(rows.iter()), Some(4.0));
        assert_eq!(width([].iter()), None);
        assert_eq!(middle(-1, (1.0, 255.0), true), -1.0 / 255.0);
        assert_eq!(middle(0, (0.5, 1.0), false), 0.25);
    }
}
