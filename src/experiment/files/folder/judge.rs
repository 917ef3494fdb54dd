//! The content of a folder before a run, and whether it may be removed.

use std::collections::BTreeSet;
use std::path::Path;

use cvr_core::file::is_temporary;

use super::marker::Marker;
use super::{BELOW, Existing};
use crate::experiment::files::names::{CELLS, IMAGES};
use crate::experiment::files::results::Results;
use crate::experiment::identity::experiment;
use crate::experiment::identity::owner::{Kind, Owner};
use crate::experiment::records::provenance::Provenance;

/// Files that are named in a refusal.
const NAMED: usize = 3;

/// The requirements of a run on its folder.
#[derive(Debug)]
pub struct Claim<'a> {
    /// Whose results they will be.
    pub owner: Owner,
    /// Names of the cells that the run makes.
    pub cells: BTreeSet<String>,
    /// Files that it writes beside the folders for cells.
    pub lists: &'static [&'static str],
    /// Their origin. `None` for an atlas.
    pub provenance: Option<&'a Provenance>,
    /// Finds the files of version 0.1.0, which kept no list.
    pub earlier: fn(&Path) -> Option<Earlier>,
    /// Options of the command, for advice in errors.
    pub ways: Ways,
}

/// The options of a command.
#[derive(Copy, Clone, Debug)]
pub struct Ways {
    /// That which names another folder.
    pub out: &'static str,
    /// Whether there is `--resume`.
    pub resume: bool,
}

/// Results of a version without a list.
#[derive(Clone, Debug)]
pub struct Earlier {
    /// Whose they are.
    pub owner: Owner,
    /// The files that they name.
    pub names: BTreeSet<String>,
}

/// What may be done.
pub(super) enum Verdict {
    /// The folder has no files of ours. It has files of others only if they may stay.
    Vacant { empty: bool },
    /// These files are ours, and stay.
    Kept(BTreeSet<String>),
    /// These files are ours and are removed once there are new results. A line says so if it matters.
    Replaced { names: BTreeSet<String>, line: Option<String> },
}

/// Judges a folder.
///
/// # Errors
/// A sentence with the ways out, where it holds what must not go.
pub(super) fn judge(path: &Path, claim: &Claim<'_>, existing: Existing) -> Result<Verdict, String> {
    let known = Marker::read(path).map(|Marker { owner, names }| Earlier { owner, names });
    let earlier = || {
        let Earlier { owner, mut names } = (claim.earlier)(path)?;
        names.extend(of_cells(path, &claim.cells));
        Some(Earlier { owner, names })
    };
    let Some(Earlier { owner, mut names }) = known.or_else(earlier) else {
        let foreign = foreign(path);
        if foreign.is_empty() || existing == Existing::Overwrite {
            return Ok(Verdict::Vacant { empty: foreign.is_empty() });
        }
        let shown = foreign.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = if foreign.len() > NAMED {
            format!(" and {} more", foreign.len() - NAMED)
        } else {
            String::new()
        };
        return Err(format!(
            "{}: holds files that cvr has not written there ({shown}{more}); name another folder with {}, or write \
             beside them with --overwrite, which removes none of them",
            path.display(),
            claim.ways.out
        ));
    };
    names.retain(|name| path.join(name).symlink_metadata().is_ok());
    let cells = cells(&names);
    let is_lists = |name: &String| !name.contains('/');
    if existing == Existing::Resume {
        if owner.kind != claim.owner.kind && !cells.is_empty() {
            return Err(refusal(path, claim, &owner, &cells, "there is nothing to take over"));
        }
        return Ok(Verdict::Kept(names));
    }
    // A run that ended before its first cell has left nothing of value.
    if cells.is_empty() && !names.iter().any(is_lists) {
        return Ok(Verdict::Replaced { names, line: None });
    }
    let many = format!("{} cell(s)", cells.len());
    if existing == Existing::Overwrite {
        let line = format!(
            "{}: the results of {} ({many}) are removed once the first new cell is there",
            path.display(),
            named(&owner)
        );
        return Ok(Verdict::Replaced { names, line: Some(line) });
    }
    if owner.kind != claim.owner.kind {
        return Err(refusal(path, claim, &owner, &cells, "these are other results"));
    }
    if owner.identity != claim.owner.identity {
        let found = || Results::read(&path.join("results.json")).ok().map(|r| r.provenance);
        let reason = claim.provenance.and_then(|own| experiment::difference(&found()?, own, "this run"));
        let reason = reason.unwrap_or_else(|| "it is not this one".to_owned());
        return Err(refusal(path, claim, &owner, &cells, &reason));
    }
    let others = cells.iter().filter(|cell| !claim.cells.contains(**cell)).count();
    if others > 0 {
        let reason = format!("{others} of them would not be measured anew");
        return Err(refusal(path, claim, &owner, &cells, &reason));
    }
    let line = format!(
        "{}: the results of an earlier run of {} ({many}) are replaced once the first new cell is there",
        path.display(),
        named(&owner)
    );
    Ok(Verdict::Replaced { names, line: Some(line) })
}

fn named(owner: &Owner) -> String {
    match owner.kind {
        Kind::Run => format!("experiment `{}`", owner.experiment),
        Kind::Atlas => "the stability atlas".to_owned(),
    }
}

fn refusal(path: &Path, claim: &Claim<'_>, owner: &Owner, cells: &[&str], reason: &str) -> String {
    let resume = match claim.ways.resume && owner.kind == claim.owner.kind {
        true => "keep them and add to them with --resume, ",
        false => "",
    };
    format!(
        "{}: holds {} cell(s) of {}, and {reason}; {resume}remove them with --overwrite, or name another folder with {}",
        path.display(),
        cells.len(),
        named(owner),
        claim.ways.out
    )
}

/// Files of these cells, and reference pictures, in a folder of version 0.1.0: files that it was about to list when it
/// was killed.
fn of_cells(path: &Path, cells: &BTreeSet<String>) -> Vec<String> {
    let is_of_cell = |name: &str| name.match_indices('.').any(|(at, _)| cells.contains(&name[..at]));
    let mut found = Vec::new();
    for below in BELOW {
        for entry in std::fs::read_dir(path.join(below)).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if is_of_cell(&name) || below == IMAGES && name.starts_with("reference-") {
                found.push(format!("{below}/{name}"));
            }
        }
    }
    found
}

/// The cells among names of files.
fn cells(names: &BTreeSet<String>) -> Vec<&str> {
    let stem = |name: &'_ String| -> Option<(usize, usize)> {
        let rest = name.strip_prefix(CELLS)?.strip_prefix('/')?.strip_suffix(".json")?;
        Some((CELLS.len() + 1, rest.len()))
    };
    names.iter().filter_map(|name| stem(name).map(|(at, length)| &name[at..at + length])).collect()
}

/// The content of a folder, except half-written files of killed runs and the empty folders that such runs made.
fn foreign(path: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let is_empty =
        |name: &str| std::fs::read_dir(path.join(name)).is_ok_and(|mut below| below.next().is_none());
    let mut names: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| !(is_temporary(name) || BELOW.contains(&name.as_str()) && is_empty(name)))
        .collect();
    names.sort();
    names
}
