//! `cvr explain`

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

use comfy_table::{CellAlignment, Table, presets};
use cvr_core::codec::Site;
use cvr_core::memory::{allowed, gigabytes};
use cvr_core::pipeline::{Capabilities, Cell, Experiment, Resolution, resolve};
use cvr_core::volume::VolumeLayout;

use super::config_file::ConfigFile;
use super::memory_args::MemoryArgs;
use super::volume_args::RawArgs;
use crate::estimate::{Allowance, Cost, TRIAL_EDGE, Trials, memory, time, volume_layout};
use crate::exit::BadInput;
use crate::experiment::inputs::scenes::{check_frames, read_tables};
use crate::experiment::shards::shard::same_group;
use crate::progress::TrialBar;
use crate::registry::Names;
use crate::site;
use crate::site::target::Target;

const EXAMPLES: &str = "\
Examples:
  cvr explain configs/quickstart.toml
  cvr explain configs/compare.toml --set pipeline.site=inline
  cvr explain configs/compare.toml --volume head.nrrd --device cpu
  cvr explain configs/compare.toml --no-estimate        counts and volumes only, at once

Only the headers of volumes are read. A missing volume is reported and left out of the estimates. The estimates come from
trials: every codec with its settings encodes a small computed volume, and the device draws it. They distinguish hours
from minutes, not one cell from another. Trials take 2 s at most for each codec at each site, and 20 s in all. If that is
too little, the estimate says \"at least\", and a row for each codec and its settings names the missing trial. A trial
that is out of time is stopped; the command waits for its end.";

/// Arguments of `cvr explain`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The configuration.
    config: PathBuf,
    /// Explain it for this volume instead of those of the configuration, as in `cvr run`.
    #[arg(long, value_name = "FILE")]
    volume: Vec<PathBuf>,
    /// Override a key, as scene.step_voxels=1.0 or codec.s3dc.block=8.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// What would draw: auto (the best adapter, or the CPU mirror if there is none), cpu, vulkan, gl
    /// (the best of that backend), a part of an adapter's name, or #N of `cvr devices`.
    #[arg(long, default_value = "auto", value_name = "auto|cpu|NAME")]
    device: String,
    /// Estimate neither time nor memory: encode and draw nothing.
    #[arg(long)]
    no_estimate: bool,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    raw: RawArgs,
}

/// Prints what a configuration would run.
///
/// # Errors
/// When the configuration is wrong, or the device does not open.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    let names = Names::new()?;
    let ConfigFile { mut experiment, .. } = ConfigFile::read(&args.config, &args.set, &names)?;
    if !args.volume.is_empty() {
        experiment.replace_volumes(vec![args.raw.volume(&args.volume)?])?;
        experiment.check_size()?;
    }
    let resolution = resolve(&experiment, &names.known(), &Capabilities::default());
    say!(
        "{}: {} cells, {} combinations refused",
        args.config.display(),
        resolution.cells.len(),
        resolution.refused.len()
    );
    let layouts = print_volumes(&experiment);
    print_cells(&resolution);
    print_refused(&resolution);
    for (volume, layout) in &layouts {
        check_frames(&experiment, volume, layout.frames)?;
    }
    if !args.no_estimate && !layouts.is_empty() && !resolution.cells.is_empty() {
        read_tables(&mut experiment)?;
        print_estimates(args, &experiment, &resolution, &names, &layouts)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A table without lines, its columns apart by two spaces.
fn table(header: &[&str], right: &[usize]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header.to_vec());
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_padding((2, 0));
        if right.contains(&i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn print_table(title: &str, table: &Table) {
    say!("\n{title}");
    for line in table.lines() {
        say!("{}", line.trim_end());
    }
}

/// Prints the layouts in the headers. Returns the known ones.
fn print_volumes(experiment: &Experiment) -> BTreeMap<String, VolumeLayout> {
    let mut known = BTreeMap::new();
    let mut rows = table(&["name", "voxels", "samples", "channels", "frames", "bytes"], &[3, 4, 5]);
    let mut problems = Vec::new();
    for volume in &experiment.volumes {
        match volume_layout(volume) {
            Ok(Some(layout)) => {
                let (extent, sample) = (layout.extent.to_string(), layout.sample.to_string());
                let [channels, frames] = [layout.channels, layout.frames].map(|n| n.to_string());
                rows.add_row(vec![
                    volume.name.clone(),
                    extent,
                    sample,
                    channels,
                    frames,
                    bytes(layout.bytes()),
                ]);
                known.insert(volume.name.clone(), layout);
            }
            Ok(None) => problems
                .push(format!("volume `{}`: slices, whose size shows only when they are read", volume.name)),
            Err(problem) => problems.push(problem.to_string()),
        }
    }
    if known.is_empty() {
        say!("\nvolumes");
    } else {
        print_table("volumes", &rows);
    }
    for problem in problems {
        say!("  not known here: {problem}");
    }
    known
}

/// One line for the cells of one volume, codec and settings.
fn print_cells(resolution: &Resolution) {
    let mut rows =
        table(&["cells", "volume", "codec", "settings", "scenes", "renderers", "sites", "filters"], &[0]);
    for group in resolution.cells.chunk_by(same_group) {
        let names = |of: &dyn Fn(&Cell) -> String| distinct(group.iter().map(of)).join(" ");
        rows.add_row(vec![
            group.len().to_string(),
            group[0].volume.clone(),
            group[0].codec.clone(),
            group[0].settings.to_string(),
            names(&|c| c.scene.clone()),
            names(&|c| c.renderer.clone()),
            names(&|c| c.site.to_string()),
            names(&|c| c.filter.to_string()),
        ]);
    }
    if !resolution.cells.is_empty() {
        print_table("cells", &rows);
    }
}

/// Prints the reasons in order of appearance, each with the number of combinations that it rules out.
fn print_refused(resolution: &Resolution) {
    let mut reasons: Vec<(String, Vec<String>)> = Vec::new();
    for refusal in &resolution.refused {
        let reason = refusal.reason.to_string();
        let what = format!("{} {}", refusal.cell.codec, refusal.cell.settings);
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, all)) => all.push(what),
            None => reasons.push((reason, vec![what])),
        }
    }
    if !reasons.is_empty() {
        say!("\nrefused (`cvr check-config` lists each)");
    }
    for (reason, mut what) in reasons {
        let count = what.len();
        what.dedup();
        say!("  {count} × {reason}; of: {}", what.join(", "));
    }
}

