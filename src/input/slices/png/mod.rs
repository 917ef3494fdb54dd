//! PNG, through the crate `png`: gray or RGB, 8 or 16 bits.

mod stream;

use std::io::BufReader;
use std::path::Path;

use cvr_core::volume::StoredType;
use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};

use super::super::payload::open_regular;
use super::super::{ByteOrder, InputError, Place};
use super::{Pictures, Slice, Stack, check_claim};

/// Deflate's best, and what a row's filter byte adds in proportion.
const MAX_RATIO: u64 = 1032;
/// Bytes that the decoder may reserve in addition to pixels: text, colour profiles.
const ASIDE_BYTES: usize = 16 << 20;

/// Adds the picture of a file as one slice.
pub(super) fn add(path: &Path, stack: &mut Stack) -> Result<(), InputError> {
    let place = Place::file(path);
    let broken = |e: DecodingError| match e {
        DecodingError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            InputError::Io { place: place.clone(), action: "read the pixels", source }
        }
        other => InputError::Data {
            place: place.clone(),
            problem: format!("this is no whole PNG file ({other})"),
            remedy: "fetch or save it again".to_owned(),
        },
    };
    let (file, length) = open_regular(path, &place)?;
    let mut decoder =
        Decoder::new_with_limits(BufReader::with_capacity(1 << 16, file), Limits { bytes: ASIDE_BYTES });
    decoder.set_transformations(Transformations::IDENTITY);
    decoder.set_ignore_text_chunk(true);
    let info = decoder.read_header_info().map_err(broken)?;
    let channels = match info.color_type {
        ColorType::Grayscale => 1,
        ColorType::Rgb => 3,
        other => return Err(unsupported(&place, &format!("the colour type {other:?}"))),
    };
    let stored = match info.bit_depth {
        BitDepth::Eight => StoredType::U8,
        BitDepth::Sixteen => StoredType::U16,
        other => return Err(unsupported(&place, &format!("a bit depth of {}", other as u8))),
    };
    let slice = Slice { width: info.width, height: info.height, channels, stored };
    let bytes = stack.expect(slice, &place)?;
    check_claim(&place, Pictures::Png, bytes as u64, length, MAX_RATIO)?;
    decoder.set_limits(Limits { bytes: ASIDE_BYTES.saturating_add(bytes) });
    let mut reader = decoder.read_info().map_err(broken)?;
    let frames = reader.info().animation_control().map_or(1, |animation| animation.num_frames);
    if frames > 1 {
        return Err(unsupported(&place, &format!("an animation of {frames} pictures")));
    }
    let rows = stream::row_bytes(reader.info());
    let mut pixels = Vec::new();
    pixels
        .try_reserve_exact(bytes)
        .map_err(|_| InputError::Memory { place: place.clone(), bytes: bytes as u64 })?;
    pixels.resize(bytes, 0);
    reader.next_frame(&mut pixels).map_err(broken)?;
    // The trailer too must be there and whole, for only behind it the stream's checksums are verified.
    reader.finish().map_err(broken)?;
    let damaged = |problem: String| InputError::Data {
        place: place.clone(),
        problem: format!("this is no whole PNG file ({problem})"),
        remedy: "fetch or save it again".to_owned(),
    };
    let (file, _) = open_regular(path, &place)?;
    let found = stream::check(BufReader::with_capacity(1 << 16, file), rows);
    if let Some(problem) = found.unwrap_or_else(|e| Some(e.to_string())) {
        return Err(damaged(problem));
    }
    stack.space(None, &place)?;
    stack.push(slice, &pixels, ByteOrder::Big, &place)
}

fn unsupported(place: &Place, found: &str) -> InputError {
    InputError::Unsupported {
        place: place.clone(),
        found: found.to_owned(),
        supported: "gray or RGB of 8 or 16 bits; drop alpha channel and palette".to_owned(),
    }
}
