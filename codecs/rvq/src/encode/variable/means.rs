//! Means of blocks: what their sums begin with.

use crate::stream::{COLOUR_MEAN, TOP, decoded_mean};

/// How means are rounded.
#[derive(Copy, Clone, Debug)]
pub struct Means {
    /// Values per voxel: 1 or 3.
    pub channels: usize,
    /// Codes count two to this power; 0 for colours, which have a step of their own.
    pub shift: u32,
}

impl Means {
    /// Means whose step adds little to a root mean square error, in units of sums.
    #[must_use]
    pub fn fine_enough(channels: usize, error: f64) -> Self {
        let shift = (MEAN_STEP * error).max(1.0).log2() as u32;
        Self { channels, shift: if channels == 3 { 0 } else { shift.min(COARSEST) } }
    }

    /// The code nearest to the means of a block's values inside the volume, in units of sums.
    #[must_use]
    pub fn code(self, values: &[f32], inside: Option<&[bool]>) -> u32 {
        let mean = |c: usize| {
            let (mut sum, mut count) = (0.0, 0.0);
            for i in (c..values.len()).step_by(self.channels).filter(|i| inside.is_none_or(|all| all[*i])) {
                sum += f64::from(values[i]);
                count += 1.0;
            }
            sum / count
        };
        if self.channels == 3 {
            let of = |c: usize| (mean(c) / f64::from(COLOUR_MEAN)).round().clamp(0.0, 31.0) as u32;
            return of(0) | of(1) << 5 | of(2) << 10;
        }
        let top = f64::from(TOP as u32 >> self.shift);
        (mean(0) / f64::from(1_u32 << self.shift)).round().clamp(0.0, top) as u32
    }

    /// What a code stands for, for each channel.
    #[must_use]
    pub const fn decoded(self, code: u32) -> [i32; 3] {
        decoded_mean(self.channels as u32, self.shift, code)
    }
}

/// The step of means over the root mean square error that is expected. A step of half the error adds a fiftieth of its square.
const MEAN_STEP: f64 = 0.5;
/// Most bits that means are rounded by.
const COARSEST: u32 = 12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_those_of_voxels_inside() {
        let means = Means { channels: 1, shift: 3 };
        let mut values = vec![80.0; 64];
        values[5] = 1e4;
        let inside: Vec<bool> = (0..64).map(|i| i != 5).collect();
        assert_eq!(means.code(&values, Some(&inside)), 10);
        assert_eq!(means.code(&vec![1e6; 64], None), TOP as u32 >> 3);
    }

    #[test]
    fn colours_have_five_bits_each() {
        let step = COLOUR_MEAN as f32;
        let values: Vec<f32> = (0..64).flat_map(|_| [0.0, 3.0 * step, 65535.0]).collect();
        assert_eq!(Means { channels: 3, shift: 0 }.code(&values, None), 3 << 5 | 31 << 10);
    }
}
