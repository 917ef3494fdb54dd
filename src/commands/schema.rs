//! `cvr schema`

use std::path::PathBuf;
use std::process::ExitCode;

use cvr_core::file::write_whole;
use cvr_core::pipeline::{json_schema, markdown};

use super::output::Output;
use crate::exit::BadInput;
use crate::registry::Names;

const EXAMPLES: &str = "\
Examples:
  cvr schema --out experiment.schema.json               for editors
  cvr schema --markdown                                 for people

An editor with the language server taplo (VS Code: Even Better TOML) checks, completes and explains a configuration
whose first line names the schema, as a path relative to the file or as a URL:

  #:schema experiment.schema.json";

/// Arguments of `cvr schema`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Write it to this file instead of printing it.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print a page of Markdown instead, with a row for each key.
    #[arg(long)]
    markdown: bool,
}

/// Prints or writes the schema of configurations, with the codecs and renderers of this build.
///
/// # Errors
/// When the file cannot be written.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    let names = Names::new()?;
    let text = if args.markdown { markdown(&names.known()) } else { json_schema(&names.known()) };
    let format = if args.markdown { Output::Markdown } else { Output::Json };
    if let Some(file) = &args.out {
        Output::of(file, &[format])?;
    }
    match &args.out {
        Some(file) => write_whole(file, |f| f.write_all(text.as_bytes()))
            .map_err(|e: std::io::Error| BadInput(format!("{}: {e}", file.display())))?,
        None => say!("{}", text.trim_end()),
    }
    Ok(ExitCode::SUCCESS)
}
