//! `cvr-files.jsonl`: the list that marks a folder of results and names our files in it.
//!
//! The first line names the owner. Each further line is a file name relative to the folder, as a JSON string. A name is
//! appended and synced before its file appears. So if the process dies, every file of ours is listed. A name without a
//! file, or an incomplete last line, is harmless. Only listed files are ever removed.

use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Component, Path};

use crate::experiment::files::whole_file::{ResultsError, write_whole};
use crate::experiment::identity::owner::Owner;

/// Name of the list.
pub const MARKER: &str = "cvr-files.jsonl";

/// An owner and the names of files, each below the folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Marker {
    pub owner: Owner,
    pub names: BTreeSet<String>,
}

impl Marker {
    /// Reads the list of a folder. `None` if there is none. Names outside the folder are ignored, because a list is
    /// data.
    pub fn read(folder: &Path) -> Option<Self> {
        let bytes = std::fs::read(folder.join(MARKER)).ok()?;
        let text = String::from_utf8_lossy(&bytes);
        let mut lines = text.lines();
        let owner = serde_json::from_str(lines.next()?).ok()?;
        let names = lines.filter_map(|line| serde_json::from_str::<String>(line).ok());
        Some(Self { owner, names: names.filter(|name| is_below(name)).collect() })
    }

    /// Writes the whole list and replaces an older one.
    pub fn write(&self, folder: &Path) -> Result<(), ResultsError> {
        let path = folder.join(MARKER);
        let line = |value: Result<String, serde_json::Error>| value.map_err(|e| ResultsError::new(&path, e));
        let mut text = line(serde_json::to_string(&self.owner))? + "\n";
        for name in &self.names {
            text += &(line(serde_json::to_string(name))? + "\n");
        }
        write_whole(&path, text.as_bytes())
    }

    /// Enters names behind the others, on disk before this returns.
    pub fn append(&mut self, folder: &Path, names: &[&str]) -> Result<(), ResultsError> {
        let new: Vec<&str> = names.iter().copied().filter(|name| !self.names.contains(*name)).collect();
        if new.is_empty() {
            return Ok(());
        }
        let path = folder.join(MARKER);
        let fail = |e: std::io::Error| ResultsError::new(&path, e);
        let mut text = String::new();
        for name in &new {
            text += &(serde_json::to_string(name).map_err(|e| ResultsError::new(&path, e))? + "\n");
        }
        let mut file = OpenOptions::new().append(true).open(&path).map_err(fail)?;
        let before = file.metadata().map_err(fail)?.len();
        if let Err(e) = file.write_all(text.as_bytes()).and_then(|()| file.sync_data()) {
            // The next name must not be appended to half of this one.
            let _ = file.set_len(before);
            return Err(fail(e));
        }
        self.names.extend(new.into_iter().map(str::to_owned));
        Ok(())
    }
}

/// Whether a name stays below its folder.
pub fn is_below(name: &str) -> bool {
    let mut components = Path::new(name).components().peekable();
    components.peek().is_some() && components.all(|c| matches!(c, Component::Normal(_)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::identity::owner::Kind;

    fn marker() -> Marker {
        let owner = Owner { kind: Kind::Run, experiment: "a \"b\"\n".to_owned(), identity: "0".to_owned() };
        Marker { owner, names: ["images/a.png", "ü \"\n.csv"].map(str::to_owned).into() }
    }

    #[test]
    fn a_list_comes_back_whatever_cuts_it() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Marker::read(folder.path()), None);
        let mut marker = marker();
        marker.write(folder.path()).unwrap();
        marker.append(folder.path(), &["cells/a.json", "images/a.png"]).unwrap();
        assert_eq!(Marker::read(folder.path()).as_ref(), Some(&marker));
        assert_eq!(marker.names.len(), 3);
        let path = folder.path().join(MARKER);
        let whole = std::fs::read(&path).unwrap();
        let first = whole.iter().position(|b| *b == b'\n').unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let read = Marker::read(folder.path());
            assert_eq!(read.is_some(), length >= first, "{length}");
            assert!(read.is_none_or(|read| read.names.is_subset(&marker.names)), "{length}");
        }
    }

    #[test]
    fn no_name_leads_out_of_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let mut text = serde_json::to_string(&marker().owner).unwrap();
        for name in ["../a", "/etc/passwd", "a/../../b", ".", "", "a/b"] {
            text += &format!("\n{name:?}");
        }
        std::fs::write(folder.path().join(MARKER), text).unwrap();
        assert_eq!(Marker::read(folder.path()).unwrap().names, ["a/b".to_owned()].into());
    }
}
