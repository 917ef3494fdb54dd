//! From a document to a checked experiment.

mod codec;
mod pipeline;
mod scene;
mod settings;
mod volume;

use std::error::Error;
use std::fmt;

use super::document::{Document, Node, Value};
use super::keys;
use super::read::{Fields, unknown};
use super::{Experiment, FilePath, Known, Scene, TooManyCells, Volume};
use crate::codec::FrameStore;
use crate::diagnostic::Diagnostic;

/// All errors of a configuration: the first of every table, in the order of the sections. Never empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidExperiment(pub Vec<Diagnostic>);

impl Error for InvalidExperiment {}

/// Number of errors shown. A broken script that writes configurations may cause the same error ten thousand times.
const MOST_SHOWN: usize = 10;

impl fmt::Display for InvalidExperiment {
    /// The first diagnostics, separated by empty lines, and the number of the others.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.0.iter().take(MOST_SHOWN).enumerate() {
            write!(f, "{}{diagnostic}", if i > 0 { "\n\n" } else { "" })?;
        }
        match self.0.len().checked_sub(MOST_SHOWN) {
            None | Some(0) => Ok(()),
            Some(1) => f.write_str("\n\nand 1 error more"),
            Some(more) => write!(f, "\n\nand {more} errors more"),
        }
    }
}

const VOLUME_EXAMPLE: &str = "name = \"bonsai\"\nfile = \"$CVR_DATA/bonsai.nrrd\"";
const PIPELINE_EXAMPLE: &str = "renderer = \"raycasting\"\nsite = \"inline\"\nfilter = \"linear\"";
const SCENE_EXAMPLE: &str =
    "name = \"front\"\ntransfer_function = [[0, \"#00000000\"], [255, \"#ffffffff\"]]";

/// Advice for too many cells.
const FEWER_CELLS: &str = "shorten a list, or write a larger number as `max_cells` of `[experiment]`; in place of it, \
                           `--set experiment.max_cells=N`";

/// Megabytes of decoded frames.
fn megabytes(node: &Node) -> Result<u32, Diagnostic> {
    const EXPECTED: &str = "an integer from 1 to 4294967295, in MB";
    let number = node.integer(1, i64::from(u32::MAX), EXPECTED)?;
    u32::try_from(number).map_err(|_| node.not_allowed(EXPECTED))
}

