//! Tampered configurations: refused with a caret under the error, or resolved.

use std::path::PathBuf;

use cvr::registry::Names;
use cvr_core::pipeline::{Capabilities, Cell, Document, resolve};

use super::mutate::{Dice, campaign, text};

/// The configurations that come with the software.
fn configurations() -> Vec<String> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("configs");
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    paths.sort();
    let texts: Vec<String> = paths.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    // The configuration of the atlas has another form, which this reader would refuse as an error.
    texts.into_iter().filter(|text| text.contains("[experiment]")).collect()
}

#[test]
fn no_configuration_panics_or_is_refused_without_a_place() {
    let (configurations, names) = (configurations(), Names::new().unwrap());
    assert!(configurations.len() > 10);
    campaign("configurations", 4000, |mut dice: Dice| {
        let whole = dice.pick(&configurations).clone();
        let hostile = text(&mut dice, &whole);
        let read = Document::parse("c.toml", &hostile).map_err(|e| e.to_string());
        let read = read.and_then(|document| document.experiment(&names.known()).map_err(|e| e.to_string()));
        match read {
            Ok(experiment) => {
                let resolution = resolve(&experiment, &names.known(), &Capabilities::default());
                let ids: Vec<String> = resolution.cells.iter().map(Cell::id).collect();
                let unsafe_id = ids.iter().find(|id| id.contains(['/', '\0']) || id.starts_with('.'));
                unsafe_id.map_or(Ok(true), |id| Err(format!("{id:?} is no name of a file")))
            }
            Err(told) => {
                // A character without width has no caret under it, but a place.
                let has_place = told.contains("c.toml:") && (told.contains('^') || !hostile.is_ascii());
                let is_short = told.len() < 4000 + 2 * hostile.lines().map(str::len).max().unwrap_or(0);
                if has_place && is_short { Ok(false) } else { Err(told) }
            }
        }
    });
}
