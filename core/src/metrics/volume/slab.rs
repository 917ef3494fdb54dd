//! A few neighbouring slices of one frame: the piece that metrics work on, whichever thread does it.

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
            before: first - from,
        }
    }

    /// Samples of a slice.
    pub(super) const fn slice_len(&self) -> usize {
        self.extent[0] * self.extent[1] * self.channels
    }

    /// Decoded − original of the own samples; `+∞` where the decoded value is no number.
    pub(super) fn errors(&self) -> &[f64] {
        let from = self.before * self.slice_len();
        &self.errors[from..from + self.original.len()]
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

/// What a decoded value counts as: an integer volume's is rounded and clamped to the original's range.
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
        let mut value = f64::from(decoded);
        if self.integer {
            value = value.round().clamp(f64::from(self.range.min), f64::from(self.range.max));
        }
        let error = value - f64::from(original);
        // What is no number is infinitely wrong.
        if error.is_nan() { f64::INFINITY } else { error }
    }
}
