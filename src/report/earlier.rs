//! Folders of results of version 0.1.0, which kept no list of its files. Their files are those that `results.json` and
//! the cells name.

use std::collections::BTreeSet;
use std::path::Path;

use super::{BJONTEGAARD, PAGE, beside, charts};
use crate::experiment::cell_file::{CELLS, CellFile};
use crate::experiment::files::of_cell;
use crate::experiment::folder::{Earlier, is_below};
use crate::experiment::identity;
use crate::experiment::provenance::ReferencePicture;
use crate::experiment::record::Record;
use crate::experiment::results::Results;

/// The files of a folder with results of such a version. `None` if there is no `results.json`.
#[must_use]
pub fn earlier(folder: &Path) -> Option<Earlier> {
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
    Some(Earlier { owner: identity::owner(&provenance), names })
}
