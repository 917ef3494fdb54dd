//! TIFF and BigTIFF, through the crate `tiff`: gray or RGB, every page a slice. What the crate does not look at is
//! checked here: lengths and checksums of strips and tiles, and what a description promises beyond the pages.

mod chunks;
mod description;
mod ome;
mod pledges;
mod promise;

use std::io::BufReader;
use std::path::Path;

use cvr_core::volume::StoredType;
use tiff::decoder::{Decoder, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError, TiffFormatError};

use super::super::payload::open_regular;
use super::super::{ByteOrder, InputError, Place};
use super::{Pictures, Slice, Stack, check_claim};
use chunks::Packing;
use pledges::Pledges;

type Pages = Decoder<BufReader<std::fs::File>>;

const SUPPORTED: &str = "gray or RGB (interleaved) of 8, 16, 32 or 64 bits, not compressed or by LZW, deflate or \
                         PackBits; save the stack so";
/// Bytes that the decoder may reserve for the value of one tag: the offsets of a million strips.
const TAG_BYTES: usize = 32 << 20;

/// Adds all pages of a file as slices.
pub(super) fn add_pages(path: &Path, stack: &mut Stack) -> Result<(), InputError> {
    let whole = Place::file(path);
    let (file, length) = open_regular(path, &whole)?;
    let reader = BufReader::with_capacity(1 << 16, file);
    let mut pages = Decoder::new(reader).map_err(|e| broken(&whole, e))?;
    let limits = |page: usize| {
        let mut limits = Limits::default();
        limits.ifd_value_size = TAG_BYTES;
        limits.decoding_buffer_size = page.max(TAG_BYTES);
        limits.intermediate_buffer_size = usize::try_from(length).unwrap_or(usize::MAX).saturating_add(page);
        limits
    };
    // Pages may share their strips: it is all pages together that the file must be able to hold.
    let mut claimed = 0_u64;
    let mut pledges = Pledges::default();
    for number in 1_u64.. {
        let place = Place::part(path, format!("page {number}"));
        pages = pages.with_limits(limits(0));
        let (slice, packing) = describe(&mut pages, &place)?;
        let ratio = packing.max_ratio();
        pledges.page(&mut pages, slice, &place)?;
        let bytes = stack.expect(slice, &place)?;
        claimed = claimed.saturating_add(bytes as u64);
        check_claim(&place, Pictures::Tiff, claimed, length, ratio)?;
        pages = pages.with_limits(limits(bytes));
        let layout = pages.image_buffer_layout().map_err(|e| broken(&place, e))?;
        if layout.len != bytes {
            return Err(unsupported(&place, format!("a page of {} bytes where {bytes} are due", layout.len)));
        }
        let pixel_bytes = u64::from(slice.channels) * slice.stored.bytes() as u64;
        chunks::check(&mut pages, packing, pixel_bytes, &place)?;
        let mut pixels = Vec::new();
        pixels
            .try_reserve_exact(bytes)
            .map_err(|_| InputError::Memory { place: place.clone(), bytes: bytes as u64 })?;
        pixels.resize(bytes, 0);
        pages.read_image_bytes(&mut pixels).map_err(|e| broken(&place, e))?;
        stack.push(slice, &pixels, ByteOrder::NATIVE, &place)?;
        if !pages.more_images() {
            break;
        }
        pages.next_image().map_err(|e| broken(&Place::part(path, format!("page {}", number + 1)), e))?;
    }
    pledges.finish(stack, &whole)
}

/// Content of a page, and how its pixels are packed.
fn describe(pages: &mut Pages, place: &Place) -> Result<(Slice, Packing), InputError> {
    let tag = |pages: &mut Pages, tag, default| {
        let value = pages.find_tag_unsigned::<u16>(tag).map_err(|e| broken(place, e))?;
        Ok::<u16, InputError>(value.unwrap_or(default))
    };
    let compression = tag(pages, Tag::Compression, 1)?;
    let packing =
        Packing::of(compression).ok_or_else(|| unsupported(place, format!("compression {compression}")))?;
    let photometric = tag(pages, Tag::PhotometricInterpretation, 1)?;
    let planar = tag(pages, Tag::PlanarConfiguration, 1)?;
    let (width, height) = pages.dimensions().map_err(|e| broken(place, e))?;
    let (channels, bits) = match (pages.colortype().map_err(|e| broken(place, e))?, photometric) {
        (ColorType::Gray(bits), 1) => (1, bits),
        (ColorType::RGB(bits), 2) if planar == 1 => (3, bits),
        (ColorType::Gray(_), 0) => {
            return Err(unsupported(place, "white as zero (photometric interpretation 0)".to_owned()));
        }
        (ColorType::RGB(_), 2) => return Err(unsupported(place, "one plane per channel".to_owned())),
        (other, _) => return Err(unsupported(place, format!("the colour type {other:?}"))),
    };
    let formats = pages.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(|e| broken(place, e))?;
    let formats = formats.unwrap_or_else(|| vec![1]);
    let [format, rest @ ..] = formats.as_slice() else {
        return Err(unsupported(place, "a page without a sample format".to_owned()));
    };
    let stored = match (format, bits) {
        (1 | 4, 8) => StoredType::U8,
        (1 | 4, 16) => StoredType::U16,
        (1 | 4, 32) => StoredType::U32,
        (1 | 4, 64) => StoredType::U64,
        (2, 8) => StoredType::I8,
        (2, 16) => StoredType::I16,
        (2, 32) => StoredType::I32,
        (2, 64) => StoredType::I64,
        (3, 32) => StoredType::F32,
        (3, 64) => StoredType::F64,
        _ => return Err(unsupported(place, format!("samples of {bits} bits and format {format}"))),
    };
    if rest.iter().any(|f| f != format) {
        return Err(unsupported(place, "channels of several formats".to_owned()));
    }
    Ok((Slice { width, height, channels, stored }, packing))
}

fn unsupported(place: &Place, found: String) -> InputError {
    InputError::Unsupported { place: place.clone(), found, supported: SUPPORTED.to_owned() }
}

/// The library's message. It may quote a list as long as the file.
fn said(error: &dyn std::fmt::Display) -> String {
    const MOST: usize = 200;
    let text = error.to_string();
    text.char_indices().nth(MOST).map_or_else(|| text.clone(), |(end, _)| format!("{} …", &text[..end]))
}

fn broken(place: &Place, error: TiffError) -> InputError {
    match error {
        TiffError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            InputError::Io { place: place.clone(), action: "read the pages", source }
        }
        TiffError::UnsupportedError(what) => unsupported(place, said(&what)),
        TiffError::FormatError(TiffFormatError::InconsistentSizesEncountered) => InputError::Data {
            place: place.clone(),
            problem: "the strips or tiles are not as many as the rows of the page need".to_owned(),
            remedy: "save one page for each slice (pages of several slices, `ImageDepth`, are not read), or fetch the \
                     file again"
                .to_owned(),
        },
        other => InputError::Data {
            place: place.clone(),
            problem: format!("this is no whole TIFF file ({})", said(&other)),
            remedy: "fetch or save it again".to_owned(),
        },
    }
}
