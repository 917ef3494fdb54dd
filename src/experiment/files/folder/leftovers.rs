//! Half-written files of killed processes in a folder of results. Their names are unique to them.

use std::path::Path;

use cvr_core::file::is_temporary;

/// Removes temporary files and folders in a folder and in those below that hold results.
pub fn remove(folder: &Path, below: &[&str]) {
    for place in below.iter().map(|name| folder.join(name)).chain([folder.to_owned()]) {
        for entry in std::fs::read_dir(place).into_iter().flatten().flatten() {
            if is_temporary(&entry.file_name().to_string_lossy()) {
                let path = entry.path();
                // A link is removed, not its target.
                let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
                let _ = if is_folder { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
            }
        }
    }
}
