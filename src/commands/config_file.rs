//! A configuration from a file and `--set`.

use std::path::Path;

use cvr_core::pipeline::{Document, Experiment};

use crate::exit::BadInput;
use crate::registry::Names;

/// A configuration and its text.
pub struct ConfigFile {
    pub experiment: Experiment,
    pub text: String,
}

impl ConfigFile {
    /// Reads, overrides and checks.
    pub fn read(path: &Path, overrides: &[String], names: &Names) -> Result<Self, BadInput> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|e| BadInput(format!("{name}: {e}")))?;
        let mut document = Document::parse(&name, &text)?;
        for assignment in overrides {
            document.set(assignment)?;
        }
        let experiment = document.experiment(&names.known())?;
        for note in &experiment.notes {
            eprintln!("note: {note}");
        }
        Ok(Self { experiment, text })
    }
}
