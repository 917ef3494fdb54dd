//! The format of a file, and its reader.

use std::borrow::Cow;
use std::path::Path;

use super::header::HeaderText;
use super::layout::StoredLayout;
use super::payload::Encoding;
use super::slices::Pictures;
use super::{InputError, InputVolume, Place, metaimage, nifti, npy, nrrd, slices, vti};

/// The format of a file.
enum Format<'a> {
    Nrrd,
    Npy,
    Pictures(Pictures),
    /// With the first bytes, unpacked.
    Nifti(Cow<'a, [u8]>, Encoding),
    Vti,
    MetaImage,
}

impl<'a> Format<'a> {
    /// The content decides where it is recognised, the extension otherwise.
    fn of(text: &'a HeaderText) -> Result<Self, InputError> {
        let path = text.path();
        let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        if nrrd::has_magic(text) {
            return Ok(Self::Nrrd);
        }
        if npy::has_magic(text) {
            return Ok(Self::Npy);
        }
        if let Some(pictures) = Pictures::of(text.bytes()) {
            return Ok(Self::Pictures(pictures));
        }
        if text.starts_with(&[0x1f, 0x8b]) {
            let start = nifti::unpacked_start(text)?;
            if nifti::looks_like(&start) || extension.eq_ignore_ascii_case("gz") {
                return Ok(Self::Nifti(start.into(), Encoding::Gzip));
            }
        }
        let plain_nifti = Self::Nifti(text.bytes().into(), Encoding::Raw);
        if nifti::looks_like(text.bytes()) {
            return Ok(plain_nifti);
        }
        if vti::looks_like(text.bytes()) {
            return Ok(Self::Vti);
        }
        if metaimage::looks_like(text) {
            return Ok(Self::MetaImage);
        }
        Ok(match extension.to_ascii_lowercase().as_str() {
            "nrrd" | "nhdr" => Self::Nrrd,
            "mha" | "mhd" => Self::MetaImage,
            "nii" => plain_nifti,
            "vti" => Self::Vti,
            "npy" => Self::Npy,
            "tif" | "tiff" => Self::Pictures(Pictures::Tiff),
            "png" => Self::Pictures(Pictures::Png),
            _ => {
                let place = Place::file(path);
                return Err(InputError::UnknownFormat { place, extension, start: text.start() });
            }
        })
    }
}

/// Reads a volume from a file that describes itself, or from a folder of slices.
pub(super) fn open_one(path: &Path) -> Result<InputVolume, InputError> {
    if path.is_dir() {
        return slices::read_folder(path);
    }
    let text = HeaderText::read(path)?;
    match Format::of(&text)? {
        Format::Nrrd => nrrd::read(&text)?.read(),
        Format::Npy => npy::read(&text)?.read(),
        Format::Pictures(pictures) => slices::read_file(&text, pictures),
        Format::Nifti(start, encoding) => nifti::read(&text, &start, encoding)?.read(),
        Format::Vti => vti::read(&text),
        Format::MetaImage => metaimage::read(&text)?.read(),
    }
}

/// The layout in the header of such a file. No voxel is read. `None` for slices: their number and size are known only
/// after reading.
pub(super) fn layout_one(path: &Path) -> Result<Option<StoredLayout>, InputError> {
    if path.is_dir() {
        return Ok(None);
    }
    let text = HeaderText::read(path)?;
    match Format::of(&text)? {
        Format::Nrrd => nrrd::read(&text)?.checked().map(Some),
        Format::Npy => npy::read(&text)?.checked().map(Some),
        Format::Pictures(_) => Ok(None),
        Format::Nifti(start, encoding) => nifti::read(&text, &start, encoding)?.checked().map(Some),
        Format::Vti => vti::layout(&text).map(Some),
        Format::MetaImage => metaimage::read(&text)?.checked().map(Some),
    }
}
