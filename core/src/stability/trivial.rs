//! The trivial codec of a given rate, with which every other is compared: a coarser grid of box means in the samples'
//! own type, and trilinear interpolation between their centres.
//!
//! The grid has `max(1, ⌊N / f⌋)` means along an axis of `N` voxels, for one real factor `f ≥ 1` that all axes share:
//! the least whose file is no larger than the one to compare with. Mean `j` of `n` is that over `j·N/n .. (j+1)·N/n`,
//! voxels at its ends counting with their share. The file is the means of all frames and channels, each as wide as a
//! sample, and a header of [`RESERVED`] bytes like any container's. One mean per frame and channel fits any rate.

use rayon::prelude::*;

use crate::container::RESERVED;
use crate::volume::{BrickSource as _, Extent, FiniteVolume, FrameIndex, VolumeLayout};

/// A volume through the trivial codec.
#[derive(Clone, Debug, PartialEq)]
pub struct Trivial {
    /// Means along x, y and z.
    pub grid: Extent,
    /// Bytes of its file.
    pub file_bytes: u64,
    /// Its decoded values, frame by frame: x fastest, channels interleaved.
    pub frames: Vec<Vec<f32>>,
}

/// Bytes of an uncompressed volume in a container.
#[must_use]
pub const fn raw_bytes(layout: &VolumeLayout) -> u64 {
    RESERVED as u64 + layout.bytes()
}

impl Trivial {
    /// The one whose file has at most `file_bytes`; where not even one mean per frame and channel fits, that.
    #[must_use]
    pub fn of_rate(volume: &FiniteVolume, file_bytes: u64) -> Self {
        let grid = finest_grid(volume.layout(), file_bytes);
        Self::of_grid(volume, grid)
    }

    /// The one of a given grid, at most as fine as the volume's.
    #[must_use]
    pub fn of_grid(volume: &FiniteVolume, grid: Extent) -> Self {
        let layout = volume.layout();
        let frames = (0..layout.frames).into_par_iter();
        let frames = frames.map(|frame| frame_through(volume, FrameIndex(frame), grid)).collect();
        Self { grid, file_bytes: bytes_of(layout, grid), frames }
    }
}

/// Bytes of the file with such a grid.
fn bytes_of(layout: &VolumeLayout, grid: Extent) -> u64 {
    raw_bytes(&VolumeLayout { extent: grid, ..layout.clone() })
}

/// The finest grid whose file has at most `bytes` bytes.
fn finest_grid(layout: &VolumeLayout, file_bytes: u64) -> Extent {
    let size = layout.extent.to_array();
    // The grid changes with `f` only if an axis reaches a whole number of means: at f = N / n.
    let mut factors: Vec<f64> =
        size.iter().flat_map(|&n| (1..=n).map(move |k| f64::from(n) / f64::from(k))).collect();
    factors.sort_by(f64::total_cmp);
    factors.dedup();
    // A factor that rounds to just above N / n must not lose a mean.
    let means = |n: u32, f: f64| ((f64::from(n) / f + 1e-9).floor() as u32).clamp(1, n);
    let grids = factors.into_iter().filter_map(|f| Extent::try_from(size.map(|n| means(n, f))).ok());
    let mut fitting = grids.filter(|grid| bytes_of(layout, *grid) <= file_bytes);
    fitting.next().unwrap_or(Extent::ONE)
}

/// One frame: to box means, to the samples' own type, and back.
fn frame_through(volume: &FiniteVolume, frame: FrameIndex, grid: Extent) -> Vec<f32> {
    let layout = volume.layout();
    let original = volume.dense().frame_values(frame);
    if grid == layout.extent {
        return original;
    }
    let channels = layout.channels as usize;
    let (fine, coarse) = (layout.extent.to_array().map(|n| n as usize), grid.to_array().map(|n| n as usize));
    let mut out = vec![0.0; original.len()];
    for channel in 0..channels {
        let mut values: Vec<f64> =
            original.iter().skip(channel).step_by(channels).map(|v| f64::from(*v)).collect();
        let mut size = fine;
        for axis in 0..3 {
            values = resampled(&values, &mut size, axis, &box_weights(fine[axis], coarse[axis]));
        }
        let stored = |v: f64| if layout.sample.is_integer() { v.round() } else { f64::from(v as f32) };
        values.iter_mut().for_each(|v| *v = stored(*v));
        for axis in 0..3 {
            values = resampled(&values, &mut size, axis, &linear_weights(coarse[axis], fine[axis]));
        }
        for (out, value) in out.iter_mut().skip(channel).step_by(channels).zip(values) {
            *out = value as f32;
        }
    }
    out
}

