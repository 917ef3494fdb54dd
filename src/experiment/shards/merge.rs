//! Joining the results of several runs of one experiment: shards, or machines.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use crate::experiment::files::cell_file::{CellFile, hash};
use crate::experiment::files::flaws::Flaw;
use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::{CELLS, ERRORS, FRAMES, IMAGES, of_cell};
use crate::experiment::files::results::Results;
use crate::experiment::files::write_results::{write_csv, write_json};
use crate::experiment::identity::cell::{CellIdentity, in_words, of_record};
use crate::experiment::identity::experiment;
use crate::experiment::records::machine;
use crate::experiment::records::provenance::{Part, Provenance, ReferencePicture};
use crate::experiment::records::record::Status;

/// Why results are not merged.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", folder.display())]
pub struct MergeError {
    folder: PathBuf,
    problem: String,
}

fn refuse(folder: &Path, problem: impl ToString) -> MergeError {
    MergeError { folder: folder.to_owned(), problem: problem.to_string() }
}

/// The results in one folder.
#[derive(Debug)]
pub struct Source {
    folder: PathBuf,
    results: Results,
    cells: Vec<Entry>,
}

/// One record and its place.
#[derive(Clone, Debug)]
struct Entry {
    source: usize,
    /// Name of the cell's file, without its ending.
    stem: String,
    file: CellFile,
}

impl Source {
    /// Reads the results in a folder: the records that `results.json` lists, each from its cell's file.
    ///
    /// # Errors
    /// When the folder holds no results, or lacks the file of a cell.
    pub fn read(folder: &Path) -> Result<Self, MergeError> {
        // The error's message names the file, and so the folder.
        let results = Results::read(&folder.join("results.json")).map_err(|e| refuse(folder, e))?;
        let mut found = BTreeMap::new();
        let mut damaged = Vec::new();
        let mut paths: Vec<PathBuf> =
            std::fs::read_dir(folder.join(CELLS)).into_iter().flatten().flatten().map(|e| e.path()).collect();
        paths.sort();
        for path in paths {
            let Some(stem) = path.file_stem().map(|s| s.to_string_lossy().into_owned()) else { continue };
            match CellFile::read(&path) {
                Ok(file) => {
                    let name = (of_record(&file.record), file.record.device.clone());
                    found.insert(name, Entry { source: 0, stem, file });
                }
                Err(Flaw::Damaged) => damaged.push(format!("{CELLS}/{stem}.json")),
                Err(_) => {}
            }
        }
        let mut cells = Vec::new();
        for record in &results.records {
            let of = (of_record(record), record.device.clone());
            let missing = || {
                let hint = match damaged.first() {
                    Some(name) => format!("; {name} is not as it was written: run it again with --resume"),
                    None => String::new(),
                };
                refuse(folder, format!("{CELLS} lacks the file of cell {}{hint}", in_words(&of.0)))
            };
            cells.push(found.remove(&of).ok_or_else(missing)?);
        }
        Ok(Self { folder: folder.to_owned(), results, cells })
    }

    /// Number of records without a digest (those of version 0.1.0). It is unknown whether they were changed.
    #[must_use]
    pub fn unsealed(&self) -> usize {
        self.cells.iter().filter(|entry| !entry.file.sealed).count()
    }

    /// Origin of the records.
    #[must_use]
    pub const fn provenance(&self) -> &Provenance {
        &self.results.provenance
    }
}

/// Several results of one experiment, joined in memory.
#[derive(Debug)]
pub struct Merged {
    sources: Vec<Source>,
    entries: Vec<Entry>,
}

