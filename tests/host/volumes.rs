//! Small volumes, and volumes through codecs.

use std::sync::Arc;

use cvr::input::{Generator, generate};
use cvr_core::codec::{Codec, Decoder, EncodeError, Settings, encode_temporary};
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};

/// A scalar volume of single-precision values by their position.
pub fn floats(size: [u32; 3], value: impl Fn([u32; 3]) -> f32) -> DenseVolume {
    let extent = Extent::try_from(size).unwrap();
    let [x, y, z] = size;
    let points = (0..z).flat_map(|k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])));
    let samples = Samples::F32(points.map(value).collect());
    DenseVolume::new(VolumeLayout::scalar(extent, SampleType::F32), samples).unwrap()
}

/// A volume of moderate, varied values that every codec and sample type can hold.
pub fn varied(size: [u32; 3], sample: SampleType, channels: u32) -> FiniteVolume {
    let layout = VolumeLayout { channels, ..VolumeLayout::scalar(Extent::try_from(size).unwrap(), sample) };
    let values = (0..layout.samples() as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 25) as u8);
    let samples = match sample {
        SampleType::U8 => Samples::U8(values.collect()),
        SampleType::I8 => Samples::I8(values.map(|v| v as i8 - 64).collect()),
        SampleType::U16 => Samples::U16(values.map(|v| u16::from(v) * 300).collect()),
        SampleType::I16 => Samples::I16(values.map(|v| i16::from(v) * 250 - 16_000).collect()),
        SampleType::F32 => Samples::F32(values.map(|v| f32::from(v) * 0.37 - 20.0).collect()),
        other => panic!("add the sample type {other} here"),
    };
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// A computed volume.
pub fn computed(generator: Generator, size: [u32; 3], sample: SampleType) -> DenseVolume {
    seeded(generator, size, sample, 1)
}

/// A computed volume with a seed.
pub fn seeded(generator: Generator, size: [u32; 3], sample: SampleType, seed: u64) -> DenseVolume {
    generate(generator, Extent::try_from(size).unwrap(), sample, seed).unwrap()
}

/// The same samples at another spacing.
pub fn spaced(volume: &DenseVolume, spacing: [f64; 3]) -> DenseVolume {
    use cvr_core::volume::BrickSource as _;
    DenseVolume::new(VolumeLayout { spacing, ..volume.layout().clone() }, volume.samples().clone()).unwrap()
}

/// A volume encoded and opened again. The error is the sentence in which the codec declines such volumes.
pub fn declined_or_opened(
    codec: &dyn Codec,
    settings: &Settings,
    volume: &FiniteVolume,
) -> Result<Box<dyn Decoder>, String> {
    match encode_temporary(codec, settings, volume) {
        Ok(stream) => Ok(codec.decoder(Arc::new(stream)).unwrap()),
        Err(EncodeError::Unsupported(problem)) => Err(problem),
        Err(error) => panic!("{} {settings}: {error}", codec.info().id),
    }
}

/// A volume encoded and opened again.
pub fn opened(codec: &dyn Codec, settings: &Settings, volume: &FiniteVolume) -> Box<dyn Decoder> {
    declined_or_opened(codec, settings, volume)
        .unwrap_or_else(|problem| panic!("{} {settings}: {problem}", codec.info().id))
}
