//! The first screen: what a researcher wants to know before anything else.

use minijinja::{Value, context};

use super::cells::{
    Baseline, View, cell_name, codec_name, compressed, devices, distinct, ok, views, volumes,
};
use super::number::{bytes, decibels, fixed, median, short};
use super::pareto;
use crate::experiment::provenance::RefusedCell;
use crate::experiment::record::Record;

/// Classes of bits per voxel: upper ends, which belong to the class.
const CLASSES: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// Cells that none beats which the first screen lists; the charts show all.
const LISTED: usize = 12;
/// PSNR of a picture above which differences are hard to see.
const GOOD_PICTURE_DB: f64 = 40.0;

pub(super) fn summary(records: &[Record], refused: &[RefusedCell]) -> Value {
    let failed = records.iter().filter(|r| !ok(r)).count();
    let devices = devices(records.iter());
    let mut fronts: Vec<(View, Vec<&Record>)> = Vec::new();
    for view in views(records) {
        fronts.extend(devices.iter().map(|d| (view.clone(), pareto::of_view(records, &view, d))));
    }
    let unbeaten: usize = fronts.iter().map(|(_, front)| front.len()).sum();
    let rows = fronts.iter().flat_map(|(view, front)| front.iter().map(move |r| (view, *r)));
    let rows: Vec<Value> = rows
        .take(LISTED)
        .map(|(view, r)| {
            context! {
                volume => view.volume.clone(),
                view => if devices.len() > 1 { format!("{}, {}", view.name(), r.device) } else { view.name() },
                cell => cell_name(r),
                rate => short(r.bits_per_voxel),
                memory => bytes(r.resident_bytes),
                psnr => fixed(r.image_psnr_db, 1),
                ssim => fixed(r.image_ssim, 4),
                time => short(r.relative_frame_time),
            }
        })
        .collect();
    context! {
        cells => records.len() + refused.len(),
        ok => records.len() - failed,
        failed => failed,
        refused => refused.len(),
        volumes => volumes(records).len(),
        codecs => distinct(records.iter().map(|r| r.codec.clone())).join(", "),
        sentences => sentences(records),
        classes => class_names(),
        rates => rates(records),
        front => rows,
        unlisted => unbeaten.saturating_sub(LISTED),
    }
}

fn class_names() -> Vec<String> {
    let mut names: Vec<String> = CLASSES.iter().map(|c| format!("≤ {c}")).collect();
    names.push(format!("> {}", CLASSES[CLASSES.len() - 1]));
    names
}

/// Per volume the best voxel PSNR in each class of bits per voxel.
fn rates(records: &[Record]) -> Vec<Value> {
    volumes(records)
        .into_iter()
        .map(|volume| {
            let best = |class: usize| -> Value {
                let low = if class == 0 { f64::NEG_INFINITY } else { CLASSES[class - 1] };
                let high = CLASSES.get(class).copied().unwrap_or(f64::INFINITY);
                let within = |r: &&Record| r.bits_per_voxel.is_some_and(|b| low < b && b <= high);
                let best = records
                    .iter()
                    .filter(|r| ok(r) && r.volume == volume && r.psnr_db.is_some_and(|p| !p.is_nan()))
                    .filter(within)
                    .max_by(|a, b| a.psnr_db.unwrap_or(f64::NAN).total_cmp(&b.psnr_db.unwrap_or(f64::NAN)));
                best.map_or_else(
                    || Value::from(()),
                    |r| {
                        let psnr = if r.psnr_db == Some(f64::INFINITY) {
                            "lossless".into()
                        } else {
                            decibels(r.psnr_db)
                        };
                        context! { psnr => psnr, codec => codec_name(r) }
                    },
                )
            };
            let cells: Vec<Value> = (0..=CLASSES.len()).map(best).collect();
            context! { volume => volume, cells => cells }
        })
        .collect()
}

/// What skipping gains, over the cells that skip; `None` where none was timed.
fn skipping(records: &[Record]) -> Option<String> {
    let gains: Vec<f64> = records.iter().filter(|r| ok(r)).filter_map(|r| r.skipping_gain).collect();
    let least = gains.iter().copied().reduce(f64::min)?;
    let most = gains.iter().copied().reduce(f64::max)?;
    let slower = gains.iter().filter(|gain| **gain < 1.0).count();
    Some(format!(
        "Skipping empty macrocells makes the frames of {} cells {} × as fast (median; {} to {}), {slower} of them slower; \
         no picture differs in any bit from the one without.",
        gains.len(),
        short(median(gains.clone())),
        short(Some(least)),
        short(Some(most)),
    ))
}

/// Up to five sentences on speed, pictures and failures.
fn sentences(records: &[Record]) -> Vec<String> {
    let mut out = Vec::new();
    let times = |wanted: fn(&Record) -> bool| {
        median(records.iter().filter(|r| ok(r) && wanted(r)).filter_map(|r| r.relative_frame_time).collect())
    };
    if let Some(buffer) = times(|r| Baseline::of(r) == Some(Baseline::Buffer)) {
        out.push(format!(
            "Uncompressed, a manual linear filter takes {} × the frame time of the texture unit (median over views): the \
             filter's own share in every cell that is decoded inline.",
            short(Some(buffer))
        ));
    }
    let mut by_site = Vec::new();
    for site in distinct(records.iter().filter(|r| compressed(r)).map(|r| r.site.clone())) {
        let of_site = |r: &&Record| ok(r) && compressed(r) && r.site == site && r.filter != "nearest";
        let time = median(records.iter().filter(of_site).filter_map(|r| r.relative_frame_time).collect());
        by_site.extend(time.map(|t| format!("{} × {site}", short(Some(t)))));
    }
    if !by_site.is_empty() {
        out.push(format!(
            "Median relative frame time of compressed cells, linear filter: {}.",
            by_site.join(", ")
        ));
    }
    let good = |r: &&Record| ok(r) && compressed(r) && r.image_psnr_db.is_some_and(|p| p >= GOOD_PICTURE_DB);
    let fastest = records
        .iter()
        .filter(good)
        .filter_map(|r| Some((r, r.relative_frame_time?)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((r, time)) = fastest {
        out.push(format!(
            "The fastest compressed cell with a picture of {GOOD_PICTURE_DB} dB or more: {} on {} at {} × the baseline \
             ({}, {} bits per voxel in the file{}).",
            cell_name(r),
            r.volume,
            short(Some(time)),
            decibels(r.image_psnr_db),
            short(r.bits_per_voxel),
            r.resident_bytes.map_or_else(String::new, |b| format!(", {} in device memory", bytes(Some(b))))
        ));
    }
    out.extend(skipping(records));
    let failed: Vec<&Record> = records.iter().filter(|r| !ok(r)).collect();
    if let Some(first) = failed.first() {
        out.push(format!(
            "{} of {} cells failed, the first of them {} on {}: {}.",
            failed.len(),
            records.len(),
            cell_name(first),
            first.volume,
            first.error.as_deref().unwrap_or("no reason given").trim_end_matches('.')
        ));
    }
    out
}