/// For every sample to be made: the source samples and their weights.
type Weights = Vec<Vec<(usize, f64)>>;

/// Means over `to` equal pieces of `from` samples.
fn box_weights(from: usize, to: usize) -> Weights {
    let piece = from as f64 / to as f64;
    let of = |j: usize| {
        let (low, high) = (j as f64 * piece, (j + 1) as f64 * piece);
        let overlap = |i: usize| (high.min((i + 1) as f64) - low.max(i as f64)) / piece;
        let touched = low as usize..(high.ceil() as usize).min(from);
        let kept: Vec<_> = touched.map(|i| (i, overlap(i))).filter(|(_, w)| *w > 1e-9).collect();
        let sum: f64 = kept.iter().map(|(_, w)| w).sum();
        kept.into_iter().map(|(i, w)| (i, w / sum)).collect()
    };
    (0..to).map(of).collect()
}

/// Linear interpolation at the centres of `to` samples between those of `from`, clamped at the border.
fn linear_weights(from: usize, to: usize) -> Weights {
    let of = |i: usize| {
        let at = ((i as f64 + 0.5) * from as f64 / to as f64 - 0.5).clamp(0.0, (from - 1) as f64);
        let low = at.floor() as usize;
        let t = at - low as f64;
        let pair = [(low, 1.0 - t), ((low + 1).min(from - 1), t)];
        pair.into_iter().filter(|(_, w)| *w > 0.0).collect()
    };
    (0..to).map(of).collect()
}

