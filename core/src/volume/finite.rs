//! The volume that codecs, shaders and metrics see: NaN, infinities and subnormals are replaced and counted.
//!
//! WGSL allows a shader to assume that NaN and infinity do not occur, and to flush subnormals. Such a value must not
//! enter a comparison.

use serde::{Deserialize, Serialize};

use super::{BrickSource, DenseVolume, FrameIndex, Region, Samples, SourceError, ValueRange, VolumeLayout};

/// How many samples were replaced before encoding.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Replaced {
    /// NaN, replaced by the lowest finite value.
    pub nan: u64,
    /// ±∞, replaced by the highest or lowest finite value.
    pub infinite: u64,
    /// Subnormals, replaced by zero.
    pub subnormal: u64,
    /// Samples of a wider number type that single precision cannot hold, rounded to the nearest number. Written only if
    /// there are any.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rounded: u64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
const fn is_zero(n: &u64) -> bool {
    *n == 0
}

impl Replaced {
    /// Number of unusable samples. Rounded samples are usable and do not count.
    #[must_use]
    pub const fn total(self) -> u64 {
        self.nan + self.infinite + self.subnormal
    }

    /// A sentence about the unusable samples and their replacements, for a volume of `samples` samples. `None` if all
    /// were usable.
    #[must_use]
    pub fn in_words(self, samples: u64) -> Option<String> {
        let Self { nan, infinite, subnormal, .. } = self;
        if self.total() == 0 {
            return None;
        }
        if nan + infinite == samples {
            return Some(format!(
                "none of the {samples} samples is finite ({nan} NaN, {infinite} infinite): all stand as 0"
            ));
        }
        let mut parts = Vec::new();
        if nan > 0 {
            parts.push(format!("{nan} NaN as the lowest finite value"));
        }
        if infinite > 0 {
            parts.push(format!("{infinite} infinite as the highest or lowest finite value"));
        }
        if subnormal > 0 {
            parts.push(format!("{subnormal} subnormal as 0"));
        }
        let all = self.total();
        Some(format!(
            "{all} of {samples} samples are no usable numbers and were replaced: {}",
            parts.join(", ")
        ))
    }
}

/// A volume with its value range. Every sample is finite and not subnormal.
#[derive(Clone, Debug)]
pub struct FiniteVolume {
    volume: DenseVolume,
    range: ValueRange,
    replaced: Replaced,
}

impl FiniteVolume {
    /// Replaces unusable samples. A volume without a finite sample becomes all zero.
    #[must_use]
    pub fn new(volume: DenseVolume) -> Self {
        Self::narrowed(volume, 0)
    }

    /// As [`FiniteVolume::new`], for a volume whose reader rounded `rounded` samples to single precision.
    #[must_use]
    pub fn narrowed(volume: DenseVolume, rounded: u64) -> Self {
        let flush = |v: f32| if v.is_subnormal() { 0.0 } else { v };
        let mut replaced = Replaced { rounded, ..Replaced::default() };
        let Samples::F32(values) = volume.samples() else {
            let range = volume.value_range().unwrap_or(ValueRange { min: 0.0, max: 0.0 });
            return Self { volume, range, replaced };
        };
        let range = ValueRange::of(values.iter().map(|&v| flush(v)));
        let range = range.unwrap_or(ValueRange { min: 0.0, max: 0.0 });
        if values.iter().all(|v| v.is_finite() && !v.is_subnormal()) {
            return Self { volume, range, replaced };
        }
        let mut replace = |v: f32| {
            if v.is_nan() {
                replaced.nan += 1;
                range.min
            } else if v.is_infinite() {
                replaced.infinite += 1;
                if v > 0.0 { range.max } else { range.min }
            } else {
                replaced.subnormal += u64::from(v.is_subnormal());
                flush(v)
            }
        };
        // In place: a volume may fit into memory once and not twice.
        let mut volume = volume;
        if let Some(values) = volume.single_mut() {
            values.iter_mut().for_each(|v| *v = replace(*v));
        }
        Self { volume, range, replaced }
    }

    /// The finite samples.
    #[must_use]
    pub const fn dense(&self) -> &DenseVolume {
        &self.volume
    }

    /// Lowest and highest sample over all frames and channels.
    #[must_use]
    pub const fn range(&self) -> ValueRange {
        self.range
    }

    /// What was replaced.
    #[must_use]
    pub const fn replaced(&self) -> Replaced {
        self.replaced
    }
}

impl BrickSource for FiniteVolume {
    fn layout(&self) -> &VolumeLayout {
        self.volume.layout()
    }

    fn read(&self, frame: FrameIndex, region: Region, out: &mut [f32]) -> Result<(), SourceError> {
        self.volume.read(frame, region, out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Extent, SampleType};

    fn finite(values: &[f32]) -> FiniteVolume {
        let extent = Extent::new(values.len() as u32, 1, 1).unwrap();
        let layout = VolumeLayout::scalar(extent, SampleType::F32);
        FiniteVolume::new(DenseVolume::new(layout, Samples::F32(values.to_vec())).unwrap())
    }

    #[test]
    fn replaces_and_counts() {
        let v = finite(&[1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-40, -3.0]);
        assert_eq!(v.dense().samples(), &Samples::F32(vec![1.0, -3.0, 1.0, -3.0, 0.0, -3.0]));
        assert_eq!(v.replaced(), Replaced { nan: 1, infinite: 2, subnormal: 1, rounded: 0 });
        assert_eq!(v.range(), ValueRange { min: -3.0, max: 1.0 });
        let told = "4 of 6 samples are no usable numbers and were replaced: 1 NaN as the lowest finite value, 2 infinite \
                    as the highest or lowest finite value, 1 subnormal as 0";
        assert_eq!(v.replaced().in_words(6).as_deref(), Some(told));
        assert_eq!(finite(&[1.0]).replaced().in_words(1), None);
    }

    #[test]
    fn a_volume_without_finite_samples_is_zero() {
        let v = finite(&[f32::NAN, f32::INFINITY]);
        assert_eq!(v.dense().samples(), &Samples::F32(vec![0.0, 0.0]));
        assert_eq!(v.replaced().total(), 2);
        let told = "none of the 2 samples is finite (1 NaN, 1 infinite): all stand as 0";
        assert_eq!(v.replaced().in_words(2).as_deref(), Some(told));
    }

    #[test]
    fn rounded_samples_are_told_apart() {
        let layout = VolumeLayout::scalar(Extent::ONE, SampleType::F32);
        let one = |value| DenseVolume::new(layout.clone(), Samples::F32(vec![value])).unwrap();
        let v = FiniteVolume::narrowed(one(f32::NAN), 1);
        assert_eq!((v.replaced().total(), v.replaced().rounded), (1, 1));
        let json = |v: &FiniteVolume| serde_json::to_string(&v.replaced()).unwrap();
        assert!(json(&v).contains("\"rounded\":1"));
        let exact = FiniteVolume::new(one(1.0));
        assert!(!json(&exact).contains("rounded"), "containers of exact samples are what they were");
        assert_eq!(serde_json::from_str::<Replaced>(&json(&exact)).unwrap(), exact.replaced());
    }
}
