//! The command line: what there is to ask for.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::commands::{
    check_config, codecs, compare, convert, decode, devices, encode, explain, info, merge, presets, render,
    renderers, run, schema, shader, stability,
};
use crate::exit::{BAD_INPUT, BadInput};

/// A workbench for compressed volume rendering.
#[derive(Debug, Parser)]
#[command(name = "cvr", version, about, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  cvr run configs/quickstart.toml                       compare codecs on an embedded volume
  cvr run configs/compare.toml --volume head.nrrd       the same comparison on your own volume
  cvr run configs/compare.toml --resume                 continue a run that was stopped
  cvr explain configs/compare.toml                      what that would run, its time and memory
  cvr merge half1 half2 --out both                      join the results of two shards
  cvr compare before after                              compare two runs, with ties marked
  cvr encode head.nrrd head.cvr --codec s3dc --set block=8
  cvr info 'viscous/step*.raw' --dims 64x64x64 --dtype f32
  cvr convert head.nii.gz head.nrrd
  cvr render head.cvr head.png --azimuth 45 --transfer-function tissue --shading
  cvr stability --list                                  volumes and scenes that break codecs
  cvr codecs                                            the codecs and their settings

Exit codes: 0 success; 1 some cells failed (the report is written); 2 bad input; 130 stopped by Ctrl-C (the report of
the finished cells is written).";

#[derive(Debug, Subcommand)]
enum Command {
    /// Run an experiment and write its report.
    Run(run::Args),
    /// Join the results of shards, or of several machines, in one folder.
    Merge(merge::Args),
    /// Compare runs: ratios of the same cells on other machines or versions, with ties marked.
    Compare(compare::Args),
    /// Check a configuration: print what it would run, or what is wrong with it.
    CheckConfig(check_config::Args),
    /// Estimate what a configuration would run, its time and its memory, before anything runs.
    Explain(explain::Args),
    /// Print the JSON Schema of configurations, with which editors check and complete them.
    Schema(schema::Args),
    /// Draw codecs on volumes that are made to break them, and report where each breaks.
    Stability(stability::Args),
    /// Encode a volume.
    Encode(encode::Args),
    /// Decode an encoded volume to NRRD, NPY or headerless.
    Decode(decode::Args),
    /// Draw a volume or an encoded volume as PNG.
    Render(render::Args),
    /// Write a volume in another format: NRRD, NPY or headerless.
    Convert(convert::Args),
    /// Describe a volume or an encoded volume.
    Info(info::Args),
    /// List codecs and their settings.
    Codecs,
    /// List renderers and their settings.
    Renderers,
    /// List named transfer functions.
    Presets,
    /// List graphics adapters; fails if there is none.
    Devices(devices::Args),
    /// Print the WGSL that is generated for a codec, with the origin of every part.
    Shader(shader::Args),
}

/// Runs the command line of this process.
#[must_use]
pub fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Run(args) => run::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::CheckConfig(args) => check_config::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Stability(args) => stability::run(&args),
        Command::Encode(args) => encode::run(&args),
        Command::Decode(args) => decode::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Codecs => codecs::run(),
        Command::Renderers => Ok(renderers::run()),
        Command::Presets => Ok(presets::run()),
        Command::Devices(args) => devices::run(&args),
        Command::Shader(args) => shader::run(&args),
    };
    result.unwrap_or_else(|BadInput(message)| {
        let prefix = if message.starts_with("error:") { "" } else { "error: " };
        eprintln!("{prefix}{message}");
        ExitCode::from(BAD_INPUT)
    })
}
