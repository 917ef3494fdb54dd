//! `cvr renderers`

use std::process::ExitCode;

use super::codecs::settings;
use crate::registry::renderers;

/// Lists renderers and their settings.
#[must_use]
pub fn run() -> ExitCode {
    for renderer in renderers() {
        let info = renderer.info();
        say!("{}  {}", info.id, info.summary);
        settings(info.settings);
        say!("");
    }
    ExitCode::SUCCESS
}
