//! Drawing a shipped configuration over another volume. Tests in the application check that all configurations resolve.

use super::*;
use crate::pipeline::{Capabilities, resolve};

fn config(path: &std::path::Path) -> Experiment {
    let text = std::fs::read_to_string(path).unwrap();
    let registry = registry();
    let document = Document::parse(&path.display().to_string(), &text).unwrap_or_else(|e| panic!("{e}"));
    document.experiment(&known(&registry)).unwrap_or_else(|e| panic!("{e}"))
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
