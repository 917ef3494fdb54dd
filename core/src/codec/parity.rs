//! What a shader decoded against what the CPU decoded, sample by sample.

use std::fmt;

use super::{Agreement, Decoder};
use crate::volume::{BrickKey, FrameIndex, Level, Region};

/// How a dump of one frame compares with the CPU decoder. Its `Display` is a sentence.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Parity {
    /// What the codec states.
    pub agreement: Agreement,
    /// Samples compared; those that only one side has count too.
    pub samples: u64,
    /// Samples beyond the statement.
    pub mismatches: u64,
    /// The first of them.
    pub first: Option<Mismatch>,
    /// Largest distance between both in any sample that both have, in data units; NaN where one of them is.
    pub largest: f64,
}

/// A sample on which shader and CPU disagree.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Mismatch {
    /// Index within the frame: x fastest, channels interleaved.
    pub sample: u64,
    /// The CPU's value; NaN where it has none.
    pub cpu: f32,
    /// The shader's value; NaN where it has none.
    pub shader: f32,
}

impl Parity {
    /// Compares `shader`, a dump of `frame`, with `cpu`, the same frame decoded by `decoder`.
    #[must_use]
    pub fn compare(
        decoder: &dyn Decoder,
        agreement: Agreement,
        frame: FrameIndex,
        cpu: &[f32],
        shader: &[f32],
    ) -> Self {
        Self::compare_at(decoder, agreement, (frame, Level::FULL), cpu, shader)
    }

    /// The same where both were decoded at a level.
    #[must_use]
    pub fn compare_at(
        decoder: &dyn Decoder,
        agreement: Agreement,
        (frame, level): (FrameIndex, Level),
        cpu: &[f32],
        shader: &[f32],
    ) -> Self {
        let layout = decoder.layout();
        let (x, y) = (u64::from(layout.extent.x()), u64::from(layout.extent.y()));
        let allowed = |sample: u64, cpu: f32, shader: f32| {
            let voxel = sample / u64::from(layout.channels);
            let p = [(voxel % x) as u32, (voxel / x % y) as u32, (voxel / x / y) as u32];
            let key = BrickKey { frame, level, region: Region::voxel(p) };
            // Most samples are equal to the bit; only the others need the range of their block.
            cpu == shader || agreement.allows(cpu, shader, decoder.value_range(key))
        };
        let pairs = (0..).zip(cpu.iter().zip(shader));
        let mut bad = pairs
            .filter(|(sample, (cpu, shader))| !allowed(*sample, **cpu, **shader))
            .map(|(sample, (&cpu, &shader))| Mismatch { sample, cpu, shader });
        let mut first = bad.next();
        let mut mismatches = u64::from(first.is_some()) + bad.count() as u64;
        let distances = cpu
            .iter()
            .zip(shader)
            .map(|(&a, &b)| if a == b { 0.0 } else { (f64::from(a) - f64::from(b)).abs() });
        let largest = distances.fold(0.0, |most: f64, d| if d > most || d.is_nan() { d } else { most });
        let common = cpu.len().min(shader.len());
        if cpu.len() != shader.len() {
            mismatches += cpu.len().abs_diff(shader.len()) as u64;
            let value = |side: &[f32]| side.get(common).copied().unwrap_or(f32::NAN);
            let missing = Mismatch { sample: common as u64, cpu: value(cpu), shader: value(shader) };
            first = first.or(Some(missing));
        }
        Self { agreement, samples: cpu.len().max(shader.len()) as u64, mismatches, first, largest }
    }

    /// Whether no sample is beyond the statement.
    #[must_use]
    pub const fn holds(&self) -> bool {
        self.mismatches == 0
    }
}

impl fmt::Display for Parity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} samples disagree ({:?})", self.mismatches, self.samples, self.agreement)?;
        let Some(Mismatch { sample, cpu, shader }) = self.first else { return Ok(()) };
        let (shader_bits, cpu_bits) = (shader.to_bits(), cpu.to_bits());
        write!(
            f,
            "; the first, {sample}, is {shader:e} ({shader_bits:08x}) and should be {cpu:e} ({cpu_bits:08x})"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::DecodeError;
    use crate::volume::{Extent, ReferenceFrames, SampleType, ValueRange, VolumeLayout};

    /// Knows of each voxel that it lies below its own x.
    #[derive(Debug)]
    struct Ranges(VolumeLayout);

    impl Decoder for Ranges {
        fn layout(&self) -> &VolumeLayout {
            &self.0
        }

        fn decode_brick(
            &self,
            _: BrickKey,
            _: &dyn ReferenceFrames,
            _: &mut [f32],
        ) -> Result<(), DecodeError> {
            Err(DecodeError::Corrupt("nothing to decode".to_owned()))
        }

        fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
            Some(ValueRange { min: 0.0, max: key.region.origin[0] as f32 })
        }
    }

    fn parity(agreement: Agreement, cpu: &[f32], shader: &[f32]) -> Parity {
        let extent = Extent::new(2, 2, 1).unwrap();
        let layout = VolumeLayout { channels: 3, ..VolumeLayout::scalar(extent, SampleType::F32) };
        Parity::compare(&Ranges(layout), agreement, FrameIndex::FIRST, cpu, shader)
    }

    #[test]
    fn one_bit_is_counted_and_named() {
        let cpu = [0.5; 12];
        assert!(parity(Agreement::Exact, &cpu, &cpu).holds());
        let mut shader = cpu;
        shader[7] = 0.5_f32.next_up();
        shader[11] = f32::NAN;
        let found = parity(Agreement::Exact, &cpu, &shader);
        assert_eq!((found.samples, found.mismatches), (12, 2));
        assert!(found.largest.is_nan());
        assert_eq!(found.first, Some(Mismatch { sample: 7, cpu: 0.5, shader: 0.5_f32.next_up() }));
        assert_eq!(
            found.to_string(),
            "2 of 12 samples disagree (Exact); the first, 7, is 5.0000006e-1 (3f000001) and should be 5e-1 (3f000000)"
        );
    }

    #[test]
    fn the_range_is_that_of_the_samples_own_voxel() {
        let cpu = [0.0; 12];
        // Samples 3 and 9 lie in voxels whose range reaches 1, the others in such as hold only 0.
        let shader = [1e-8; 12];
        let found = parity(Agreement::Ulp(1), &cpu, &shader);
        assert_eq!((found.mismatches, found.first.map(|m| m.sample)), (6, Some(0)));
        assert_eq!(found.largest, f64::from(1e-8_f32));
    }

    #[test]
    fn what_one_side_lacks_disagrees() {
        let (long, short) = ([1.0; 12], [1.0; 9]);
        for (cpu, shader) in [(&long[..], &short[..]), (&short, &long)] {
            let found = parity(Agreement::Exact, cpu, shader);
            assert_eq!((found.samples, found.mismatches), (12, 3));
            assert_eq!(found.first.map(|m| m.sample), Some(9));
        }
        assert_eq!(parity(Agreement::Exact, &[], &long).mismatches, 12);
    }
}