/// Joins results. Records are in `order`, followed by unknown ones. Of records with one cell and key, one is kept,
/// preferably one that did not fail. Records of several devices are all kept.
///
/// # Errors
/// When a folder holds another experiment, or a cell that has come out otherwise on the same device.
pub fn merge(mut sources: Vec<Source>, order: &[CellIdentity]) -> Result<Merged, MergeError> {
    for later in sources.iter().skip(1) {
        let first = sources[0].folder.display().to_string();
        if let Some(difference) = experiment::difference(later.provenance(), sources[0].provenance(), &first)
        {
            return Err(refuse(&later.folder, difference));
        }
    }
    let mut entries: Vec<Entry> = Vec::new();
    for (number, source) in sources.iter_mut().enumerate() {
        for mut entry in std::mem::take(&mut source.cells) {
            entry.source = number;
            let (own, device) = (of_record(&entry.file.record), &entry.file.record.device);
            let same = entries
                .iter()
                .position(|e| of_record(&e.file.record) == own && e.file.record.device == *device);
            match same {
                None => entries.push(entry),
                Some(at) if entry.file.key.is_some() && entries[at].file.key == entry.file.key => {
                    if entries[at].file.record.status == Status::Failed {
                        entries[at] = entry;
                    }
                }
                Some(_) => {
                    let problem = format!(
                        "cell {} stands in an earlier folder too, measured on the same device ({device}) with \
                         other software, processor, data or settings",
                        in_words(&own)
                    );
                    return Err(refuse(&source.folder, problem));
                }
            }
        }
    }
    let rank: BTreeMap<&CellIdentity, usize> = order.iter().enumerate().map(|(i, name)| (name, i)).collect();
    // Stable: cells of one name stay in the order of the folders.
    entries.sort_by_key(|e| rank.get(&of_record(&e.file.record)).copied().unwrap_or(usize::MAX));
    Ok(Merged { sources, entries })
}

impl Merged {
    /// Number of cells of `order` without a record in any folder.
    #[must_use]
    pub fn missing(&self, order: &[CellIdentity]) -> usize {
        let known: BTreeSet<CellIdentity> = self.entries.iter().map(|e| of_record(&e.file.record)).collect();
        order.iter().filter(|name| !known.contains(*name)).count()
    }

