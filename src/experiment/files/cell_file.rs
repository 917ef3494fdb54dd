//! `cells/<id>.json`: one record, and the key that decides whether it may replace a run of its cell.
//!
//! The file is the record as `results.json` holds it, with four fields more: `key` ([`crate::experiment::identity::key`]), `pictures`
//! (BLAKE3 of every file that belongs to it, its references among them), `not_finite` (values that JSON
//! has no number for, so that a record comes back as it was), and `digest` ([`digest_of`] all the others).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cvr_core::pipeline::Cell;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::flaws::Flaw;
use super::folder::OutFolder;
use super::names::{CELLS, IMAGES, of_cell};
use super::whole_file::ResultsError;
use crate::experiment::identity::cell::of_record;
use crate::experiment::records::record::{Record, Status};
use crate::experiment::records::series;

/// A record with the key of its inputs, so that a later run can take it over.
pub trait Keyed: Serialize + DeserializeOwned {
    /// Whether it stands for a run that need not be repeated.
    fn ended_well(&self) -> bool;

    /// Files that belong to it, relative to the folder of results.
    fn files(&self) -> Vec<String> {
        Vec::new()
    }

    /// Fills in fields that older versions did not write.
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
    /// Hash of all inputs. `None` in files of versions without it.
    #[serde(default)]
    pub key: Option<String>,
    /// Paths relative to the report, and the BLAKE3 of the files.
    #[serde(default)]
    pub pictures: BTreeMap<String, String>,
    /// Columns whose value is infinite or no number, as text.
    #[serde(default)]
    not_finite: BTreeMap<String, String>,
    /// Whether the file carries a digest. Files of version 0.1.0 do not, so it is unknown whether they were changed.
    #[serde(skip)]
    pub sealed: bool,
}

/// Name of the field with the digest.
const DIGEST: &str = "digest";

/// BLAKE3 in hexadecimal of a cell's file without its digest, as compact JSON with sorted keys; spaces and line breaks
/// do not count.
#[must_use]
pub fn digest_of(file: &serde_json::Value) -> String {
    // A value always serialises.
    blake3::hash(&serde_json::to_vec(file).unwrap_or_default()).to_hex().to_string()
}

impl<R: Keyed> CellFile<R> {
    /// A record with its key. Hashes the cell's files and its `references` in `folder`.
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
        Self { record, key, pictures, not_finite, sealed: true }
    }

    /// The bytes of the file.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        // Maps of strings and numbers always serialise.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        let digest = digest_of(&value);
        if let Some(fields) = value.as_object_mut().filter(|_| self.sealed) {
            fields.insert(DIGEST.to_owned(), digest.into());
        }
        let mut text = serde_json::to_vec_pretty(&value).unwrap_or_default();
        text.push(b'\n');
        text
    }

    /// Writes the file with this name completely, or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, out: &OutFolder, id: &str) -> Result<(), ResultsError> {
        out.write(&format!("{CELLS}/{id}.json"), &self.bytes())
    }

    /// Reads a file, and checks by its digest, if it has one, that it is unchanged.
    ///
    /// # Errors
    /// When there is none, it is no record, or its digest is not that of the rest.
    pub fn read(path: &Path) -> Result<Self, Flaw> {
        let bytes = std::fs::read(path).map_err(|_| Flaw::Absent)?;
        let mut value: serde_json::Value = serde_json::from_slice(&bytes).map_err(|_| Flaw::Damaged)?;
        let digest = value.as_object_mut().ok_or(Flaw::Damaged)?.remove(DIGEST);
        let sealed = digest.is_some();
        if digest.is_some_and(|digest| digest != digest_of(&value)) {
            return Err(Flaw::Damaged);
        }
        let mut file: Self = serde_json::from_value(value).map_err(|_| Flaw::Damaged)?;
        let Self { record, not_finite, .. } = &mut file;
        record.restore();
        let mut whole = true;
        record.each_unbounded(&mut |name, value| {
            if let Some(text) = not_finite.get(name) {
                *value = text.parse().ok();
                whole &= value.is_some();
            }
        });
        if whole { Ok(Self { sealed, ..file }) } else { Err(Flaw::Damaged) }
    }

    /// The file with this name in `folder`, if it may replace a run of the cell that `is_of` accepts: unchanged, same
    /// key, not failed, files unchanged.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn whole(folder: &Path, id: &str, key: &str, is_of: impl Fn(&R) -> bool) -> Result<Self, Flaw> {
        let file = Self::read(&path(folder, id))?;
        if !file.sealed {
            return Err(Flaw::Unsealed);
        }
        if !is_of(&file.record) {
            return Err(Flaw::OtherCell);
        }
        if file.key.as_deref() != Some(key) || !file.record.ended_well() {
            return Err(Flaw::Outdated);
        }
        let intact = file.record.files().iter().all(|path| file.is_intact(folder, path));
        if intact { Ok(file) } else { Err(Flaw::Files) }
    }

    /// Whether a picture in `folder` is unchanged since the record was written.
    #[must_use]
    pub fn is_intact(&self, folder: &Path, picture: &str) -> bool {
        let known = self.pictures.get(picture);
        known.is_some() && hash(&folder.join(picture)).as_ref() == known
    }
}

