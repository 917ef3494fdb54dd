//! Volumes from files and generators.
//!
//! Every reader ends in a [`DenseVolume`]: one scalar frame, x fastest, spacing in the file's unit of length
//! (1 where the file is silent). A header is never believed: sizes are bounded before they are multiplied,
//! compared with the length of the file before memory is reserved, and a compressed stream is decoded only as
//! far as the header's byte count. Data files of detached headers may lie anywhere; errors name both files.
//!
//! Nothing about orientation is read yet: `space origin` and the directions' signs (NRRD), `TransformMatrix`
//! and `Offset` (MetaImage) are ignored, as are NRRD's `axis mins` and `axis maxs`.

mod error;
mod generate;
mod header;
mod layout;
mod metaimage;
mod nrrd;
mod nrrd_write;
mod payload;
mod raw;
#[cfg(test)]
mod tests;

pub use cvr_core::pipeline::{ByteOrder, RawLayout};
pub use error::{InputError, Place};
pub use generate::{Generator, generate};
pub use nrrd_write::write_nrrd;
pub use raw::open_raw;

use std::path::Path;

use cvr_core::volume::DenseVolume;

use header::HeaderText;

/// Largest volume that is read or generated, in bytes of uncompressed samples.
pub const MAX_VOLUME_BYTES: u64 = 1 << 33;

/// The file formats, for help texts and errors.
pub const FORMATS: &str = "NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), and headerless raw files, whose \
                           dimensions, sample type and byte order must be given";

/// Reads a volume from a file that describes itself: NRRD or MetaImage, with attached or detached data.
///
/// The content decides where it is recognised (NRRD's magic, MetaImage's first key), the extension otherwise.
///
/// # Errors
/// When the file cannot be read, is of no supported format, breaks the rules of its format, uses a part of it
/// that is not supported, or holds more or fewer data than its header claims.
pub fn open(path: &Path) -> Result<DenseVolume, InputError> {
    let text = HeaderText::read(path)?;
    let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
    if nrrd::has_magic(&text) {
        return nrrd::read(&text);
    }
    if metaimage::looks_like(&text) {
        return metaimage::read(&text);
    }
    match extension.to_ascii_lowercase().as_str() {
        "nrrd" | "nhdr" => nrrd::read(&text),
        "mha" | "mhd" => metaimage::read(&text),
        _ => Err(InputError::UnknownFormat { place: Place::file(path), extension, start: text.start() }),
    }
}
