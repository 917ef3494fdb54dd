//! `cvr run`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use cvr_core::pipeline::{Capabilities, Experiment, Resolution, resolve};

use super::check_config::print_refused;
use super::config_file::ConfigFile;
use super::volume_args::RawArgs;
use crate::exit::{BadInput, SOME_FAILED};
use crate::experiment::machine;
use crate::experiment::provenance::Provenance;
use crate::experiment::record::{Record, Status};
use crate::experiment::runner::{Outcome, Run};
use crate::experiment::target::Target;
use crate::experiment::volumes::{LoadedVolume, load};
use crate::progress::CellBar;
use crate::registry::Names;
use crate::report;

/// Arguments of `cvr run`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The configuration.
    config: PathBuf,
    /// Folder for records, pictures and report; default results/<name of the experiment>.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Run on this volume instead of those of the configuration. Scenes that name volumes do not apply to it.
    #[arg(long, value_name = "FILE")]
    volume: Option<PathBuf>,
    /// Override a key, as scene.step_voxels=1.0, codec.s3dc.block=8 or pipeline.filter='["linear"]'.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// What draws: auto (the best adapter, or the CPU mirror where there is none), cpu, a part of an adapter's
    /// name, or #N of `cvr devices`.
    #[arg(long, default_value = "auto", value_name = "auto|cpu|NAME")]
    device: String,
    /// Print the cells and the refused combinations, and run nothing.
    #[arg(long)]
    list_cells: bool,
    #[command(flatten)]
    raw: RawArgs,
}

/// Runs an experiment.
///
/// # Errors
/// When configuration, volumes, device or folder are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    let names = Names::new()?;
    let ConfigFile { mut experiment, text } = ConfigFile::read(&args.config, &args.set, &names)?;
    if let Some(path) = &args.volume {
        experiment.replace_volumes(vec![args.raw.volume(path)?])?;
    }
    let resolution = resolve(&experiment, &names.known(), &Capabilities::default());
    if args.list_cells {
        for cell in &resolution.cells {
            say!("{}", cell.id());
        }
        print_refused(&resolution);
        return Ok(ExitCode::SUCCESS);
    }
    if resolution.cells.is_empty() {
        print_refused(&resolution);
        return Err(BadInput(format!("{}: no combination can run", args.config.display())));
    }
    let folder = args.out.clone().unwrap_or_else(|| Path::new("results").join(file_name(&experiment.name)));
    let target = Target::open(&args.device)?;
    announce(&target);
    let volumes = load_all(&experiment)?;
    // Only now: bad input leaves no empty folder behind.
    std::fs::create_dir_all(&folder).map_err(|e| BadInput(format!("{}: {e}", folder.display())))?;

    let start = Instant::now();
    let bar = CellBar::new(resolution.cells.len());
    let run = Run {
        experiment: &experiment,
        resolution: &resolution,
        volumes: &volumes,
        names: &names,
        target: &target,
        folder: &folder,
        report: &|index, name| bar.cell(index, name),
    };
    let outcome = run.run(provenance(&experiment, text, &volumes, &target))?;
    bar.finish();
    report::write(&folder, &outcome.provenance, &outcome.records, &outcome.refused)?;
    summary(&folder, &outcome, &resolution, start);
    Ok(if outcome.failed() > 0 { ExitCode::from(SOME_FAILED) } else { ExitCode::SUCCESS })
}

/// All volumes before the first cell: a missing file is bad input, not a failed cell.
fn load_all(experiment: &Experiment) -> Result<Vec<LoadedVolume>, BadInput> {
    Ok(experiment.volumes.iter().map(|v| load(v, experiment.seed)).collect::<Result<_, _>>()?)
}

/// Says what draws where it is not what one would expect.
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
        command_line: machine::command_line(),
        date: machine::date(),
        baseline:
            "raw, native samples in a 3-D texture, filtered linearly by the texture unit (the CPU mirror: by \
                   hand); drawn in turn with each cell"
                .to_owned(),
        references: Vec::new(),
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
    say!("report: {}", folder.join("report.html").display());
}

/// An experiment's name as that of a folder.
fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let name: String = name.chars().map(safe).collect();
    let name = name.trim_start_matches('.');
    if name.is_empty() { "experiment".to_owned() } else { name.to_owned() }
}
