//! `cells/<id>.json`: one record, and what tells whether it may stand for a run of its cell.
//!
//! The file is the record as `results.json` holds it, with three fields more: `key` ([`super::key`]), `pictures`
//! (BLAKE3 of every file that belongs to it, its references among them), and `not_finite` (values that JSON
//! has no number for, so that a record comes back as it was).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cvr_core::pipeline::Cell;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::files::{IMAGES, of_cell};
use super::record::{Record, Status};
use super::results::{ResultsError, write_whole};
use super::series;

/// Folder of the single records, below the report's.
pub const CELLS: &str = "cells";

/// A record that is kept with the key of all that went into it, so that a later run may take it over.
pub trait Keyed: Serialize + DeserializeOwned {
    /// Whether it stands for a run that need not be repeated.
    fn ended_well(&self) -> bool;

    /// Files that belong to it, relative to the folder of results.
    fn files(&self) -> Vec<String> {
        Vec::new()
    }

    /// Enters what versions that wrote it before did not know.
    fn restore(&mut self) {}

    /// Calls with each figure that may be infinite, for which JSON has no number.
    fn each_unbounded(&mut self, _each: &mut dyn FnMut(&'static str, &mut Option<f64>)) {}
}

impl Keyed for Record {
    fn ended_well(&self) -> bool {
        self.status == Status::Ok && self.error.is_none()
    }

    fn files(&self) -> Vec<String> {
        of_cell(self)
    }

    fn restore(&mut self) {
        series::restore(self);
    }

    fn each_unbounded(&mut self, each: &mut dyn FnMut(&'static str, &mut Option<f64>)) {
        psnrs(self).into_iter().for_each(|(name, value)| each(name, value));
        self.figures_mut().into_iter().for_each(|(name, value)| each(name, value));
    }
}

/// A record and its key.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellFile<R = Record> {
    /// The record.
    #[serde(flatten)]
    pub record: R,
    /// Hash of all that went into it; `None` in files of versions that had none.
    #[serde(default)]
    pub key: Option<String>,
    /// Paths relative to the report, and the BLAKE3 of the files.
    #[serde(default)]
    pub pictures: BTreeMap<String, String>,
    /// Columns whose value is infinite or no number, as text.
    #[serde(default)]
    not_finite: BTreeMap<String, String>,
}

impl<R: Keyed> CellFile<R> {
    /// A record with its key. The cell's files and its `references` are hashed as they lie in `folder`.
    #[must_use]
    pub fn new<'r>(
        mut record: R,
        key: Option<String>,
        folder: &Path,
        references: impl IntoIterator<Item = &'r str>,
    ) -> Self {
        let paths = record.files().into_iter().chain(references.into_iter().map(str::to_owned));
        let pictures = paths.filter_map(|path| hash(&folder.join(&path)).map(|hash| (path, hash))).collect();
        let mut not_finite = BTreeMap::new();
        record.each_unbounded(&mut |name, value| {
            if let Some(value) = value.filter(|v| !v.is_finite()) {
                not_finite.insert(name.to_owned(), value.to_string());
            }
        });
        Self { record, key, pictures, not_finite }
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ResultsError> {
        // Maps of strings and numbers always serialise.
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        write_whole(path, &text)
    }

    /// Reads a file; `None` where there is none or it is no record: whoever asks can run the cell again.
    #[must_use]
    pub fn read(path: &Path) -> Option<Self> {
        let mut file: Self = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
        let Self { record, not_finite, .. } = &mut file;
        record.restore();
        let mut whole = true;
        record.each_unbounded(&mut |name, value| {
            if let Some(text) = not_finite.get(name) {
                *value = text.parse().ok();
                whole &= value.is_some();
            }
        });
        whole.then_some(file)
    }

    /// The file of this name in `folder`, where it may stand for a run: same key, ended well, its files as they were.
    #[must_use]
    pub fn whole(folder: &Path, id: &str, key: &str) -> Option<Self> {
        let file = Self::read(&path(folder, id))?;
        let intact = file.record.files().iter().all(|path| file.is_intact(folder, path));
        (file.key.as_deref() == Some(key) && file.record.ended_well() && intact).then_some(file)
    }

    /// Whether a picture lies in `folder` as it did when the record was written.
    #[must_use]
    pub fn is_intact(&self, folder: &Path, picture: &str) -> bool {
        let known = self.pictures.get(picture);
        known.is_some() && hash(&folder.join(picture)).as_ref() == known
    }
}

impl CellFile {
    /// The file of `cell`, where it may stand for a run and has the pictures of this cell.
    #[must_use]
    pub fn taken_over(folder: &Path, cell: &Cell, key: &str) -> Option<Self> {
        let id = cell.id();
        let file = Self::whole(folder, &id, key)?;
        let expected = [format!("{IMAGES}/{id}.png"), format!("{IMAGES}/{id}.error.png")];
        let named = [&file.record.image, &file.record.error_image];
        named.iter().zip(&expected).all(|(path, expected)| path.as_ref() == Some(expected)).then_some(file)
    }
}

/// Where the file of a cell stands.
#[must_use]
pub fn path(folder: &Path, id: &str) -> PathBuf {
    folder.join(CELLS).join(format!("{id}.json"))
}

/// BLAKE3 of a file in hexadecimal, where it can be read.
#[must_use]
pub fn hash(path: &Path) -> Option<String> {
    std::fs::read(path).ok().map(|bytes| blake3::hash(&bytes).to_hex().to_string())
}

/// The PSNRs, which identical data make infinite.
fn psnrs(record: &mut Record) -> [(&'static str, &mut Option<f64>); 8] {
    [
        ("psnr_db", &mut record.psnr_db),
        ("foreground_psnr_db", &mut record.foreground_psnr_db),
        ("image_psnr_db", &mut record.image_psnr_db),
        ("image_psnr_whole_db", &mut record.image_psnr_whole_db),
        ("codec_image_psnr_db", &mut record.codec_image_psnr_db),
        ("psnr_red_db", &mut record.psnr_red_db),
        ("psnr_green_db", &mut record.psnr_green_db),
        ("psnr_blue_db", &mut record.psnr_blue_db),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::results::tests::record;

    #[test]
    fn a_record_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let file = path(folder.path(), "a");
        std::fs::create_dir(folder.path().join(CELLS)).unwrap();
        let lossless = Record {
            psnr_db: Some(f64::INFINITY),
            foreground_psnr_db: Some(f64::INFINITY),
            image_psnr_db: Some(f64::NEG_INFINITY),
            codec_image_psnr_db: Some(0.1 + 0.2),
            encode_seconds: Some(1.234_567_890_123_456_7e-5),
            voxels: u64::MAX,
            block_discontinuity: Some(f64::INFINITY),
            image_flip: Some(0.125),
            ..record("v", "raw")
        };
        let written = CellFile::new(lossless.clone(), Some("k".to_owned()), folder.path(), []);
        written.write(&file).unwrap();
        let read = CellFile::<Record>::read(&file).unwrap();
        assert_eq!((&read, &read.record), (&written, &lossless));
    }

    #[test]
    fn what_is_no_record_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.json");
        assert_eq!(CellFile::<Record>::read(&file), None);
        CellFile::new(record("v", "raw"), None, folder.path(), []).write(&file).unwrap();
        let whole = std::fs::read(&file).unwrap();
        assert!(CellFile::<Record>::read(&file).is_some());
        for bad in [&whole[..whole.len() / 2], b"", b"{}", b"[1]", b"\xff\x00"] {
            std::fs::write(&file, bad).unwrap();
            assert_eq!(CellFile::<Record>::read(&file), None, "{bad:?}");
        }
    }

    #[test]
    fn a_changed_or_missing_picture_is_not_intact() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("a.png");
        std::fs::write(&picture, "picture").unwrap();
        let named = Record { image: Some("a.png".to_owned()), ..record("v", "raw") };
        let file = CellFile::new(named, None, folder.path(), []);
        assert!(file.is_intact(folder.path(), "a.png") && !file.is_intact(folder.path(), "b.png"));
        std::fs::write(&picture, "pictura").unwrap();
        assert!(!file.is_intact(folder.path(), "a.png"));
        std::fs::remove_file(&picture).unwrap();
        assert!(!file.is_intact(folder.path(), "a.png"));
    }
}