    /// Names of the cells in the merged folder.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let mut stems = BTreeSet::new();
        let mut name = |entry: &Entry| {
            let mut stem = entry.stem.clone();
            for number in 2.. {
                if stems.insert(stem.clone()) {
                    break;
                }
                stem = format!("{}-{number}", entry.stem);
            }
            stem
        };
        self.entries.iter().map(&mut name).collect()
    }

    /// Writes cells, pictures, `results.csv` and `results.json`. Old results are removed after all cells and pictures
    /// are written.
    ///
    /// # Errors
    /// When a picture is missing or has changed, or a file cannot be written.
    pub fn write(&self, out: &OutFolder) -> Result<Results, MergeError> {
        let mut records = Vec::new();
        let mut provenance = self.provenance();
        let mut copied = BTreeSet::new();
        for source in &self.sources {
            for reference in &source.results.provenance.references {
                if provenance.references.contains(reference) {
                    for path in reference.files().filter(|path| copied.insert((*path).to_owned())) {
                        copy(&source.folder, path, out, path, None)?;
                    }
                }
            }
        }
        for (entry, stem) in self.entries.iter().zip(self.names()) {
            let file = self.copy_cell(entry, &stem, out)?;
            file.write(out, &stem).map_err(|e| refuse(out.path(), e))?;
            records.push(file.record);
        }
        out.begin().map_err(|e| refuse(out.path(), e))?;
        let mut refused = Vec::new();
        for cell in self.sources.iter().flat_map(|s| &s.results.refused) {
            if !refused.contains(cell) {
                refused.push(cell.clone());
            }
        }
        provenance.command_line = machine::command_line();
        provenance.date = machine::date();
        write_csv(out, &records).map_err(|e| refuse(out.path(), e))?;
        write_json(out, &provenance, &records, &refused).map_err(|e| refuse(out.path(), e))?;
        Ok(Results { provenance, records, refused })
    }

    /// Copies the files of a cell, with the name `stem`.
    fn copy_cell(&self, entry: &Entry, stem: &str, out: &OutFolder) -> Result<CellFile, MergeError> {
        let folder = &self.sources[entry.source].folder;
        let Entry { file, .. } = entry;
        let mut record = file.record.clone();
        let named = [
            (&mut record.image, format!("{IMAGES}/{stem}.png")),
            (&mut record.error_image, format!("{IMAGES}/{stem}.error.png")),
            (&mut record.frame_figures, format!("{FRAMES}/{stem}.csv")),
            (&mut record.error_histogram, format!("{ERRORS}/{stem}.csv")),
        ];
        for (path, name) in named {
            if path.is_some() {
                *path = Some(name);
            }
        }
        let (own, renamed) = (of_cell(&file.record), of_cell(&record));
        for (path, target) in own.iter().zip(&renamed) {
            copy(folder, path, out, target, file.pictures.get(path))?;
        }
        let references = file.pictures.keys().filter(|path| !own.contains(path)).map(String::as_str);
        let mut copy = CellFile::new(record, file.key.clone(), &out.current(), references);
        // Nobody vouches for a record that carried no digest.
        copy.sealed = file.sealed;
        Ok(copy)
    }

    /// The joint provenance. Differences between the folders are listed side by side.
    #[must_use]
    pub fn provenance(&self) -> Provenance {
        let all: Vec<&Provenance> = self.sources.iter().map(Source::provenance).collect();
        let join = |field: fn(&Provenance) -> Option<&str>| {
            let mut distinct: Vec<&str> = Vec::new();
            for value in all.iter().filter_map(|p| field(p)) {
                if !distinct.contains(&value) {
                    distinct.push(value);
                }
            }
            distinct.join("; ")
        };
        let git_hash = join(|p| p.git_hash.as_deref());
        let mut references = Vec::new();
        for reference in all.iter().flat_map(|p| &p.references) {
            let known = |r: &ReferencePicture| {
                (&r.volume, &r.scene, &r.renderer)
                    == (&reference.volume, &reference.scene, &reference.renderer)
            };
            if !references.iter().any(known) {
                references.push(reference.clone());
            }
        }
        Provenance {
            version: join(|p| Some(&p.version)),
            git_hash: (!git_hash.is_empty()).then_some(git_hash),
            adapter: join(|p| Some(&p.adapter)),
            driver: join(|p| Some(&p.driver)),
            backend: join(|p| Some(&p.backend)),
            cpu: join(|p| Some(&p.cpu)),
            cores: all.iter().map(|p| p.cores).max().unwrap_or(0),
            references,
            parts: self.sources.iter().flat_map(parts).collect(),
            ..all.first().map(|p| (*p).clone()).unwrap_or_default()
        }
    }
}

/// A folder as a part, or the parts of a merged folder.
fn parts(source: &Source) -> Vec<Part> {
    let p = source.provenance().clone();
    if !p.parts.is_empty() {
        return p.parts;
    }
    let name = source.folder.canonicalize().unwrap_or_else(|_| source.folder.clone());
    vec![Part {
        folder: name.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        records: source.results.records.len() as u64,
        version: p.version,
        git_hash: p.git_hash,
        adapter: p.adapter,
        driver: p.driver,
        backend: p.backend,
        cpu: p.cpu,
        cores: p.cores,
        command_line: p.command_line,
        date: p.date,
    }]
}

/// Copies a picture completely, or not at all. Only paths inside the folder are read: a record is data, and must not
/// add other files to results that are passed on.
fn copy(
    folder: &Path,
    path: &str,
    out: &OutFolder,
    target: &str,
    blake3: Option<&String>,
) -> Result<(), MergeError> {
    let below = |path: &str| Path::new(path).components().all(|c| matches!(c, Component::Normal(_)));
    if !below(path) || !below(target) {
        return Err(refuse(folder, format!("{path} is no picture of this folder")));
    }
    let from = folder.join(path);
    if blake3.is_some_and(|known| hash(&from).is_some_and(|now| now != *known)) {
        return Err(refuse(folder, format!("{path} has changed since its cell was measured")));
    }
    let bytes = std::fs::read(&from).map_err(|e| refuse(folder, format!("{path}: {e}")))?;
    out.write(target, &bytes).map_err(|e| refuse(out.path(), e))
}
