//! The first screen: what a researcher wants to know before anything else.

use minijinja::{Value, context};

use super::cells::{Baseline, View, compressed, devices, distinct, ok, shown, views, volumes};
use super::noise::{is_noisy, tie};
use super::number::{bytes, decibels, fixed, median, short};
use super::pareto;
use crate::experiment::inputs::blank;
use crate::experiment::records::checked::not_run;
use crate::experiment::records::labels::{Labels, full_cell, full_coding};
use crate::experiment::records::provenance::RefusedCell;
use crate::experiment::records::record::Record;

/// Columns of bits per voxel: each holds all that takes as many bits or fewer.
const AT_MOST: [f64; 5] = [1.0, 2.0, 4.0, 8.0, f64::INFINITY];
/// Cells that none beats which the first screen lists; the charts show all.
const LISTED: usize = 12;
/// PSNR of a picture above which differences are hard to see.
const GOOD_PICTURE_DB: f64 = 40.0;
/// Cells that tie with the fastest which its sentence names.
const NAMED_TIES: usize = 3;

pub(super) fn summary(records: &[Record], refused: &[RefusedCell], labels: &Labels) -> Value {
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
                cell => labels.cell(r),
                full => full_cell(r),
                rate => short(r.bits_per_voxel),
                memory => bytes(r.resident_bytes),
                psnr => fixed(r.image_psnr_db, 1),
                ssim => fixed(r.image_ssim, 4),
                time => short(r.relative_frame_time),
                spread => r.relative_frame_time_iqr.map(|iqr| format!("IQR {}", short(Some(iqr)))),
                noisy => is_noisy(r),
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
        warnings => warnings(records),
        sentences => sentences(records, labels),
        budgets => budget_names(),
        rates => rates(records, labels),
        front => rows,
        unlisted => unbeaten.saturating_sub(LISTED),
    }
}

fn budget_names() -> Vec<String> {
    AT_MOST.iter().map(|most| if most.is_finite() { format!("≤ {most}") } else { "any".to_owned() }).collect()
}

/// The scenes that show nothing.
fn warnings(records: &[Record]) -> Vec<String> {
    let told = blank::warnings(records).into_iter();
    told.map(|warning| format!("Warning: {warning}; its pictures are not judged.")).collect()
}

/// Per volume, the best voxel PSNR within a number of bits per voxel of payload. Of equal ones the one with the fewest
/// bits, of these the last.
fn rates(records: &[Record], labels: &Labels) -> Vec<Value> {
    volumes(records)
        .into_iter()
        .map(|volume| {
            let own = |r: &&Record| ok(r) && r.volume == volume;
            let measured =
                |r| Some((r, Record::payload_bits_per_voxel(r)?, r.psnr_db.filter(|p| !p.is_nan())?));
            let own: Vec<(&Record, f64, f64)> = records.iter().filter(own).filter_map(measured).collect();
            let best = |most: &f64| -> Value {
                let within = own.iter().filter(|(_, bits, _)| bits <= most);
                let best = within.max_by(|a, b| a.2.total_cmp(&b.2).then(b.1.total_cmp(&a.1)));
                best.map_or_else(
                    || Value::from(()),
                    |(r, ..)| {
                        let psnr = if r.psnr_db == Some(f64::INFINITY) {
                            "lossless".into()
                        } else {
                            decibels(r.psnr_db)
                        };
                        context! { psnr => psnr, codec => labels.coding(r), full => full_coding(r) }
                    },
                )
            };
            let cells: Vec<Value> = AT_MOST.iter().map(best).collect();
            context! { volume => volume, cells => cells }
        })
        .collect()
}

/// What skipping gains, over the cells that skip; `None` where none was timed.
fn skipping(records: &[Record]) -> Option<String> {
    let gains: Vec<f64> = records.iter().filter(|r| shown(r)).filter_map(|r| r.skipping_gain).collect();
    let least = gains.iter().copied().reduce(f64::min)?;
    let most = gains.iter().copied().reduce(f64::max)?;
    // Beyond noise: not even the upper quartile reaches 1.
    let lost = |r: &&Record| {
        r.skipping_gain.is_some_and(|gain| gain + r.skipping_gain_iqr.unwrap_or(0.0) / 2.0 < 1.0)
    };
    let slower = records.iter().filter(|r| shown(r)).filter(lost).count();
    Some(format!(
        "Skipping empty macrocells makes the frames of {} cells {} × as fast (median; {} to {}), {slower} of them slower \
         beyond noise; no picture differs in any bit from the one without.",
        gains.len(),
        short(median(gains.clone())),
        short(Some(least)),
        short(Some(most)),
    ))
}

