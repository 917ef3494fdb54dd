//! The page as a whole. `CVR_SAMPLE_REPORT=DIR cargo test --lib sample_report` keeps the sample to be looked at.

use std::path::Path;

use super::*;
use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::ERRORS;
use crate::experiment::files::write_results::rows_to_csv;
use crate::experiment::identity::experiment;
use crate::experiment::measured::error_histogram::Row;
use crate::experiment::records::provenance::{Part, ReferencePicture, VolumeProvenance};
use crate::experiment::records::record::Status;
use crate::experiment::records::record::tests::record;

/// A ball in `tone`, wrong by `error` in rings.
fn write_ball(path: &Path, size: u32, tone: [f32; 3], error: f32, difference: bool) {
    let mut rgb = Vec::new();
    for y in 0..size {
        for x in 0..size {
            let (u, v) = (x as f32 / size as f32 - 0.5, y as f32 / size as f32 - 0.5);
            let r = u.hypot(v) * 2.4;
            let light = (1.0 - r * r).max(0.0).sqrt();
            let wrong = if light > 0.0 { error * ((u * 60.0).sin() * (v * 47.0).cos()).abs() } else { 0.0 };
            let pixel = if difference {
                cvr_core::metrics::error_colour(wrong)
            } else {
                tone.map(|t| (255.0 * (0.08 + 0.9 * (light * t + wrong)).clamp(0.0, 1.0)) as u8)
            };
            rgb.extend(pixel);
        }
    }
    cvr_core::render::write_png(path, [size, size], &rgb).unwrap();
}

/// Errors of a two-sided geometric distribution; returns the path below `dir`.
fn write_errors(dir: &Path, stem: &str, error: f64) -> String {
    let path = format!("{ERRORS}/{stem}.csv");
    std::fs::create_dir_all(dir.join(ERRORS)).unwrap();
    let decay = (-1.0 / (error * 100.0 + 0.3)).exp();
    let samples = |e: i32| (1e6 * decay.powi(e.abs())) as u64;
    let rows = (-40..40).filter(|e| samples(*e) > 0).map(|e| Row {
        from: f64::from(e),
        below: f64::from(e + 1),
        samples: samples(e),
        share: 0.0,
    });
    std::fs::write(dir.join(&path), rows_to_csv(&rows.collect::<Vec<_>>()).unwrap()).unwrap();
    path
}

