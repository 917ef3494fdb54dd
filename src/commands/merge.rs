//! `cvr merge`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cvr_core::pipeline::{Capabilities, Document, Experiment, FilePath, Volume, VolumeSource, resolve};

use crate::exit::{BadInput, SOME_FAILED};
use crate::experiment::files::folder::{Existing, OutFolder};
use crate::experiment::identity::cell::{CellIdentity, of_cell};
use crate::experiment::inputs::blank;
use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::Status;
use crate::experiment::shards::merge::{Source, merge};
use crate::registry::Names;
use crate::report;

/// Arguments of `cvr merge`.
#[derive(Debug, clap::Args)]
#[command(after_help = NOTES)]
pub struct Args {
    /// Folders that `cvr run` or `cvr merge` wrote, all of one experiment.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Folder for the joined results. Results of the same experiment in it are replaced if all their cells are among the
    /// joined ones. Anything else is refused.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Remove all results in the folder, and write beside other files. Only files that cvr has written there are ever
    /// removed or replaced.
    #[arg(long)]
    overwrite: bool,
}

const NOTES: &str = "\
Examples:
  cvr merge results/shard-1 results/shard-2 --out results/all

Configuration, --set, seed and volumes must agree. A cell in several folders is kept once if everything that determines
it is equal, and once per device if it ran on several. Other duplicates are refused. Resume a stopped shard first: cells
that no folder holds are missing from the result, and their number is printed. A record that was changed is refused.
Records of version 0.1.0 have no digest and are accepted as they are.";

/// Merges results.
///
/// # Errors
/// When a folder holds no results, or those of another experiment.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    let out = &args.out;
    for folder in &args.folders {
        let is_out = |out: PathBuf| folder.canonicalize().is_ok_and(|folder| folder == out);
        if out.canonicalize().is_ok_and(is_out) {
            return Err(BadInput(format!(
                "{}: is merged itself; name another folder with --out",
                out.display()
            )));
        }
    }
    let sources: Vec<Source> = args.folders.iter().map(|f| Source::read(f)).collect::<Result<_, _>>()?;
    for (folder, source) in args.folders.iter().zip(&sources).filter(|(_, source)| source.unsealed() > 0) {
        eprintln!(
            "{}: {} record(s) carry no digest, as those of version 0.1.0, and are taken as they are; `cvr run` with \
             --resume measures them anew",
            folder.display(),
            source.unsealed()
        );
    }
    let order = order(sources[0].provenance());
    let merged = merge(sources, &order.clone().unwrap_or_default())?;

    // Only now: bad input leaves the folder as it was.
    let provenance = merged.provenance();
    let claim = report::claim(&provenance, merged.names(), false);
    let folder = OutFolder::open(out, &claim, Existing::of(false, args.overwrite)).map_err(BadInput)?;
    let results = merged.write(&folder)?;
    report::write(&folder, &results.provenance, &results.records, &results.refused)?;

    let failed = results.records.iter().filter(|r| r.status == Status::Failed).count();
    let (all, folders) = (results.records.len(), args.folders.len());
    say!("{all} cells of {folders} folders: {} ok, {failed} failed", all - failed);
    if let Some(order) = order {
        match merged.missing(&order) {
            0 => {}
            missing => eprintln!("{missing} of {} cells of the experiment are in no folder", order.len()),
        }
    }
    for warning in blank::warnings(&results.records) {
        eprintln!("warning: {warning}; its pictures are not judged");
    }
    say!("report: {}", out.join("report.html").display());
    Ok(if failed > 0 { ExitCode::from(SOME_FAILED) } else { ExitCode::SUCCESS })
}

/// The cells of an experiment in order, if this version can read its configuration.
fn order(provenance: &Provenance) -> Option<Vec<CellIdentity>> {
    let names = Names::new().ok()?;
    let mut document = Document::parse("the results' configuration", &provenance.config).ok()?;
    for assignment in &provenance.overrides {
        document.set(assignment).ok()?;
    }
    let mut experiment: Experiment = document.experiment(&names.known()).ok()?;
    let known = provenance.volumes.iter().map(|v| v.name.as_str());
    if !known.eq(experiment.volumes.iter().map(|v| v.name.as_str())) {
        // `--volume`: only the names matter here.
        let volume = |name: &str| Some(Volume { name: name.to_owned(), source: file(name)? });
        let volumes = provenance.volumes.iter().map(|v| volume(&v.name)).collect::<Option<_>>()?;
        experiment.replace_volumes(volumes).ok()?;
        experiment.check_size().ok()?;
    }
    let resolution = resolve(&experiment, &names.known(), &Capabilities::default());
    Some(resolution.cells.iter().map(of_cell).collect())
}

fn file(name: &str) -> Option<VolumeSource> {
    let path = FilePath::literal(Path::new(name).to_str()?).ok()?;
    Some(VolumeSource::file(path))
}
