//! Tampered volume files of every format: refused in a sentence that names the file, or read as the header says.

use std::path::PathBuf;

use cvr::input;
use cvr_core::volume::BrickSource as _;

use super::mutate::{Dice, bytes, campaign};

/// Largest number of samples that a file may claim and have: deflate makes at most 1032 bytes from one.
const MOST_SAMPLES: u64 = 64 << 20;

/// Small valid files: those of other tools next to the readers, those that `cvr` writes, and, if `CVR_DATA` names a
/// folder next to `cases`, those too.
fn files() -> Vec<(String, Vec<u8>)> {
    let own = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/input/tests/foreign");
    let cases = std::env::var_os("CVR_DATA").map(|data| PathBuf::from(data).join("../cases/inputs"));
    let mut files = Vec::new();
    for folder in [Some(own), cases].into_iter().flatten() {
        let found = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|entry| entry.path());
        for path in found.filter(|path| path.is_file()) {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            let is_volume = ![".py", ".json", ".raw", ".gz"].iter().any(|end| name.ends_with(end))
                || name.ends_with(".nii.gz");
            if is_volume && path.metadata().unwrap().len() < 1 << 16 {
                files.push((name, std::fs::read(&path).unwrap()));
            }
        }
    }
    files.sort();
    let formats = [".nrrd", ".mha", ".nii", ".nii.gz", ".vti", ".npy", ".tif"];
    for format in formats {
        assert!(files.iter().any(|(name, _)| name.ends_with(format)), "no file of {format}");
    }
    files
}

#[test]
fn no_volume_file_panics_or_is_read_as_what_it_is_not() {
    let (files, folder) = (files(), tempfile::tempdir().unwrap());
    campaign("volumes", 3000, |mut dice: Dice| {
        let ((name, whole), (_, other)) = (dice.pick(&files).clone(), dice.pick(&files).clone());
        let mut file = whole;
        bytes(&mut dice, &mut file, &other);
        let path = folder.path().join(&name);
        std::fs::write(&path, &file).unwrap();
        let promised = input::layout(std::slice::from_ref(&path), None, None);
        let read = input::read(std::slice::from_ref(&path), None, None);
        match read {
            Err(error) => {
                let told = error.to_string();
                if !told.contains(&name) || told.len() > 2000 {
                    return Err(format!("{name}: {told}"));
                }
                Ok(false)
            }
            Ok(volume) => {
                let layout = volume.volume.layout();
                if volume.volume.samples().len() as u64 != layout.samples() || layout.samples() > MOST_SAMPLES
                {
                    return Err(format!("{name}: {} samples of {layout:?}", volume.volume.samples().len()));
                }
                match promised {
                    Ok(Some(promised)) if promised != *layout => {
                        Err(format!("{name}: the header promises {promised:?}, read was {layout:?}"))
                    }
                    Err(error) => Err(format!("{name}: its header is refused, and it is read: {error}")),
                    _ => Ok(true),
                }
            }
        }
    });
}