fn print_estimates(
    args: &Args,
    experiment: &Experiment,
    resolution: &Resolution,
    names: &Names,
    layouts: &BTreeMap<String, VolumeLayout>,
) -> Result<(), BadInput> {
    let target = Target::open(&args.device)?;
    let bar = TrialBar::new();
    let report = |what: &str| bar.begins(what);
    let mut trials = Trials::reporting(names, Allowance::default(), &report);
    let layout_of = |name: &str| layouts.get(name);
    let left_out = resolution.cells.iter().filter(|cell| !layouts.contains_key(&cell.volume)).count();
    say!("\nestimate, from a computed volume of {TRIAL_EDGE}³ voxels tried now; drawn by: {}", target.name());
    if left_out > 0 {
        say!("  {left_out} cells are left out, whose volumes are not known here");
    }
    let memory = memory::estimate(resolution, names, &mut trials, &target, &layout_of);
    let time = time::estimate(experiment, resolution, names, &mut trials, &target, &layout_of);
    trials.end();
    bar.finish();
    match memory {
        Ok(memory) => print_memory(&memory, &target),
        Err(problem) => say!("  memory  no estimate: {problem}"),
    }
    match time {
        Ok(time) => {
            let total = duration(time.coding + time.drawing);
            let about = if time.at_least { "at least" } else { "about" };
            say!(
                "  time    {about} {total}: {} to encode and decode, {} to draw",
                duration(time.coding),
                duration(time.drawing)
            );
            print_shares(&time, trials.costs());
        }
        Err(problem) => say!("  time    no estimate: {problem}"),
    }
    for site in Site::ALL {
        print_holders(site, resolution, &mut trials, &target, layouts);
    }
    say!("\n{}\n\n{}", folded("Memory.", memory::COUNTED), folded("Time.", time::COUNTED));
    Ok(())
}

fn print_memory(memory: &memory::Memory, target: &Target) {
    let least = if memory.at_least { "at least " } else { "" };
    say!("  memory  {least}{} in main memory", bytes(memory.main_bytes));
    if let Some(bound) = allowed().filter(|bound| memory.main_bytes > bound.bytes) {
        say!(
            "          more than the {} that may be taken: cells that need more would fail",
            gigabytes(bound.bytes)
        );
    }
    if let Target::Device(_) = target {
        say!("          {least}{} on the device", bytes(memory.device_bytes));
    }
}

