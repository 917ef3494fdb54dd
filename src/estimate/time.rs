//! Time that a run takes.

use cvr_core::codec::Site;
use cvr_core::pipeline::{Cell, Experiment, Resolution};
use cvr_core::render::Filter;
use cvr_core::volume::VolumeLayout;
use cvr_engine::timing::{FrameTime, PairBudget, paired};

use super::Trials;
use super::trial::samples;
use crate::experiment::measured::pairs;
use crate::experiment::measured::reference::{BASELINE, RAW, REFERENCE, filter_of_raw};
use crate::experiment::shards::shard::same_group;
use crate::registry::Names;
use crate::site::target::Target;

/// What is counted, as a sentence for readers of the figures.
pub const COUNTED: &str = "Counted: voxels × seconds per voxel to encode and to decode, each codec and its settings once \
     for a volume, raw once more; and frames × (a fixed part + pixels × samples along a ray × a rate): reference, \
     picture, raw's picture, and the pairs that time a cell. No ray is taken to miss or to end early. Training is \
     scaled with the voxels, too much where a codec trains on a sample of them. Not counted: loading volumes, comparing \
     voxels and pictures, decoding and uploading textures, files.";

/// Seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Time {
    /// Encoding, and decoding on the CPU.
    pub coding: f64,
    /// Drawing.
    pub drawing: f64,
    /// Times of each codec with its settings, in the order of the cells. Raw's pictures as the baseline are not
    /// included.
    pub shares: Vec<Share>,
    /// Whether a trial is missing or was cut short, so the time may be longer.
    pub at_least: bool,
}

/// Times of one codec with one set of settings, over all volumes.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// Codec id.
    pub codec: String,
    /// Its settings.
    pub settings: String,
    /// Seconds of encoding, and of decoding on the CPU.
    pub coding: f64,
    /// Seconds of drawing and timing its own pictures, including the baseline's in the pairs.
    pub drawing: f64,
}

impl Time {
    fn share(&mut self, cell: &Cell) -> &mut Share {
        let settings = cell.settings.to_string();
        let known = self.shares.iter().position(|s| s.codec == cell.codec && s.settings == settings);
        let at = known.unwrap_or_else(|| {
            let codec = cell.codec.clone();
            self.shares.push(Share { codec, settings, coding: 0.0, drawing: 0.0 });
            self.shares.len() - 1
        });
        &mut self.shares[at]
    }
}

/// Pictures of raw that were drawn, by volume, scene and renderer. The first of each is the reference.
type RawPictures = Vec<(String, String, (Site, Filter))>;

/// The sum over all cells whose volume has a layout. `layout_of` gives a volume's layout by its name.
///
/// What no trial could measure counts as zero, and `at_least` is set.
///
/// # Errors
/// A sentence, when there is no codec `raw`.
pub fn estimate<'l>(
    experiment: &Experiment,
    resolution: &Resolution,
    names: &Names,
    trials: &mut Trials<'_>,
    target: &Target,
    layout_of: &dyn Fn(&str) -> Option<&'l VolumeLayout>,
) -> Result<Time, String> {
    let raw_settings = names.codecs().get(RAW).map_err(|e| e.to_string())?.info().default_settings();
    let mut time = Time::default();
    for of_volume in resolution.cells.chunk_by(|a, b| a.volume == b.volume) {
        let Some(layout) = layout_of(&of_volume[0].volume) else { continue };
        time.coding += coding_seconds(trials, RAW, &raw_settings, layout);
        let mut drawn = RawPictures::new();
        for group in of_volume.chunk_by(same_group) {
            let coding = coding_seconds(trials, &group[0].codec, &group[0].settings, layout);
            time.coding += coding;
            time.share(&group[0]).coding += coding;
            for cell in group {
                let Some(scene) = experiment.scene(&cell.scene) else { continue };
                let samples = samples(scene, layout);
                let pictures = scene.frames.iter().count() as f64;
                let mut frame_ms = |cell: &Cell| {
                    trials.frames(target, cell, scene, layout).map_or(0.0, |frames| frames.frame_ms(samples))
                };
                let raw = |(site, filter)| Cell {
                    codec: RAW.to_owned(),
                    settings: raw_settings.clone(),
                    site,
                    filter,
                    stages: None,
                    resolution: 0,
                    ..cell.clone()
                };
                for of_raw in [REFERENCE, (cell.site, filter_of_raw(cell.filter))] {
                    let key = (cell.scene.clone(), cell.renderer.clone(), of_raw);
                    if !drawn.contains(&key) {
                        time.drawing += pictures * frame_ms(&raw(of_raw)) / 1000.0;
                        drawn.push(key);
                    }
                }
                let own = frame_ms(cell);
                let baseline = frame_ms(&raw(BASELINE));
                let drawing = pictures * (own + pairing_ms(baseline, own, pairs::budget())) / 1000.0;
                time.drawing += drawing;
                time.share(cell).drawing += drawing;
            }
        }
    }
    time.at_least = trials.costs().iter().any(|cost| cost.lacks.is_some());
    Ok(time)
}

fn coding_seconds(
    trials: &mut Trials<'_>,
    codec: &str,
    settings: &cvr_core::codec::Settings,
    layout: &VolumeLayout,
) -> f64 {
    let per_voxel = trials
        .of(codec, settings, layout)
        .map_or(0.0, |trial| trial.encode_seconds_per_voxel() + trial.decode_seconds_per_voxel());
    per_voxel * layout.voxels() as f64
}

/// Milliseconds of a pairing, warm-up included. It runs the real protocol over frames of these times.
fn pairing_ms(baseline_ms: f64, cell_ms: f64, budget: PairBudget) -> f64 {
    let spent = std::cell::Cell::new(0.0);
    let frame = |wall_ms: f64| {
        spent.set(spent.get() + wall_ms);
        Ok::<_, std::convert::Infallible>(FrameTime { wall_ms, gpu_ms: None, cpu_ms: None })
    };
    let Ok(_) = paired(|| frame(baseline_ms), || frame(cell_ms), budget);
    spent.get()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pairing_draws_as_often_as_the_protocol_says() {
        // Fast frames: three warm-up rounds and 31 pairs. Slow frames: one warm-up round and 7 pairs.
        let budget = PairBudget::default();
        assert!((pairing_ms(1.0, 2.0, budget) - 34.0 * 3.0).abs() < 1e-6);
        assert!((pairing_ms(1000.0, 500.0, budget) - 8.0 * 1500.0).abs() < 1e-6);
    }
}
