//! `cvr run`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use cvr_core::memory;
use cvr_core::pipeline::{Capabilities, Cell, Experiment, Resolution, resolve};
use cvr_core::volume::BrickSource;

use super::check_config::print_refused;
use super::config_file::ConfigFile;
use super::memory_args::MemoryArgs;
use super::volume_args::RawArgs;
use crate::estimate::volume_layout;
use crate::exit::{BadInput, INTERRUPTED, SOME_FAILED};
use crate::experiment::files::folder::{Existing, OutFolder};
use crate::experiment::inputs::blank;
use crate::experiment::inputs::scenes::{check_frames, read_tables};
use crate::experiment::inputs::volumes::{LoadedVolume, load};
use crate::experiment::measured::pairs;
use crate::experiment::records::checked::not_run;
use crate::experiment::records::machine;
use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::{Record, Status};
use crate::experiment::running::interrupt;
use crate::experiment::running::outcome::Outcome;
use crate::experiment::running::run::Run;
use crate::experiment::shards::shard::Shard;
use crate::progress::CellBar;
use crate::registry::Names;
use crate::report;
use crate::site::target::Target;

const NOTES: &str = "\
Examples:
  cvr run configs/quickstart.toml
  CVR_DATA=folder cvr run configs/compare.toml --device cpu
  cvr run configs/compare.toml --volume head.nrrd --set scene.step_voxels=1.0 --out results/head
  cvr run configs/compare.toml --resume --shard 1/4

Every file in the folder is whole or not there, whenever a run ends. Ctrl-C stops after the running step, writes the
report of the finished cells and exits with 130. A second Ctrl-C stops at once. To continue, give the same command with
--resume.

The folder lists the files of a run in cvr-files.jsonl. Only these are ever replaced or removed. Results of the same
experiment (configuration, --set, seed and volumes; not the device) are replaced once the new run has its first cell,
and the run says so. Results of another experiment, a folder with cells that this run would not measure, and a folder
with other files are refused. --resume keeps what is there and adds to it. --overwrite removes the results and writes
beside other files. --out names another folder.

Shards that run at the same time need folders of their own; `cvr merge` joins them. Shards that run one after another
may share a folder with --resume, which never removes cells of other shards. A last run with --resume and without
--shard then writes the results of all.";

/// Arguments of `cvr run`.
#[derive(Debug, clap::Args)]
#[command(after_help = NOTES)]
pub struct Args {
    /// The configuration.
    config: PathBuf,
    /// Folder for records, pictures and report [default: results/NAME, with the name of the experiment].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Run on this volume instead of those of the configuration: a file of any format, a folder of slices, or a
    /// pattern like 'step*.raw' whose files are frames. If given several times, the frames follow each other. The volume is
    /// named after the stem of its first file; scenes that name volumes apply only if they name it.
    #[arg(long, value_name = "FILE")]
    volume: Vec<PathBuf>,
    /// Override a key, as scene.step_voxels=1.0, codec.s3dc.block=8 or pipeline.filter='["linear"]'.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// What draws: auto (the best adapter, or the CPU mirror if there is none), cpu, vulkan, gl
    /// (the best of that backend), a part of an adapter's name, or #N of `cvr devices`.
    #[arg(long, default_value = "auto", value_name = "auto|cpu|NAME")]
    device: String,
    /// Print the cells and the refused combinations, and run nothing.
    #[arg(long)]
    list_cells: bool,
    /// Keep the cells that an earlier run finished in the folder. Run only cells that are missing, failed, or have other
    /// data, settings, scenes, seed, device or software now. A record that was changed, or has no digest, is run
    /// again.
    #[arg(long)]
    resume: bool,
    /// Remove all results in the folder once the first new cell is there, and write beside other files. Only files that
    /// cvr has written there are ever removed or replaced.
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
    /// Run only the I-th of N shares of the cells, from 1/N to N/N. No two shares encode the same stream.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Run only the cell of this name, as --list-cells prints it, and load only its volume. May be given several times.
    /// The baseline of the frame times is added automatically.
    #[arg(long, value_name = "ID", conflicts_with = "shard")]
    cell: Vec<String>,
    /// Most decoded frames that are kept of each stream whose frames are predicted from others, in MB (10⁶ bytes), in place
    /// of what the configuration says.
    #[arg(
        long,
        value_name = "N",
        help_heading = "Memory",
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    decoded_frames_mb: Option<u32>,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    raw: RawArgs,
}

