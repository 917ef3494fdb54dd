//! A volume held in memory.

use rayon::prelude::*;

use crate::memory::Held;

use super::{BrickSource, FrameIndex, Region, SampleType, SourceError, ValueRange, VolumeLayout};

/// Samples in their own number type: x fastest, channels interleaved, frames one after another.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Samples {
    /// Unsigned, 8 bits.
    U8(Vec<u8>),
    /// Signed, 8 bits.
    I8(Vec<i8>),
    /// Unsigned, 16 bits.
    U16(Vec<u16>),
    /// Signed, 16 bits.
    I16(Vec<i16>),
    /// IEEE single precision.
    F32(Vec<f32>),
}

/// Applies one expression to the vector inside a `Samples`.
macro_rules! each {
    ($samples:expr, $v:ident => $body:expr) => {
        match $samples {
            Samples::U8($v) => $body,
            Samples::I8($v) => $body,
            Samples::U16($v) => $body,
            Samples::I16($v) => $body,
            Samples::F32($v) => $body,
        }
    };
}

impl Samples {
    /// Number type.
    #[must_use]
    pub const fn sample_type(&self) -> SampleType {
        match self {
            Self::U8(_) => SampleType::U8,
            Self::I8(_) => SampleType::I8,
            Self::U16(_) => SampleType::U16,
            Self::I16(_) => SampleType::I16,
            Self::F32(_) => SampleType::F32,
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        each!(self, v => v.len())
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The samples as little-endian bytes (a copy-free view on little-endian machines).
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        each!(self, v => bytemuck::cast_slice(v))
    }

    /// Builds samples from raw bytes. `big_endian` is their byte order.
    ///
    /// Returns `None` if the number of bytes is not a multiple of the sample size.
    #[must_use]
    pub fn from_bytes(sample: SampleType, bytes: &[u8], big_endian: bool) -> Option<Self> {
        if !bytes.len().is_multiple_of(sample.bytes()) {
            return None;
        }
        let two = |b: &[u8]| if big_endian { [b[1], b[0]] } else { [b[0], b[1]] };
        let four = |b: &[u8]| if big_endian { [b[3], b[2], b[1], b[0]] } else { [b[0], b[1], b[2], b[3]] };
        Some(match sample {
            SampleType::U8 => Self::U8(bytes.to_vec()),
            SampleType::I8 => Self::I8(bytes.iter().map(|&b| b as i8).collect()),
            SampleType::U16 => Self::U16(bytes.chunks_exact(2).map(|b| u16::from_le_bytes(two(b))).collect()),
            SampleType::I16 => Self::I16(bytes.chunks_exact(2).map(|b| i16::from_le_bytes(two(b))).collect()),
            SampleType::F32 => {
                Self::F32(bytes.chunks_exact(4).map(|b| f32::from_le_bytes(four(b))).collect())
            }
        })
    }

    /// Sample `i` in data units.
    #[must_use]
    #[allow(clippy::unnecessary_cast, reason = "one expression serves all number types")]
    pub fn get(&self, i: usize) -> f32 {
        each!(self, v => v[i] as f32)
    }
}

/// A whole volume in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseVolume {
    layout: VolumeLayout,
    samples: Samples,
    _held: Held,
}

impl DenseVolume {
    /// # Errors
    /// A sentence that names the mismatch, when sample count or type disagree with the layout, or the layout
    /// itself is invalid.
    pub fn new(layout: VolumeLayout, samples: Samples) -> Result<Self, String> {
        layout.validate().map_err(|e| e.to_string())?;
        if samples.sample_type() != layout.sample {
            return Err(format!("samples are {}, the layout says {}", samples.sample_type(), layout.sample));
        }
        if samples.len() as u64 != layout.samples() {
            return Err(format!("{} samples given, the layout needs {}", samples.len(), layout.samples()));
        }
        Ok(Self { layout, _held: Held::of(samples.as_bytes()), samples })
    }

