//! The figures of several frames as those of one cell.
//!
//! Errors of pictures are pooled as if all frames were one picture ([`ImageError::pooled`]). The table of columns says
//! how each other column is pooled ([`Record::COLUMNS`]).

use cvr_core::metrics::ImageError;

use super::picture_errors::PictureErrors;
use crate::experiment::records::record::Record;

/// Enters the figures of the frames. `errors` are those of completely drawn frames.
pub fn enter(record: &mut Record, frames: &[Record], errors: &[PictureErrors]) {
    if frames.is_empty() {
        return;
    }
    if let [only] = frames {
        let frames = (record.first_frame, record.last_frame);
        *record = only.clone();
        (record.first_frame, record.last_frame) = frames;
        return;
    }
    if !errors.is_empty() {
        let pooled = |of: fn(&PictureErrors) -> ImageError| ImageError::pooled(errors.iter().map(of));
        PictureErrors { reference: pooled(|e| e.reference), raw: pooled(|e| e.raw) }.enter(record);
    }
    record.pool(frames);
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
        // An error of `error` in every visible pixel.
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
    }

    #[test]
    fn a_single_frame_is_the_cell() {
        let mut record = Record { first_frame: 3, last_frame: 3, ..Record::default() };
        let only = Record { first_frame: 3, last_frame: 3, ..frame(2.0, 5, "b") };
        enter(&mut record, std::slice::from_ref(&only), &[]);
        assert_eq!(record, only);
    }
}
