//! Comparison of a shader's values with the CPU decoder's, sample by sample.

use std::fmt;

use super::{Agreement, Block, Decoder};
use crate::volume::{BrickKey, FrameIndex, Level, Region};

/// Comparison of a dump of one frame with the CPU decoder. Its `Display` is a sentence.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Parity {
    /// The codec's stated agreement.
    pub agreement: Agreement,
    /// Samples compared; those that only one side has count too.
    pub samples: u64,
    /// Samples beyond the statement.
    pub mismatches: u64,
    /// The first of them.
    pub first: Option<Mismatch>,
    /// Largest distance over the samples that both have, in data units. NaN if one of the values is NaN.
    pub largest: f64,
}

/// A sample on which shader and CPU disagree.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Mismatch {
    /// Index within the frame: x fastest, channels interleaved.
    pub sample: u64,
    /// The frame.
    pub frame: FrameIndex,
    /// The voxel, x y z.
    pub voxel: [u32; 3],
    /// The channel, if the volume has several.
    pub channel: Option<u32>,
    /// The block of the voxel: its position in the block grid, and its size. See [`Parity::with_block`].
    pub block: Option<([u32; 3], Block)>,
    /// The CPU's value. NaN if it has none.
    pub cpu: f32,
    /// The shader's value. NaN if it has none.
    pub shader: f32,
    /// Allowed distance in data units.
    pub allowed: f64,
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

    /// As [`Parity::compare`], at a level.
    #[must_use]
    pub fn compare_at(
        decoder: &dyn Decoder,
        agreement: Agreement,
        (frame, level): (FrameIndex, Level),
        cpu: &[f32],
        shader: &[f32],
    ) -> Self {
        let layout = decoder.layout().at_resolution(level.resolution);
        let (x, y) = (u64::from(layout.extent.x()), u64::from(layout.extent.y()));
        let place = |sample: u64| {
            let voxel = sample / u64::from(layout.channels);
            [(voxel % x) as u32, (voxel / x % y) as u32, (voxel / x / y) as u32]
        };
        let range = |sample: u64| {
            decoder.value_range(BrickKey { frame, level, region: Region::voxel(place(sample)) })
        };
        // Most samples are equal bit for bit. Only the others need the range of their block.
        let allowed = |sample: u64, cpu: f32, shader: f32| {
            cpu == shader || agreement.allows(cpu, shader, range(sample))
        };
        let several = layout.channels > 1;
        let mismatch = |sample: u64, cpu: f32, shader: f32, allowed: f64| Mismatch {
            sample,
            frame,
            voxel: place(sample),
            channel: several.then(|| (sample % u64::from(layout.channels)) as u32),
            block: None,
            cpu,
            shader,
            allowed,
        };
        let pairs = (0..).zip(cpu.iter().zip(shader));
        let mut bad = pairs.filter(|(sample, (cpu, shader))| !allowed(*sample, **cpu, **shader)).map(
            |(sample, (&cpu, &shader))| {
                mismatch(sample, cpu, shader, agreement.tolerance(cpu, range(sample)))
            },
        );
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
            first = first.or_else(|| Some(mismatch(common as u64, value(cpu), value(shader), 0.0)));
        }
        Self { agreement, samples: cpu.len().max(shader.len()) as u64, mismatches, first, largest }
    }

    /// Adds the codec's block to the first mismatch, if there is a block.
    #[must_use]
    pub fn with_block(mut self, block: Option<Block>) -> Self {
        if let Some(first) = &mut self.first {
            let index = |size: [u32; 3]| [0, 1, 2].map(|axis| first.voxel[axis] / size[axis]);
            first.block = block.map(|block| (index(block.0.to_array()), block));
        }
        self
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
        self.first.map_or(Ok(()), |first| write!(f, "; the first is {first}"))
    }
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { frame, voxel: [x, y, z], cpu, shader, allowed, .. } = *self;
        write!(f, "voxel {x} {y} {z} (frame {})", frame.0)?;
        if let Some(channel) = self.channel {
            write!(f, ", channel {channel}")?;
        }
        if let Some(([x, y, z], block)) = self.block {
            write!(f, ", in block {x} {y} {z} of {} voxels", block.0)?;
        }
        let (shader_bits, cpu_bits) = (shader.to_bits(), cpu.to_bits());
        write!(f, ": {shader:e} ({shader_bits:08x}) where the CPU decodes {cpu:e} ({cpu_bits:08x})")?;
        write!(f, ", and {allowed:e} apart is allowed")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::DecodeError;
    use crate::volume::{Extent, ReferenceFrames, SampleType, ValueRange, VolumeLayout};

    /// States a range for each voxel that ends at the voxel's x.
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
        let expected = Mismatch {
            sample: 7,
            frame: FrameIndex::FIRST,
            voxel: [0, 1, 0],
            channel: Some(1),
            block: None,
            cpu: 0.5,
            shader: 0.5_f32.next_up(),
            allowed: 0.0,
        };
        assert_eq!(found.first, Some(expected));
        let told = "2 of 12 samples disagree (Exact); the first is voxel 0 1 0 (frame 0), channel 1: 5.0000006e-1 \
                    (3f000001) where the CPU decodes 5e-1 (3f000000), and 0e0 apart is allowed";
        assert_eq!(found.to_string(), told);
    }

    #[test]
    fn the_first_mismatch_is_told_with_its_block_and_what_is_allowed_there() {
        let extent = Extent::new(7, 6, 2).unwrap();
        let ranges = Ranges(VolumeLayout::scalar(extent, SampleType::F32));
        let cpu = vec![1.0; 84];
        let mut shader = cpu.clone();
        // Voxel 4 5 1, whose range reaches 4: an ulp there is 2^-21.
        shader[4 + 7 * (5 + 6)] = 1.5;
        let found = Parity::compare(&ranges, Agreement::Ulp(2), FrameIndex(3), &cpu, &shader);
        let told = found.with_block(Some("3x2x2".parse().unwrap())).to_string();
        let expected = "1 of 84 samples disagree (Ulp(2)); the first is voxel 4 5 1 (frame 3), in block 1 2 0 of 3×2×2 \
                        voxels: 1.5e0 (3fc00000) where the CPU decodes 1e0 (3f800000), and 9.5367431640625e-7 apart is \
                        allowed";
        assert_eq!(told, expected);
        assert!(!found.to_string().contains("block"), "a codec without blocks");
    }

    #[test]
    fn the_range_is_that_of_the_samples_own_voxel() {
        let cpu = [0.0; 12];
        // Voxels with samples 3 and 9 have a range that reaches 1. The others hold only 0.
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
