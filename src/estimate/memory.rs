//! Memory that a run holds at its height.

use cvr_core::codec::{Settings, Site};
use cvr_core::pipeline::Resolution;
use cvr_core::volume::VolumeLayout;

use super::Trials;
use crate::experiment::measured::reference::{BASELINE, RAW, REFERENCE};
use crate::registry::Names;
use crate::site;
use crate::site::target::Target;

/// What is counted, as a sentence for readers of the figures.
pub const COUNTED: &str = "Counted in main memory: every original at once, and, of one volume and one codec at a time, \
     the encoded stream and the decoded frame in single precision, both also of raw, the baseline. On the device: the \
     texture and buffers of raw, and texture, buffers or both of the cell, as its site asks; of a ring, its layers across the shortest axis. Not counted: pictures, \
     scratch space of encoders and of passes, a second copy where a file's axes are reordered, and decoded frames that are \
     kept to predict others, at most `decoded_frames_mb` of a stream.";

/// Bytes.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// In main memory.
    pub main_bytes: u64,
    /// Bytes on the device. 0 if the CPU mirror draws.
    pub device_bytes: u64,
    /// Whether a trial is missing: there may be more.
    pub at_least: bool,
}

/// Memory of a codec with its settings for a volume.
struct Held {
    /// Stream and decoded frame, in main memory.
    main: f64,
    /// On the device, for each requested site.
    device: Vec<f64>,
}

impl Held {
    /// Without a trial, only the decoded frame is known.
    fn unknown(layout: &VolumeLayout) -> Self {
        Self { main: frame_bytes(layout), device: Vec::new() }
    }
}

fn frame_bytes(layout: &VolumeLayout) -> f64 {
    layout.samples_per_frame() as f64 * size_of::<f32>() as f64
}

/// The maximum over all cells whose volume has a layout, if `target` draws. `layout_of` gives a volume's layout by its
/// name.
///
/// What no trial could measure is left out.
///
/// # Errors
/// A sentence, when there is no codec `raw`.
pub fn estimate<'l>(
    resolution: &Resolution,
    names: &Names,
    trials: &mut Trials<'_>,
    target: &Target,
    layout_of: &dyn Fn(&str) -> Option<&'l VolumeLayout>,
) -> Result<Memory, String> {
    let raw_settings = names.codecs().get(RAW).map_err(|e| e.to_string())?.info().default_settings();
    let mut originals: Vec<(&str, u64)> = Vec::new();
    let (mut main, mut device, mut at_least) = (0.0_f64, 0.0_f64, false);
    for group in resolution.cells.chunk_by(crate::experiment::shards::shard::same_group) {
        let first = &group[0];
        let Some(layout) = layout_of(&first.volume) else { continue };
        if !originals.iter().any(|(name, _)| *name == first.volume) {
            originals.push((&first.volume, layout.bytes()));
        }
        let mut of = |codec: &str, settings: &Settings, sites: &[Site]| {
            held(trials, target, (codec, settings, sites), layout).unwrap_or_else(|_| {
                at_least = true;
                Held::unknown(layout)
            })
        };
        let sites: Vec<Site> = group.iter().map(|cell| cell.site).collect();
        let raw = of(RAW, &raw_settings, &[BASELINE.0, REFERENCE.0]);
        let own = of(&first.codec, &first.settings, &sites);
        main = main.max(raw.main + own.main);
        let largest = own.device.into_iter().fold(0.0, f64::max);
        device = device.max(raw.device.into_iter().sum::<f64>() + largest);
    }
    let originals: u64 = originals.iter().map(|(_, bytes)| bytes).sum();
    Ok(Memory { main_bytes: originals + main as u64, device_bytes: device as u64, at_least })
}

fn held(
    trials: &mut Trials<'_>,
    target: &Target,
    (codec, settings, sites): (&str, &Settings, &[Site]),
    layout: &VolumeLayout,
) -> Result<Held, String> {
    let trial = trials.of(codec, settings, layout)?;
    let at = |site: &Site| site::of(*site).device_bytes(trial.coded(codec), target, layout);
    Ok(Held {
        main: trial.stream_bytes_per_voxel() * layout.voxels() as f64 + frame_bytes(layout),
        device: sites.iter().map(at).collect::<Result<_, _>>()?,
    })
}

#[cfg(test)]
mod tests {
    use cvr_core::pipeline::{Capabilities, Document, resolve};
    use cvr_core::volume::{Extent, SampleType};

    use super::*;
    use crate::estimate::Allowance;

    #[test]
    fn the_height_is_what_lies_in_memory_at_once() {
        let text = include_str!("../../configs/quickstart.toml");
        let names = Names::new().unwrap();
        let set = |sites: &str| {
            let mut document = Document::parse("x.toml", text).unwrap();
            document.set("codec.s3dc.block=16").unwrap();
            document.set("codec.s3dc.index_bits=8").unwrap();
            document.set("pipeline.filter=linear").unwrap();
            document.set("pipeline.renderer=slicing").unwrap();
            document.set("pipeline.geometry=axis").unwrap();
            document.set(&format!("pipeline.site={sites}")).unwrap();
            resolve(&document.experiment(&names.known()).unwrap(), &names.known(), &Capabilities::default())
        };
        let layout = VolumeLayout::scalar(Extent::cube(64).unwrap(), SampleType::U8);
        let mut trials = Trials::new(&names, Allowance::default());
        let cpu = Target::Cpu { reason: None };
        let mut memory = |sites: &str| {
            let layout_of = |name: &str| (name == "rings").then_some(&layout);
            estimate(&set(sites), &names, &mut trials, &cpu, &layout_of).unwrap()
        };
        let voxels = (64.0_f64).powi(3);
        // Original; stream and frame of raw; the larger of the other streams and frames; plus headers of files.
        let main = memory("inline").main_bytes as f64 / voxels;
        assert!((1.0 + 5.0 + 5.0..11.2).contains(&main), "{main}");
        // raw in a texture and in a buffer; s3dc as one-byte indices, or in single precision.
        for (sites, bytes) in
            [("inline", 3.0), ("host", 6.0), ("deferred", 7.0), ("ring", 3.0 + 4.0 * 5.0 / 64.0)]
        {
            let device = memory(sites).device_bytes as f64 / voxels;
            assert!((bytes..bytes + 0.1).contains(&device), "{sites}: {device}");
        }
        let none =
            estimate(&set("inline"), &names, &mut Trials::new(&names, Allowance::default()), &cpu, &|_| None)
                .unwrap();
        assert_eq!(none, Memory::default());
    }
}