impl Document {
    /// Reads and checks the whole configuration. Environment variables in paths are not expanded.
    ///
    /// # Errors
    /// When a key, type, value or name is wrong, a table is missing, or a name is given twice.
    pub fn experiment(&self, known: &Known<'_>) -> Result<Experiment, InvalidExperiment> {
        let root = Fields::open("the configuration", &self.root).map_err(|e| InvalidExperiment(vec![e]))?;
        let mut problems = Problems::default();
        let configuration = keys::configuration(known);
        let sections = configuration.names();
        for entry in root.entries() {
            if !sections.contains(&entry.key.as_str()) {
                problems.0.push(root.unknown_key(entry, &sections));
            }
        }
        let experiment = problems.keep(
            section(&root, "experiment", "name = \"compare\"")
                .and_then(|node| Fields::of("the experiment", node, &keys::experiment().names()))
                .and_then(|fields| {
                    let name = name_of(&fields, "name = \"compare\"")?;
                    let seed = fields.optional("seed", |n| n.integer(0, i64::MAX, "an integer from 0"))?;
                    let max_cells =
                        fields.optional("max_cells", |n| n.integer(1, i64::MAX, "an integer from 1"))?;
                    let max_cells = max_cells.map_or(Experiment::MAX_CELLS, i64::unsigned_abs);
                    let decoded_frames_mb = fields.optional("decoded_frames_mb", megabytes)?;
                    let decoded_frames_mb = decoded_frames_mb.unwrap_or(FrameStore::DEFAULT_MB);
                    Ok((name, seed.unwrap_or(0).unsigned_abs(), max_cells, decoded_frames_mb))
                }),
        );
        let max_cells = experiment.as_ref().map_or(Experiment::MAX_CELLS, |(_, _, max_cells, _)| *max_cells);
        let mut notes = Vec::new();
        let volumes = problems.tables(&root, "volume", VOLUME_EXAMPLE, |node| volume::read(node, known));
        let codecs =
            problems.tables(&root, "codec", "id = \"raw\"", |node| codec::read(node, known, &mut notes));
        let pipeline = problems.keep(
            section(&root, "pipeline", PIPELINE_EXAMPLE)
                .and_then(|node| pipeline::read(node, known, max_cells, &mut notes)),
        );
        let scenes = problems.tables(&root, "scene", SCENE_EXAMPLE, scene::read);

        problems.distinct_names("volume", volumes.iter().map(|(node, v)| (*node, v.name.as_str())));
        problems.distinct_names("scene", scenes.iter().map(|(node, s)| (*node, s.name.as_str())));
        // If a volume or scene failed, a correct reference to it would look wrong.
        if problems.0.is_empty() {
            problems.scene_volumes(&volumes, &scenes);
        }
        let codecs = values(codecs);
        match (experiment, pipeline) {
            (Some((name, seed, max_cells, decoded_frames_mb)), Some(pipeline)) if problems.0.is_empty() => {
                let (volumes, scenes) = (values(volumes), values(scenes));
                let experiment = Experiment {
                    name,
                    seed,
                    max_cells,
                    decoded_frames_mb,
                    volumes,
                    codecs,
                    pipeline,
                    scenes,
                    notes,
                };
                experiment.check_size().map_err(|e| InvalidExperiment(vec![too_many(&root, &e)]))?;
                Ok(experiment)
            }
            _ => Err(InvalidExperiment(problems.0)),
        }
    }
}

/// The error for too many cells. It points at the limit, if the configuration has one.
fn too_many(root: &Fields<'_>, problem: &TooManyCells) -> Diagnostic {
    let TooManyCells { cells, allowed } = problem;
    let message = format!("the experiment has {cells} cells, and {allowed} are allowed");
    let section = root.get("experiment");
    let fields = section.and_then(|node| Fields::open("the experiment", node).ok());
    let error = match (fields.and_then(|f| f.get("max_cells")), section) {
        (Some(limit), _) => limit.error(message, "as this says"),
        (None, Some(section)) => section.error(message, "has no `max_cells` of its own"),
        (None, None) => root.error(message, "in this file"),
    };
    error
        .with_note("they are volumes × settings of codecs × scenes × renderers × sites × filters × skipping × stages × \
             resolutions")
        .with_note(FEWER_CELLS)
}

fn values<T>(tables: Vec<(&Node, T)>) -> Vec<T> {
    tables.into_iter().map(|(_, value)| value).collect()
}

/// A required table of the configuration.
fn section<'a>(root: &Fields<'a>, name: &str, example: &str) -> Result<&'a Node, Diagnostic> {
    let node = root.get(name).ok_or_else(|| missing_section(root, &format!("[{name}]"), example))?;
    match node.value {
        Value::List(_) => {
            let error =
                node.error(format!("`{name}` is a single table, and this is a list"), "list of tables");
            Err(error.with_note(format!("write `[{name}]`")))
        }
        _ => Ok(node),
    }
}

/// The error for a missing section. `example` holds lines that would work.
fn missing_section(root: &Fields<'_>, header: &str, example: &str) -> Diagnostic {
    root.error(format!("the configuration has no `{header}`"), "none in this file")
        .with_note(format!("add, for instance,\n{header}\n{example}"))
}

/// A name: a non-empty string without control characters. Records and file names contain it.
fn name_of(fields: &Fields<'_>, example: &str) -> Result<String, Diagnostic> {
    let node = fields.require("name", example)?;
    let name = node.text()?;
    if name.trim().is_empty() || name.chars().any(char::is_control) {
        return Err(node.not_allowed("a name without control characters"));
    }
    Ok(name.to_owned())
}

