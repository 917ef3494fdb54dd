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
  cvr run configs/compare.toml --resume                 go on where a run was stopped
  cvr explain configs/compare.toml                      what that would run, in what time and memory
  cvr merge half1 half2 --out both                      join what two shards have measured
  cvr compare before after                              lay two runs side by side, with ties where they are
  cvr encode head.nrrd head.cvr --codec s3dc --set block=8
  cvr info 'viscous/step*.raw' --dims 64x64x64 --dtype f32
  cvr convert head.nii.gz head.nrrd
  cvr render head.cvr head.png --azimuth 45 --transfer-function tissue --shading
  cvr stability --list                                  volumes and scenes that break codecs
  cvr codecs                                            what there is to choose from

Exit codes: 0 all went well; 1 some cells failed (the report is written); 2 bad input; 130 stopped by Ctrl-C (the
report of what was finished is written).";

#[derive(Debug, Subcommand)]
enum Command {
    /// Run an experiment and write its report.
    Run(run::Args),
    /// Join the results of shards, or of several machines, in one folder.
    Merge(merge::Args),
    /// Lay runs side by side: ratios of the same cells on other machines or versions, and what is a tie.
    Compare(compare::Args),
    /// Read a configuration and say what it would run, or what is wrong with it.
    CheckConfig(check_config::Args),
    /// Say before anything runs what a configuration would run, and about how long and in how much memory.
    Explain(explain::Args),
    /// Print what a configuration may hold: the JSON Schema by which editors check and complete it.
    Schema(schema::Args),
    /// Take codecs through volumes that provoke, and say where each of them breaks.
    Stability(stability::Args),
    /// Encode a volume.
    Encode(encode::Args),
    /// Decode an encoded volume to NRRD, NPY or headerless.
    Decode(decode::Args),
    /// Draw a volume or an encoded volume as PNG.
    Render(render::Args),
    /// Write a volume in another format: NRRD, NPY or headerless.
    Convert(convert::Args),
    /// Say what a volume or an encoded volume is.
    Info(info::Args),
    /// List codecs and their settings.
    Codecs,
    /// List renderers and their settings.
    Renderers,
    /// List named transfer functions.
    Presets,
    /// List graphics adapters; fails where there is none.
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
