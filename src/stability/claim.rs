//! Whose a folder of an atlas is, and what version 0.1.0, which kept no list of its files, left in it.

use std::collections::BTreeSet;
use std::path::Path;

use cvr_core::stability::Subject;

use super::encoder::EncoderMeasured;
use super::measured::Measured;
use super::plan::Plan;
use super::report::worst_name;
use super::runner::{RESULTS, names};
use crate::experiment::files::cell_file::{CellFile, Keyed};
use crate::experiment::files::folder::{Claim, Earlier, Ways};
use crate::experiment::files::names::{CELLS, CHARTS};
use crate::experiment::identity::key::hash_of;
use crate::experiment::identity::owner::{Kind, Owner};

/// What an atlas wants of its folder: it is the same as another where configuration and sizes are; which codecs are
/// measured shows in its cells.
#[must_use]
pub fn claim(plan: &Plan) -> Claim<'static> {
    let identity = hash_of(&format!("{:?}", plan.config));
    Claim {
        owner: Owner { kind: Kind::Atlas, experiment: "stability".to_owned(), identity },
        cells: names(plan),
        lists: &RESULTS,
        provenance: None,
        earlier,
        ways: Ways { out: "--output", resume: true },
    }
}

/// An earlier atlas has no identity, so that it is never the same as another.
fn earlier(folder: &Path) -> Option<Earlier> {
    let atlas: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("atlas.json")).ok()?).ok()?;
    atlas.get("verdicts")?.as_array()?;
    atlas.get("provenance")?.get("version")?.as_str()?;
    let mut names: BTreeSet<String> = RESULTS.map(str::to_owned).into();
    names.insert(format!("{CHARTS}/heat-map.svg"));
    names.extend(
        Subject::all()
            .flat_map(|s| ["dial", "generations"].map(|kind| format!("{CHARTS}/{kind}-{}.svg", s.name))),
    );
    names.extend((1..=99).map(worst_name));
    for entry in std::fs::read_dir(folder.join(CELLS)).into_iter().flatten().flatten() {
        if is_cell::<Measured>(&entry.path()) || is_cell::<EncoderMeasured>(&entry.path()) {
            names.insert(format!("{CELLS}/{}", entry.file_name().to_string_lossy()));
        }
    }
    let owner = Owner { kind: Kind::Atlas, experiment: "stability".to_owned(), identity: String::new() };
    Some(Earlier { owner, names })
}

fn is_cell<R: Keyed>(path: &Path) -> bool {
    CellFile::<R>::read(path).is_ok_and(|file| file.key.is_some())
}