/// A row for each codec with its settings: the time of a run, the time of the trials, and what the trials lack.
fn print_shares(time: &time::Time, costs: &[Cost]) {
    let header = ["codec", "encode, decode", "draw", "tried for", "lacks", "settings"];
    let mut rows = table(&header, &[1, 2, 3]);
    for share in &time.shares {
        let own = || costs.iter().filter(|c| c.codec == share.codec && c.settings == share.settings);
        let lacks = distinct(own().filter_map(|cost| cost.lacks.clone()));
        let lacks = match &lacks[..] {
            [] => String::new(),
            [one] => one.clone(),
            [first, others @ ..] => format!("{first}; and {} more", others.len()),
        };
        rows.add_row(vec![
            share.codec.clone(),
            duration(share.coding),
            duration(share.drawing),
            duration(own().map(|cost| cost.seconds).sum()),
            lacks,
            share.settings.clone(),
        ]);
    }
    print_table("what costs", &rows);
    if time.at_least {
        say!(
            "\nWhat a trial lacks counts as nothing, or by what was tried: the run takes longer than this says."
        );
    }
}

/// Prints what holds volumes at a site, if that depends on codec and target: one line for each kind of texture,
/// followed by its codecs and volumes.
fn print_holders(
    site: Site,
    resolution: &Resolution,
    trials: &mut Trials<'_>,
    target: &Target,
    layouts: &BTreeMap<String, VolumeLayout>,
) {
    let Some(holder) = site::of(site).holder() else { return };
    let mut found: Vec<(String, &Cell)> = Vec::new();
    for cell in resolution.cells.chunk_by(same_group).filter_map(|g| g.iter().find(|c| c.site == site)) {
        let Some(layout) = layouts.get(&cell.volume) else { continue };
        let trial = trials.of(&cell.codec, &cell.settings, layout);
        let holder = trial.and_then(|trial| holder(trial.coded(&cell.codec), target));
        found.push((holder.unwrap_or_else(|problem| problem), cell));
    }
    if found.is_empty() {
        return;
    }
    say!("\nsite {site}, on {}", target.name());
    // Settings are shown if cells of one codec and volume have different textures.
    let several = |of: &Cell| {
        let same = |c: &Cell| c.volume == of.volume && c.codec_label() == of.codec_label();
        distinct(found.iter().filter(|(_, c)| same(c)).map(|(texture, _)| texture.clone())).len() > 1
    };
    for texture in distinct(found.iter().map(|(texture, _)| texture.clone())) {
        say!("  {texture}");
        let name = |cell: &Cell| match several(cell) {
            true => format!("{} {}", cell.codec_label(), cell.settings),
            false => cell.codec_label(),
        };
        let own = || found.iter().filter(|(own, _)| *own == texture);
        for codec in distinct(own().map(|(_, cell)| name(cell))) {
            let volumes = own().filter(|(_, cell)| name(cell) == codec).map(|(_, cell)| cell.volume.clone());
            say!("    {codec}: {}", distinct(volumes).join(", "));
        }
    }
}

/// The distinct values, in order of first appearance.
fn distinct(values: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen: Vec<String> = Vec::new();
    for value in values {
        if !seen.contains(&value) {
            seen.push(value);
        }
    }
    seen
}

/// `16.0 MiB`.
fn bytes(bytes: u64) -> String {
    const UNITS: [&str; 4] = ["KiB", "MiB", "GiB", "TiB"];
    if bytes < 1024 {
        return format!("{bytes} B");
    }
    let mut amount = bytes as f64;
    let mut unit = "B";
    for next in UNITS {
        if amount < 1024.0 {
            break;
        }
        (amount, unit) = (amount / 1024.0, next);
    }
    format!("{amount:.1} {unit}")
}

/// Two digits: an estimate has no more.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 0.095 => format!("{:.2} s", s.max(0.01)),
        s if s < 9.5 => format!("{s:.1} s"),
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 5970.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// Text in lines of at most 100 characters.
fn folded(title: &str, text: &str) -> String {
    let mut lines = vec![title.to_owned()];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= 100 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_have_units_that_people_read() {
        for (amount, text) in [(0, "0 B"), (1023, "1023 B"), (1024, "1.0 KiB"), (3 << 29, "1.5 GiB")] {
            assert_eq!(bytes(amount), text);
        }
        for (seconds, text) in
            [(0.0, "0.01 s"), (1.24, "1.2 s"), (59.6, "60 s"), (600.0, "10 min"), (9000.0, "2.5 h")]
        {
            assert_eq!(duration(seconds), text);
        }
        let text = folded("A.", &"word ".repeat(60));
        assert!(text.lines().count() == 4 && text.lines().all(|line| line.chars().count() <= 100), "{text}");
    }
}
