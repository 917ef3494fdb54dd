//! The strips or tiles of a page. Each must hold exactly its pixels, and its stream must be whole: the crate
//! `tiff` stops behind the last pixel, before a checksum.

use std::io::{BufRead, Error, ErrorKind, Read, Result, Seek as _, SeekFrom, Write, sink};

use flate2::bufread::ZlibDecoder;
use tiff::decoder::ChunkType;
use tiff::tags::Tag;
use weezl::BitOrder;
use weezl::LzwStatus;
use weezl::decode::Configuration;

use super::super::super::{InputError, Place};
use super::{Pages, broken};

/// How chunks are packed.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    None,
    Lzw,
    Deflate,
    PackBits,
}

impl Packing {
    /// Values of the tag `Compression`.
    pub const fn of(compression: u16) -> Option<Self> {
        Some(match compression {
            1 => Self::None,
            5 => Self::Lzw,
            8 | 32946 => Self::Deflate,
            32773 => Self::PackBits,
            _ => return None,
        })
    }

    /// The most bytes that one byte becomes.
    pub const fn max_ratio(self) -> u64 {
        match self {
            Self::None => 1,
            // A code of at least 9 bits encodes at most 4096 bytes.
            Self::Lzw => 4096,
            Self::Deflate => 1032,
            Self::PackBits => 128,
        }
    }

    /// Bytes that a chunk holds, at most one more than `most`.
    ///
    /// # Errors
    /// When its stream is damaged, or bytes other than zeros follow it.
    fn unpacked(self, chunk: &mut dyn BufRead, most: u64) -> Result<u64> {
        let bytes = match self {
            Self::None => return Ok(most),
            Self::Lzw => lzw(chunk, most)?,
            Self::Deflate => {
                let mut stream = ZlibDecoder::new(&mut *chunk);
                // The byte too many, which is not there, makes the stream verify its checksum.
                std::io::copy(&mut (&mut stream).take(most.saturating_add(1)), &mut sink())?
            }
            Self::PackBits => packbits(chunk, most)?,
        };
        if bytes <= most && std::io::copy(chunk, &mut OnlyZeros).is_err() {
            return Err(Error::new(ErrorKind::InvalidData, "bytes follow its stream"));
        }
        Ok(bytes)
    }
}

/// Compares the chunks of the current page with its pixels of this many bytes each.
///
/// # Errors
/// When a chunk holds more or fewer bytes than its rows take, or its stream is damaged.
pub(super) fn check(
    pages: &mut Pages,
    packing: Packing,
    pixel_bytes: u64,
    place: &Place,
) -> std::result::Result<(), InputError> {
    let is_tiled = pages.get_chunk_type() == ChunkType::Tile;
    let (name, tags) = if is_tiled {
        ("tile", [Tag::TileOffsets, Tag::TileByteCounts])
    } else {
        ("strip", [Tag::StripOffsets, Tag::StripByteCounts])
    };
    let [offsets, counts] = tags.map(|tag| pages.find_tag_unsigned_vec::<u64>(tag));
    let offsets = offsets.map_err(|e| broken(place, e))?.unwrap_or_default();
    let counts = counts.map_err(|e| broken(place, e))?.unwrap_or_default();
    let (width, height) = pages.chunk_dimensions();
    for (index, (offset, count)) in (0_u32..).zip(offsets.into_iter().zip(counts)) {
        let row = u64::from(width) * pixel_bytes;
        let whole = row.saturating_mul(u64::from(height));
        // Tiles are stored whole. The last strip may be: its rows behind the page are not pixels.
        let due = if is_tiled { whole } else { row * u64::from(pages.chunk_data_dimensions(index).1) };
        let file = pages.inner();
        let found = match packing {
            Packing::None => Ok(count),
            _ => file
                .seek(SeekFrom::Start(offset))
                .and_then(|_| packing.unpacked(&mut file.take(count), whole)),
        };
        let wrong = |problem: String| InputError::Data {
            place: place.clone(),
            problem: format!("{name} {} {problem}", index + 1),
            remedy: "fetch or save the file again".to_owned(),
        };
        match found {
            Ok(bytes) if bytes == due || bytes == whole => {}
            Ok(bytes) => {
                let is_counted = packing == Packing::None || bytes < whole;
                let bytes = if is_counted { format!("{bytes} bytes") } else { "more bytes".to_owned() };
                return Err(wrong(format!("holds {bytes}, and its pixels take {due}")));
            }
            Err(e) => return Err(wrong(format!("is damaged ({e})"))),
        }
    }
    Ok(())
}

/// Accepts nothing but zeros, with which writers pad.
struct OnlyZeros;

impl Write for OnlyZeros {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        if bytes.iter().all(|b| *b == 0) { Ok(bytes.len()) } else { Err(ErrorKind::InvalidData.into()) }
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

fn lzw(chunk: &mut dyn BufRead, most: u64) -> Result<u64> {
    let configuration = Configuration::with_tiff_size_switch(BitOrder::Msb, 8);
    let mut decoder = configuration.with_yield_on_full_buffer(true).build();
    let mut out = [0; 4096];
    let mut bytes = 0;
    loop {
        let packed = chunk.fill_buf()?;
        let is_end = packed.is_empty();
        let step = decoder.decode_bytes(packed, &mut out);
        chunk.consume(step.consumed_in);
        bytes += step.consumed_out as u64;
        match step.status {
            Err(e) => return Err(Error::new(ErrorKind::InvalidData, e)),
            _ if bytes > most => return Ok(bytes),
            Ok(LzwStatus::Done) => return Ok(bytes),
            // Some writers leave the end code out.
            Ok(_) if is_end && step.consumed_out == 0 => return Ok(bytes),
            Ok(_) => {}
        }
    }
}

/// Stops behind `most` bytes, for the format has no end code.
fn packbits(chunk: &mut dyn BufRead, most: u64) -> Result<u64> {
    let mut bytes = 0;
    while bytes < most {
        let mut header = [0];
        if chunk.read(&mut header)? == 0 {
            break;
        }
        let (packed, unpacked) = match i8::from_ne_bytes(header) {
            -128 => (0, 0),
            n if n < 0 => (1, 1 + u64::from(n.unsigned_abs())),
            n => (1 + u64::from(n.unsigned_abs()), 1 + u64::from(n.unsigned_abs())),
        };
        if std::io::copy(&mut (&mut *chunk).take(packed), &mut sink())? < packed {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        bytes += unpacked;
    }
    Ok(bytes)
}
