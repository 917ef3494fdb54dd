//! What makes two cells of different runs the same.

use std::collections::BTreeMap;

use cvr_core::pipeline::{Document, Experiment, Scene};

use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::Record;
use crate::registry::Names;

/// All that defines a cell, and nothing of the machine or software that ran it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Identity {
    /// Samples and layout: hash, size, type and spacing; the volume's name if the results have none of these.
    volume: String,
    /// The configuration's definition of the scene, or the scene's name.
    scene: String,
    /// Codec, settings, renderer, site and filter, as the record has them.
    names: [String; 5],
    skipping: bool,
    stages: Option<u8>,
    resolution: u8,
}

/// The definitions of scenes by name, as this version reads them; `None` where it does not.
pub(super) fn scenes(provenance: &Provenance) -> Option<BTreeMap<String, String>> {
    let names = Names::new().ok()?;
    let mut document = Document::parse("the results' configuration", &provenance.config).ok()?;
    for assignment in &provenance.overrides {
        document.set(assignment).ok()?;
    }
    let experiment: Experiment = document.experiment(&names.known()).ok()?;
    // The volumes that a scene is for do not change what it shows of one of them.
    let definition = |s: &Scene| format!("{:?}", Scene { volumes: None, ..s.clone() });
    Some(experiment.scenes.iter().map(|s| (s.name.clone(), definition(s))).collect())
}

impl Identity {
    /// The identity of a record. `scenes` are the definitions, if all compared runs have them.
    pub(super) fn of(
        record: &Record,
        provenance: &Provenance,
        scenes: Option<&BTreeMap<String, String>>,
    ) -> Self {
        let known = provenance.volumes.iter().find(|v| v.name == record.volume && !v.blake3.is_empty());
        let volume = known.map_or_else(
            || record.volume.clone(),
            |v| format!("{} {:?} {} {:?}", v.blake3, v.dims, v.dtype, v.spacing),
        );
        let scene = scenes.and_then(|s| s.get(&record.scene)).unwrap_or(&record.scene).clone();
        let names = [&record.codec, &record.settings, &record.renderer, &record.site, &record.filter];
        Self {
            volume,
            scene,
            names: names.map(Clone::clone),
            skipping: record.skipping,
            stages: record.stages,
            resolution: record.resolution,
        }
    }
}
