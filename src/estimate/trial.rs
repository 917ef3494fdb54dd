//! A codec with its settings tried on a small computed volume.

use std::collections::BTreeMap;

use cvr_core::codec::{Progress, Settings, Site};
use cvr_core::pipeline::{Cell, Scene, TransferDomain};
use cvr_core::render::{Filter, Preset, View};
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, SampleType, Samples, VolumeLayout,
};

use crate::experiment::encoded::{Encoded, encode};
use crate::experiment::host_texture::HostTexture;
use crate::experiment::target::{Decoded, Target, VoxelSource};
use crate::input::{Generator, generate};
use crate::registry::{Names, renderer};

/// Voxels along each axis of the volume that is tried.
pub const TRIAL_EDGE: u32 = 48;
/// Sides in pixels of the two pictures that are drawn of it.
const SIDES: [u32; 2] = [32, 96];

/// What one codec with one set of settings made of the small volume.
#[derive(Debug)]
pub struct Trial {
    encoded: Encoded,
    voxels: f64,
}

/// Milliseconds of a frame: `fixed_ms + ms_per_sample × samples`, samples as [`samples`] counts them.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Frames {
    /// What a frame takes however small it is.
    pub fixed_ms: f64,
    /// What each sample along a ray, or on a slice, adds.
    pub ms_per_sample: f64,
}

impl Frames {
    /// Milliseconds of a frame of so many samples.
    #[must_use]
    pub fn frame_ms(self, samples: f64) -> f64 {
        self.fixed_ms + self.ms_per_sample * samples
    }

    /// The line through two measurements; neither part is negative.
    fn through([(few, few_ms), (many, many_ms)]: [(f64, f64); 2]) -> Self {
        let ms_per_sample = ((many_ms - few_ms) / (many - few)).max(0.0);
        Self { fixed_ms: (few_ms - ms_per_sample * few).max(0.0), ms_per_sample }
    }
}

/// Samples of a picture: its pixels times the edge of a cube as large as the volume, in steps. Rays that pass by or end
/// early, clip boxes and skipping are not taken off.
#[must_use]
pub fn samples(scene: &Scene, layout: &VolumeLayout) -> f64 {
    let [width, height] = scene.size.map(f64::from);
    let lengths = layout.extent.to_array().into_iter().zip(layout.spacing);
    let volume: f64 = lengths.map(|(n, spacing)| f64::from(n) * spacing / layout.voxel_length()).product();
    width * height * volume.cbrt() / f64::from(scene.step_voxels)
}

impl Trial {
    /// Encodes and decodes the small volume.
    ///
    /// # Errors
    /// A sentence, when the codec or the disk refuses.
    pub fn new(
        names: &Names,
        codec: &str,
        settings: &Settings,
        sample: SampleType,
        channels: u32,
    ) -> Result<Self, String> {
        let codec = names.codecs().get(codec).map_err(|e| e.to_string())?;
        let volume = small_volume(sample, channels)?;
        let scratch = tempfile::tempdir().map_err(|e| format!("a temporary folder: {e}"))?;
        let encoded = encode(codec.as_ref(), settings, &volume, scratch.path(), &Progress::silent())?;
        Ok(Self { encoded, voxels: volume.layout().voxels() as f64 })
    }

    /// Wall seconds to encode a voxel, the file written and synced.
    #[must_use]
    pub fn encode_seconds_per_voxel(&self) -> f64 {
        self.encoded.encode_seconds / self.voxels
    }

    /// Wall seconds to decode a voxel on the CPU.
    #[must_use]
    pub fn decode_seconds_per_voxel(&self) -> f64 {
        self.encoded.decode_seconds / self.voxels
    }

    /// Bytes of the encoded file for each voxel.
    #[must_use]
    pub fn stream_bytes_per_voxel(&self) -> f64 {
        self.encoded.file_bytes as f64 / self.voxels
    }

    /// Bytes of a texel of the decoded frame on a device. Textures have one channel or four.
    #[must_use]
    pub fn texel_bytes(&self) -> u64 {
        let channels = if self.encoded.decoder.layout().channels == 1 { 1 } else { 4 };
        self.encoded.decoder.decoded_form().format.bytes() as u64 * channels
    }

    /// Bytes for each voxel of the texture at the site *host*: of blocks where the target takes those of the codec, else
    /// of texels.
    #[must_use]
    pub fn host_bytes_per_voxel(&self, target: &Target) -> f64 {
        let decoder = self.encoded.decoder.as_ref();
        match target.blocks(decoder, (FrameIndex::FIRST, self.encoded.level)) {
            Some(Ok(blocks)) => (blocks.words.len() * 4) as f64 / decoder.layout().extent.voxels() as f64,
            _ => self.texel_bytes() as f64,
        }
    }

