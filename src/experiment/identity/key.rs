//! One hash of everything that a cell's result depends on. Results with equal keys can replace each other.

use cvr_core::pipeline::{Cell, Experiment, Scene};
use cvr_core::volume::BrickSource;
use serde::Serialize;

use crate::experiment::inputs::volumes::LoadedVolume;
use crate::experiment::measured::reference::RAW;
use crate::experiment::records::machine;
use crate::registry::Names;
use crate::site::target::Target;

/// Version of the figures' definitions: reference, baseline, pairing of frame times, metrics. It increases whenever one
/// changes, so that no resumed run mixes both.
pub const FIGURES_VERSION: u32 = 2;

/// All inputs of a result. A superfluous field costs a second run. A missing one mixes different results.
#[derive(Serialize)]
struct Inputs<'a> {
    figures_version: u32,
    version: &'a str,
    git_hash: Option<String>,
    // Times of optimised and unoptimised builds differ.
    build: &'a str,
    seed: u64,
    volume: &'a str,
    samples_blake3: &'a str,
    layout: String,
    codec: &'a str,
    settings: String,
    // Stream versions of the codec, and of `raw`, which makes reference and baseline.
    stream_versions: [Option<u32>; 2],
    scene: String,
    renderer: &'a str,
    site: &'a str,
    filter: &'a str,
    skipping: bool,
    stages: Option<u8>,
    resolution: u8,
    device: String,
    driver: String,
    cpu: String,
    cores: u32,
}

/// Makes the keys of an experiment's cells.
#[derive(Copy, Clone, Debug)]
pub struct Keys<'a> {
    /// Scenes and seed.
    pub experiment: &'a Experiment,
    /// Codecs.
    pub names: &'a Names,
}

impl Keys<'_> {
    /// BLAKE3 of all inputs of the result of `cell` of `volume` on `target`, in hexadecimal.
    #[must_use]
    pub fn of(&self, cell: &Cell, volume: &LoadedVolume, target: &Target) -> String {
        let stream_version = |id: &str| self.names.codecs().get(id).ok().map(|c| c.info().stream_version);
        // The other volumes of a scene do not affect this one.
        let scene = self.experiment.scene(&cell.scene).map(|s| Scene { volumes: None, ..s.clone() });
        let inputs = Inputs {
            figures_version: FIGURES_VERSION,
            version: env!("CARGO_PKG_VERSION"),
            git_hash: machine::git_hash(),
            build: if cfg!(debug_assertions) { "debug" } else { "release" },
            seed: self.experiment.seed,
            volume: &cell.volume,
            samples_blake3: &volume.provenance.blake3,
            layout: layout_of(volume),
            codec: &cell.codec,
            settings: cell.settings.to_string(),
            stream_versions: [stream_version(&cell.codec), stream_version(RAW)],
            // `Debug` shows every field, also later ones, and floats without loss.
            scene: format!("{scene:?}"),
            renderer: &cell.renderer,
            site: cell.site.name(),
            filter: cell.filter.name(),
            skipping: cell.skipping,
            stages: cell.stages,
            resolution: cell.resolution,
            device: target.name(),
            driver: target.driver(),
            cpu: machine::cpu(),
            cores: machine::cores(),
        };
        hash_of(&inputs)
    }
}

/// BLAKE3 of all that goes into a result, in hexadecimal.
#[must_use]
pub fn hash_of(inputs: &impl Serialize) -> String {
    // Strings and integers always serialise. If they did not, an empty text would equal no other key's.
    let text = serde_json::to_vec(inputs).unwrap_or_default();
    blake3::hash(&text).to_hex().to_string()
}

