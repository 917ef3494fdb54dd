//! The folder of results: whose it is, which files in it are ours, and what becomes of those that an earlier run left.
//!
//! A list (`marker`) names every file of ours, and only these are ever replaced or removed. Results of an earlier run
//! stand until the new one has its first cell: until then its files lie in a temporary folder beside them.

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

/// Folders of results, below the one that is named.
const BELOW: [&str; 5] = [IMAGES, FRAMES, ERRORS, CELLS, CHARTS];

/// What is to become of results that a folder holds.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Those of the same experiment are replaced, all else is refused.
    Replace,
    /// They stay, and cells that are as they would come out are taken over.
    Resume,
    /// They are removed whatever they are of, and files of others stay beside the new ones.
    Overwrite,
}

impl Existing {
    /// What the options `--resume` and `--overwrite` ask for.
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
    /// Makes a folder, claims it for this process, and judges what lies in it. Says in a line that results of an earlier run
    /// are going to be replaced. Nothing is removed yet but what killed runs left half-written.
    ///
    /// # Errors
    /// When it holds what must not be replaced, with the ways out; when another process writes to it; when it cannot be
    /// made.
    pub fn open(path: &Path, claim: &Claim<'_>, existing: Existing) -> Result<Self, String> {
        let fail = |e: std::io::Error| format!("{}: {e}", path.display());
        std::fs::create_dir_all(path).map_err(fail)?;
        let lock = lock(path)?;
        let owner = claim.owner.clone();
        // In a folder of others, what looks half-written may be just being written by another process.
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

    /// Claims a folder as it is, whatever it holds: what its list names stays ours, and all else stays another's.
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

    /// Whether what an earlier run finished is taken over.
    #[must_use]
    pub const fn resumes(&self) -> bool {
        self.resumes
    }

    /// Whether results of an earlier run still stand in the folder, and none of this one.
    #[must_use]
    pub fn is_waiting(&self) -> bool {
        self.staged.read().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Where a file lies that was written, relative to the folder.
    #[must_use]
    pub fn current(&self) -> PathBuf {
        let staged = self.staged.read().unwrap_or_else(PoisonError::into_inner);
        staged.as_ref().map_or_else(|| self.path.clone(), |staged| staged.folder.path().to_owned())
    }

    /// Writes a file, whole or not at all. `name` is relative to the folder, with `/` between its parts.
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

    /// Results of this run take the place of those of an earlier one, which are removed. Without such, or once that is
    /// done, nothing happens.
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
        // First what lists others, so that no record outlives what it names.
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
            // What was entered and could not be written is not there.
            if staged.exists() {
                let path = self.path.join(name);
                place(&path, |path| std::fs::rename(&staged, path).map_err(|e| ResultsError::new(path, e)))?;
            }
        }
        Ok(())
    }

    /// Removes the files of ours in a folder below that are not among these.
    ///
    /// # Errors
    /// When one cannot be removed.
    pub fn keep_only(&self, below: &str, names: &[String]) -> Result<(), ResultsError> {
        let in_folder = |name: &&String| name.strip_prefix(below).is_some_and(|rest| rest.starts_with('/'));
        let listed: Vec<String> = self.marker().names.iter().filter(in_folder).cloned().collect();
        listed.iter().filter(|name| !names.contains(name)).try_for_each(|name| self.remove_file(name))
    }

    /// Refuses a name under which there is a file that is not ours.
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
            // A folder of that name is not what was written.
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

/// Whether a file is one of the results that its folder, or the folder above it, lists as its own.
#[must_use]
pub fn is_result(path: &Path) -> bool {
    let Ok(path) = path.canonicalize() else { return false };
    let listed = |folder: &Path| {
        let name = path.strip_prefix(folder).ok()?.to_str()?.replace(std::path::MAIN_SEPARATOR, "/");
        Marker::read(folder)?.names.contains(&name).then_some(())
    };
    path.ancestors().skip(1).take(2).any(|folder| listed(folder).is_some())
}

/// Makes the folder of a file, and then the file.
fn place(path: &Path, make: impl FnOnce(&Path) -> Result<(), ResultsError>) -> Result<(), ResultsError> {
    let folder = file::folder_of(path);
    std::fs::create_dir_all(folder).map_err(|e| ResultsError::new(folder, e))?;
    make(path)
}