/// The cell with the lowest relative frame time of those that are compressed and look right, and what ties with it.
fn fastest(records: &[Record], labels: &Labels) -> Option<String> {
    let good =
        |r: &&Record| shown(r) && compressed(r) && r.image_psnr_db.is_some_and(|p| p >= GOOD_PICTURE_DB);
    let timed = records.iter().filter(good).filter_map(|r| Some((r, r.relative_frame_time?)));
    let mut timed: Vec<(&Record, f64)> = timed.filter(|(_, time)| !time.is_nan()).collect();
    timed.sort_by(|a, b| a.1.total_cmp(&b.1));
    let ((first, time), others) = timed.split_first()?;
    let named = |r: &Record, time: f64| {
        format!("{} on {} at {} × the baseline", labels.cell(r), r.volume, short(Some(time)))
    };
    let mut sentence = format!(
        "The fastest compressed cell with a picture of {GOOD_PICTURE_DB} dB or more: {} ({}, {} bits per voxel in the file{}{})",
        named(first, *time),
        decibels(first.image_psnr_db),
        short(first.bits_per_voxel),
        first.resident_bytes.map_or_else(String::new, |b| format!(", {} in device memory", bytes(Some(b)))),
        if is_noisy(first) { ", noisy timing" } else { "" },
    );
    let ties: Vec<String> =
        others.iter().filter(|(r, _)| tie(first, r)).map(|(r, time)| named(r, *time)).collect();
    if !ties.is_empty() {
        let more = ties.len().saturating_sub(NAMED_TIES);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let ties = ties[..ties.len().min(NAMED_TIES)].join("; ");
        sentence += &format!("; a tie within noise with {ties}{more}");
    }
    Some(sentence + ".")
}

