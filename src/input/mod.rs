//! Volumes from files and generators.
//!
//! Every reader returns an [`InputVolume`]: samples x fastest, channels interleaved, frame after frame; spacing in the
//! file's unit of length (1 if the file has none). Headers are not trusted: sizes are bounded before they are
//! multiplied, and compared with the length of the file before memory is reserved. A compressed stream is decoded only
//! up to the header's byte count. Data files of detached headers may be anywhere; errors name both files.
//!
//! `docs/user/inputs.md` lists for each format what is read and what is refused. Orientation is never read: origins,
//! directions and matrices have no effect on a picture yet.

mod axes;
mod error;
mod format;
mod generate;
mod header;
mod layout;
mod metaimage;
mod nifti;
mod npy;
mod nrrd;
mod payload;
mod raw;
mod samples;
mod slices;
mod source;
#[cfg(test)]
mod tests;
mod volume;
mod vti;

pub use cvr_core::pipeline::{ByteOrder, RawLayout};
pub use error::{InputError, Place};
pub use generate::{Generator, generate, generate_frames};
pub use npy::{write_npy, write_npy_from};
pub use nrrd::{write_nrrd, write_nrrd_from};
pub use source::{found, layout, read};
pub use volume::InputVolume;

use std::path::Path;

use cvr_core::volume::DenseVolume;

use format::open_one;

/// Largest volume to read or generate, in bytes of uncompressed samples.
pub const MAX_VOLUME_BYTES: u64 = 1 << 33;

/// The file formats, for help texts and errors.
pub const FORMATS: &str = "NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI-1 (.nii, .nii.gz), VTK image data (.vti), \
                           NumPy arrays (.npy), TIFF stacks (.tif), folders of TIFF or PNG slices, and headerless \
                           raw files, whose dimensions, sample type and byte order must be given";

/// Reads a volume from a file that describes itself, or from a folder of slices.
///
/// The content decides the format if it is recognised, else the extension. [`read`] also returns how wide number types
/// were converted.
///
/// # Errors
/// When the file cannot be read, is of no supported format, breaks the rules of its format, uses a part of it
/// that is not supported, or holds more or fewer data than its header claims.
pub fn open(path: &Path) -> Result<DenseVolume, InputError> {
    open_one(path).map(|input| input.volume)
}

/// Reads a headerless file. Its voxels must fill it exactly from `skip_bytes` to its end.
///
/// # Errors
/// When the file cannot be read or has another length, the spacing is not positive and finite, or the volume
/// is larger than [`MAX_VOLUME_BYTES`].
pub fn open_raw(path: &Path, raw: &RawLayout) -> Result<DenseVolume, InputError> {
    raw::read(path, raw)?.read().map(|input| input.volume)
}
