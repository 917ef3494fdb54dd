//! The folder of results: its owner, the files in it that are ours, and the handling of an earlier run's files.
//!
//! A list (`marker`) names every file of ours. Only listed files are replaced or removed. Results of an earlier run
//! stay until the new run has its first cell. Until then, new files are in a temporary folder next to them.

mod judge;
mod leftovers;
mod lock;
mod marker;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock};

use cvr_core::file;
use tempfile::TempDir;

pub use judge::{Claim, Earlier, Ways};
pub use lock::{Lock, lock};
pub use marker::{MARKER, is_below};

use super::names::{CELLS, CHARTS, ERRORS, FRAMES, IMAGES};
use super::whole_file::{ResultsError, write_whole};
use crate::experiment::identity::owner::Owner;
use judge::Verdict;
use marker::Marker;

/// Folders of results, below the given folder.
const BELOW: [&str; 5] = [IMAGES, FRAMES, ERRORS, CELLS, CHARTS];

/// What happens to existing results in a folder.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Results of the same experiment are replaced. Anything else is refused.
    Replace,
    /// They stay, and cells with unchanged inputs are taken over.
    Resume,
    /// Any results are removed, and files of others stay.
    Overwrite,
}

impl Existing {
    /// The meaning of the options `--resume` and `--overwrite`.
    #[must_use]
    pub const fn of(resume: bool, overwrite: bool) -> Self {
        match (resume, overwrite) {
            (true, _) => Self::Resume,
            (_, true) => Self::Overwrite,
            _ => Self::Replace,
        }
    }
}

/// A folder that this process writes results to.
#[derive(Debug)]
pub struct OutFolder {
    path: PathBuf,
    resumes: bool,
    marker: Mutex<Marker>,
    staged: RwLock<Option<Staged>>,
    _lock: Lock,
}

/// Results that do not stand in their place yet.
#[derive(Debug)]
struct Staged {
    folder: TempDir,
    names: Mutex<BTreeSet<String>>,
    owner: Owner,
}

impl OutFolder {
    /// Creates a folder, claims it for this process, and judges its content. Says in a line that results of an earlier
    /// run will be replaced. Removes only half-written files of killed runs.
    ///
    /// # Errors
    /// When it holds what must not be replaced, with the ways out; when another process writes to it; when it cannot be
    /// made.
    pub fn open(path: &Path, claim: &Claim<'_>, existing: Existing) -> Result<Self, String> {
        let fail = |e: std::io::Error| format!("{}: {e}", path.display());
        std::fs::create_dir_all(path).map_err(fail)?;
        let lock = lock(path)?;
        let owner = claim.owner.clone();
        // In a folder of others, a file that looks half-written may belong to a running process.
        let (names, replaces, sweeps) = match judge::judge(path, claim, existing)? {
            Verdict::Vacant { empty } => (BTreeSet::new(), false, empty),
            Verdict::Kept(names) => (names, false, true),
            Verdict::Replaced { names, line } => {
                if let Some(line) = line {
                    eprintln!("{line}");
                }
                (names, true, true)
            }
        };
        if sweeps {
            leftovers::remove(path, &BELOW);
        }
        let staged = if replaces {
            let folder = file::temporary_folder(path).map_err(fail)?;
            Some(Staged { folder, names: Mutex::default(), owner: owner.clone() })
        } else {
            None
        };
        // The old list stands until its results go.
        let owner = if replaces { Marker::read(path).map_or(owner, |m| m.owner) } else { owner };
        let marker = Marker { owner, names };
        let out = Self {
            path: path.to_owned(),
            resumes: existing == Existing::Resume,
            marker: Mutex::new(marker),
            staged: RwLock::new(staged),
            _lock: lock,
        };
        // Now, and not after the first cell.
        claim.lists.iter().try_for_each(|name| out.check(name)).map_err(|e| e.to_string())?;
        if !replaces {
            out.marker().write(path).map_err(|e| e.to_string())?;
        }
        Ok(out)
    }

