//! `cvr check-config`

use std::path::PathBuf;
use std::process::ExitCode;

use cvr_core::pipeline::{Capabilities, Resolution, resolve};

use super::config_file::ConfigFile;
use crate::exit::BadInput;
use crate::experiment::inputs::preview::{Preview, preview};
use crate::registry::Names;

const EXAMPLES: &str = "\
Examples:
  cvr check-config configs/compare.toml
  cvr check-config configs/compare.toml --set codec.s3dc.block=[2,4] --set pipeline.site=inline

Scenes are compared with their data: a scene that shows nothing is a warning. Volumes of up to 32 million samples (64
million in all) are read; of larger ones only the number type is used. A volume that cannot be read here is not an error.

`cvr explain` prints the same in groups, with the volumes, and estimates time and memory. `cvr schema` lets an editor
check while you write.";

/// Arguments of `cvr check-config`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The configuration.
    config: PathBuf,
    /// Override a key, as scene.step_voxels=1.0 or codec.s3dc.block=8.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Checks a configuration.
///
/// # Errors
/// With a caret under what is wrong.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    let names = Names::new()?;
    let config = ConfigFile::read(&args.config, &args.set, &names)?;
    let resolution = resolve(&config.experiment, &names.known(), &Capabilities::default());
    say!("{}: {} cells", args.config.display(), resolution.cells.len());
    print_refused(&resolution);
    let Preview { warnings, unchecked } = preview(&config.experiment, &resolution);
    warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    unchecked.iter().for_each(|problem| eprintln!("not held against data: {problem}"));
    Ok(ExitCode::SUCCESS)
}

/// Prints the refused combinations with their reasons.
pub fn print_refused(resolution: &Resolution) {
    for refusal in &resolution.refused {
        say!("refused {}: {}", refusal.cell.id(), refusal.reason);
    }
}