    /// What holds a frame at the site *host*, were `target` to draw.
    ///
    /// # Errors
    /// A sentence, when the target has no texture for it.
    pub fn host_texture(&self, target: &Target) -> Result<HostTexture, String> {
        let key = (FrameIndex::FIRST, self.encoded.level);
        HostTexture::of(target, self.encoded.decoder.as_ref(), key).map_err(|e| e.to_string())
    }

    /// Bytes for each voxel of the buffers from which a shader decodes; 0 of a codec that has none.
    ///
    /// # Errors
    /// A sentence, when the stream lacks one.
    pub fn buffer_bytes_per_voxel(&self) -> Result<f64, String> {
        let Some(shader) = self.encoded.decoder.shader() else { return Ok(0.0) };
        let resources = shader.resources(FrameIndex::FIRST).map_err(|e| e.to_string())?;
        Ok(resources.iter().map(|r| r.words.len() * 4).sum::<usize>() as f64 / self.voxels)
    }

    /// Draws two pictures of the small volume as `cell` would, in `scene`'s step, light and box, under a faint transfer
    /// function that ends no ray; each once to warm up, and once to time it.
    ///
    /// # Errors
    /// A sentence, when the target refuses.
    pub fn frames(&self, target: &Target, cell: &Cell, scene: &Scene) -> Result<Frames, String> {
        let renderer = renderer(&cell.renderer)?;
        let decoder = self.encoded.decoder.as_ref();
        let (index, level) = (FrameIndex::FIRST, cell.level());
        let frame = self.encoded.frame(index)?;
        let decoded = match cell.site {
            Site::Host => target.upload(decoder, (index, level), frame).map(Decoded::Host),
            Site::Ring => Ok(Decoded::Ring(frame.clone())),
            Site::Deferred => {
                target.decode(&cell.codec, decoder, (index, level), &frame).map(Decoded::Deferred)
            }
            _ => Ok(Decoded::Inline),
        };
        let decoded = decoded.map_err(|e| e.to_string())?;
        let voxels = VoxelSource { codec: &cell.codec, decoder, frame: index, level, decoded };
        let mut measured = [(0.0, 0.0); 2];
        for (side, measured) in SIDES.into_iter().zip(&mut measured) {
            let scene = small_scene(scene, side);
            let view = view_of(&scene, decoder.layout(), cell.filter)?;
            let picture = target.picture(renderer.as_ref(), &view, &voxels).map_err(|e| e.to_string())?;
            picture.draw().map_err(|e| e.to_string())?;
            let time = picture.draw().map_err(|e| e.to_string())?;
            *measured = (samples(&scene, decoder.layout()), time.wall_ms);
        }
        Ok(Frames::through(measured))
    }
}

fn small_scene(scene: &Scene, side: u32) -> Scene {
    let ramp = Preset::named("ramp").map(Preset::control_points).unwrap_or_default();
    Scene {
        size: [side; 2],
        control_points: ramp,
        domain: TransferDomain::Range,
        early_termination: 1.0,
        ..scene.clone()
    }
}

fn view_of(scene: &Scene, layout: &VolumeLayout, filter: Filter) -> Result<View, String> {
    let (min, max) = layout.sample.integer_range().unwrap_or((0, 1));
    let range = cvr_core::volume::ValueRange { min: min.max(0) as f32, max: max as f32 };
    scene.view(range, filter).map_err(|e| e.to_string())
}

/// Noise of several octaves: neither the easiest nor the hardest thing for a codec. Of a colour volume, all channels
/// hold the same.
fn small_volume(sample: SampleType, channels: u32) -> Result<FiniteVolume, String> {
    fn repeated<T: Copy>(values: Vec<T>, channels: u32) -> Vec<T> {
        values.into_iter().flat_map(|v| std::iter::repeat_n(v, channels as usize)).collect()
    }
    let extent = Extent::cube(TRIAL_EDGE).map_err(|e| e.to_string())?;
    let scalar = generate(Generator::Turbulence, extent, sample, 1).map_err(|e| e.to_string())?;
    let layout = VolumeLayout { channels, ..scalar.layout().clone() };
    let samples = match scalar.into_samples() {
        Samples::U8(v) => Samples::U8(repeated(v, channels)),
        Samples::I8(v) => Samples::I8(repeated(v, channels)),
        Samples::U16(v) => Samples::U16(repeated(v, channels)),
        Samples::I16(v) => Samples::I16(repeated(v, channels)),
        Samples::F32(v) => Samples::F32(repeated(v, channels)),
        _ => return Err(format!("samples of type {sample} are not generated")),
    };
    Ok(FiniteVolume::new(DenseVolume::new(layout, samples)?))
}

