//! `cvr devices`

use std::process::ExitCode;

use crate::exit::{BadInput, SOME_FAILED};

/// Arguments of `cvr devices`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// For scripts: one line per adapter, with fields separated by tabs: number, backend (vulkan, metal, dx12, gl), kind
    /// (discrete, integrated, virtual, cpu for a software adapter, other), name, driver.
    #[arg(long)]
    tsv: bool,
}

/// Lists adapters.
///
/// # Errors
/// Never. The exit code shows an empty list.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    let adapters = cvr_engine::list_adapters();
    for (i, adapter) in adapters.iter().enumerate() {
        if args.tsv {
            let driver = format!("{} {}", adapter.driver, adapter.driver_info);
            let fields = [adapter.backend.as_str(), adapter.kind.name(), &adapter.name, driver.trim()];
            say!("{i}\t{}", fields.map(|field| field.replace(['\t', '\n'], " ")).join("\t"));
        } else {
            say!("#{i}  {adapter}");
        }
    }
    if !args.tsv {
        say!("cpu  the CPU mirror, always there");
    }
    Ok(if adapters.is_empty() { ExitCode::from(SOME_FAILED) } else { ExitCode::SUCCESS })
}
