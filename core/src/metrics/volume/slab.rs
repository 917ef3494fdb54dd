//! A chunk of a few neighbouring layers of one frame: the unit of work of metrics, on any thread.

use crate::volume::{BrickSource, FiniteVolume, ValueRange};

/// Slices of a slab, but for the last one; also the side of the blocks in which [`Slab::blocks`] walks.
pub(super) const SLICES: usize = 4;

/// Original samples and errors of a slab, x fastest, channels interleaved.
#[derive(Debug)]
pub(super) struct Slab<'a> {
    /// The slab's own original samples.
    pub(super) original: &'a [f32],
    /// Errors of the own slices, and of one slice before and after them where the frame has it.
    errors: Vec<f64>,
    /// Columns, rows, and own slices.
    pub(super) extent: [usize; 3],
    /// Samples per voxel.
    pub(super) channels: usize,
    /// Number of the first own slice in its frame.
    pub(super) first: usize,
    /// Slices in `errors` before the first own one: 0 or 1.
    before: usize,
}

impl<'a> Slab<'a> {
    /// Slab `number` of a frame.
    pub(super) fn new(volume: &FiniteVolume, original: &'a [f32], decoded: &[f32], number: usize) -> Self {
        let layout = volume.layout();
        let channels = layout.channels as usize;
        let [x, y, z] = layout.extent.to_array().map(|n| n as usize);
        let slice = x * y * channels;
        let first = number * SLICES;
        let end = (first + SLICES).min(z);
        let (from, to) = (first.saturating_sub(1), (end + 1).min(z));
        let judge = Judge::new(volume);
        let pairs = original[from * slice..to * slice].iter().zip(&decoded[from * slice..to * slice]);
        Self {
            original: &original[first * slice..end * slice],
            errors: pairs.map(|(original, decoded)| judge.error(*original, *decoded)).collect(),
            extent: [x, y, end - first],
            channels,
            first,
            before: first - from,
        }
    }

    /// Samples of a slice.
    pub(super) const fn slice_len(&self) -> usize {
        self.extent[0] * self.extent[1] * self.channels
    }

    /// Decoded − original of the own samples; `+∞` where the decoded value is not a number.
    pub(super) fn errors(&self) -> &[f64] {
        let from = self.before * self.slice_len();
        &self.errors[from..from + self.original.len()]
    }

    /// One slice of errors: own ones from 0; −1 and the one after the last where the frame has them.
    fn slice(&self, z: isize) -> Option<&[f64]> {
        let at = usize::try_from(z + self.before as isize).ok()? * self.slice_len();
        self.errors.get(at..at + self.slice_len())
    }

    /// Runs of errors and of their next neighbours along an axis, of the same channel and of equal length, with the
    /// position of the first error of the run along that axis. Along x positions rise by 1 every `channels` errors;
    /// along y and z they stay. Each pair comes once, in the slab that owns its first error.
    pub(super) fn neighbours(&self, axis: usize) -> impl Iterator<Item = (usize, &[f64], &[f64])> {
        let [x, y, z] = self.extent;
        let row = x * self.channels;
        let step = [self.channels, row, 0][axis];
        (0..z).flat_map(move |k| {
            let slice = self.slice(k as isize).unwrap_or_default();
            let next = if axis == 2 { self.slice(k as isize + 1).unwrap_or_default() } else { slice };
            let rows = match axis {
                1 => y - 1,
                2 if next.is_empty() => 0,
                _ => y,
            };
            (0..rows).map(move |v| {
                let (at, len) = (v * row, if axis == 0 { row - step } else { row });
                let position = [0, v, self.first + k][axis];
                (position, &slice[at..at + len], &next[at + step..at + step + len])
            })
        })
    }

    /// Runs of errors before and after along an axis, two voxels apart, around each voxel that has both neighbours.
    pub(super) fn around(&self, axis: usize) -> impl Iterator<Item = (&[f64], &[f64])> {
        let [x, y, z] = self.extent;
        let row = x * self.channels;
        let step = [2 * self.channels, 2 * row, 0][axis];
        (0..z as isize).flat_map(move |k| {
            let beside = |offset| self.slice(k + offset).unwrap_or_default();
            let (before, after) = if axis == 2 { (beside(-1), beside(1)) } else { (beside(0), beside(0)) };
            let rows = match axis {
                1 => y.saturating_sub(2),
                2 if before.is_empty() || after.is_empty() => 0,
                _ => y,
            };
            (0..rows).map(move |v| {
                let (at, len) = (v * row, if axis == 0 { row.saturating_sub(step) } else { row });
                let after_from = (at + step).min(after.len());
                (&before[at..at + len], &after[after_from..after_from + len])
            })
        })
    }

    /// Sample indices of the blocks of 4³ voxels of one channel, cut at the volume's edge, and that channel.
    pub(super) fn blocks(&self) -> impl Iterator<Item = (usize, impl Iterator<Item = usize>)> {
        let ([x, y, z], channels) = (self.extent, self.channels);
        (0..y).step_by(SLICES).flat_map(move |y0| {
            (0..x).step_by(SLICES).flat_map(move |x0| {
                let (y1, x1) = ((y0 + SLICES).min(y), (x0 + SLICES).min(x));
                (0..channels).map(move |channel| {
                    let voxels = (0..z).flat_map(move |z| {
                        (y0..y1).flat_map(move |v| {
                            (x0..x1).map(move |u| ((z * y + v) * x + u) * channels + channel)
                        })
                    });
                    (channel, voxels)
                })
            })
        })
    }
}

/// The compared value of a decoded sample: for an integer volume it is rounded and clamped to the original's range.
#[derive(Copy, Clone, Debug)]
struct Judge {
    range: ValueRange,
    integer: bool,
}

impl Judge {
    fn new(volume: &FiniteVolume) -> Self {
        Self { range: volume.range(), integer: volume.layout().sample.is_integer() }
    }

    fn error(self, original: f32, decoded: f32) -> f64 {
        // A value that is not a number has an infinite error.
        if decoded.is_nan() {
            return f64::INFINITY;
        }
        let mut value = f64::from(decoded);
        if self.integer {
            value = value.clamp(f64::from(self.range.min), f64::from(self.range.max));
            // To the nearest, halves away from zero, as `f64::round`, which is a call where the processor has none; the
            // range of an integer type fits.
            let whole = f64::from(value as i32);
            let rest = value - whole;
            value = whole + f64::from(i8::from(rest >= 0.5) - i8::from(rest <= -0.5));
        }
        value - f64::from(original)
    }
}
