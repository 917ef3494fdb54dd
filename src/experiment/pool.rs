//! The figures of several frames as those of one cell.
//!
//! Errors of pictures are pooled as if all frames were one picture ([`ImageError::pooled`]). Times, and what is measured
//! once for each frame, are medians over the frames; pixels and samples that differ are added up; of memory the frame
//! that needs most counts.

use cvr_core::metrics::ImageError;

use super::frame_run::PictureErrors;
use super::record::Record;

/// Enters what was measured of the frames. `errors` are those of the frames that were drawn to the end.
pub fn enter(record: &mut Record, frames: &[Record], errors: &[PictureErrors]) {
    let Some(first) = frames.first() else { return };
    if let [only] = frames {
        let frames = (record.first_frame, record.last_frame);
        *record = only.clone();
        (record.first_frame, record.last_frame) = frames;
        return;
    }
    record.image = first.image.clone();
    record.error_image = first.error_image.clone();
    record.filtering = first.filtering.clone();
    record.frame_clock = first.frame_clock.clone();
    if !errors.is_empty() {
        let pooled = |of: fn(&PictureErrors) -> ImageError| ImageError::pooled(errors.iter().map(of));
        PictureErrors { reference: pooled(|e| e.reference), raw: pooled(|e| e.raw) }.enter(record);
    }
    let mid = |field: fn(&Record) -> Option<f64>| median(frames.iter().filter_map(field).collect());
    record.frame_ms = mid(|r| r.frame_ms);
    record.frame_ms_iqr = mid(|r| r.frame_ms_iqr);
    record.frame_cpu_ms = mid(|r| r.frame_cpu_ms);
    record.relative_frame_time = mid(|r| r.relative_frame_time);
    record.relative_frame_time_iqr = mid(|r| r.relative_frame_time_iqr);
    record.device_decode_ms = mid(|r| r.device_decode_ms);
    record.skipping_gain = mid(|r| r.skipping_gain);
    record.skipping_gain_iqr = mid(|r| r.skipping_gain_iqr);
    record.empty_macrocells = mid(|r| r.empty_macrocells);
    record.macrocell_seconds = mid(|r| r.macrocell_seconds);
    let most = |field: fn(&Record) -> Option<u64>| frames.iter().filter_map(field).max();
    record.resident_bytes = most(|r| r.resident_bytes);
    record.device_decode_bytes = most(|r| r.device_decode_bytes);
    let sum = |field: fn(&Record) -> Option<u64>| frames.iter().filter_map(field).reduce(|a, b| a + b);
    record.parity_mismatches = sum(|r| r.parity_mismatches);
    record.skipping_mismatches = sum(|r| r.skipping_mismatches);
    record.frame_pairs = frames.iter().filter_map(|r| r.frame_pairs).reduce(|a, b| a + b);
    // Remarks of frames follow those of the cell, equal ones once.
    let own = record.notes.clone().unwrap_or_default();
    let mut said: Vec<&str> = own.split("; ").collect();
    for remark in frames.iter().filter_map(|r| r.notes.as_deref()).flat_map(|notes| notes.split("; ")) {
        if !said.contains(&remark) {
            record.remark(remark);
            said.push(remark);
        }
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = values.get(values.len() / 2)?;
    Some((values[(values.len() - 1) / 2] + upper) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::render::Image;

    fn frame(ms: f64, mismatches: u64, notes: &str) -> Record {
        Record {
            frame_ms: Some(ms),
            parity_mismatches: Some(mismatches),
            resident_bytes: Some(100 + mismatches),
            frame_pairs: Some(7),
            notes: Some(notes.to_owned()),
            ..Record::default()
        }
    }

    #[test]
    fn frames_become_one_cell() {
        let mut record = Record { notes: Some("a".to_owned()), ..Record::default() };
        // Wrong by `error` where anything is visible.
        let errors = |error: f32, visible: usize| {
            let of = |tone: f32| {
                let pixels = (0..400).map(|i| if i < visible { [tone, tone, tone, 1.0] } else { [0.0; 4] });
                Image::from_pixels([20, 20], pixels.collect()).unwrap()
            };
            ImageError::compare(&of(0.5), &of(0.5 + error), [0.0; 3]).unwrap()
        };
        let both = |e| PictureErrors { reference: e, raw: e };
        let frames = [frame(2.0, 0, "a; b"), frame(9.0, 3, "a; c"), frame(4.0, 1, "b")];
        enter(&mut record, &frames, &[both(errors(0.1, 300)), both(errors(0.0, 100))]);
        assert_eq!((record.frame_ms, record.parity_mismatches), (Some(4.0), Some(4)));
        assert_eq!((record.resident_bytes, record.frame_pairs), (Some(103), Some(21)));
        assert_eq!(record.notes.as_deref(), Some("a; b; c"));
        // 0.01 over 300 of 400 pixels.
        let expected = -10.0 * 0.0075_f64.log10();
        assert!((record.image_psnr_db.unwrap() - expected).abs() < 1e-5);
        assert_eq!(record.visible_pixels, Some(400));
        assert_eq!(median(vec![4.0, 1.0]), Some(2.5));
    }

    #[test]
    fn a_single_frame_is_the_cell() {
        let mut record = Record { first_frame: 3, last_frame: 3, ..Record::default() };
        let only = Record { first_frame: 3, last_frame: 3, ..frame(2.0, 5, "b") };
        enter(&mut record, std::slice::from_ref(&only), &[]);
        assert_eq!(record, only);
    }
}
