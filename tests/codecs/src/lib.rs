//! Code that the tests of several codecs share. A failure here is a failure of the calling test.

#![allow(
    clippy::unwrap_used,
    clippy::missing_panics_doc,
    reason = "helpers of tests, which a failed unwrap fails"
)]

pub mod device;
pub mod kept;
pub mod mutated;
pub mod real;

use cvr_core::codec::{Codec, SettingKind, SettingValue, Settings, Site};
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};

/// Settings as a configuration would write them.
#[must_use]
pub fn settings(pairs: &[(&str, &str)]) -> Settings {
    pairs.iter().map(|(name, value)| ((*name).to_owned(), SettingValue::from(*value))).collect()
}

/// Complete settings with which a codec offers a site: its defaults if it can be, or else the first that differ from them
/// in two of its choices at most. `None` if it never offers it.
#[must_use]
pub fn offering(codec: &dyn Codec, site: Site) -> Option<Settings> {
    let info = codec.info();
    let offers = |pairs: &[&(&str, SettingValue)]| {
        let given = pairs.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        let settings = info.complete(&given).unwrap();
        (codec.offers(&settings, site) && codec.encoder(&settings).is_ok()).then_some(settings)
    };
    let choices = info.settings.iter().flat_map(|setting| {
        let values: Vec<SettingValue> = match setting.kind {
            SettingKind::OneOf(numbers) => numbers.iter().map(|n| SettingValue::Integer(*n)).collect(),
            SettingKind::Choice(words) => words.iter().map(|w| SettingValue::from(*w)).collect(),
            _ => Vec::new(),
        };
        values.into_iter().map(|value| (setting.name, value))
    });
    let choices: Vec<_> = choices.collect();
    let pairs = choices.iter().flat_map(|one| choices.iter().map(move |two| [one, two]));
    offers(&[]).or_else(|| pairs.into_iter().find_map(|pair| offers(&pair)))
}

/// Frames of bytes by position, channel and frame.
#[must_use]
pub fn bytes(
    size: [u32; 3],
    channels: u32,
    frames: u32,
    value: impl Fn([u32; 3], u32, u32) -> u8,
) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, SampleType::U8) };
    let [x, y, _] = size.map(u64::from);
    let sample = |i: u64| {
        let (voxel, channel) = (i / u64::from(channels), (i % u64::from(channels)) as u32);
        let (frame, voxel) = ((voxel / extent.voxels()) as u32, voxel % extent.voxels());
        value([(voxel % x) as u32, (voxel / x % y) as u32, (voxel / x / y) as u32], channel, frame)
    };
    let samples = Samples::U8((0..layout.samples()).map(sample).collect());
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// Noise that depends on position and seed alone.
#[must_use]
pub fn hash(p: [u32; 3], seed: u32) -> u8 {
    let h = p.iter().fold(seed, |h, v| (h ^ v).wrapping_mul(0x85eb_ca6b) ^ (h >> 13));
    (h.wrapping_mul(0xc2b2_ae35) >> 24) as u8
}