/// About 40 cells: two volumes, raw and two lossy codecs, three sites, two filters; one cell broke its bound.
fn sample(dir: &Path) -> (Provenance, Vec<Record>, Vec<RefusedCell>) {
    let mut records = Vec::new();
    let mut references = Vec::new();
    let mut volumes = Vec::new();
    for (v, (volume, tone)) in
        [("bonsai", [0.9, 0.75, 0.5]), ("engine-cylinder", [0.6, 0.8, 0.9])].into_iter().enumerate()
    {
        let name = format!("{volume}-reference.png");
        write_ball(&dir.join(&name), 240, tone, 0.0, false);
        references.push(ReferencePicture {
            volume: volume.into(),
            scene: "front".into(),
            renderer: "raycasting".into(),
            image: name,
            later_frames: Vec::new(),
        });
        volumes.push(VolumeProvenance {
            name: volume.into(),
            source: format!("$CVR_DATA/{volume}.nrrd"),
            blake3: "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262".into(),
            dims: [256, 256, 178],
            dtype: "u8".into(),
            spacing: [1.0, 1.0, 1.40625],
            range: [0.0, 255.0],
        });
        let mut cell =
            |codec: &str, settings: &str, site: &str, filter: &str, bits: f64, psnr: f64, time: f64| {
                let nearest = filter == "nearest";
                let image_psnr = if nearest { psnr.min(33.0) - 1.5 } else { psnr - 4.0 };
                let stem = format!("{volume}-{}", records.len());
                let error = (10f32.powf(-image_psnr.min(90.0) as f32 / 20.0) * 4.0).min(0.4);
                write_ball(&dir.join(format!("{stem}.png")), 160, tone, error * 0.5, false);
                write_ball(&dir.join(format!("{stem}-error.png")), 160, tone, error, true);
                let histogram = write_errors(dir, &stem, f64::from(error));
                let hardware = site != "inline" && !nearest;
                records.push(Record {
                    settings: settings.into(),
                    site: site.into(),
                    filter: filter.into(),
                    renderer: "raycasting".into(),
                    scene: "front".into(),
                    device: "llvmpipe (LLVM 15.0.6, 256 bits)".into(),
                    driver: "llvmpipe 22.3.6".into(),
                    voxels: 256 * 256 * 178,
                    frames: 1,
                    bits_per_voxel: Some(bits),
                    file_bytes: Some((bits * 256.0 * 256.0 * 178.0 / 8.0) as u64),
                    resident_bytes: Some((bits * 256.0 * 256.0 * 178.0 / 8.0) as u64),
                    encode_seconds: Some(1.234),
                    decode_seconds: Some(0.087_65),
                    decode_voxels_per_second: Some(1.33e8),
                    psnr_db: Some(if psnr > 90.0 { f64::INFINITY } else { psnr }),
                    foreground_psnr_db: Some(if psnr > 90.0 { f64::INFINITY } else { psnr - 2.3 }),
                    max_abs_error: Some(if psnr > 90.0 { 0.0 } else { 9.0 }),
                    error_bound: Some(9.0),
                    image_psnr_db: Some(if psnr > 90.0 && !nearest && !hardware {
                        f64::INFINITY
                    } else {
                        image_psnr.min(61.0)
                    }),
                    image_ssim: Some(1.0 - 10f64.powf(-image_psnr.min(61.0) / 24.0)),
                    codec_image_psnr_db: Some(psnr - 3.0),
                    codec_image_ssim: Some(0.987),
                    frame_ms: Some(12.0 * time),
                    frame_ms_iqr: Some(0.4),
                    frame_cpu_ms: Some(20.0 * time),
                    frame_clock: Some("timestamp".into()),
                    relative_frame_time: Some(time * (1.0 + 0.04 * v as f64)),
                    relative_frame_time_iqr: Some(0.03),
                    frame_pairs: Some(11),
                    filtering: Some(if hardware { "hardware" } else { "manual" }.into()),
                    image: Some(format!("{stem}.png")),
                    error_image: Some(format!("{stem}-error.png")),
                    error_histogram: Some(histogram),
                    ..record(volume, codec)
                });
            };
        cell("raw", "", "host", "linear", 8.0, 99.0, 1.0);
        cell("raw", "", "host", "nearest", 8.0, 99.0, 0.93);
        cell("raw", "", "inline", "linear", 8.0, 99.0, 2.4);
        cell("raw", "", "inline", "nearest", 8.0, 99.0, 1.1);
        for (block, bits, psnr) in [(4, 4.25, 52.0), (8, 4.03, 48.5), (16, 4.004, 46.0), (32, 4.001, 43.6)] {
            let settings = format!("block={block} bits=4");
            cell("s3dc", &settings, "inline", "linear", bits, psnr, 3.1 + 4.0 / f64::from(block));
            cell("s3dc", &settings, "inline", "nearest", bits, psnr, 1.25);
        }
        cell("s3dc", "block=4 bits=2", "inline", "linear", 2.25, 38.0, 3.6);
        cell("s3dc", "block=16 bits=2", "inline", "linear", 2.004, 31.0, 3.3);
        cell("s3dc", "block=16 bits=2", "inline", "nearest", 2.004, 31.0, 1.2);
        cell("s3dc", "block=16 bits=4", "deferred", "linear", 4.004, 46.0, 1.7);
        cell("s3dc", "block=16 bits=4", "host", "linear", 4.004, 46.0, 1.02);
        cell("tvq", "stages=4", "inline", "linear", 0.56, 37.0, 4.9);
        cell("tvq", "stages=2", "inline", "linear", 0.27, 33.2, 3.9);
        cell("tvq", "stages=4", "deferred", "linear", 0.56, 37.0, 1.45);
        cell("tvq", "stages=1", "inline", "linear", 0.13, 28.4, 0.8);
    }
    let broken = records.last_mut().unwrap();
    broken.status = Status::Failed;
    broken.error = Some("voxel (3, 17, 41) is wrong by 14, the bound is 9".into());
    let provenance = Provenance {
        experiment: "sample".into(),
        version: "0.1.0".into(),
        git_hash: Some("23dd2f7".into()),
        adapter: "llvmpipe (LLVM 15.0.6, 256 bits)".into(),
        driver: "llvmpipe Mesa 22.3.6".into(),
        backend: "Vulkan".into(),
        cpu: "Intel Xeon 2.2 GHz".into(),
        cores: 2,
        volumes,
        seed: 7,
        config:
            "[volumes.bonsai]\nfile = \"$CVR_DATA/bonsai.nrrd\"\n\n[codecs.s3dc]\nblock = [4, 8, 16, 32]\n"
                .into(),
        command_line: "cvr run configs/compare.toml --out results".into(),
        date: "2026-11-22T19:00:00Z".into(),
        baseline: "raw texture + hardware linear, 11 pairs ABAB after 3 of warm-up".into(),
        references,
        ..Provenance::default()
    };
    let refused = vec![RefusedCell {
        volume: "bonsai".into(),
        codec: "raw".into(),
        settings: String::new(),
        site: "inline".into(),
        filter: "optimised-linear".into(),
        renderer: "raycasting".into(),
        scene: "front".into(),
        skipping: false,
        stages: None,
        resolution: 0,
        reason: "codec raw offers no fetch of a whole cell".into(),
    }];
    (provenance, records, refused)
}

