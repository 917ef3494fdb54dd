//! Checks scenes against their data before a run: which of them show nothing. For some, the number type of the samples
//! is enough. Small volumes are read or computed, and drawn as thumbnails.

use std::collections::BTreeSet;

use cvr_core::pipeline::{Experiment, Resolution, Scene, Volume};
use cvr_core::render::{DecodedFrame, Filter, Image, Renderer, View};
use cvr_core::volume::{BrickSource, FiniteVolume, ValueRange};

use super::blank;
use super::scenes::read_table;
use super::volumes::{LoadError, read};
use crate::estimate::volume_layout;
use crate::experiment::measured::reference::check_range;
use crate::registry::renderer;

/// Most samples of a volume to read, and of all volumes together.
const MOST_SAMPLES: [u64; 2] = [1 << 25, 1 << 26];
/// Longer sides of thumbnails. A picture that is blank in the small size is drawn again in the larger one.
const THUMBNAILS: [u32; 2] = [24, 96];
/// Frames of a scene that are drawn.
const MOST_FRAMES: usize = 8;

/// What was found.
#[derive(Debug, Default)]
pub struct Preview {
    /// Scenes that show nothing.
    pub warnings: Vec<String>,
    /// Why scenes were not checked, one sentence for each volume or scene.
    pub unchecked: Vec<String>,
}

/// Looks at the scenes that cells draw.
#[must_use]
pub fn preview(experiment: &Experiment, resolution: &Resolution) -> Preview {
    let drawn: BTreeSet<(&str, &str)> =
        resolution.cells.iter().map(|cell| (cell.volume.as_str(), cell.scene.as_str())).collect();
    let mut preview = Preview::default();
    let mut left = MOST_SAMPLES[1];
    for volume in &experiment.volumes {
        let is_drawn = |scene: &&Scene| drawn.contains(&(volume.name.as_str(), scene.name.as_str()));
        let mut scenes: Vec<Scene> = experiment.scenes_of(&volume.name).filter(is_drawn).cloned().collect();
        scenes.retain_mut(|scene| match read_table(scene) {
            Ok(()) => true,
            Err(problem) => {
                preview.unchecked.push(problem.to_string());
                false
            }
        });
        if let Err(problem) = look(volume, scenes, experiment.seed, &mut left, &mut preview.warnings) {
            preview.unchecked.push(problem);
        }
    }
    preview
}

/// Checks the scenes of one volume. The error says why not all were checked.
fn look(
    volume: &Volume,
    mut scenes: Vec<Scene>,
    seed: u64,
    left: &mut u64,
    warnings: &mut Vec<String>,
) -> Result<(), String> {
    let Volume { name, .. } = volume;
    let text = |e: LoadError| e.to_string();
    let layout = volume_layout(volume).map_err(text)?;
    let layout = layout.ok_or_else(|| format!("volume `{name}`: slices are not read before a run"))?;
    let mut warn = |scene: &Scene, remark: &str| warnings.push(blank::warning(&scene.name, name, remark));
    if let Some(range) = layout.sample.integer_range().map(|(min, max)| [min, max].map(|v| v as f32)) {
        let range = ValueRange { min: range[0], max: range[1] };
        scenes.retain(|scene| {
            let remark = blank::foreseen(scene, layout.channels, range);
            remark.iter().for_each(|remark| warn(scene, &format!("{remark} at most ({})", layout.sample)));
            remark.is_none()
        });
    }
    if scenes.is_empty() {
        return Ok(());
    }
    let samples = layout.samples();
    if samples > MOST_SAMPLES[0].min(*left) {
        return Err(format!("volume `{name}`: {samples} samples are not read before a run"));
    }
    *left -= samples;
    let volume = read(volume, seed).map_err(text)?.0.finite();
    check_range(volume.range()).map_err(|problem| format!("volume `{name}`: {problem}"))?;
    for scene in &scenes {
        let remark = blank::foreseen(scene, layout.channels, volume.range());
        match remark.map_or_else(|| thumbnails(scene, &volume), |remark| Ok(Some(remark))) {
            Ok(remark) => remark.iter().for_each(|remark| warn(scene, remark)),
            Err(problem) => return Err(format!("scene `{}` of volume `{name}`: {problem}", scene.name)),
        }
    }
    Ok(())
}

/// The remark on frames whose thumbnail shows nothing.
fn thumbnails(scene: &Scene, volume: &FiniteVolume) -> Result<Option<String>, String> {
    let renderer = renderer("raycasting")?;
    let layout = volume.layout();
    let view = scene.view(volume.range(), Filter::Linear).map_err(|e| e.to_string())?;
    let mut blank = Vec::new();
    for frame in scene.frames.iter().filter(|frame| frame.0 < layout.frames).take(MOST_FRAMES) {
        let values = volume.dense().frame_values(frame);
        let voxels = DecodedFrame::new(layout.clone(), values).ok_or("no whole frame")?;
        let mut shows = false;
        for longer in THUMBNAILS {
            shows = shows || !blank::is_blank(&thumbnail(renderer.as_ref(), &view, longer, &voxels)?);
        }
        if !shows {
            blank.push(frame);
        }
    }
    let [width, height] = thumbnail_size(view.size, THUMBNAILS[1]);
    let remark = blank::remark(&view, layout.channels, &blank, scene.frames);
    Ok(remark.map(|remark| format!("{remark} (seen in {width} × {height} pixels)")))
}

fn thumbnail(
    renderer: &dyn Renderer,
    view: &View,
    longer: u32,
    voxels: &DecodedFrame,
) -> Result<Image, String> {
    let view = View { size: thumbnail_size(view.size, longer), ..view.clone() };
    let mut image = Image::new(view.size);
    renderer.reference(&view, voxels, &mut image).map_err(|e| e.to_string())?;
    Ok(image)
}

/// A size in about these proportions, no larger than the picture's own.
fn thumbnail_size(size: [u32; 2], longer: u32) -> [u32; 2] {
    let longest = u64::from(size[0].max(size[1]));
    let scaled = |n: u32| (u64::from(n) * u64::from(longer) / longest).max(1) as u32;
    if longest <= u64::from(longer) { size } else { size.map(scaled) }
}