/// Trials that were made, each once.
#[derive(Debug)]
pub struct Trials<'a> {
    names: &'a Names,
    trials: BTreeMap<String, Result<Trial, String>>,
    frames: BTreeMap<String, Result<Frames, String>>,
}

impl<'a> Trials<'a> {
    /// None yet.
    #[must_use]
    pub const fn new(names: &'a Names) -> Self {
        Self { names, trials: BTreeMap::new(), frames: BTreeMap::new() }
    }

    /// The trial of a codec with settings for volumes of this layout.
    ///
    /// # Errors
    /// As [`Trial::new`].
    pub fn of(&mut self, codec: &str, settings: &Settings, layout: &VolumeLayout) -> Result<&Trial, String> {
        let key = trial_key(codec, settings, layout);
        let make = || Trial::new(self.names, codec, settings, layout.sample, layout.channels);
        self.trials.entry(key).or_insert_with(make).as_ref().map_err(Clone::clone)
    }

    /// What frames of a cell take. Scenes that differ in size, camera or colours share a measurement.
    ///
    /// # Errors
    /// As [`Trial::new`] and [`Trial::frames`].
    pub fn frames(
        &mut self,
        target: &Target,
        cell: &Cell,
        scene: &Scene,
        layout: &VolumeLayout,
    ) -> Result<Frames, String> {
        let lit = if scene.shading.is_some() { "lit" } else { "unlit" };
        let trial = trial_key(&cell.codec, &cell.settings, layout);
        let key = format!("{trial} {} {} {} {lit}", cell.renderer, cell.site, cell.filter);
        if let Some(known) = self.frames.get(&key) {
            return known.clone();
        }
        let frames =
            self.of(&cell.codec, &cell.settings, layout).and_then(|trial| trial.frames(target, cell, scene));
        self.frames.insert(key, frames.clone());
        frames
    }
}

fn trial_key(codec: &str, settings: &Settings, layout: &VolumeLayout) -> String {
    format!("{codec} {settings} {} {}", layout.sample, layout.channels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_through_both_measurements_unless_a_part_were_negative() {
        let line = Frames::through([(100.0, 3.0), (1100.0, 5.0)]);
        assert!((line.frame_ms(100.0) - 3.0).abs() < 1e-9 && (line.frame_ms(1100.0) - 5.0).abs() < 1e-9);
        assert_eq!(
            Frames::through([(100.0, 5.0), (1100.0, 3.0)]),
            Frames { fixed_ms: 5.0, ms_per_sample: 0.0 }
        );
        let steep = Frames::through([(100.0, 1.0), (200.0, 10.0)]);
        assert!(steep.fixed_ms == 0.0 && steep.ms_per_sample > 0.0);
    }

    #[test]
    fn a_trial_says_what_a_codec_makes_of_a_voxel() {
        let names = Names::new().unwrap();
        let mut trials = Trials::new(&names);
        let layout = VolumeLayout::scalar(Extent::cube(100).unwrap(), SampleType::U16);
        let raw = names.codecs().get("raw").unwrap().info().default_settings();
        let raw = trials.of("raw", &raw, &layout).unwrap();
        assert!((raw.stream_bytes_per_voxel() - 2.0).abs() < 0.05);
        assert_eq!((raw.texel_bytes(), raw.buffer_bytes_per_voxel().unwrap()), (2, 2.0));
        let colour = VolumeLayout { channels: 3, sample: SampleType::U8, ..layout.clone() };
        let raw = names.codecs().get("raw").unwrap().info().default_settings();
        assert_eq!(trials.of("raw", &raw, &colour).unwrap().texel_bytes(), 4);
        let s3dc = names.codecs().get("s3dc").unwrap().info().default_settings();
        let s3dc = trials.of("s3dc", &s3dc, &layout).unwrap();
        // 4 bits of index, and two ends for a block of 16³.
        assert!((s3dc.buffer_bytes_per_voxel().unwrap() - 0.5).abs() < 0.01);
        assert!(s3dc.encode_seconds_per_voxel() > 0.0 && s3dc.decode_seconds_per_voxel() > 0.0);
        // Half a byte in blocks where the target takes such; decoded, 16 bits.
        let bc4 = names.codecs().get("bc4").unwrap().info().default_settings();
        let bc4 = trials.of("bc4", &bc4, &layout).unwrap();
        assert_eq!(bc4.buffer_bytes_per_voxel().unwrap(), 0.5);
        assert_eq!(bc4.host_bytes_per_voxel(&Target::Cpu { reason: None }), 2.0);
        assert!(trials.of("none", &Settings::default(), &layout).is_err());
    }
}