fn upper_first(sentence: String) -> String {
    let mut letters = sentence.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Up to six sentences on speed, what was not compared, pictures and failures.
fn sentences(records: &[Record], labels: &Labels) -> Vec<String> {
    let mut out = Vec::new();
    let times = |wanted: fn(&Record) -> bool| {
        let timed = records.iter().filter(|r| shown(r) && wanted(r));
        median(timed.filter_map(|r| r.relative_frame_time).collect())
    };
    if let Some(buffer) = times(|r| Baseline::of(r) == Some(Baseline::Buffer)) {
        out.push(format!(
            "Uncompressed, a manual linear filter takes {} × the frame time of the texture unit (median over views): this is the \
             filter's share in every cell that is decoded inline.",
            short(Some(buffer))
        ));
    }
    let mut by_site = Vec::new();
    for site in distinct(records.iter().filter(|r| compressed(r)).map(|r| r.site.clone())) {
        let of_site = |r: &&Record| shown(r) && compressed(r) && r.site == site && r.filter != "nearest";
        let time = median(records.iter().filter(of_site).filter_map(|r| r.relative_frame_time).collect());
        by_site.extend(time.map(|t| format!("{} × {site}", short(Some(t)))));
    }
    if !by_site.is_empty() {
        out.push(format!(
            "Median relative frame time of compressed cells, linear filter: {}.",
            by_site.join(", ")
        ));
    }
    out.extend(not_run(records).map(upper_first));
    out.extend(fastest(records, labels));
    out.extend(skipping(records));
    let failed: Vec<&Record> = records.iter().filter(|r| !ok(r)).collect();
    if let Some(first) = failed.first() {
        out.push(format!(
            "{} of {} cells failed, the first of them {} on {}: {}.",
            failed.len(),
            records.len(),
            labels.cell(first),
            first.volume,
            first.error.as_deref().unwrap_or("no reason given").trim_end_matches('.')
        ));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::Status;
    use crate::experiment::records::record::tests::record;

    fn timed(codec: &str, time: f64, iqr: f64) -> Record {
        Record {
            site: "inline".into(),
            filter: "linear".into(),
            image_psnr_db: Some(45.0),
            relative_frame_time: Some(time),
            relative_frame_time_iqr: Some(iqr),
            ..record("v", codec)
        }
    }

    #[test]
    fn what_noise_hides_is_called_a_tie() {
        let told = |records: &[Record]| fastest(records, &Labels::of(records)).unwrap();
        let apart = told(&[timed("vq", 1.5, 0.1), timed("hvq", 1.2, 0.1)]);
        assert!(apart.contains(": hvq, inline, linear on v at 1.20 × the baseline (45.0 dB"), "{apart}");
        assert!(!apart.contains("tie") && !apart.contains("noisy"), "{apart}");
        let near = told(&[timed("vq", 1.3, 0.1), timed("hvq", 1.2, 0.4), timed("zfp", 2.0, 0.1)]);
        assert!(
            near.contains("noisy timing); a tie within noise with vq, inline, linear on v at 1.30"),
            "{near}"
        );
        assert!(!near.contains("zfp"), "{near}");
        let many: Vec<Record> = ["a", "b", "c", "d", "e"].map(|codec| timed(codec, 1.0, 0.1)).to_vec();
        assert!(
            told(&many).ends_with("d, inline, linear on v at 1.00 × the baseline and 1 more."),
            "{}",
            told(&many)
        );
        assert_eq!(fastest(&[], &Labels::default()), None);
    }

    /// Explanations of the first table's columns.
    fn best(records: &[Record]) -> Vec<(String, String)> {
        let rows = rates(records, &Labels::of(records));
        let cells = rows[0].get_attr("cells").unwrap();
        let text = |cell: &Value, key: &str| cell.get_attr(key).map(|v| v.to_string()).unwrap_or_default();
        cells.try_iter().unwrap().map(|cell| (text(&cell, "psnr"), text(&cell, "codec"))).collect()
    }

    fn coded(codec: &str, payload_bytes: u64, header_bytes: u64, psnr: f64) -> Record {
        let file_bytes = payload_bytes + header_bytes;
        Record {
            voxels: 8000,
            psnr_db: Some(psnr),
            bits_per_voxel: Some(file_bytes as f64 / 1000.0),
            file_bytes: Some(file_bytes),
            payload_bytes: Some(payload_bytes),
            ..record("v", codec)
        }
    }

    #[test]
    fn each_column_holds_what_takes_fewer_bits_too() {
        let told = |records: &[Record]| {
            let cells = best(records).into_iter().map(|(psnr, codec)| format!("{codec} {psnr}"));
            cells.collect::<Vec<_>>().join(" | ")
        };
        assert_eq!(budget_names(), ["≤ 1", "≤ 2", "≤ 4", "≤ 8", "any"]);
        // 44 dB at 1 bit beside 23 dB at 2 bits: the header of 2 KiB does not move a codec into the next column.
        let records = [
            coded("good", 1000, 2048, 44.0),
            coded("poor", 2000, 2048, 23.0),
            coded("raw", 8001, 2048, 90.0),
        ];
        assert_eq!(told(&records), "good 44.0 dB | good 44.0 dB | good 44.0 dB | good 44.0 dB | raw 90.0 dB");
        // A value that is as good with fewer bits, in any order.
        let lossless = [
            coded("few", 3000, 0, f64::INFINITY),
            coded("less", 1500, 0, 30.0),
            coded("many", 8000, 0, f64::INFINITY),
        ];
        assert_eq!(told(&lossless), "  | less 30.0 dB | few lossless | few lossless | few lossless");
        // Records of former versions have the whole file alone.
        let former: Vec<Record> =
            records.iter().map(|r| Record { payload_bytes: None, ..r.clone() }).collect();
        assert_eq!(told(&former), "  |   | good 44.0 dB | good 44.0 dB | raw 90.0 dB");
        let failed = [Record { status: Status::Failed, ..records[0].clone() }, records[1].clone()];
        assert!(told(&failed).starts_with("  | poor 23.0 dB | poor"), "{}", told(&failed));
    }

    #[test]
    fn a_scene_that_shows_nothing_is_warned_of_and_counts_nowhere() {
        let blank = |codec: &str| Record {
            visible_pixels: Some(0),
            skipping_gain: Some(90.0),
            notes: Some("shows nothing: why".into()),
            scene: "nowhere".into(),
            ..timed(codec, 0.001, 0.0)
        };
        let seen = Record { visible_pixels: Some(7), skipping_gain: Some(2.0), ..timed("vq", 1.5, 0.0) };
        let records = [blank("vq"), blank("hvq"), seen.clone()];
        let warning =
            "Warning: scene `nowhere` shows nothing of volume `v`: why; its pictures are not judged.";
        assert_eq!(warnings(&records), [warning]);
        let labels = Labels::of(&records);
        assert_eq!(sentences(&records, &labels), sentences(&[seen], &labels));
        assert!(sentences(&records[..2], &labels).is_empty(), "{:?}", sentences(&records[..2], &labels));
    }

    #[test]
    fn cells_whose_shader_did_not_run_are_told() {
        let cell = |notes: Option<&str>| Record { notes: notes.map(str::to_owned), ..timed("vq", 1.0, 0.1) };
        let told = |records: &[Record]| sentences(records, &Labels::of(records)).join("\n");
        let ran = [cell(None), cell(Some("noisy timing"))];
        assert!(!told(&ran).contains("hader not run"));
        let mixed = [cell(None), cell(Some("noisy timing; shader not run: the CPU mirror drew"))];
        assert!(told(&mixed).contains("Shader not run: 1 of 2 cells"), "{}", told(&mixed));
    }

    #[test]
    fn skipping_is_slower_only_beyond_noise() {
        let gain = |gain: f64, iqr: f64| Record {
            skipping_gain: Some(gain),
            skipping_gain_iqr: Some(iqr),
            ..record("v", "vq")
        };
        let told = skipping(&[gain(0.95, 0.2), gain(0.8, 0.2), gain(2.0, 0.1)]).unwrap();
        assert!(
            told.contains("3 cells 0.950 × as fast") && told.contains(", 1 of them slower beyond"),
            "{told}"
        );
    }
}
