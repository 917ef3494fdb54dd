//! The shape of a volume: size, spacing, channels, frames, number type.

use serde::{Deserialize, Serialize};

use super::{Extent, Level, SampleType};

/// Index of a frame (time step), from 0.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FrameIndex(pub u32);

impl FrameIndex {
    /// The first frame.
    pub const FIRST: Self = Self(0);
}

/// Everything about a volume but its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VolumeLayout {
    /// Voxels along x, y, z.
    pub extent: Extent,
    /// Distance between voxel centres along x, y, z, in the file's unit of length. Positive and finite.
    pub spacing: [f64; 3],
    /// Values per voxel: 1 (scalar) or 3 (RGB).
    pub channels: u32,
    /// Time steps; at least 1.
    pub frames: u32,
    /// Number type of the samples.
    pub sample: SampleType,
}

/// Why a layout is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LayoutError {
    /// A spacing is zero, negative or not finite.
    #[error("spacing {0:?}: each must be a positive, finite length")]
    Spacing([f64; 3]),
    /// Neither scalar nor RGB.
    #[error("{0} channels: only 1 (scalar) and 3 (RGB) are supported")]
    Channels(u32),
    /// No frames.
    #[error("a volume needs at least one frame")]
    NoFrames,
    /// More voxels than this software counts.
    #[error("{frames} frames of {extent}: more than 2^40 voxels")]
    TooLarge {
        /// Frames.
        frames: u32,
        /// Voxels of each.
        extent: Extent,
    },
}

impl VolumeLayout {
    /// One scalar frame with unit spacing.
    #[must_use]
    pub const fn scalar(extent: Extent, sample: SampleType) -> Self {
        Self { extent, spacing: [1.0; 3], channels: 1, frames: 1, sample }
    }

    /// Checks the invariants that the field types cannot express.
    ///
    /// # Errors
    /// When spacing, channels or frames are out of range.
    pub fn validate(&self) -> Result<(), LayoutError> {
        if !self.spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
            return Err(LayoutError::Spacing(self.spacing));
        }
        if !matches!(self.channels, 1 | 3) {
            return Err(LayoutError::Channels(self.channels));
        }
        if self.frames == 0 {
            return Err(LayoutError::NoFrames);
        }
        // This bound keeps all products of a layout within 64 bits.
        if u128::from(self.extent.voxels()) * u128::from(self.frames) > 1 << 40 {
            return Err(LayoutError::TooLarge { frames: self.frames, extent: self.extent });
        }
        Ok(())
    }

    /// The layout at a resolution: each step halves every axis, rounded up, and doubles the spacing. Voxel `i` of a
    /// level stands for the voxels `i · 2^r .. (i + 1) · 2^r` of the volume. At the upper faces of odd sizes it stands
    /// for fewer voxels, but its centre still lies at `(i + ½) · 2^r`.
    #[must_use]
    pub fn at_resolution(&self, resolution: u8) -> Self {
        let scale = Level::scale(resolution);
        let spacing = self.spacing.map(|spacing| spacing * scale);
        Self { extent: self.extent.at_resolution(resolution), spacing, ..*self }
    }

    /// Samples of one frame: voxels × channels.
    #[must_use]
    pub const fn samples_per_frame(&self) -> u64 {
        self.extent.voxels() * self.channels as u64
    }

    /// Voxels of all frames.
    #[must_use]
    pub const fn voxels(&self) -> u64 {
        self.extent.voxels() * self.frames as u64
    }

    /// Samples of all frames.
    #[must_use]
    pub const fn samples(&self) -> u64 {
        self.samples_per_frame() * self.frames as u64
    }

    /// Bytes of all samples, uncompressed.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.samples() * self.sample.bytes() as u64
    }

    /// The smallest spacing. Steps and opacities per voxel refer to it.
    #[must_use]
    pub fn voxel_length(&self) -> f64 {
        self.spacing.iter().copied().fold(f64::INFINITY, f64::min)
    }
}