/// A path of a file. The file need not exist during parsing.
fn path(file: &Node) -> Result<FilePath, Diagnostic> {
    FilePath::new(file.text()?).map_err(|e| {
        file.error(e.to_string(), "not a path")
            .with_note("`$NAME` and `${NAME}` stand for environment variables, `$$` for `$`")
    })
}

/// The errors so far.
#[derive(Default)]
struct Problems(Vec<Diagnostic>);

impl Problems {
    fn keep<T>(&mut self, result: Result<T, Diagnostic>) -> Option<T> {
        result.map_err(|e| self.0.push(e)).ok()
    }

    /// Reads a list of tables, `[[name]]`. Each table that fails adds an error.
    fn tables<'a, T>(
        &mut self,
        root: &Fields<'a>,
        name: &str,
        example: &str,
        mut read: impl FnMut(&'a Node) -> Result<T, Diagnostic>,
    ) -> Vec<(&'a Node, T)> {
        let header = format!("[[{name}]]");
        let nodes = root.get(name).ok_or_else(|| missing_section(root, &header, example));
        let nodes = nodes.and_then(|node| match &node.value {
            Value::Table(_) => Err(node
                .error(format!("`{name}` is a list of tables, and this is a single one"), "single table")
                .with_note(format!("write `{header}`"))),
            Value::List(items) if items.is_empty() => Err(missing_section(root, &header, example)),
            _ => node.list("a list of tables"),
        });
        let nodes = self.keep(nodes).unwrap_or(&[]);
        nodes.iter().filter_map(|node| self.keep(read(node)).map(|value| (node, value))).collect()
    }

    /// Names become file names, and some file systems do not distinguish `A` and `a`.
    fn distinct_names<'a>(&mut self, what: &str, tables: impl Iterator<Item = (&'a Node, &'a str)>) {
        let place = |node: &Node| {
            let name = Fields::open(what, node).ok().and_then(|f| f.get("name"));
            name.unwrap_or(node).place.clone()
        };
        let mut seen: Vec<(&Node, &str)> = Vec::new();
        for (node, name) in tables {
            match seen.iter().find(|(_, other)| other.to_lowercase() == name.to_lowercase()) {
                None => seen.push((node, name)),
                Some((first, other)) => {
                    let message = format!("two {what}s are called `{name}`");
                    let mut error = Diagnostic::new(message, place(node), "again")
                        .with_secondary(place(first), "first")
                        .with_note("records and files go by this name: choose another");
                    if *other != name {
                        error =
                            error.with_note("upper and lower case do not tell file names apart everywhere");
                    }
                    self.0.push(error);
                }
            }
        }
    }

    /// Scenes name volumes that exist, and every volume has a scene.
    fn scene_volumes(&mut self, volumes: &[(&Node, Volume)], scenes: &[(&Node, Scene)]) {
        let known: Vec<&str> = volumes.iter().map(|(_, v)| v.name.as_str()).collect();
        for (node, _) in scenes {
            let list = Fields::open("the scene", node).ok().and_then(|f| f.get("volumes"));
            let items = match list.map(|list| (list, &list.value)) {
                Some((_, Value::List(items))) => items.as_slice(),
                Some((list, _)) => std::slice::from_ref(list),
                None => &[],
            };
            for item in items {
                let name = item.text().unwrap_or_default();
                if !known.contains(&name) {
                    self.0.push(unknown(&item.place, "volume", name, &known));
                }
            }
        }
        if scenes.iter().any(|(_, s)| s.volumes.is_none()) {
            return;
        }
        for (node, volume) in volumes {
            let named = scenes.iter().any(|(_, s)| s.volumes.iter().flatten().any(|v| *v == volume.name));
            if !named {
                let error =
                    node.error(format!("no scene applies to volume `{}`", volume.name), "never drawn");
                self.0
                    .push(error.with_note("add a `[[scene]]` without `volumes`, or name the volume in one"));
            }
        }
    }
}
