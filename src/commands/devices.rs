//! `cvr devices`

use std::process::ExitCode;

use crate::exit::{BadInput, SOME_FAILED};

/// Lists adapters.
///
/// # Errors
/// Never; an empty list is told by the exit code.
pub fn run() -> Result<ExitCode, BadInput> {
    let adapters = cvr_engine::list_adapters();
    for (i, adapter) in adapters.iter().enumerate() {
        say!("#{i}  {adapter}");
    }
    say!("cpu  the CPU mirror, always there");
    Ok(if adapters.is_empty() { ExitCode::from(SOME_FAILED) } else { ExitCode::SUCCESS })
}
