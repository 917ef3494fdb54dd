//! How far the picture of a frame is from the reference, and from the picture of the uncompressed volume.

use cvr_core::metrics::{Against, ImageError};

use crate::experiment::records::record::Record;

/// The picture of a frame compared with two others.
#[derive(Copy, Clone, Debug)]
pub struct PictureErrors {
    /// Against the reference.
    pub reference: ImageError,
    /// Against raw's picture under the same site and filter.
    pub raw: ImageError,
}

impl PictureErrors {
    /// Enters the figures.
    pub fn enter(&self, record: &mut Record) {
        let Self { reference, raw } = self;
        record.visible_pixels = Some(reference.visible_pixels);
        for (name, value) in reference.values(Against::Reference).chain(raw.values(Against::Raw)) {
            record.enter(name, value);
        }
    }
}