/// Runs an experiment.
///
/// # Errors
/// When configuration, volumes, device or folder are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    run_with(args, &Names::new()?)
}

/// As [`run`], with the codecs of a registry.
///
/// # Errors
/// As [`run`].
pub fn run_with(args: &Args, names: &Names) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    pairs::checked_budget()?;
    let ConfigFile { mut experiment, text } = ConfigFile::read(&args.config, &args.set, names)?;
    experiment.decoded_frames_mb = args.decoded_frames_mb.unwrap_or(experiment.decoded_frames_mb);
    if !args.volume.is_empty() {
        experiment.replace_volumes(vec![args.raw.volume(&args.volume)?])?;
        experiment.check_size()?;
    }
    let mut resolution = resolve(&experiment, &names.known(), &Capabilities::default());
    let no_cells = resolution.cells.is_empty();
    if let Some(shard) = args.shard {
        resolution.cells = shard.select(resolution.cells);
    }
    select(&mut resolution, &args.cell).map_err(BadInput)?;
    if args.list_cells {
        let ids: Vec<String> = resolution.cells.iter().map(Cell::id).collect();
        if !ids.is_empty() {
            say!("{}", ids.join("\n"));
        }
        print_refused(&resolution);
        return Ok(ExitCode::SUCCESS);
    }
    // A shard may be empty, if there are more shards than groups of cells.
    if no_cells {
        print_refused(&resolution);
        return Err(BadInput(format!("{}: no combination can run", args.config.display())));
    }
    let folder = args.out.clone().unwrap_or_else(|| Path::new("results").join(file_name(&experiment.name)));
    let target = Target::open(&args.device)?;
    announce(&target);
    // All volumes, so that the shards of one experiment agree. A single cell loads only its own.
    let needed = |name: &str| args.cell.is_empty() || resolution.cells.iter().any(|c| c.volume == name);
    let volumes = load_all(&experiment, needed)?;
    for volume in &volumes {
        check_frames(&experiment, &volume.name, volume.volume.layout().frames)?;
    }
    read_tables(&mut experiment)?;
    let warned = warn_of_blank_scenes(&experiment, &resolution, &volumes);
    // Only now: bad input leaves no empty folder behind.
    let provenance = provenance(args, &experiment, text, &volumes, &target);
    let cells = resolution.cells.iter().map(Cell::id);
    let claim = report::claim(&provenance, cells, true);
    let out =
        OutFolder::open(&folder, &claim, Existing::of(args.resume, args.overwrite)).map_err(BadInput)?;

    let stop: &AtomicBool = interrupt::listen();
    let start = Instant::now();
    let bar = CellBar::new(resolution.cells.len());
    let run = Run {
        experiment: &experiment,
        resolution: &resolution,
        volumes: &volumes,
        names,
        target: &target,
        reopen: &|| Target::open(&args.device).map_err(|e| e.to_string()),
        out: &out,
        stop,
        report: &|index, name| bar.cell(index, name),
    };
    let outcome = run.run(provenance.clone())?;
    bar.finish();
    if out.is_waiting() {
        eprintln!("interrupted before the first cell: {} is as it was", folder.display());
        return Ok(ExitCode::from(INTERRUPTED));
    }
    report::write(&out, &outcome.provenance, &outcome.records, &outcome.refused)?;
    if args.resume {
        let Outcome { taken_over, encodings, .. } = outcome;
        say!("{taken_over} of {} cells taken over; {encodings} encodings", resolution.cells.len());
    }
    let warnings = blank::warnings(&outcome.records);
    warnings.iter().filter(|text| !warned.contains(text)).for_each(|text| warn(text));
    summary(&folder, &outcome, &resolution, start);
    if outcome.missing > 0 {
        let command = machine::command_line();
        // A later command needs no `--overwrite`: the old results are gone.
        let command = command.replace(" --overwrite", "");
        let resume = if args.resume { "" } else { " --resume" };
        eprintln!("interrupted: {} cells are left; go on with: {command}{resume}", outcome.missing);
        return Ok(ExitCode::from(INTERRUPTED));
    }
    Ok(if outcome.failed() > 0 { ExitCode::from(SOME_FAILED) } else { ExitCode::SUCCESS })
}

