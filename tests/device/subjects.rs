//! Volumes, and their encoded streams.

use std::sync::Arc;

use cvr::registry;
use cvr_codec_tests::offering;
use cvr_core::codec::{
    Codec, ConfigError, Decoder, EncodeError, SettingKind, SettingValue, Settings, Site, decode_frame,
    encode_temporary,
};
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples, VolumeLayout,
};

/// The extent that fits no block and no workgroup.
pub const ODD: [u32; 3] = [13, 17, 23];

/// A volume whose samples are a function of the voxel's position.
pub fn volume(
    size: [u32; 3],
    spacing: [f64; 3],
    sample: SampleType,
    value: impl Fn([u32; 3]) -> f64,
) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { spacing, ..VolumeLayout::scalar(extent, sample) };
    let position = |i: u64| {
        let (x, y) = (u64::from(size[0]), u64::from(size[1]));
        [(i % x) as u32, (i / x % y) as u32, (i / x / y) as u32]
    };
    let values = || (0..extent.voxels()).map(|i| value(position(i)));
    let samples = match sample {
        SampleType::U8 => Samples::U8(values().map(|v| v.round() as u8).collect()),
        SampleType::I8 => Samples::I8(values().map(|v| v.round() as i8).collect()),
        SampleType::U16 => Samples::U16(values().map(|v| v.round() as u16).collect()),
        SampleType::I16 => Samples::I16(values().map(|v| v.round() as i16).collect()),
        SampleType::F32 => Samples::F32(values().map(|v| v as f32).collect()),
        other => panic!("no volumes of {other} in these tests"),
    };
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// Noise over the range of the number type, limited to halves, with both signs if the type has them. Floats have many
/// magnitudes.
pub fn noise(size: [u32; 3], sample: SampleType) -> FiniteVolume {
    let (low, high) = sample.integer_range().map_or((-1000.0, 1000.0), |(l, h)| (f64::from(l), f64::from(h)));
    volume(size, [1.0; 3], sample, |p| {
        let h = hash(p);
        let unit = f64::from(h) / f64::from(u32::MAX);
        let scale = if sample == SampleType::F32 { [1.0, 1e-3, 1e-7][(h % 3) as usize] } else { 1.0 };
        (low + (high - low) * unit).min(65504.0) * scale
    })
}

/// A number that differs from voxel to voxel.
pub fn hash(p: [u32; 3]) -> u32 {
    let mut h = 0x9e37_79b9_u32;
    for v in p {
        h = (h ^ v).wrapping_mul(0x85eb_ca6b);
        h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
        h ^= h >> 16;
    }
    h
}

/// The registered codec of this id.
pub fn codec(id: &str) -> Arc<dyn Codec> {
    registry::codecs().unwrap().get(id).unwrap().clone()
}

/// Settings from their text; the rest keep their defaults.
pub fn settings(pairs: &[(&str, &str)]) -> Settings {
    pairs.iter().map(|(name, value)| ((*name).to_owned(), SettingValue::from(*value))).collect()
}

/// A volume through a codec. `None` if the codec declines such volumes with these settings.
pub fn accepted(codec: &dyn Codec, settings: &Settings, volume: &FiniteVolume) -> Option<Box<dyn Decoder>> {
    match encode_temporary(codec, settings, volume) {
        Err(EncodeError::Unsupported(_)) => None,
        stream => Some(codec.decoder(Arc::new(stream.unwrap())).unwrap()),
    }
}

/// A volume through a codec.
pub fn encoded(codec: &dyn Codec, settings: &Settings, volume: &FiniteVolume) -> Box<dyn Decoder> {
    accepted(codec, settings, volume).unwrap()
}

/// The first frame on the CPU.
pub fn decoded(decoder: &dyn Decoder) -> Vec<f32> {
    decode_frame(decoder, FrameIndex::FIRST, &NoReferences).unwrap()
}

/// Values of a setting that give different shaders.
fn values(kind: &SettingKind) -> Vec<SettingValue> {
    match kind {
        SettingKind::Integer { min, max } => vec![SettingValue::Integer(*min), SettingValue::Integer(*max)],
        SettingKind::OneOf(all) => all.iter().map(|&i| SettingValue::Integer(i)).collect(),
        SettingKind::Float { min, max } => vec![SettingValue::Float(*min), SettingValue::Float(*max)],
        SettingKind::Choice(all) => all.iter().map(|&word| SettingValue::Text(word.to_owned())).collect(),
        SettingKind::Boolean => vec![SettingValue::Boolean(false), SettingValue::Boolean(true)],
        // A cube, boxes with an odd edge and with a long one, and one that no volume here fills.
        SettingKind::Block { .. } => ["4", "3x5x2", "1x7x16", "8x4x4", "32"]
            .iter()
            .filter_map(|&b| kind.canonical(&SettingValue::Text(b.to_owned())))
            .collect(),
        // Only the codec knows the meaning of a text, so the default is used.
        SettingKind::Text { .. } => Vec::new(),
    }
}

/// Settings in which every value of every setting occurs, but for contradictions. From one to the next, each setting advances by
/// one, so settings with different numbers of values meet in new pairs. `turn` is the start. If a snippet decodes the codec with
/// some settings, but with none of these, such settings come last.
pub fn sweep(codec: &dyn Codec, turn: usize) -> Vec<Settings> {
    let all = codec.info().settings.iter().map(|s| (s.name, values(&s.kind)));
    let all: Vec<_> = all.filter(|(_, values)| !values.is_empty()).collect();
    let count = all.iter().map(|(_, values)| values.len()).max().unwrap_or(1);
    let nth = |n: usize| {
        let pick = |(name, values): &(&str, Vec<SettingValue>)| {
            ((*name).to_owned(), values[(n + turn * count) % values.len()].clone())
        };
        without_contradiction(codec, all.iter().map(pick).collect())
    };
    let mut all: Vec<Settings> = (0..count).map(nth).collect();
    let inline = |settings: &Settings| codec.offers(&codec.info().complete(settings).unwrap(), Site::Inline);
    if !all.iter().any(inline) {
        all.extend(offering(codec, Site::Inline));
    }
    all
}

/// Settings that a codec accepts: the last number that a contradiction depends on has its default instead, and so on. If there is
/// still one, another setting has its default, the first with which there is none.
fn without_contradiction(codec: &dyn Codec, mut settings: Settings) -> Settings {
    let info = codec.info();
    let contradicts = |settings: &Settings| {
        matches!(codec.encoder(&info.complete(settings).unwrap()), Err(ConfigError::Contradiction(_)))
    };
    let numbers = info.settings.iter().rev().filter(|s| matches!(s.kind, SettingKind::Float { .. }));
    for setting in numbers {
        if !contradicts(&settings) {
            return settings;
        }
        settings.set(setting.name, info.default_settings().get(setting.name).unwrap().clone());
    }
    if !contradicts(&settings) {
        return settings;
    }
    let without = info.settings.iter().map(|setting| {
        let mut settings = settings.clone();
        settings.set(setting.name, info.default_settings().get(setting.name).unwrap().clone());
        settings
    });
    without.into_iter().find(|settings| !contradicts(settings)).unwrap_or_else(|| info.default_settings())
}
