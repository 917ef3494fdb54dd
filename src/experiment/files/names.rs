//! Names of files and folders, below the folder of the results.

use cvr_core::volume::FrameIndex;

use crate::experiment::records::record::Record;

/// Folder of the single records, below that of the results.
pub const CELLS: &str = "cells";
/// Folder of the charts.
pub const CHARTS: &str = "charts";
/// Folder of the pictures.
pub const IMAGES: &str = "images";
/// Folder of the figures of single frames.
pub const FRAMES: &str = "frames";
/// Folder of the histograms of errors.
pub const ERRORS: &str = "errors";

/// Endings of pictures, the longer first.
const ENDINGS: [&str; 2] = [".error.png", ".png"];

/// Name of a later frame's picture, from that of the scene's first frame: `a.png` becomes `a.f0007.png` for frame 7,
/// `a.error.png` becomes `a.f0007.error.png`.
#[must_use]
pub fn of_frame(path: &str, frame: FrameIndex) -> String {
    let ending = ENDINGS.iter().find(|ending| path.ends_with(**ending)).unwrap_or(&"");
    format!("{}.f{:04}{ending}", path.strip_suffix(ending).unwrap_or(path), frame.0)
}

/// A picture and those of the later frames, in order.
pub fn of_frames(first: &str, record: &Record) -> Vec<String> {
    let later = (record.first_frame..record.last_frame).map(|f| of_frame(first, FrameIndex(f + 1)));
    std::iter::once(first.to_owned()).chain(later).collect()
}

/// All files of a cell: pictures, pictures of errors, the figures of its frames, and the histogram of its errors.
#[must_use]
pub fn of_cell(record: &Record) -> Vec<String> {
    let pictures = [&record.image, &record.error_image].into_iter().flatten();
    let tables = [&record.frame_figures, &record.error_histogram].into_iter().flatten().cloned();
    pictures.flat_map(|first| of_frames(first, record)).chain(tables).collect()
}

/// The files that every cell of this name has, including its record.
#[must_use]
pub fn of_id(id: &str) -> [String; 4] {
    [
        format!("{CELLS}/{id}.json"),
        format!("{IMAGES}/{id}.png"),
        format!("{IMAGES}/{id}.error.png"),
        format!("{ERRORS}/{id}.csv"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_frames_are_named_after_the_first() {
        let record = Record {
            first_frame: 8,
            last_frame: 10,
            image: Some("images/a.b.png".to_owned()),
            error_image: Some("images/a.b.error.png".to_owned()),
            frame_figures: Some("frames/a.b.csv".to_owned()),
            error_histogram: Some("errors/a.b.csv".to_owned()),
            ..Record::default()
        };
        let expected = [
            "images/a.b.png",
            "images/a.b.f0009.png",
            "images/a.b.f0010.png",
            "images/a.b.error.png",
            "images/a.b.f0009.error.png",
            "images/a.b.f0010.error.png",
            "frames/a.b.csv",
            "errors/a.b.csv",
        ];
        assert_eq!(of_cell(&record), expected);
        assert_eq!(of_cell(&Record::default()), [""; 0]);
    }
}
