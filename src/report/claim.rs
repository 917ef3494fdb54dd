//! What an experiment wants of its folder, and what version 0.1.0 left there, which kept no list of its files: what its
//! `results.json`, and the cells beside it, name.

use std::collections::BTreeSet;
use std::path::Path;

use super::{BJONTEGAARD, PAGE, beside, charts};
use crate::experiment::files::cell_file::CellFile;
use crate::experiment::files::folder::{Claim, Earlier, Ways, is_below};
use crate::experiment::files::names::{CELLS, of_cell};
use crate::experiment::files::results::Results;
use crate::experiment::identity::experiment;
use crate::experiment::records::provenance::{Provenance, ReferencePicture};
use crate::experiment::records::record::Record;

/// What an experiment, run or merged, wants of the folder that the option `--out` names.
#[must_use]
pub fn claim(provenance: &Provenance, cells: impl IntoIterator<Item = String>, resume: bool) -> Claim<'_> {
    Claim {
        owner: experiment::owner(provenance),
        cells: cells.into_iter().collect(),
        lists: &["results.json", "results.csv", PAGE],
        provenance: Some(provenance),
        earlier,
        ways: Ways { out: "--out", resume },
    }
}

/// The files of a folder with results of such a version. `None` if there is no `results.json`.
fn earlier(folder: &Path) -> Option<Earlier> {
    let Results { provenance, records, .. } = Results::read(&folder.join("results.json")).ok()?;
    let mut names: BTreeSet<String> = ["results.json", "results.csv", PAGE].map(str::to_owned).into();
    names.extend(records.iter().flat_map(of_cell));
    names.extend(provenance.references.iter().flat_map(ReferencePicture::files).map(str::to_owned));
    for entry in std::fs::read_dir(folder.join(CELLS)).into_iter().flatten().flatten() {
        if let Ok(file) = CellFile::<Record>::read(&entry.path())
            && file.key.is_some()
        {
            names.insert(format!("{CELLS}/{}", entry.file_name().to_string_lossy()));
            names.extend(file.pictures.into_keys());
        }
    }
    // Charts have names that follow from the records.
    let figures = charts::figures(folder, &records, &provenance, &charts::Palette::new(&records));
    names.extend(beside::names(&figures, std::iter::once(BJONTEGAARD)));
    names.retain(|name| is_below(name));
    Some(Earlier { owner: experiment::owner(&provenance), names })
}