/// Loads all volumes before the first cell: a missing file is bad input, not a failed cell.
fn load_all(experiment: &Experiment, needed: impl Fn(&str) -> bool) -> Result<Vec<LoadedVolume>, BadInput> {
    let needed: Vec<_> = experiment.volumes.iter().filter(|v| needed(&v.name)).collect();
    // The sum over all headers. A wrong header is reported when its file is read.
    let promised = needed.iter().filter_map(|v| volume_layout(v).ok().flatten());
    let bytes = promised.map(|layout| layout.bytes()).fold(0, u64::saturating_add);
    let what = || format!("{}: holding all volumes of the experiment", experiment.name);
    memory::check(bytes, what)?;
    Ok(needed.into_iter().map(|v| load(v, experiment.seed)).collect::<Result<_, _>>()?)
}

/// Warns of scenes that show nothing, before hours are spent on them. Returns the warnings.
fn warn_of_blank_scenes(
    experiment: &Experiment,
    resolution: &Resolution,
    volumes: &[LoadedVolume],
) -> Vec<String> {
    let mut warned = Vec::new();
    for LoadedVolume { name, volume, .. } in volumes {
        for scene in experiment.scenes_of(name) {
            let drawn = resolution.cells.iter().any(|c| c.volume == *name && c.scene == scene.name);
            let remark = blank::foreseen(scene, volume.layout().channels, volume.range());
            warned.extend(remark.filter(|_| drawn).map(|remark| blank::warning(&scene.name, name, &remark)));
        }
    }
    warned.iter().for_each(|text| warn(text));
    warned
}

fn warn(text: &str) {
    eprintln!("warning: {text}; its pictures are not judged");
}

/// Keeps only the cells of these names. Without names, all.
fn select(resolution: &mut Resolution, names: &[String]) -> Result<(), String> {
    for name in names {
        if resolution.cells.iter().any(|cell| cell.id() == *name) {
            continue;
        }
        let refusal = resolution.refused.iter().find(|refusal| refusal.cell.id() == *name);
        return Err(match refusal {
            Some(refusal) => format!("--cell {name}: cannot run: {}", refusal.reason),
            None => format!("--cell {name}: there is no such cell; --list-cells prints the names of all"),
        });
    }
    if !names.is_empty() {
        resolution.cells.retain(|cell| names.contains(&cell.id()));
        resolution.refused.clear();
    }
    Ok(())
}

/// Prints what draws, if it is not the expected device.
fn announce(target: &Target) {
    match target {
        Target::Cpu { reason: Some(reason) } => {
            eprintln!("The CPU mirror draws, since there is {reason}.");
            eprintln!("Pictures are those of a device with manual filtering; frame times are the CPU's.");
        }
        Target::Cpu { reason: None } => {}
        Target::Device(device) => eprintln!("drawing on {}", device.info()),
    }
}

fn provenance(
    args: &Args,
    experiment: &Experiment,
    config: String,
    volumes: &[LoadedVolume],
    target: &Target,
) -> Provenance {
    Provenance {
        experiment: experiment.name.clone(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        git_hash: machine::git_hash(),
        adapter: target.name(),
        driver: target.driver(),
        backend: target.backend(),
        cpu: machine::cpu(),
        cores: machine::cores(),
        volumes: volumes.iter().map(|v| v.provenance.clone()).collect(),
        seed: experiment.seed,
        config,
        overrides: args.set.clone(),
        command_line: machine::command_line(),
        date: machine::date(),
        baseline:
            "raw, native samples in a 3-D texture, filtered linearly by the texture unit (the CPU mirror: by \
                   hand); drawn in turn with each cell"
                .to_owned(),
        references: Vec::new(),
        parts: Vec::new(),
    }
}

fn summary(folder: &Path, outcome: &Outcome, resolution: &Resolution, start: Instant) {
    let failed = outcome.failed();
    for record in outcome.records.iter().filter(|r| r.status == Status::Failed) {
        let problem = record.error.as_deref().unwrap_or("no reason given");
        let Record { volume, codec, settings, site, filter, scene, .. } = record;
        eprintln!("failed: {volume} {codec} {settings} {site} {filter} {scene}: {problem}");
    }
    say!(
        "{} cells: {} ok, {failed} failed; {} combinations refused; {:.0} s",
        outcome.records.len(),
        outcome.records.len() - failed,
        resolution.refused.len(),
        start.elapsed().as_secs_f64()
    );
    if let Some(told) = not_run(&outcome.records) {
        eprintln!("{told}");
    }
    say!("report: {}", folder.join("report.html").display());
}

/// The name of an experiment, as a folder name.
fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let name: String = name.chars().map(safe).collect();
    let name = name.trim_start_matches('.');
    if name.is_empty() { "experiment".to_owned() } else { name.to_owned() }
}
