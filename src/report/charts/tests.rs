//! Which cells a chart draws: fronts, devices, means over volumes.

use super::super::chart::Point;
use super::*;
use crate::experiment::records::record::tests::record;

/// A codec's settings on a volume, one for each (bits per voxel, PSNR).
fn settings(volume: &str, codec: &str, points: &[(f64, f64)]) -> Vec<Record> {
    let one = |(i, (rate, psnr)): (usize, &(f64, f64))| Record {
        settings: format!("i={i}"),
        bits_per_voxel: Some(*rate),
        psnr_db: Some(*psnr),
        ..record(volume, codec)
    };
    points.iter().enumerate().map(one).collect()
}

#[test]
fn the_mean_over_volumes_is_taken_at_equal_rates_where_all_curves_reach() {
    let line = |low: f64, high: f64, at_one: f64| {
        [low, (low * high).sqrt(), high].map(|rate| (rate, at_one + 20.0 * rate.log10()))
    };
    let mut records = settings("a", "vq", &line(0.5, 4.0, 40.0));
    records.extend(settings("b", "vq", &line(1.0, 8.0, 50.0)));
    records.extend(settings("a", "tvq", &line(0.5, 8.0, 60.0)));
    let palette = Palette::new(&records);
    let (drawing, note) = pooled::pooled(&records, &palette, Measure::Voxels).unwrap();
    let Chart { points, lines, legend, .. } = drawing.chart;
    assert_eq!((lines.len(), legend.len()), (1, 1), "tvq lacks a volume");
    assert!(note.contains("Volumes: a, b.") && note.ends_with("without a common rate: tvq."), "{note}");
    let (first, last) = (&points[0], &points[points.len() - 1]);
    assert!((first.x - 1.0).abs() < 1e-9 && (last.x - 4.0).abs() < 1e-9, "{} to {}", first.x, last.x);
    for Point { x, y, cell, .. } in &points {
        assert!((y - (45.0 + 20.0 * x.log10())).abs() < 1e-9, "{y} at {x}");
        assert_eq!(*cell, None, "a mean is no cell");
    }
    assert!(pooled::pooled(&records[..3], &palette, Measure::Voxels).is_none(), "one volume has no mean");
    assert!(pooled::pooled(&records, &palette, Measure::Foreground).is_none(), "not measured");
}

#[test]
fn methods_of_a_codec_have_lines_of_their_own() {
    let method = |payload: &str, better: f64| {
        let mut cells =
            settings("a", "tvq", &[(0.5, 30.0 + better), (1.0, 35.0 + better), (2.0, 40.0 + better)]);
        for cell in &mut cells {
            cell.settings += &format!(" payload={payload}");
            cell.series = format!("payload={payload}");
            cell.encode_seconds = Some(1.0 + better);
            cell.resident_bytes = Some(1 << 20);
            cell.image_psnr_db = cell.psnr_db;
            cell.relative_frame_time = Some(1.0);
        }
        cells
    };
    let mut records = method("fixed", 0.0);
    records.extend(method("variable", 3.0));
    let (fixed, variable) = ("tvq payload=fixed", "tvq payload=variable");
    let drawn = |records: &[Record]| {
        let palette = Palette::new(records);
        let voxels = rate_distortion::voxel_psnr(records, &palette, "a").unwrap();
        let encode = encode_time::encode_time(records, &palette, "a", "").unwrap();
        let view = View::of(&records[0]);
        let memory = memory_budget::best_picture(records, &palette, &view, "").unwrap().chart;
        let labels = |chart: &Chart| chart.legend.iter().map(|entry| entry.label.clone()).collect::<Vec<_>>();
        let lines = [voxels.lines.len(), encode.lines.len()];
        (lines, labels(&voxels), labels(&encode), labels(&memory), voxels.legend)
    };
    let (lines, voxels, encode, memory, legend) = drawn(&records);
    assert_eq!(lines, [2, 2]);
    assert_eq!(voxels, [fixed, variable]);
    assert_eq!(encode[..2], [fixed, variable]);
    assert_eq!(memory[..2], [format!("{fixed}, "), format!("{variable}, ")]);
    assert!(legend[0].mark.colour != legend[1].mark.colour && legend[0].mark.shape != legend[1].mark.shape);
    // If no codec lists them as methods, they are settings of one curve, and the curve has the codec's name.
    let unmarked: Vec<Record> =
        records.iter().map(|r| Record { series: String::new(), ..r.clone() }).collect();
    let (lines, voxels, ..) = drawn(&unmarked);
    assert_eq!((lines, voxels), ([1, 1], vec!["tvq".to_owned()]));
    assert_eq!(drawn(&records[..3]).1, ["tvq"]);
}

#[test]
fn more_series_than_colours_differ_in_colour_or_shape() {
    let records: Vec<Record> = (0..20).map(|i| record("v", &format!("c{i}"))).collect();
    let palette = Palette::new(&records);
    let marks: Vec<_> = records.iter().map(|r| palette.mark_of(r)).collect();
    for (i, mark) in marks.iter().enumerate() {
        assert!(!marks[..i].contains(mark), "{i}");
    }
}

#[test]
fn what_another_beats_is_grey_and_devices_do_not_meet() {
    let cell = |codec: &str, device: &str, seconds: f64, psnr: f64| Record {
        device: device.into(),
        settings: psnr.to_string(),
        psnr_db: Some(psnr),
        encode_seconds: Some(seconds),
        decode_voxels_per_second: Some(1e6 / seconds),
        ..record("v", codec)
    };
    let mut records = vec![
        cell("raw", "one", 0.001, f64::INFINITY),
        cell("vq", "one", 1.0, 40.0),
        cell("vq", "one", 2.0, 39.0),
        cell("tvq", "one", 9.0, 50.0),
        cell("tvq", "two", 0.1, 50.0),
    ];
    records[1].device_decode_ms = Some(4.0);
    records[1].voxels = 2_000_000;
    records[1].frames = 2;
    let palette = Palette::new(&records);
    let chart = encode_time::encode_time(&records, &palette, "v", "one").unwrap();
    let told = |points: &[Point]| {
        let mut told: Vec<_> = points.iter().map(|p| (p.cell.unwrap(), p.unbeaten, p.mark.faint)).collect();
        told.sort_unstable();
        told
    };
    let expected = [(1, true, false), (2, false, true), (3, true, false)];
    assert_eq!(told(&chart.points), expected, "raw is no competitor, the other device elsewhere");
    let lines: Vec<_> = chart.lines.iter().map(|line| line.points.clone()).collect();
    assert_eq!(lines, [[(40.0, 1.0)], [(50.0, 9.0)]], "one for each codec");

    let Drawing { chart, sheet } = speed_accuracy::decode_rate(&records, &palette, "v", "one").unwrap();
    let (device, cpu): (Vec<Point>, Vec<Point>) = chart.points.into_iter().partition(|p| p.mark.filled);
    assert_eq!(told(&cpu), expected);
    assert_eq!(told(&device), [(1, true, false)]);
    // A million voxels of one frame in 4 ms.
    assert!((device[0].y - 250.0).abs() < 1e-9, "{}", device[0].y);
    assert_eq!(sheet.unwrap().rows.len(), 4);

    let names: Vec<String> = figures(Path::new("nowhere"), &records, &Provenance::default(), &palette)
        .into_iter()
        .map(|f| f.name)
        .collect();
    for name in ["v-one-encode-time", "v-two-encode-time", "v-one-decode-rate", "v-two-decode-rate"] {
        assert!(names.iter().any(|n| n == name), "{name}: {names:?}");
    }
}