    /// Claims a folder with any content. Listed files stay ours, all others stay foreign.
    ///
    /// # Errors
    /// When another process writes to it, or it cannot be made.
    pub fn adopt(path: &Path, owner: Owner) -> Result<Self, String> {
        std::fs::create_dir_all(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let lock = lock(path)?;
        let marker = Marker { owner, names: Marker::read(path).map(|m| m.names).unwrap_or_default() };
        marker.write(path).map_err(|e| e.to_string())?;
        let (marker, staged) = (Mutex::new(marker), RwLock::new(None));
        Ok(Self { path: path.to_owned(), resumes: false, marker, staged, _lock: lock })
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether finished cells of an earlier run are taken over.
    #[must_use]
    pub const fn resumes(&self) -> bool {
        self.resumes
    }

    /// Whether the folder still holds results of an earlier run and none of this one.
    #[must_use]
    pub fn is_waiting(&self) -> bool {
        self.staged.read().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// The folder with the written files.
    #[must_use]
    pub fn current(&self) -> PathBuf {
        let staged = self.staged.read().unwrap_or_else(PoisonError::into_inner);
        staged.as_ref().map_or_else(|| self.path.clone(), |staged| staged.folder.path().to_owned())
    }

    /// Writes a file completely, or not at all. `name` is relative to the folder, with `/` as separator.
    ///
    /// # Errors
    /// When it cannot be written, or a file of that name is none of ours.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        let staged = self.staged.read().unwrap_or_else(PoisonError::into_inner);
        self.check(name)?;
        let base = match &*staged {
            Some(staged) => {
                staged.names.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned());
                staged.folder.path()
            }
            None => {
                self.marker().append(&self.path, &[name])?;
                &self.path
            }
        };
        place(&base.join(name), |path| write_whole(path, bytes))
            // A temporary place is nobody's concern.
            .map_err(|e| e.about(&self.path.join(name)))
    }

    /// Enters files that are about to be written, all at once.
    ///
    /// # Errors
    /// When the list cannot be written, or a file of such a name is none of ours.
    pub fn announce(&self, names: &[&str]) -> Result<(), ResultsError> {
        let staged = self.staged.read().unwrap_or_else(PoisonError::into_inner);
        names.iter().try_for_each(|name| self.check(name))?;
        if staged.is_some() { Ok(()) } else { self.marker().append(&self.path, names) }
    }

    /// Replaces the results of an earlier run by this run's, and removes the old ones. Without old results, or when
    /// called again, nothing happens.
    ///
    /// # Errors
    /// When a file cannot be moved or the list not written.
    pub fn begin(&self) -> Result<(), ResultsError> {
        let mut waiting = self.staged.write().unwrap_or_else(PoisonError::into_inner);
        let Some(Staged { folder, names, owner }) = waiting.take() else { return Ok(()) };
        let names = names.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut marker = self.marker();
        let old = std::mem::take(&mut marker.names);
        // Wherever this ends, the list names all that is ours.
        *marker = Marker { owner, names: old.union(&names).cloned().collect() };
        marker.write(&self.path)?;
        // Files that list others go first, so that no record outlives its files.
        let (lists, files): (Vec<&String>, Vec<&String>) = old.iter().partition(|name| !name.contains('/'));
        let (cells, files): (Vec<&String>, Vec<&String>) =
            files.into_iter().partition(|name| name.starts_with(&format!("{CELLS}/")));
        for name in lists.into_iter().chain(cells).chain(files) {
            self.remove_file(name)?;
        }
        self.remove_empty_folders();
        marker.names.clone_from(&names);
        marker.write(&self.path)?;
        for name in &names {
            let staged = folder.path().join(name);
            // A file that was listed but could not be written does not exist.
            if staged.exists() {
                let path = self.path.join(name);
                place(&path, |path| std::fs::rename(&staged, path).map_err(|e| ResultsError::new(path, e)))?;
            }
        }
        Ok(())
    }

    /// Removes our files in a subfolder, except these.
    ///
    /// # Errors
    /// When one cannot be removed.
    pub fn keep_only(&self, below: &str, names: &[String]) -> Result<(), ResultsError> {
        let in_folder = |name: &&String| name.strip_prefix(below).is_some_and(|rest| rest.starts_with('/'));
        let listed: Vec<String> = self.marker().names.iter().filter(in_folder).cloned().collect();
        listed.iter().filter(|name| !names.contains(name)).try_for_each(|name| self.remove_file(name))
    }

    /// Refuses a name that a foreign file has.
    fn check(&self, name: &str) -> Result<(), ResultsError> {
        let path = self.path.join(name);
        if !is_below(name) {
            return Err(ResultsError::new(&path, "does not lie in the folder of the results"));
        }
        if !self.marker().names.contains(name) && path.symlink_metadata().is_ok() {
            let problem =
                "is there already, and no run of cvr has written it here: move it, or name another folder";
            return Err(ResultsError::new(&path, problem));
        }
        Ok(())
    }

    fn remove_file(&self, name: &str) -> Result<(), ResultsError> {
        let path = self.path.join(name);
        match std::fs::remove_file(&path) {
            // A folder with that name is not one of our files.
            Err(e) if e.kind() != std::io::ErrorKind::NotFound && !path.is_dir() => {
                Err(ResultsError::new(&path, e))
            }
            _ => Ok(()),
        }
    }

    /// Those that hold nothing any more.
    fn remove_empty_folders(&self) {
        for name in BELOW {
            let _ = std::fs::remove_dir(self.path.join(name));
        }
    }

    fn marker(&self) -> MutexGuard<'_, Marker> {
        self.marker.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether a file is one of the results that its folder, or the parent folder, lists.
#[must_use]
pub fn is_result(path: &Path) -> bool {
    let Ok(path) = path.canonicalize() else { return false };
    let listed = |folder: &Path| {
        let name = path.strip_prefix(folder).ok()?.to_str()?.replace(std::path::MAIN_SEPARATOR, "/");
        Marker::read(folder)?.names.contains(&name).then_some(())
    };
    path.ancestors().skip(1).take(2).any(|folder| listed(folder).is_some())
}

/// Creates the folder of a file, then the file.
fn place(path: &Path, make: impl FnOnce(&Path) -> Result<(), ResultsError>) -> Result<(), ResultsError> {
    let folder = file::folder_of(path);
    std::fs::create_dir_all(folder).map_err(|e| ResultsError::new(folder, e))?;
    make(path)
}
