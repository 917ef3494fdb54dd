use super::*;
use crate::experiment::records::provenance::Provenance;

fn provenance(seed: u64) -> Provenance {
    Provenance { experiment: "e".to_owned(), seed, ..Provenance::default() }
}

fn open(
    path: &Path,
    provenance: &Provenance,
    cells: &[&str],
    existing: Existing,
) -> Result<OutFolder, String> {
    let claim = crate::report::claim(provenance, cells.iter().map(|c| (*c).to_owned()), true);
    OutFolder::open(path, &claim, existing)
}

fn names(path: &Path) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for folder in BELOW.iter().map(|below| path.join(below)).chain([path.to_owned()]) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten().filter(|e| e.path().is_file())
        {
            names.push(entry.path().strip_prefix(path).unwrap().to_str().unwrap().to_owned());
        }
    }
    names.sort();
    names
}

/// A folder in which an experiment has measured the cells `a` and `b`, beside files of others.
fn finished() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let out = open(folder.path(), &provenance(1), &["a", "b"], Existing::Replace).unwrap();
    for name in
        ["images/a.png", "cells/a.json", "cells/b.json", "results.json", "report.html", "charts/x.svg"]
    {
        out.write(name, b"old").unwrap();
    }
    for foreign in ["images/fig1.png", "cells/notes.json", "thesis.tex"] {
        std::fs::write(folder.path().join(foreign), "mine").unwrap();
    }
    folder
}

const FOREIGN: [&str; 3] = ["cells/notes.json", "images/fig1.png", "thesis.tex"];

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

#[test]
fn results_stand_until_there_is_a_cell_to_take_their_place() {
    let folder = finished();
    let before = names(folder.path());
    let out = open(folder.path(), &provenance(1), &["b", "a"], Existing::Replace).unwrap();
    out.write("images/a.png", b"new").unwrap();
    out.write("images/reference.png", b"new").unwrap();
    assert!(out.is_waiting() && out.current().join("images/reference.png").is_file());
    assert_eq!(
        (names(folder.path()), text(folder.path(), "images/a.png")),
        (before.clone(), "old".to_owned())
    );
    drop(out);
    assert_eq!(names(folder.path()), before, "a run that ends before its first cell leaves nothing");
    assert_eq!(
        std::fs::read_dir(folder.path())
            .unwrap()
            .flatten()
            .filter(|e| file::is_temporary(&e.file_name().to_string_lossy()))
            .count(),
        0
    );

    let out = open(folder.path(), &provenance(1), &["b", "a"], Existing::Replace).unwrap();
    out.write("images/a.png", b"new").unwrap();
    out.begin().unwrap();
    out.write("cells/a.json", b"new").unwrap();
    let mut expected = ["cells/a.json", "cvr-files.jsonl", "images/a.png"].map(str::to_owned).to_vec();
    expected.extend(FOREIGN.map(str::to_owned));
    expected.sort();
    assert_eq!(names(folder.path()), expected);
    assert_eq!(text(folder.path(), "images/a.png"), "new");
    assert!(!folder.path().join(CHARTS).exists(), "what is empty goes");
    assert_eq!(
        Marker::read(folder.path()).unwrap().names,
        ["cells/a.json", "images/a.png"].map(str::to_owned).into()
    );
}

#[test]
fn what_is_not_the_same_is_refused_and_left_as_it_was() {
    let folder = finished();
    let before = names(folder.path());
    let refused =
        |seed, cells: &[&str], existing| open(folder.path(), &provenance(seed), cells, existing).unwrap_err();
    let other = refused(2, &["a", "b"], Existing::Replace);
    assert!(other.contains("2 cell(s) of experiment `e`") && other.contains("it is not this one"), "{other}");
    assert!(["--resume", "--overwrite", "--out"].iter().all(|way| other.contains(way)), "{other}");
    let fewer = refused(1, &["a"], Existing::Replace);
    assert!(fewer.contains("1 of them would not be measured anew"), "{fewer}");
    assert_eq!(names(folder.path()), before);
    // The twins: the ways out.
    let resumed = open(folder.path(), &provenance(2), &["a"], Existing::Resume).unwrap();
    assert!(resumed.resumes() && !resumed.is_waiting());
    drop(resumed);
    assert_eq!(names(folder.path()), before);
    let over = open(folder.path(), &provenance(3), &["c"], Existing::Overwrite).unwrap();
    over.begin().unwrap();
    let mut left = FOREIGN.map(str::to_owned).to_vec();
    left.insert(1, MARKER.to_owned());
    assert_eq!(names(folder.path()), left);
}

#[test]
fn a_folder_of_others_is_written_to_on_request_alone_and_never_over_their_files() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join(IMAGES)).unwrap();
    std::fs::write(folder.path().join("images/fig1.png"), "mine").unwrap();
    for existing in [Existing::Replace, Existing::Resume] {
        let refused = open(folder.path(), &provenance(1), &["a"], existing).unwrap_err();
        assert!(refused.contains("(images)") && refused.contains("--overwrite"), "{refused}");
    }
    let out = open(folder.path(), &provenance(1), &["a"], Existing::Overwrite).unwrap();
    let refused = out.write("images/fig1.png", b"new").unwrap_err().to_string();
    assert!(refused.contains("fig1.png: is there already"), "{refused}");
    assert!(out.write("../outside", b"new").is_err());
    out.write("images/a.png", b"new").unwrap();
    out.keep_only(IMAGES, &[]).unwrap();
    assert_eq!(names(folder.path()), [MARKER, "images/fig1.png"]);
    drop(out);
    std::fs::write(folder.path().join("report.html"), "mine").unwrap();
    let refused = open(folder.path(), &provenance(1), &["a"], Existing::Overwrite).unwrap_err();
    assert!(refused.contains("report.html: is there already"), "{refused}");
    assert_eq!(text(folder.path(), "report.html"), "mine");
}

#[test]
fn leftovers_of_ours_go_and_everything_else_stays() {
    let folder = finished();
    let left = file::temporary_folder(folder.path()).unwrap().keep();
    std::fs::write(left.join("volume.cvr"), "half").unwrap();
    let half = folder.path().join(CELLS).join(".cvr-ab12cd.part");
    std::fs::write(&half, "half").unwrap();
    let others = [".tmpAb12cD", "cells/.tmpAb12cD", ".cvr-mine", ".cvr-ab12cd"];
    for name in others {
        std::fs::write(folder.path().join(name), "mine").unwrap();
    }
    drop(open(folder.path(), &provenance(1), &["a", "b"], Existing::Resume).unwrap());
    assert!(!left.exists() && !half.exists());
    assert!(others.iter().all(|name| folder.path().join(name).exists()));
}

#[test]
fn a_file_of_results_is_known_as_one() {
    let folder = finished();
    for (name, is) in [
        ("report.html", true),
        ("images/a.png", true),
        ("thesis.tex", false),
        ("images/fig1.png", false),
        ("none", false),
    ] {
        assert_eq!(is_result(&folder.path().join(name)), is, "{name}");
    }
}
