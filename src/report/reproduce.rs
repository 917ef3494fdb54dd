//! The command that runs one cell again: that of the run, without what chose other cells or another folder.

use cvr_core::codec::Site;
use cvr_core::pipeline::Cell;
use cvr_core::render::Filter;

use crate::experiment::records::machine::quoted;
use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::Record;
use crate::experiment::records::series;

/// Options of `cvr run` that say which cells run or where results go, and whether a value follows.
const DROPPED: [(&str, bool); 6] = [
    ("--out", true),
    ("--shard", true),
    ("--cell", true),
    ("--resume", false),
    ("--overwrite", false),
    ("--list-cells", false),
];

/// A separate folder. The cell that was requested last replaces the one before.
const OUT: &str = "results/one-cell";

/// The name of a record's cell, as `cvr run --list-cells` prints it; `None` where its site or filter is unknown.
pub(super) fn cell_id(record: &Record) -> Option<String> {
    let cell = Cell {
        volume: record.volume.clone(),
        codec: Cell::codec_of_label(&record.codec).to_owned(),
        // The name of a cell shows values of any kind as text.
        settings: series::read(&record.settings)?,
        scene: record.scene.clone(),
        renderer: record.renderer.clone(),
        site: Site::ALL.into_iter().find(|site| site.name() == record.site)?,
        filter: Filter::ALL.into_iter().find(|filter| filter.name() == record.filter)?,
        skipping: record.skipping,
        stages: record.stages,
        resolution: record.resolution,
    };
    Some(cell.id())
}

/// The command that yields this record again, given the run's files and environment.
pub(super) fn command(record: &Record, provenance: &Provenance) -> Option<String> {
    let id = cell_id(record)?;
    // Of a merged folder, a run on the same device.
    let runs = || provenance.parts.iter().filter(|part| part.records > 0);
    let part = runs().find(|part| part.adapter == record.device).or_else(|| runs().next());
    let line = part.map_or(&provenance.command_line, |part| &part.command_line);
    let words = shlex::split(line)?;
    let [program, run, rest @ ..] = words.as_slice() else { return None };
    if run != "run" {
        return None;
    }
    let mut kept = vec![program.clone(), run.clone()];
    let mut rest = rest.iter();
    while let Some(word) = rest.next() {
        let name = word.split_once('=').map_or(word.as_str(), |(name, _)| name);
        match DROPPED.iter().find(|(dropped, _)| *dropped == name) {
            Some((_, true)) if name == word => _ = rest.next(),
            Some(_) => {}
            None => kept.push(word.clone()),
        }
    }
    kept.extend(["--cell", &id, "--out", OUT, "--overwrite"].map(str::to_owned));
    Some(kept.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::provenance::Part;
    use crate::experiment::records::record::tests::record;

    fn cell() -> Record {
        Record {
            settings: "block=8x8x4 index_bits=2".into(),
            site: "inline".into(),
            filter: "linear".into(),
            renderer: "raycasting".into(),
            scene: "front".into(),
            device: "one".into(),
            ..record("v", "s3dc")
        }
    }

    #[test]
    fn words_are_those_that_were_quoted() {
        let all = ["cvr", "a b", "", "it's", r"back\slash", "--set", "x=[1, 2]"];
        let line = all.map(quoted).join(" ");
        assert_eq!(shlex::split(&line).unwrap(), all);
    }

    #[test]
    fn what_chose_cells_or_folder_goes_and_what_chose_data_stays() {
        let run = "cvr run x.toml --out=far --overwrite --shard 1/2 --set 'scene.size=[9, 9]' --device cpu --out far";
        let provenance = Provenance { command_line: run.into(), ..Default::default() };
        assert_eq!(
            command(&cell(), &provenance).unwrap(),
            "cvr run x.toml --set 'scene.size=[9, 9]' --device cpu --cell \
             v-s3dc-block=8x8x4,index_bits=2-front-raycasting-inline-linear --out results/one-cell --overwrite"
        );
        let part = |adapter: &str, config: &str| Part {
            adapter: adapter.into(),
            records: 1,
            command_line: format!("cvr run {config}"),
            ..Default::default()
        };
        let merged = Provenance {
            command_line: "cvr merge a b --out c".into(),
            parts: vec![part("two", "b.toml"), part("one", "a.toml")],
            ..Default::default()
        };
        assert!(command(&cell(), &merged).unwrap().starts_with("cvr run a.toml --cell "));
        for line in ["", "cvr merge a --out b", "cvr run 'x"] {
            let provenance = Provenance { command_line: line.into(), ..Default::default() };
            assert_eq!(command(&cell(), &provenance), None, "{line}");
        }
        assert_eq!(command(&Record { site: "moon".into(), ..cell() }, &provenance), None);
    }
}
