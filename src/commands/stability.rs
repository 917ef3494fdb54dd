//! `cvr stability`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use cvr_core::stability::{Subject, Verdict};

use super::memory_args::MemoryArgs;
use crate::exit::{BadInput, INTERRUPTED, SOME_FAILED};
use crate::experiment::files::folder::{Existing, OutFolder};
use crate::experiment::records::machine;
use crate::experiment::running::interrupt;
use crate::progress::CellBar;
use crate::registry::codecs;
use crate::stability::atlas::Atlas;
use crate::stability::breaking::Breaking;
use crate::stability::claim::claim;
use crate::stability::config::Config;
use crate::stability::plan::Plan;
use crate::stability::report::{self, Provenance};
use crate::stability::runner::{Outcome, Run};
use crate::stability::scenes::Provocation;

const NOTES: &str = "\
Examples:
  cvr stability --quick
  cvr stability s3dc vq --output results/atlas
  cvr stability --output results/atlas --resume
  cvr stability --edge 32 --picture 48 --output results/atlas32
  cvr stability --config configs/stability.toml --list

Every codec, with its default settings and those of the configuration, is drawn on volumes and in scenes that are made to
break codecs. Each volume has a dial from easy to hard. docs/user/stability.md documents the rules of the verdicts. The
folder then holds atlas.html (heat map, curves, breaking points, the worst pictures), atlas.csv, breaking.csv,
encoders.csv and atlas.json.

Ctrl-C stops after the running cells, writes the finished ones and exits with 130; --resume continues. The exit code is 1
if a codec broke its own promise.";

/// Arguments of `cvr stability`.
#[derive(Debug, clap::Args)]
#[command(after_help = NOTES)]
pub struct Args {
    /// Codecs by id [default: all].
    #[arg(value_name = "CODEC")]
    codecs: Vec<String>,
    /// A coarser atlas: smaller volumes and pictures, fewer steps and scenes.
    #[arg(long)]
    quick: bool,
    /// Folder for tables and pictures [default: results/stability, with --quick results/stability-quick].
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Keep the cells that an earlier run measured in the folder with the same settings and software. Without this option
    /// an atlas with the same settings is replaced once the first new cell is there, if all its cells are measured
    /// again. Anything else is refused.
    #[arg(long)]
    resume: bool,
    /// Remove all results in the folder once the first new cell is there, and write beside other files. Only files that
    /// cvr has written there are ever removed or replaced.
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
    /// Sizes, scenes and further settings [default: the configuration that comes with the program].
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Longest axis of the volumes in voxels, 12 to 48; replaces that of the configuration.
    #[arg(long, value_name = "VOXELS")]
    edge: Option<u32>,
    /// Edge of the pictures in pixels, 16 to 96; replaces that of the configuration.
    #[arg(long, value_name = "PIXELS")]
    picture: Option<u32>,
    /// Print volumes, dials, scenes and codecs, and run nothing.
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// Runs the atlas.
///
/// # Errors
/// When configuration, codecs or folder are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    let config = match &args.config {
        Some(path) => Config::read(path),
        None => Config::own(),
    };
    let config = config.map_err(BadInput)?;
    let mut config = if args.quick { config.quick() } else { config };
    for note in &config.notes {
        eprintln!("note: {note}");
    }
    config.edge = args.edge.unwrap_or(config.edge);
    config.picture = args.picture.unwrap_or(config.picture);
    config.check().map_err(|e| BadInput(format!("--edge or --picture: {e}")))?;
    let plan = Plan::new(config, &codecs()?, &args.codecs).map_err(BadInput)?;
    if args.list {
        list(&plan);
        return Ok(ExitCode::SUCCESS);
    }
    let folder = args.output.clone().unwrap_or_else(|| {
        Path::new("results").join(if args.quick { "stability-quick" } else { "stability" })
    });
    let existing = Existing::of(args.resume, args.overwrite);
    let out = OutFolder::open(&folder, &claim(&plan), existing).map_err(BadInput)?;
    let start = Instant::now();
    let bar = CellBar::new(plan.cells() + plan.encoder_cells());
    let run =
        Run { plan: &plan, out: &out, stop: interrupt::listen(), report: &|done, name| bar.cell(done, name) };
    let outcome = run.run().map_err(BadInput)?;
    bar.finish();
    if out.is_waiting() {
        eprintln!("interrupted before the first cell: {} is as it was", folder.display());
        return Ok(ExitCode::from(INTERRUPTED));
    }
    let atlas = Atlas::of(&outcome.measured);
    let provenance = Provenance::now(&plan);
    atlas.write(&out, &provenance, &outcome.encoders)?;
    report::write(&out, &provenance, &plan, &atlas, &outcome).map_err(BadInput)?;
    Ok(summary(args, &folder, &atlas, &outcome, start))
}

fn list(plan: &Plan) {
    for dial in &plan.dials {
        let Subject { name, doc, dial: turns, .. } = dial.subject;
        let values: Vec<String> = dial.steps.iter().map(|s| dial.subject.steps[*s].to_string()).collect();
        say!("{name}  {doc}\n    {turns}: {}", values.join(", "));
    }
    say!("");
    for Provocation { name, doc, .. } in &plan.scenes {
        say!("{name}  {doc}");
    }
    say!("");
    for contestant in &plan.contestants {
        say!("{}", contestant.label);
    }
    say!("\n{} cells, {} measurements of encoders", plan.cells(), plan.encoder_cells());
}

fn summary(args: &Args, folder: &Path, atlas: &Atlas, outcome: &Outcome, start: Instant) -> ExitCode {
    for Breaking { label, subject, dial, fails_at, fails_in, fails_by, .. } in &atlas.breaking {
        if let (Some(at), Some(scene), Some(reason)) = (fails_at, fails_in, fails_by) {
            say!("{label}: {subject} breaks at {at} ({dial}), {scene}, {}", reason.name());
        }
    }
    let broken: Vec<_> = atlas.broken().collect();
    for row in &broken {
        let problem = row.problem.as_deref().unwrap_or("no reason given");
        eprintln!("broken promise: {} {} at {}: {problem}", row.label, row.subject, row.value);
    }
    for encoder in outcome.encoders.iter().filter(|e| e.problem.is_none() && !e.threads_agree) {
        eprintln!(
            "broken promise: {} {}: bytes depend on the number of threads",
            encoder.label, encoder.subject
        );
    }
    let count = |verdict| atlas.rows.iter().filter(|r| r.verdict == verdict).count();
    say!(
        "{} verdicts: {} hold, {} degrade, {} fail, {} refused; {:.0} s",
        atlas.rows.len(),
        count(Verdict::Holds),
        count(Verdict::Degrades),
        count(Verdict::Fails),
        count(Verdict::Refused),
        start.elapsed().as_secs_f64()
    );
    if args.resume {
        say!("{} cells taken over", outcome.taken_over);
    }
    say!("atlas: {}", folder.join("atlas.html").display());
    if outcome.missing > 0 {
        let command = machine::command_line();
        // A later command needs no `--overwrite`: the old results are gone.
        let command = command.replace(" --overwrite", "");
        let resume = if args.resume { "" } else { " --resume" };
        eprintln!("interrupted: {} cells are left; go on with: {command}{resume}", outcome.missing);
        return ExitCode::from(INTERRUPTED);
    }
    let threads = outcome.encoders.iter().any(|e| e.problem.is_none() && !e.threads_agree);
    if broken.is_empty() && !threads { ExitCode::SUCCESS } else { ExitCode::from(SOME_FAILED) }
}
