//! Whose a folder is while a process runs.

use std::fs::{File, TryLockError};
use std::path::Path;

/// A lock on a folder against other runs. The system frees it when the process ends in any way.
#[derive(Debug)]
pub struct Lock {
    _folder: Option<File>,
}

/// Claims a folder for this process. If the system cannot lock folders, nothing is claimed.
///
/// # Errors
/// When another process has claimed it.
pub fn lock(folder: &Path) -> Result<Lock, String> {
    let Ok(file) = File::open(folder) else { return Ok(Lock { _folder: None }) };
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(format!(
            "{}: another run writes to this folder; wait for it, or name another folder",
            folder.display()
        )),
        _ => Ok(Lock { _folder: Some(file) }),
    }
}

#[cfg(test)]
mod tests {
    #[cfg(unix)]
    #[test]
    fn a_folder_is_claimed_once() {
        use super::lock;
        let folder = tempfile::tempdir().unwrap();
        let first = lock(folder.path()).unwrap();
        assert!(lock(folder.path()).unwrap_err().contains("another run"));
        drop(first);
        assert!(lock(folder.path()).is_ok());
    }
}