impl CellFile {
    /// The file of `cell`, if it may replace a run of this cell. `expected` is the record before the cell runs.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn taken_over(folder: &Path, cell: &Cell, key: &str, expected: &Record) -> Result<Self, Flaw> {
        let id = cell.id();
        let names = |r: &Record| {
            let samples = [r.voxels, u64::from(r.frames), u64::from(r.first_frame), u64::from(r.last_frame)];
            (of_record(r), r.device.clone(), r.driver.clone(), samples)
        };
        let pictures = [format!("{IMAGES}/{id}.png"), format!("{IMAGES}/{id}.error.png")];
        let file = Self::whole(folder, &id, key, |record| names(record) == names(expected))?;
        let named = [&file.record.image, &file.record.error_image];
        let own = named.iter().zip(&pictures).all(|(path, own)| path.as_ref() == Some(own));
        if own { Ok(file) } else { Err(Flaw::OtherCell) }
    }
}

/// Path of a cell's file.
#[must_use]
pub fn path(folder: &Path, id: &str) -> PathBuf {
    folder.join(CELLS).join(format!("{id}.json"))
}

/// BLAKE3 of a file in hexadecimal, if it can be read.
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
    use crate::experiment::records::record::tests::record;

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
        std::fs::write(&file, written.bytes()).unwrap();
        let read = CellFile::<Record>::read(&file).unwrap();
        assert_eq!((&read, &read.record), (&written, &lossless));
    }

    #[test]
    fn what_is_no_record_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.json");
        assert_eq!(CellFile::<Record>::read(&file), Err(Flaw::Absent));
        let whole = CellFile::new(record("v", "raw"), None, folder.path(), []).bytes();
        std::fs::write(&file, &whole).unwrap();
        assert!(CellFile::<Record>::read(&file).is_ok());
        for bad in [&whole[..whole.len() / 2], b"", b"{}", b"[1]", b"\xff\x00"] {
            std::fs::write(&file, bad).unwrap();
            assert_eq!(CellFile::<Record>::read(&file), Err(Flaw::Damaged), "{bad:?}");
        }
    }

    /// Every significant byte: each digit of a figure, each letter of a name.
    #[test]
    fn a_record_that_was_edited_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.json");
        let record = Record { psnr_db: Some(41.25), frame_ms: Some(1e-7), ..record("v", "raw") };
        let written = CellFile::new(record, Some("k".to_owned()), folder.path(), []);
        let text = String::from_utf8(written.bytes()).unwrap();
        let read = |text: &str| {
            std::fs::write(&file, text).unwrap();
            CellFile::<Record>::read(&file)
        };
        for (from, to) in [
            ("41.25", "41.26"),
            ("41.25", "null"),
            ("1e-7", "2e-7"),
            ("\"codec\": \"raw\"", "\"codec\": \"row\""),
            ("\"key\": \"k\"", "\"key\": \"l\""),
            ("\"status\": \"ok\"", "\"status\": \"failed\""),
            ("\"digest\": \"", "\"digest\": \"0"),
        ] {
            assert!(text.contains(from), "{from}: {text}");
            assert_eq!(read(&text.replacen(from, to, 1)), Err(Flaw::Damaged), "{from} {to}");
        }
        // The twins: an insignificant byte, and a missing digest.
        assert_eq!(read(&text.replace('\n', "")).as_ref(), Ok(&written));
        let unsealed = read(&text.replace("\"digest\"", "\"another\"")).unwrap();
        assert!(!unsealed.sealed && unsealed.record == written.record);
        assert!(!String::from_utf8(unsealed.bytes()).unwrap().contains("digest"), "nobody vouches for it");
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
