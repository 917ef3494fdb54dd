//! The folder of a run: whose it is, and what an earlier run left in it.

use std::fs::{File, TryLockError};
use std::path::Path;

use super::cell_file::CELLS;
use super::files::{ERRORS, FRAMES, IMAGES};

/// Folder of the charts, below the report's.
pub const CHARTS: &str = "charts";

/// A folder that no other run writes to. The system frees it when the process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    _folder: Option<File>,
}

/// Claims a folder for this process. Where the system cannot lock folders, nothing is claimed.
///
/// # Errors
/// When another process has claimed it.
pub fn lock(folder: &Path) -> Result<Lock, String> {
    let Ok(file) = File::open(folder) else { return Ok(Lock { _folder: None }) };
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(format!(
            "{}: another run writes to this folder; wait for it, or name another with --out",
            folder.display()
        )),
        _ => Ok(Lock { _folder: Some(file) }),
    }
}

/// Empties a folder of all results, so that none of an earlier run passes for one of this run.
///
/// # Errors
/// When its folders cannot be made.
pub fn clear(folder: &Path) -> Result<(), String> {
    clear_of(folder, &["report.html", "results.csv", "results.json"])
}

/// The same where results are these files beside the folders that all runs have.
///
/// # Errors
/// As [`clear`].
pub fn clear_of(folder: &Path, results: &[&str]) -> Result<(), String> {
    for name in results {
        let _ = std::fs::remove_file(folder.join(name));
    }
    for name in [IMAGES, FRAMES, ERRORS, CELLS, CHARTS] {
        let _ = std::fs::remove_dir_all(folder.join(name));
    }
    prepare(folder)
}

/// Makes the folders that are missing and removes half-written files of a run that was killed.
///
/// # Errors
/// When its folders cannot be made.
pub fn prepare(folder: &Path) -> Result<(), String> {
    for name in [IMAGES, CELLS] {
        let folder = folder.join(name);
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    let below = [IMAGES, FRAMES, ERRORS, CELLS, CHARTS].map(|name| folder.join(name));
    for folder in below.into_iter().chain([folder.to_owned()]) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            if is_temporary(&entry.file_name().to_string_lossy()) {
                let path = entry.path();
                let _ =
                    if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
            }
        }
    }
    Ok(())
}

/// The names that files bear until they are whole, and the scratch folders of encoders.
fn is_temporary(name: &str) -> bool {
    name.strip_prefix(".tmp").is_some_and(|rest| rest.len() == 6 && rest.chars().all(char::is_alphanumeric))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leftovers_go_and_everything_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        prepare(folder.path()).unwrap();
        let left = tempfile::Builder::new().tempdir_in(folder.path()).unwrap().keep();
        std::fs::write(left.join("volume.cvr"), "half").unwrap();
        let (_, file) = tempfile::NamedTempFile::new_in(folder.path().join(CELLS)).unwrap().keep().unwrap();
        for name in ["cells/a.json", ".tmp", ".tmpfiles", ".tmp-mine", "results.csv"] {
            std::fs::write(folder.path().join(name), "mine").unwrap();
        }
        prepare(folder.path()).unwrap();
        assert!(!left.exists() && !file.exists());
        for name in ["cells/a.json", ".tmp", ".tmpfiles", ".tmp-mine", "results.csv"] {
            assert!(folder.path().join(name).exists(), "{name}");
        }
        std::fs::create_dir(folder.path().join(CHARTS)).unwrap();
        std::fs::write(folder.path().join("charts/a.svg"), "drawn").unwrap();
        clear(folder.path()).unwrap();
        assert!(!folder.path().join(CHARTS).exists());
        assert!(!folder.path().join("cells/a.json").exists() && folder.path().join(CELLS).is_dir());
        assert!(!folder.path().join("results.csv").exists() && folder.path().join(".tmpfiles").exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_is_claimed_once() {
        let folder = tempfile::tempdir().unwrap();
        let first = lock(folder.path()).unwrap();
        assert!(lock(folder.path()).unwrap_err().contains("another run"));
        drop(first);
        assert!(lock(folder.path()).is_ok());
    }
}