fn html(provenance: &Provenance, records: &[Record], refused: &[RefusedCell]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let out = OutFolder::adopt(folder.path(), experiment::owner(provenance)).unwrap();
    let path = write(&out, provenance, records, refused).unwrap();
    std::fs::read_to_string(path).unwrap()
}

fn count(html: &str, what: &str) -> usize {
    html.matches(what).count()
}

/// Every element that opens closes, in the right order; what a browser would repair in silence fails here.
fn assert_well_formed(html: &str) {
    const VOID: [&str; 5] = ["meta", "img", "br", "input", "!DOCTYPE"];
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html;
    while let Some((_, after)) = rest.split_once('<') {
        if let Some(comment) = after.strip_prefix("!--") {
            rest = comment.split_once("-->").unwrap().1;
            continue;
        }
        let (tag, after) = after.split_once('>').unwrap();
        rest = after;
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closing </{name}>");
        } else if !tag.ends_with('/') && !VOID.contains(&name) {
            open.push(name);
            if name == "style" || name == "script" {
                rest = &rest[rest.find(&format!("</{name}>")).unwrap()..];
            }
        }
    }
    assert_eq!(open, [""; 0], "left open");
}

#[test]
fn sample_report_is_whole_and_needs_no_network() {
    let temporary = tempfile::tempdir().unwrap();
    let kept = std::env::var_os("CVR_SAMPLE_REPORT").map(PathBuf::from);
    let dir = kept.as_deref().unwrap_or(temporary.path());
    let (provenance, records, refused) = sample(dir);
    let out = OutFolder::adopt(dir, experiment::owner(&provenance)).unwrap();
    let html = std::fs::read_to_string(write(&out, &provenance, &records, &refused).unwrap()).unwrap();

    assert_well_formed(&html);
    for foreign in ["http://", "https://", "<script src", "@import", "url(", "<link"] {
        assert!(!html.contains(foreign), "{foreign}");
    }
    for section in ["summary", "pictures", "charts", "cells", "provenance", "refused"] {
        assert_eq!(count(&html, &format!("<section id=\"{section}\">")), 1, "{section}");
        assert_eq!(count(&html, &format!("href=\"#{section}\"")), 1, "{section}");
    }
    // Two of both volumes; per volume: voxels, picture, encoding, decoding, frame time, two of memory, errors.
    assert_eq!(count(&html, "<svg class=\"chart\""), 2 + 2 * 8);
    // Per volume a reference; per cell a picture and its error.
    assert_eq!(count(&html, "src=\"data:image/png;base64,"), 2 + 2 * records.len());
    assert_eq!(count(&html, "<tr class=\"failed\""), 1);
    assert!(html.contains("FAILED: voxel (3, 17, 41) is wrong by 14"), "the charts say why");
    assert!(html.contains(">lossless</text>") && html.contains(">identical</text>"));
    assert!(html.contains("baseline: raw texture, hardware linear filter"));
    assert!(html.contains("codec raw offers no fetch of a whole cell"));
}

/// `docs/user/evaluation.md` names every chart by the last part of its files' names.
#[test]
fn every_chart_is_described() {
    let folder = tempfile::tempdir().unwrap();
    let (provenance, records, _) = sample(folder.path());
    let palette = charts::Palette::new(&records);
    let figures = charts::figures(folder.path(), &records, &provenance, &palette);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/user/evaluation.md");
    let docs = std::fs::read_to_string(path).unwrap();
    let described = |kind: &str| docs.contains(&format!("`{kind}`"));
    for figure in &figures {
        assert!(figure.name.contains(&figure.kind), "{}", figure.name);
        assert!(
            described(&figure.kind),
            "docs/user/evaluation.md does not describe the chart `{}`",
            figure.kind
        );
    }
    let kinds: std::collections::BTreeSet<&str> = figures.iter().map(|f| f.kind.as_str()).collect();
    assert_eq!(kinds.len(), 10, "{kinds:?}");
    assert!(!described("a-chart-that-is-not"));
}

