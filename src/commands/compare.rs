//! `cvr compare`

use std::path::PathBuf;
use std::process::ExitCode;

use super::output::Output;
use crate::compare::{csv, page, pair, read, text};
use crate::exit::BadInput;
use crate::experiment::files::folder::is_result;
use crate::experiment::files::whole_file::write_whole;

/// Arguments of `cvr compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = NOTES)]
pub struct Args {
    /// Files `results.json`, or folders that hold one. The others are compared with the first.
    #[arg(required = true, value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// Write every cell and quantity in full precision. Replaces an existing file, but no file of a run's results.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write a page for a browser, without network or scripts. Replaces an existing file, but no file of a run's
    /// results.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Noise of times that are taken once (encoding, decoding), in percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 10.0)]
    noise: f64,
}

const NOTES: &str = "\
Examples:
  cvr compare before/results.json after/results.json    two versions on one machine
  cvr compare laptop desktop server                     folders of three runs; each against the first
  cvr compare both                                      results of two devices, joined by `cvr merge`
  cvr compare before after --csv change.csv --noise 5
  cvr compare before after --html change.html           the same as a page

Cells are matched by their definition (samples of the volume, codec, settings, scene, renderer, site, filter, stages,
skipping), not by machine, version or the name of a volume. A change within the noise of both measurements is a tie. A
file of several devices counts as one run for each device.";

/// Lays runs side by side.
///
/// # Errors
/// When a file holds no results, there is but one run, or none has a cell in common with the first.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    if !(args.noise >= 0.0 && args.noise.is_finite()) {
        return Err(BadInput(format!("--noise {}: a percentage of 0 or more", args.noise)));
    }
    let sides = read(&args.results)?;
    let [first, others @ ..] = sides.as_slice() else { return Err(BadInput("no results".to_owned())) };
    if others.is_empty() {
        return Err(BadInput(format!(
            "{}: is one run on one device; name a second to compare it with",
            first.file.display()
        )));
    }
    if others.iter().all(|other| pair(first, other).only_first.len() == first.cells.len()) {
        let files: Vec<String> = others.iter().map(|s| s.file.display().to_string()).collect();
        return Err(BadInput(format!(
            "{}: has no cell in common with {}: other volumes, codecs, settings or scenes; `cvr explain` says what a \
             configuration runs",
            first.file.display(),
            files.join(", ")
        )));
    }
    let once = args.noise / 100.0;
    for (path, option) in [(&args.csv, "--csv"), (&args.html, "--html")] {
        let Some(path) = path else { continue };
        let same = |side: &crate::compare::Side| {
            path.canonicalize().is_ok_and(|path| side.file.canonicalize().is_ok_and(|file| file == path))
        };
        if sides.iter().any(same) {
            return Err(BadInput(format!(
                "{}: is compared itself; name another file with {option}",
                path.display()
            )));
        }
        if is_result(path) {
            return Err(BadInput(format!(
                "{}: is one of the results of its folder; name another file with {option}",
                path.display()
            )));
        }
    }
    if args.csv.is_some() && args.csv == args.html {
        return Err(BadInput("--csv and --html name one file: name two".to_owned()));
    }
    for (path, format) in [(&args.csv, Output::Csv), (&args.html, Output::Html)] {
        if let Some(path) = path {
            Output::of(path, &[format])?;
        }
    }
    if let Some(path) = &args.csv {
        write_whole(path, &csv(&sides, once)?)?;
    }
    if let Some(path) = &args.html {
        write_whole(path, page(&sides, once)?.as_bytes())?;
    }
    say!("{}", text(&sides, once).trim_end());
    Ok(ExitCode::SUCCESS)
}
