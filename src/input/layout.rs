//! From claimed dimensions to a layout, with the guard on the total size.

use cvr_core::volume::{Extent, SampleType, StoredType, VolumeLayout};

use super::{InputError, MAX_VOLUME_BYTES, Place};

/// Voxels along x, y, z, values per voxel, and time steps, as a header claims them.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    pub dims: [u32; 3],
    pub channels: u32,
    pub frames: u32,
}

impl Shape {
    /// One scalar frame.
    pub const fn scalar(dims: [u32; 3]) -> Self {
        Self { dims, channels: 1, frames: 1 }
    }

    /// The sentence's subject in errors: `3×4×2 voxels of 3 channels in 10 frames`.
    pub fn words(&self) -> String {
        let Self { dims: [x, y, z], channels, frames } = self;
        let channels = if *channels == 1 { String::new() } else { format!(" of {channels} channels") };
        let frames = if *frames == 1 { String::new() } else { format!(" in {frames} frames") };
        format!("{x}×{y}×{z} voxels{channels}{frames}")
    }

    /// Five 32-bit factors, and 8 bytes of each sample at most: 163 bits, which saturate in 128.
    fn bytes(&self, per_sample: usize) -> u128 {
        let factors = self.dims.into_iter().chain([self.channels, self.frames]);
        factors.fold(per_sample as u128, |product, n| product.saturating_mul(u128::from(n)))
    }
}

/// The layout of a volume, and the number type that its file has.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StoredLayout {
    /// As it is kept in memory.
    pub layout: VolumeLayout,
    /// As it lies in the file.
    pub stored: StoredType,
}

impl StoredLayout {
    /// `place` is where the shape is claimed.
    ///
    /// # Errors
    /// When a dimension is zero, there are neither 1 nor 3 channels, a spacing is not a positive finite length, or
    /// the volume is too large.
    pub fn new(
        place: &Place,
        shape: Shape,
        spacing: [f64; 3],
        stored: StoredType,
    ) -> Result<Self, InputError> {
        let header = |problem: String, remedy: &str| InputError::Header {
            place: place.clone(),
            problem,
            remedy: remedy.to_owned(),
        };
        let kept = stored.kept();
        let bytes = shape.bytes(stored.bytes().max(kept.bytes()));
        if bytes > u128::from(MAX_VOLUME_BYTES) {
            return Err(InputError::TooLarge { place: place.clone(), what: shape.words(), bytes });
        }
        let extent = Extent::try_from(shape.dims)
            .map_err(|e| header(e.to_string(), "correct the dimensions of the volume"))?;
        let Shape { channels, frames, .. } = shape;
        let layout = VolumeLayout { extent, spacing, channels, frames, sample: kept };
        layout.validate().map_err(|e| {
            let remedy = match e {
                cvr_core::volume::LayoutError::Spacing(_) => "correct the spacing, or leave it out for 1",
                _ => "correct the number of channels or frames",
            };
            header(e.to_string(), remedy)
        })?;
        Ok(Self { layout, stored })
    }

    /// The same samples, scaled to single precision.
    ///
    /// # Errors
    /// When the volume is then too large.
    pub fn scaled(mut self, place: &Place) -> Result<Self, InputError> {
        let shape = self.shape();
        let bytes = shape.bytes(SampleType::F32.bytes());
        if bytes > u128::from(MAX_VOLUME_BYTES) {
            return Err(InputError::TooLarge { place: place.clone(), what: shape.words(), bytes });
        }
        self.layout.sample = SampleType::F32;
        Ok(self)
    }

    pub fn shape(&self) -> Shape {
        let VolumeLayout { extent, channels, frames, .. } = self.layout;
        Shape { dims: extent.to_array(), channels, frames }
    }

    /// Bytes in the file, uncompressed.
    pub const fn bytes(&self) -> u64 {
        self.layout.samples() * self.stored.bytes() as u64
    }

    /// What the file must hold, as a sentence without its end.
    pub fn need(&self) -> String {
        format!("{} of {} take {} bytes", self.shape().words(), self.stored, self.bytes())
    }
}
