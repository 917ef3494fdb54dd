//! Files of results are whole or not there.

use std::path::{Path, PathBuf};

use cvr_core::file;

/// Why a file of results could not be written or read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct ResultsError {
    path: PathBuf,
    problem: String,
}

impl ResultsError {
    /// A problem with a file or folder.
    #[must_use]
    pub fn new(path: &Path, problem: impl ToString) -> Self {
        Self { path: path.to_owned(), problem: problem.to_string() }
    }

    /// The same problem with another file.
    #[must_use]
    pub fn about(self, path: &Path) -> Self {
        Self { path: path.to_owned(), ..self }
    }
}

/// Writes a file that is whole or not there.
///
/// # Errors
/// When the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ResultsError> {
    file::write_whole(path, |file| file.write_all(bytes)).map_err(|e| ResultsError::new(path, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_written_is_named() {
        let error = write_whole(Path::new("no/such/folder/results.csv"), b"").unwrap_err();
        assert!(error.to_string().starts_with("no/such/folder/results.csv: "), "{error}");
    }
}
