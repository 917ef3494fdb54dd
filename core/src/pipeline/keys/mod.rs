//! The table of all keys of a configuration, with type, unit, range, default and meaning. This file holds the whole
//! configuration, `[experiment]` and `[pipeline]`.

mod codecs;
pub mod number;
pub(super) mod scene;
pub(super) mod shape;
pub(super) mod volume;
mod words;

use super::{Experiment, Known};
use crate::codec::{FrameStore, Setting, Site};
use crate::render::Filter;
use shape::{Key, Relation, Shape, Table};

/// Word for all stages of a stream.
pub(super) const ALL_STAGES: &str = "all";
/// Most stages that can be asked for.
pub(super) const MOST_STAGES: i64 = 254;
/// Highest allowed resolution. Beyond it, no axis is longer than one voxel.
pub(super) const MOST_RESOLUTION: i64 = 32;

/// All that a configuration holds.
pub(super) fn configuration(known: &Known<'_>) -> Table {
    let list = |tables| Shape::Tables(tables);
    let keys = vec![
        Key::required("experiment", Shape::Table(experiment()), "Name and seed"),
        Key::required(
            "volume",
            list(volume::tables(known.generators)),
            "What is drawn; one table for each volume",
        ),
        Key::required(
            "codec",
            list(codecs::tables(known)),
            "What compresses; one table for each codec, or for each way to set one",
        ),
        Key::required("pipeline", Shape::Table(pipeline(known)), "How pictures are made"),
        Key::required(
            "scene",
            list(vec![("scene".to_owned(), scene::table())]),
            "What the volumes look like; one table for each scene",
        ),
    ];
    Table::new(
        "An experiment of cvr: the product volumes × codecs × settings × scenes × renderers × sites × filters × skipping × \
         stages × resolutions. Each combination that is possible is a cell, and each cell yields one record.",
        keys,
    )
}

pub(super) fn experiment() -> Table {
    let seed = Shape::Integer { min: 0, max: i64::MAX };
    let keys = vec![
        Key::required("name", Shape::Name, "Name of the experiment, of its report and of its folder"),
        Key::with_default("seed", seed, "0", "Seed of all random choices"),
        Key::with_default(
            "max_cells",
            Shape::Integer { min: 1, max: i64::MAX },
            Experiment::MAX_CELLS.to_string(),
            "Limit of cells, refused combinations included; a larger experiment is refused before its cells are made",
        ),
        Key::with_default(
            "decoded_frames_mb",
            Shape::Integer { min: 1, max: i64::from(u32::MAX) },
            FrameStore::DEFAULT_MB.to_string(),
            "Decoded frames that are kept of each stream whose frames are predicted from others; more are decoded anew",
        )
        .unit("MB"),
    ];
    Table::new("Name and seed of the experiment.", keys)
}

/// The settings of all renderers, each with the renderers that use it.
fn renderer_settings<'a>(known: &Known<'a>) -> Vec<(&'a Setting, Vec<String>)> {
    let mut all: Vec<(&Setting, Vec<String>)> = Vec::new();
    for info in known.renderers {
        for setting in info.settings {
            match all.iter_mut().find(|(other, _)| other.name == setting.name && other.kind == setting.kind) {
                Some((_, owners)) => owners.push(info.id.to_owned()),
                None => all.push((setting, vec![info.id.to_owned()])),
            }
        }
    }
    all
}

/// The keys that `[pipeline]` has whatever the renderer; `renderers` are words with their meaning.
pub(super) fn axes(renderers: Vec<(String, String)>) -> Vec<Key> {
    let axis = |words| Shape::Axis(Box::new(Shape::Words(words)));
    let sites = Site::ALL.map(|site| (site.name().to_owned(), site.summary().to_owned()));
    let filters = Filter::ALL.map(|filter| (filter.name().to_owned(), words::filter(filter).to_owned()));
    vec![
        Key::required("renderer", axis(renderers), "What draws"),
        Key::required("site", axis(sites.into()), "Where voxels are decoded"),
        Key::required("filter", axis(filters.into()), "How values between voxels are found"),
        Key::with_default(
            "skipping",
            Shape::Axis(Box::new(Shape::Boolean)),
            "false",
            "Whether macrocells in which the scene shows nothing are skipped",
        ),
        Key::with_default(
            "stages",
            Shape::Axis(Box::new(Shape::Any(vec![
                Shape::Words(vec![(ALL_STAGES.to_owned(), "as many as the stream has".to_owned())]),
                Shape::Integer { min: 1, max: MOST_STAGES },
            ]))),
            format!("\"{ALL_STAGES}\""),
            "How many stages of a stream are decoded, of codecs that refine in stages",
        ),
        Key::with_default(
            "resolution",
            Shape::Axis(Box::new(Shape::Integer { min: 0, max: MOST_RESOLUTION })),
            "0",
            "Which resolution of a stream is decoded, of codecs that have several; 0 is the full one, and each step halves \
             every axis",
        ),
    ]
}

fn pipeline(known: &Known<'_>) -> Table {
    let mut keys = axes(known.renderers.iter().map(|r| (r.id.to_owned(), r.summary.to_owned())).collect());
    let own = keys.len();
    let settings = renderer_settings(known);
    let mut named: Vec<(String, Vec<String>)> = Vec::new();
    for (setting, owners) in settings {
        let shape = Shape::Sweep(Box::new(Shape::Setting(setting.kind)));
        let doc = format!("Of renderer {}: {}", owners.join(", "), setting.doc);
        match named.iter_mut().zip(&mut keys[own..]).find(|((name, _), _)| name == setting.name) {
            // Two renderers use one name for different settings. The named renderers decide which values are allowed.
            Some(((_, all), key)) => {
                let first = std::mem::replace(&mut key.shape, Shape::Boolean);
                key.shape = Shape::Any(vec![first, shape]);
                key.doc = format!("{}. {doc}", key.doc);
                all.extend(owners);
            }
            None => {
                let default = codecs::written(setting.kind, setting.default);
                keys.push(Key::with_default(setting.name, shape, default, doc));
                named.push((setting.name.to_owned(), owners));
            }
        }
    }
    let doc = "How pictures are made: the product of these lists, without the pairs that cannot be. Settings of renderers \
               stand beside them.";
    Table { relation: Some(Relation::RendererSettings(named)), ..Table::new(doc, keys) }
}
