//! `cvr codecs`

use std::process::ExitCode;

use cvr_core::codec::{Setting, Site};

use crate::exit::BadInput;
use crate::registry::codecs;

/// Lists codecs and their settings.
///
/// # Errors
/// When the list of codecs is wrong.
pub fn run() -> Result<ExitCode, BadInput> {
    for codec in codecs()?.iter() {
        let info = codec.info();
        say!("{}  {}", info.id, info.summary);
        if let Some(paper) = info.paper {
            say!("    {}: {}. {}.", paper.authors, paper.title, paper.venue);
        }
        let sites: Vec<&str> = info.offered().map(Site::name).collect();
        let cell = if info.fetch_cell { "; filter optimised-linear" } else { "" };
        say!("    sites: {}{cell}; stream version {}", sites.join(", "), info.stream_version);
        if !info.methods.is_empty() {
            say!("    curves of their own for: {}", info.methods.join(", "));
        }
        settings(info.settings);
        say!("");
    }
    Ok(ExitCode::SUCCESS)
}

/// Lists settings with their defaults and ranges.
pub(super) fn settings(schema: &[Setting]) {
    for setting in schema {
        say!("    {} = {}", setting.name, setting.default);
        say!("        {} ({})", setting.doc, setting.kind.describe());
    }
}