/// The layout, and the number of rounded samples, which records contain.
fn layout_of(volume: &LoadedVolume) -> String {
    let layout = format!("{:?}", volume.volume.layout());
    match volume.volume.replaced().rounded {
        0 => layout,
        n => format!("{layout}, {n} rounded"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::inputs::volumes::load;
    use cvr_core::codec::Site;
    use cvr_core::pipeline::{Capabilities, Document, SceneOpacity, TransferDomain, resolve};
    use cvr_core::render::{ClipBox, ColourOpacity, Filter, OpacityTable, Preset, Shading};
    use std::sync::Arc;

    const CONFIG: &str = r##"
[experiment]
name = "keys"
seed = 1
[[volume]]
name = "v"
generate = "turbulence"
dims = [4, 4, 4]
[[codec]]
id = "s3dc"
[pipeline]
renderer = "raycasting"
site = "inline"
filter = "linear"
[[scene]]
name = "s"
transfer_function = [[0, "#00000000"], [255, "#ffffffff"]]
"##;

    fn key(
        names: &Names,
        config: &str,
        change: impl Fn(&mut Cell, &mut LoadedVolume, &mut Experiment),
    ) -> String {
        let mut experiment = Document::parse("x.toml", config).unwrap().experiment(&names.known()).unwrap();
        let mut cell = resolve(&experiment, &names.known(), &Capabilities::default()).cells.remove(0);
        let mut volume = load(&experiment.volumes[0], experiment.seed).unwrap();
        change(&mut cell, &mut volume, &mut experiment);
        Keys { experiment: &experiment, names }.of(&cell, &volume, &Target::Cpu { reason: None })
    }

    #[test]
    fn every_input_moves_the_key_and_nothing_else_does() {
        let names = Names::new().unwrap();
        let first = key(&names, CONFIG, |_, _, _| {});
        assert_eq!(first, key(&names, CONFIG, |_, _, _| {}));
        assert_eq!(first.len(), 64);
        type Change = fn(&mut Cell, &mut LoadedVolume, &mut Experiment);
        let changes: [(&str, Change); 24] = [
            ("volume", |c, _, _| c.volume.push('2')),
            ("codec", |c, _, _| c.codec = "raw".to_owned()),
            ("site", |c, _, _| c.site = Site::Host),
            ("filter", |c, _, _| c.filter = Filter::Nearest),
            ("skipping", |c, _, _| c.skipping = true),
            ("stages", |c, _, _| c.stages = Some(2)),
            ("resolution", |c, _, _| c.resolution = 1),
            ("renderer", |c, _, _| c.renderer.push('2')),
            ("settings", |c, _, _| c.settings.set("index_bits", cvr_core::codec::SettingValue::Integer(2))),
            ("samples", |_, v, _| v.provenance.blake3 = "0".repeat(64)),
            ("seed", |_, _, e| e.seed = 2),
            ("step", |_, _, e| e.scenes[0].step_voxels = 0.51),
            ("camera", |_, _, e| e.scenes[0].camera.azimuth += 1.0),
            ("colours", |_, _, e| e.scenes[0].control_points[1].value = 254.0),
            ("background", |_, _, e| e.scenes[0].background = [0.0, 0.0, 0.1]),
            ("early termination", |_, _, e| e.scenes[0].early_termination = 0.9),
            ("shading", |_, _, e| e.scenes[0].shading = Some(Shading::default())),
            ("light", |_, _, e| {
                let direction = [0.0, 0.0, 1.0];
                e.scenes[0].shading = Some(Shading { direction, ..Shading::default() });
            }),
            ("clip box", |_, _, e| {
                e.scenes[0].clip = Some(ClipBox { high: [1.0, 1.0, 0.5], ..ClipBox::WHOLE });
            }),
            ("frame", |_, _, e| e.scenes[0].frames.last = 1),
            ("opacity", |_, _, e| {
                e.scenes[0].opacity = SceneOpacity::Known(ColourOpacity::Channel(1));
            }),
            ("opacity table", |_, _, e| {
                let table = OpacityTable::new(2, &[0.5; 8]).unwrap();
                e.scenes[0].opacity = SceneOpacity::Known(ColourOpacity::Table(Arc::new(table)));
            }),
            ("domain", |_, _, e| e.scenes[0].domain = TransferDomain::Range),
            ("preset", |_, _, e| e.scenes[0].control_points = Preset::ALL[0].control_points()),
        ];
        let mut seen = vec![first.clone()];
        for (name, change) in changes {
            let key = key(&names, CONFIG, change);
            assert!(!seen.contains(&key), "{name} does not move the key");
            seen.push(key);
        }
        let written = |lines: &str| {
            let config =
                CONFIG.replace("transfer_function = [[0, \"#00000000\"], [255, \"#ffffffff\"]]", lines);
            key(&names, &config, |_, _, _| {})
        };
        let lines =
            ["", "shading = true", "shading = { shininess = 31 }", "clip_box = [[0, 0, 0], [1, 0.5, 1]]"];
        for line in
            ["tissue", "heat"].iter().flat_map(|p| lines.map(|l| format!("transfer_function = '{p}'\n{l}")))
        {
            let key = written(&line);
            assert!(!seen.contains(&key), "{line} does not move the key");
            seen.push(key);
        }
        assert_eq!(
            written("transfer_function = 'heat'\nshading = {}"),
            written("transfer_function = 'heat'\nshading = true")
        );
        let spaced = CONFIG.replace("dims = [4, 4, 4]", "dims = [4, 2, 8]");
        let same_samples =
            |_: &mut Cell, v: &mut LoadedVolume, _: &mut Experiment| v.provenance.blake3 = "0".repeat(64);
        assert_ne!(key(&names, &spaced, same_samples), key(&names, CONFIG, same_samples), "layout");
        let elsewhere = |_: &mut Cell, _: &mut LoadedVolume, e: &mut Experiment| {
            e.name = "other".to_owned();
            e.scenes[0].volumes = Some(vec!["v".to_owned(), "w".to_owned()]);
        };
        assert_eq!(key(&names, CONFIG, elsewhere), first, "what has no bearing on the result");
    }

    #[test]
    fn another_device_is_another_key() {
        let names = Names::new().unwrap();
        let experiment = Document::parse("x.toml", CONFIG).unwrap().experiment(&names.known()).unwrap();
        let cell = resolve(&experiment, &names.known(), &Capabilities::default()).cells.remove(0);
        let volume = load(&experiment.volumes[0], 1).unwrap();
        let keys = Keys { experiment: &experiment, names: &names };
        let cpu = keys.of(&cell, &volume, &Target::Cpu { reason: None });
        let fallback = keys.of(&cell, &volume, &Target::Cpu { reason: Some("no adapter".to_owned()) });
        assert_eq!(cpu, fallback, "the mirror is the mirror, whatever led to it");
        if let Some(device) = cvr_engine::testing::test_device("key::device") {
            assert_ne!(cpu, keys.of(&cell, &volume, &Target::Device(device.clone())));
        }
    }
}
