//! What subjects are made of: samples by position, hashes, and a smooth field.

use crate::volume::{DenseVolume, Extent, SampleType, Samples, VolumeLayout};

/// Where a sample lies.
pub(super) struct At {
    pub(super) p: [u32; 3],
    pub(super) frame: u32,
    pub(super) size: [u32; 3],
}

impl At {
    /// A number of its own for every voxel, frame and `seed`, `0.0..=1.0`.
    pub(super) fn noise(&self, seed: u32) -> f64 {
        let [x, y, z] = self.p;
        share([seed, x, y, z, self.frame])
    }

    /// Centre of the voxel along each axis, in the unit interval.
    pub(super) fn unit(&self) -> [f64; 3] {
        [0, 1, 2].map(|a: usize| (f64::from(self.p[a]) + 0.5) / f64::from(self.size[a]))
    }

    /// A smooth bump over most of the volume, 0 at the border and 1 in its middle, which is none of the volume's.
    pub(super) fn bump(&self) -> f64 {
        let [x, y, z] = self.unit();
        let along = |t: f64, centre: f64| ((t - centre) / 0.62).powi(2);
        let rest = (1.0 - along(x, 0.46) - along(y, 0.55) - along(z, 0.51)).max(0.0);
        rest * rest
    }

    /// From 0 at the first voxel to 1 at the last, along a direction that no axis has.
    pub(super) fn ramp(&self) -> f64 {
        let weigh = |p: [u32; 3]| f64::from(p[0] + 2 * p[1] + 3 * p[2]);
        weigh(self.p) / weigh(self.size.map(|n| n - 1)).max(1.0)
    }
}

/// A hash of numbers, evenly spread.
pub(super) fn hash<const N: usize>(numbers: [u32; N]) -> u32 {
    numbers.into_iter().fold(0x9e37_79b9, |h: u32, v| {
        let h = (h ^ v).wrapping_mul(0x85eb_ca6b);
        let h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
        h ^ (h >> 16)
    })
}

/// The same as a number `0.0..=1.0`.
pub(super) fn share<const N: usize>(numbers: [u32; N]) -> f64 {
    f64::from(hash(numbers)) / f64::from(u32::MAX)
}

/// A volume of `value` at every voxel; integers are rounded into their type.
#[allow(clippy::cast_possible_truncation, reason = "values are rounded into the range of the type")]
pub(super) fn volume(
    size: [u32; 3],
    frames: u32,
    sample: SampleType,
    value: impl Fn(&At) -> f64,
) -> DenseVolume {
    let extent = Extent::try_from(size).unwrap_or(Extent::ONE);
    let layout = VolumeLayout { frames, ..VolumeLayout::scalar(extent, sample) };
    let at = |i: usize| {
        let voxels = extent.voxels() as usize;
        value(&At { p: extent.position(i % voxels), frame: (i / voxels) as u32, size: extent.to_array() })
    };
    let values = (0..layout.samples() as usize).map(at);
    let samples = match sample {
        SampleType::U8 => Samples::U8(values.map(|v| v.round() as u8).collect()),
        SampleType::I8 => Samples::I8(values.map(|v| v.round() as i8).collect()),
        SampleType::U16 => Samples::U16(values.map(|v| v.round() as u16).collect()),
        SampleType::I16 => Samples::I16(values.map(|v| v.round() as i16).collect()),
        SampleType::F32 => Samples::F32(values.map(|v| v as f32).collect()),
    };
    #[allow(clippy::expect_used, reason = "the samples were made by the layout")]
    DenseVolume::new(layout, samples).expect("a volume made by its own layout")
}