#[test]
fn a_failed_cell_is_a_cross_and_never_on_the_front() {
    let cell = |status, time| Record {
        status,
        relative_frame_time: Some(time),
        image_psnr_db: Some(40.0),
        error: Some("broke its bound".into()),
        ..record("v", "s3dc")
    };
    let html = html(&Provenance::default(), &[cell(Status::Failed, 0.01), cell(Status::Ok, 2.0)], &[]);
    let chart = html.split("<svg class=\"chart\"").nth(1).unwrap();
    let failed = chart.split("<g class=").find(|g| g.contains("FAILED: broke its bound")).unwrap();
    assert!(failed.contains("var(--failure)"), "{failed}");
    assert!(html.contains("1 of 2 cells are not beaten"));
}

#[test]
fn hostile_text_stays_text() {
    let evil = "<script>alert('x')</script>\"><img src=x onerror=y>&{{ 7*7 }}";
    let all = Record {
        settings: evil.into(),
        site: evil.into(),
        filter: evil.into(),
        scene: evil.into(),
        renderer: evil.into(),
        device: evil.into(),
        error: Some(evil.into()),
        notes: Some(evil.into()),
        image: Some(evil.into()),
        error_image: Some("../../etc/passwd".into()),
        status: Status::Failed,
        bits_per_voxel: Some(1.0),
        psnr_db: Some(40.0),
        image_psnr_db: Some(40.0),
        image_ssim: Some(0.9),
        relative_frame_time: Some(2.0),
        ..record(evil, evil)
    };
    let provenance = Provenance {
        experiment: "sample".into(),
        adapter: evil.into(),
        config: evil.into(),
        command_line: evil.into(),
        parts: vec![Part { folder: evil.into(), date: evil.into(), ..Default::default() }],
        volumes: vec![VolumeProvenance { name: evil.into(), source: evil.into(), ..Default::default() }],
        ..Default::default()
    };
    let refused = [RefusedCell { reason: evil.into(), volume: evil.into(), ..Default::default() }];
    let html = html(&provenance, &[all], &refused);
    assert_well_formed(&html);
    assert_eq!(count(&html, "<script"), 2, "the page's own: data and script");
    for raw in ["<script>alert", "<img src=x", "passwd"] {
        assert!(!html.contains(raw), "{raw}");
    }
    assert!(html.contains("{{ 7*7 }}"), "templates are not read twice");
}

#[test]
fn nothing_one_bare_record_and_infinities_everywhere_are_reports_too() {
    assert_well_formed(&html(&Provenance::default(), &[], &[]));
    let bare = html(&Provenance::default(), &[record("v", "s3dc")], &[]);
    assert_well_formed(&bare);
    assert!(bare.contains("No measured values to draw."));
    for value in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.0, -1.0, 1e300] {
        let some = Some(value);
        let extreme = Record {
            bits_per_voxel: some,
            encode_seconds: some,
            decode_seconds: some,
            decode_voxels_per_second: some,
            psnr_db: some,
            foreground_psnr_db: some,
            max_abs_error: some,
            error_bound: some,
            image_psnr_db: some,
            image_ssim: some,
            codec_image_psnr_db: some,
            codec_image_ssim: some,
            frame_ms: some,
            frame_ms_iqr: some,
            frame_cpu_ms: some,
            relative_frame_time: some,
            ..record("v", "s3dc")
        };
        let html = html(&Provenance::default(), &[extreme], &[]);
        assert_well_formed(&html);
        let (page, data) = html.split_once("<script type=").unwrap();
        let (data, _) = data.split_once("</script>").unwrap();
        assert!(!page.contains("NaN") && !data.contains("NaN"), "{value}");
    }
}

#[test]
fn a_failed_write_leaves_the_old_report() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing");
    let out = OutFolder::adopt(&missing, experiment::owner(&Provenance::default())).unwrap();
    std::fs::remove_dir_all(&missing).unwrap();
    assert!(matches!(write(&out, &Provenance::default(), &[], &[]), Err(ReportError::File(_))));
    assert!(!missing.exists());
}
