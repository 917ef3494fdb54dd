//! The shipped configurations, read and resolved with the real codecs.

use cvr::registry::Names;
use cvr_core::pipeline::{Capabilities, Document, Experiment, Resolution, resolve};

/// The configuration of the documentation, word for word.
pub const COMPARE: &str = include_str!("../../docs/example.toml");

/// Reads and resolves a configuration. The error is the text that a user would see.
pub fn resolved(name: &str, text: &str) -> Result<(Experiment, Resolution), String> {
    let names = Names::new().unwrap();
    let document = Document::parse(name, text).map_err(|e| e.to_string())?;
    let experiment = document.experiment(&names.known()).map_err(|e| e.to_string())?;
    let resolution = resolve(&experiment, &names.known(), &Capabilities::default());
    Ok((experiment, resolution))
}

/// Not an experiment: the configuration of `cvr stability`.
pub const NO_EXPERIMENT: &str = "stability";

/// Name and text of every experiment in `configs/`, sorted.
fn configurations() -> Vec<(String, String)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let mut all: Vec<(String, String)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| {
            assert_eq!(path.extension().unwrap(), "toml", "{}: only configurations lie here", path.display());
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read_to_string(path).unwrap())
        })
        .filter(|(name, _)| name != NO_EXPERIMENT)
        .collect();
    all.sort();
    all
}

#[test]
fn every_configuration_resolves() {
    let mut counts = Vec::new();
    for (name, text) in configurations() {
        let (experiment, resolution) = resolved(&name, &text).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(experiment.name, name, "an experiment bears the name of its file");
        counts.push((name, resolution.cells.len(), resolution.refused.len()));
    }
    let expected = [
        ("bc4", 18, 6),
        ("compare", 60, 0),
        ("cost-growth", 80, 32),
        ("evaluate", 679, 329),
        ("hvq", 20, 16),
        ("peers", 174, 0),
        ("quickstart", 34, 11),
        ("renderers", 104, 40),
        ("ring", 18, 0),
        ("rvq-codebooks", 8, 0),
        ("rvq-paper", 8, 0),
        ("rvq-speed", 21, 0),
        ("rvq-training", 8, 0),
        ("s3dc-table1", 42, 0),
        ("skipping", 96, 0),
        ("training", 36, 0),
        ("tvq-classification", 8, 0),
        ("tvq-decode-speed", 16, 0),
        ("tvq-progressive", 32, 0),
        ("tvq-rate-distortion", 20, 0),
        ("volumes", 160, 8),
        ("vq", 24, 0),
        ("wavelet-coders", 105, 0),
        ("wavelet-filters", 56, 0),
        ("wavelet-quantiser-scale", 20, 0),
        ("zfp", 56, 24),
    ];
    assert_eq!(counts, expected.map(|(name, cells, refused)| (name.to_owned(), cells, refused)));
}

#[test]
fn the_quickstart_needs_no_file_and_says_why_combinations_are_refused() {
    let (_, text) = configurations().into_iter().find(|(name, _)| name == "quickstart").unwrap();
    let (experiment, resolution) = resolved("quickstart.toml", &text).unwrap();
    for volume in &experiment.volumes {
        cvr::experiment::inputs::volumes::load(volume, experiment.seed).unwrap();
    }
    let reasons: Vec<String> = resolution
        .refused
        .iter()
        .map(|r| format!("{} {} {}: {}", r.cell.codec, r.cell.site, r.cell.filter, r.reason))
        .collect();
    insta::assert_snapshot!(reasons.join("\n"));
}

#[test]
fn the_configuration_of_the_documentation_makes_28_cells() {
    let (experiment, resolution) = resolved("compare.toml", COMPARE).unwrap_or_else(|e| panic!("{e}"));
    // raw once, s3dc in 3 blocks × 2 widths; 2 sites × 2 filters.
    assert_eq!((resolution.cells.len(), resolution.refused.len()), (28, 0));
    assert_eq!((experiment.name.as_str(), experiment.seed), ("compare", 1));
    let blocks: Vec<String> =
        resolution.cells.iter().filter_map(|c| c.settings.get("block")).map(ToString::to_string).collect();
    assert!(blocks.contains(&"8x8x4".to_owned()), "{blocks:?}");
    let unique: std::collections::BTreeSet<String> =
        resolution.cells.iter().map(cvr_core::pipeline::Cell::id).collect();
    assert_eq!(unique.len(), 28, "each cell has a name of its own");
}

#[test]
fn a_configuration_with_one_wrong_letter_does_not_resolve() {
    for (right, wrong) in
        [("step_voxels", "step_voxel"), ("s3dc", "s3bc"), ("8x8x4", "8x8"), ("host", "hots")]
    {
        let error = resolved("x.toml", &COMPARE.replace(right, wrong)).unwrap_err();
        assert!(error.contains(wrong) && error.contains('^'), "{error}");
    }
}
