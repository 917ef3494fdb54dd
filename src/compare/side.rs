//! One run on one device: a side of a comparison.

use std::path::{Path, PathBuf};

use super::identity::{Identity, scenes};
use crate::experiment::files::results::Results;
use crate::experiment::files::whole_file::ResultsError;
use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::Record;

/// The cells that one device ran, as one file of results has them.
#[derive(Clone, Debug)]
pub struct Side {
    /// The file.
    pub file: PathBuf,
    /// The device, and what else the provenance says of machine and software.
    pub machine: String,
    /// Version and commit of this software.
    pub software: String,
    /// When it was run.
    pub date: String,
    /// Cells with what defines them, in the order of the file.
    pub cells: Vec<(Identity, Record)>,
    /// Scenes are matched by their names alone.
    pub scenes_by_name: bool,
}

/// Reads results: files, or folders with a `results.json`. A file of several devices, as `cvr merge` writes, is one side
/// for each of them.
///
/// # Errors
/// When a file cannot be read, is none, or has no records.
pub fn read(paths: &[PathBuf]) -> Result<Vec<Side>, ResultsError> {
    let mut all = Vec::new();
    for path in paths {
        let file = if path.is_dir() { path.join("results.json") } else { path.clone() };
        let results = Results::read(&file)?;
        if results.records.is_empty() {
            return Err(ResultsError::new(&file, "no cell was run, so that there is nothing to compare"));
        }
        all.push((file, results));
    }
    let definitions: Option<Vec<_>> = all.iter().map(|(_, r)| scenes(&r.provenance)).collect();
    let mut sides = Vec::new();
    for (i, (file, results)) in all.iter().enumerate() {
        let Results { provenance, records, .. } = results;
        let scenes = definitions.as_ref().map(|d| &d[i]);
        let mut devices: Vec<&str> = Vec::new();
        for record in records {
            if !devices.contains(&record.device.as_str()) {
                devices.push(&record.device);
            }
        }
        for device in devices {
            let own = records.iter().filter(|r| r.device == device);
            let cells = own.map(|r| (Identity::of(r, provenance, scenes), r.clone())).collect();
            sides.push(Side::new(file, provenance, device, cells, scenes.is_none()));
        }
    }
    Ok(sides)
}

impl Side {
    fn new(
        file: &Path,
        p: &Provenance,
        device: &str,
        cells: Vec<(Identity, Record)>,
        scenes_by_name: bool,
    ) -> Self {
        // Of a merged folder, the run on this device.
        let part = p.parts.iter().find(|part| part.adapter == device && part.records > 0);
        let (version, git_hash, driver, cpu, cores, date) = part
            .map_or((&p.version, &p.git_hash, &p.driver, &p.cpu, p.cores, &p.date), |p| {
                (&p.version, &p.git_hash, &p.driver, &p.cpu, p.cores, &p.date)
            });
        let commit = git_hash.as_deref().map(|hash| format!(" ({hash})")).unwrap_or_default();
        let cores = format!("{cores} cores");
        let machine = [device, driver, cpu, &cores].into_iter().filter(|part| !part.is_empty());
        Self {
            file: file.to_owned(),
            machine: machine.collect::<Vec<_>>().join(", "),
            software: format!("cvr {version}{commit}"),
            date: date.clone(),
            cells,
            scenes_by_name,
        }
    }
}
