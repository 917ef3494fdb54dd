//! Every file in `configs/` reads and resolves.

use super::*;
use crate::pipeline::{Capabilities, resolve};

fn config(path: &std::path::Path) -> Experiment {
    let text = std::fs::read_to_string(path).unwrap();
    let registry = registry();
    let document = Document::parse(&path.display().to_string(), &text).unwrap_or_else(|e| panic!("{e}"));
    document.experiment(&known(&registry)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn every_config_reads_and_resolves() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs");
    let mut counts = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let experiment = config(&path);
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        assert_eq!(experiment.name, stem, "an experiment bears the name of its file");
        let registry = registry();
        let resolution = resolve(&experiment, &known(&registry), &Capabilities::default());
        assert!(!resolution.cells.is_empty());
        counts.push((stem, resolution.cells.len(), resolution.refused.len()));
    }
    counts.sort();
    insta::assert_debug_snapshot!(counts, @r#"
    [
        (
            "compare",
            60,
            0,
        ),
        (
            "quickstart",
            34,
            11,
        ),
        (
            "skipping",
            96,
            0,
        ),
    ]
    "#);
}

#[test]
fn compare_draws_any_other_volume() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/compare.toml");
    let mut experiment = config(&path);
    let mut other = experiment.volumes[0].clone();
    other.name = "mine".to_owned();
    experiment.replace_volumes(vec![other]).unwrap();
    let registry = registry();
    let resolution = resolve(&experiment, &known(&registry), &Capabilities::default());
    assert_eq!(resolution.cells.len(), 20);
    assert!(resolution.cells.iter().all(|cell| cell.scene == "any"));
}