/// Resamples along one axis.
fn resampled(values: &[f64], size: &mut [usize; 3], axis: usize, weights: &Weights) -> Vec<f64> {
    let stride: usize = size[..axis].iter().product();
    let (old, new) = (size[axis], weights.len());
    let outer: usize = size[axis + 1..].iter().product();
    let mut out = Vec::with_capacity(stride * new * outer);
    for block in values.chunks_exact(stride * old).take(outer) {
        for weights in weights {
            let sum = |i: usize| weights.iter().map(|(at, w)| block[at * stride + i] * w).sum::<f64>();
            out.extend((0..stride).map(sum));
        }
    }
    size[axis] = new;
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::VolumeError;
    use crate::volume::{DenseVolume, SampleType, Samples};

    fn volume(size: [u32; 3], value: impl Fn([u32; 3]) -> f32) -> FiniteVolume {
        let layout = VolumeLayout::scalar(Extent::try_from(size).unwrap(), SampleType::F32);
        let values = (0..layout.samples() as usize).map(|i| value(layout.extent.position(i))).collect();
        FiniteVolume::new(DenseVolume::new(layout, Samples::F32(values)).unwrap())
    }

    fn noise(p: [u32; 3]) -> f32 {
        let hash = (p[0] + 31 * p[1] + 977 * p[2]).wrapping_mul(2_654_435_761);
        (hash >> 20) as f32
    }

    #[test]
    fn the_finest_grid_that_fits_is_taken() {
        let noise = volume([9, 7, 5], noise);
        let all = raw_bytes(noise.layout());
        for bytes in (0..=all).step_by(37).chain([all, all + 1, 10 * all]) {
            let trivial = Trivial::of_rate(&noise, bytes);
            let [x, y, z] = trivial.grid.to_array();
            assert!(
                trivial.file_bytes <= bytes || trivial.grid == Extent::ONE,
                "{bytes}: {:?}",
                trivial.grid
            );
            // A factor a little smaller has a mean more along some axis, and no longer fits.
            let f = (9.0 / f64::from(x + 1)).max(7.0 / f64::from(y + 1)).max(5.0 / f64::from(z + 1));
            let finer = [9, 7, 5].map(|n: u32| ((f64::from(n) / f + 1e-9).floor() as u32).clamp(1, n));
            let finer = Extent::try_from(finer).unwrap();
            assert!(
                trivial.grid == noise.layout().extent || bytes_of(noise.layout(), finer) > bytes,
                "{bytes}"
            );
        }
    }

    #[test]
    fn at_the_rate_of_raw_it_is_exact_and_one_byte_less_is_not() {
        let noise = volume([8, 6, 4], noise);
        let all = raw_bytes(noise.layout());
        let error = |bytes| VolumeError::compare(&noise, Trivial::of_rate(&noise, bytes).frames).mse;
        assert_eq!(error(all), 0.0);
        assert!(error(all - 1) > 0.0);
    }

    #[test]
    fn one_mean_is_the_mean_and_fits_no_bytes_at_all() {
        let ramp = volume([4, 3, 2], |p| p[0] as f32);
        let trivial = Trivial::of_rate(&ramp, 0);
        assert_eq!((trivial.grid, &trivial.frames[0]), (Extent::ONE, &vec![1.5; 24]));
    }

    /// A box of two and a half voxels takes half of the third.
    #[test]
    fn means_weigh_by_overlap_and_lie_between_centres() {
        let line = volume([5, 1, 1], |p| [10.0, 20.0, 30.0, 40.0, 50.0][p[0] as usize]);
        let trivial = Trivial::of_grid(&line, Extent::new(2, 1, 1).unwrap());
        let (low, high) = ((10.0 + 20.0 + 15.0) / 2.5_f32, (15.0 + 40.0 + 50.0) / 2.5_f32);
        let expected = [low, low + (high - low) * 0.1, (low + high) / 2.0, high - (high - low) * 0.1, high];
        for (got, expected) in trivial.frames[0].iter().zip(expected) {
            assert!((got - expected).abs() < 1e-4, "{got} {expected}");
        }
    }

    #[test]
    fn axes_channels_and_frames_stay_apart() {
        let size = Extent::new(6, 4, 2).unwrap();
        let layout = VolumeLayout { channels: 3, frames: 2, ..VolumeLayout::scalar(size, SampleType::U8) };
        let values = |i: u64| {
            let (channel, voxel) = (i % 3, i / 3);
            let (p, frame) = (size.position((voxel % 48) as usize), voxel / 48);
            // Constant along all axes but one, another for each channel.
            (u64::from(p[channel as usize]) * 10 + 100 * frame) as u8
        };
        let samples = Samples::U8((0..layout.samples()).map(values).collect());
        let volume = FiniteVolume::new(DenseVolume::new(layout, samples).unwrap());
        let trivial = Trivial::of_grid(&volume, Extent::new(6, 2, 1).unwrap());
        assert_eq!(trivial.frames.len(), 2);
        for (frame, values) in trivial.frames.iter().enumerate() {
            for (i, voxel) in values.chunks_exact(3).enumerate() {
                let base = 100.0 * frame as f32;
                let p = size.position(i);
                assert_eq!(voxel[0], base + p[0] as f32 * 10.0, "x is kept");
                assert_eq!(voxel[1], base + [5.0, 10.0, 20.0, 25.0][p[1] as usize], "y in halves");
                assert_eq!(voxel[2], base + 5.0, "z is one mean");
            }
        }
    }

    #[test]
    fn integers_are_stored_as_integers() {
        let layout = VolumeLayout::scalar(Extent::new(2, 1, 1).unwrap(), SampleType::U8);
        let volume = FiniteVolume::new(DenseVolume::new(layout, Samples::U8(vec![1, 2])).unwrap());
        assert_eq!(Trivial::of_grid(&volume, Extent::ONE).frames[0], [2.0, 2.0]);
    }
}