    /// The samples without the layout.
    #[must_use]
    pub fn into_samples(self) -> Samples {
        self.samples
    }

    /// The samples in their own type.
    #[must_use]
    pub const fn samples(&self) -> &Samples {
        &self.samples
    }

    /// The samples, if they are single precision.
    pub(super) fn single_mut(&mut self) -> Option<&mut [f32]> {
        match &mut self.samples {
            Samples::F32(values) => Some(values),
            _ => None,
        }
    }

    /// One frame as `f32`, x fastest, channels interleaved.
    ///
    /// # Panics
    /// When the frame does not exist.
    #[must_use]
    #[allow(clippy::unnecessary_cast, reason = "one expression serves all number types")]
    pub fn frame_values(&self, frame: FrameIndex) -> Vec<f32> {
        let n = self.layout.samples_per_frame() as usize;
        let at = frame.0 as usize * n;
        each!(&self.samples, v => v[at..at + n].par_iter().map(|&s| s as f32).collect())
    }

    /// Range of the finite samples. `None` if no sample is finite.
    #[must_use]
    #[allow(clippy::unnecessary_cast, reason = "one expression serves all number types")]
    pub fn value_range(&self) -> Option<ValueRange> {
        each!(&self.samples, v => v
            .par_chunks(1 << 16)
            .filter_map(|c| ValueRange::of(c.iter().map(|&s| s as f32)))
            .reduce_with(ValueRange::union))
    }
}

impl BrickSource for DenseVolume {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    #[allow(clippy::unnecessary_cast, reason = "one expression serves all number types")]
    fn read(&self, frame: FrameIndex, region: Region, out: &mut [f32]) -> Result<(), SourceError> {
        let VolumeLayout { extent, channels, frames, .. } = self.layout;
        if frame.0 >= frames || !region.fits(extent) {
            return Err(SourceError::OutOfBounds {
                origin: region.origin,
                extent: region.extent,
                frame: frame.0,
            });
        }
        let channels = channels as usize;
        assert_eq!(out.len() as u64, region.extent.voxels() * channels as u64, "output of the wrong size");
        let row = region.extent.x() as usize * channels;
        let base = frame.0 as usize * self.layout.samples_per_frame() as usize;
        for (start, out) in region.rows().zip(out.chunks_exact_mut(row)) {
            let at = base + extent.index(start) * channels;
            each!(&self.samples, v => {
                for (o, s) in out.iter_mut().zip(&v[at..at + row]) {
                    *o = *s as f32;
                }
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Extent;

    fn ramp() -> DenseVolume {
        let layout = VolumeLayout::scalar(Extent::new(3, 4, 5).unwrap(), SampleType::U8);
        DenseVolume::new(layout, Samples::U8((0..60).collect())).unwrap()
    }

    #[test]
    fn reads_a_box_in_memory_order() {
        let mut out = [0.0; 4];
        let region = Region { origin: [1, 2, 3], extent: Extent::new(2, 1, 2).unwrap() };
        ramp().read(FrameIndex::FIRST, region, &mut out).unwrap();
        assert_eq!(out, [43.0, 44.0, 55.0, 56.0]);
    }

    #[test]
    fn refuses_a_box_that_sticks_out() {
        let region = Region { origin: [2, 0, 0], extent: Extent::new(2, 1, 1).unwrap() };
        assert!(ramp().read(FrameIndex::FIRST, region, &mut [0.0; 2]).is_err());
        assert!(ramp().read(FrameIndex(1), Region::voxel([0; 3]), &mut [0.0]).is_err());
    }

    #[test]
    fn reads_both_byte_orders() {
        let little = Samples::from_bytes(SampleType::I16, &[0xfe, 0xff, 1, 0], false);
        let big = Samples::from_bytes(SampleType::I16, &[0xff, 0xfe, 0, 1], true);
        assert_eq!(little, Some(Samples::I16(vec![-2, 1])));
        assert_eq!(little, big);
        assert_eq!(Samples::from_bytes(SampleType::F32, &[0; 3], false), None);
    }
}
