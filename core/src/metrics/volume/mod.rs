//! Error of decoded voxels against the original volume.
//!
//! The error `e` of a sample is decoded − original. Where samples are integers, a decoded value is rounded to the
//! nearest integer and clamped to the original's min..=max first, for that is what a file of that type would hold; a
//! value that is not a number has an infinite error. Conventions are the same as those of the peer measurements this
//! software is compared with. One file holds one metric, and `list.rs` names them all.

mod autocorrelation;
mod block_faces;
mod foreground;
mod gradient;
mod histogram;
pub mod isosurface;
mod list;
mod max_abs;
mod mean_abs;
mod metric;
mod percentile;
mod slab;
mod squared_error;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use self::list::{All, COUNT, Outcomes, Sums};
use self::metric::Subject;
use self::slab::{SLICES, Slab};
use super::{Figure, psnr_db};
use crate::codec::Block;
use crate::volume::{BrickSource, FiniteVolume, FrameIndex};

pub use histogram::{ErrorBin, ErrorHistogram};

/// Every figure of voxels.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    list::figures().chain(isosurface::FIGURES)
}

/// Error of a decoded volume, over all frames and channels.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct VolumeError {
    /// PSNR over all voxels; infinite without error.
    pub psnr_db: f64,
    /// PSNR over the foreground; `None` when there is none (a constant volume has none).
    pub foreground_psnr_db: Option<f64>,
    /// Largest absolute difference in data units; infinite when a decoded value is not a number.
    pub max_abs_error: f64,
    /// Mean squared error in squared data units.
    pub mse: f64,
    /// PSNR of red, green and blue, each with the volume's own peak; of a scalar volume `None`.
    pub channel_psnr_db: [Option<f64>; 3],
    /// Every figure of the list, in its order.
    values: [Option<f64>; COUNT],
}

/// Error of one decoded frame.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FrameError {
    /// PSNR of the frame, with the peak of the whole volume.
    pub psnr_db: f64,
    /// Largest absolute difference in data units.
    pub max_abs_error: f64,
}

impl VolumeError {
    /// The value of a figure; `None` where it is not defined, or there is no figure of this name.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        list::figures().zip(self.values).find(|(figure, _)| figure.name == name)?.1
    }

    /// Compares all frames of a decoded volume with the original.
    ///
    /// # Panics
    /// When frames or samples are too few or too many.
    #[must_use]
    pub fn compare<F: AsRef<[f32]>>(
        reference: &FiniteVolume,
        decoded: impl IntoIterator<Item = F>,
    ) -> VolumeError {
        let mut comparison = VolumeComparison::new(reference, None);
        for frame in decoded {
            comparison.add_frame(frame.as_ref());
        }
        comparison.finish()
    }
}

/// A comparison that takes the decoded frames one after the other, so that only one need be in memory.
pub struct VolumeComparison<'a> {
    subject: Subject<'a>,
    metrics: All,
    frames: u32,
    sums: Sums,
}

impl std::fmt::Debug for VolumeComparison<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VolumeComparison").field("frames", &self.frames).finish_non_exhaustive()
    }
}

impl<'a> VolumeComparison<'a> {
    /// Finds what the original alone decides, such as its modal value. `block` is that of the codec, where it has one.
    #[must_use]
    pub fn new(reference: &'a FiniteVolume, block: Option<Block>) -> Self {
        let subject = Subject { reference, block };
        Self { subject, metrics: All::new(&subject), frames: 0, sums: Sums::default() }
    }

    /// Compares the next frame: x fastest, channels interleaved. Returns the error of this frame alone.
    ///
    /// # Panics
    /// When the original has no further frame, or not this many samples in one.
    pub fn add_frame(&mut self, decoded: &[f32]) -> FrameError {
        let reference = self.subject.reference;
        let layout = reference.layout();
        assert!(self.frames < layout.frames, "the original has {} frames", layout.frames);
        assert_eq!(decoded.len() as u64, layout.samples_per_frame(), "samples of a decoded frame");
        let original = reference.dense().frame_values(FrameIndex(self.frames));
        // Slabs are fixed pieces and are added up in their order, independent of threads.
        let slabs: Vec<Sums> = (0..(layout.extent.z() as usize).div_ceil(SLICES))
            .into_par_iter()
            .map(|number| self.metrics.slab(&Slab::new(reference, &original, decoded, number)))
            .collect();
        let mut frame = Sums::default();
        for slab in slabs {
            self.metrics.add(&mut frame, slab);
        }
        let mse = frame.squared.all / layout.samples_per_frame() as f64;
        let error =
            FrameError { psnr_db: psnr_db(mse, reference.range().span()), max_abs_error: frame.max_abs };
        self.metrics.add(&mut self.sums, frame);
        self.frames += 1;
        error
    }

    /// The error over all frames, without the histogram.
    ///
    /// # Panics
    /// When a frame of the original has not been compared.
    #[must_use]
    pub fn finish(self) -> VolumeError {
        self.finish_with_histogram().0
    }

    /// The error over all frames, and how many samples have which.
    ///
    /// # Panics
    /// When a frame of the original has not been compared.
    #[must_use]
    pub fn finish_with_histogram(self) -> (VolumeError, ErrorHistogram) {
        assert_eq!(self.frames, self.subject.layout().frames, "compared frames");
        let outcomes: Outcomes = self.metrics.finish(&self.subject, self.sums);
        let error = VolumeError {
            psnr_db: outcomes.squared.psnr_db,
            foreground_psnr_db: outcomes.foreground,
            max_abs_error: outcomes.max_abs,
            mse: outcomes.squared.mse,
            channel_psnr_db: outcomes.squared.channel_psnr_db,
            values: outcomes.values(),
        };
        (error, outcomes.histogram)
    }
}
