//! The voxels behind a header: skipped to, decompressed within bounds, checked against the claimed size.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::bufread::{MultiGzDecoder, ZlibDecoder};

use super::axes::{Axis, rearranged};
use super::layout::StoredLayout;
use super::samples::{ReadFault, SampleSink, Scale, fill, read_samples};
use super::{ByteOrder, InputError, InputVolume, Place};

/// How the voxels are packed.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Not at all.
    Raw,
    /// One or more gzip members.
    Gzip,
    /// One zlib stream.
    Zlib,
}

impl Encoding {
    const fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Gzip => "gzip",
            Self::Zlib => "zlib",
        }
    }
}

/// Bytes in front of the voxels.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Skip {
    /// So many.
    Bytes(u64),
    /// All but the last ones, which are the voxels. Only for [`Encoding::Raw`].
    AllButVoxels,
}

/// Where the voxels lie and how they are stored.
#[derive(Debug)]
pub(super) struct Payload {
    pub file: PathBuf,
    /// What errors name.
    pub place: Place,
    /// Bytes of the file to pass over first: the attached header.
    pub offset: u64,
    /// Then lines to pass over, before decompression.
    pub skip_lines: u64,
    /// Then bytes to pass over, after decompression.
    pub skip: Skip,
    /// Bytes that the compressed stream takes in the file, where the header claims it.
    pub stored_bytes: Option<u64>,
    pub encoding: Encoding,
    pub byte_order: ByteOrder,
    /// The conversion of every sample.
    pub scale: Option<Scale>,
}

/// A volume whose header is read and whose voxels are not.
#[derive(Debug)]
pub(super) struct Described {
    pub layout: StoredLayout,
    pub payload: Payload,
    /// The file's axes, fastest first. Empty if they are in memory order.
    pub axes: Vec<Axis>,
}

impl Described {
    /// Reads the voxels.
    ///
    /// # Errors
    /// As [`Payload::read`].
    pub fn read(self) -> Result<InputVolume, InputError> {
        rearranged(self.payload.read(&self.layout)?, &self.axes, &self.payload.place)
    }

    /// The layout, once the voxels are known to be there: the file exists, and uncompressed ones fill it.
    ///
    /// # Errors
    /// When they are not.
    pub fn checked(self) -> Result<StoredLayout, InputError> {
        let Payload { file, place, offset, skip_lines, encoding, .. } = &self.payload;
        let (_, length) = open_regular(file, place)?;
        if *encoding == Encoding::Raw && *skip_lines == 0 {
            self.payload.raw_start(*offset, length, &self.layout)?;
        }
        Ok(self.layout)
    }
}

/// A deflate stream holds at most 1032 times its own bytes: 258 bytes per match of two one-bit codes.
const MAX_DEFLATE_RATIO: u64 = 1032;

/// Opens a file for reading, with its length. Pipes and devices are refused before opening, which could block.
pub(super) fn open_regular(path: &Path, place: &Place) -> Result<(File, u64), InputError> {
    let io = |source| InputError::Io { place: place.clone(), action: "open the file", source };
    let metadata = std::fs::metadata(path).map_err(io)?;
    if !metadata.is_file() {
        return Err(InputError::NotAFile { place: place.clone() });
    }
    Ok((File::open(path).map_err(io)?, metadata.len()))
}

impl Payload {
    /// Reads the voxels of a volume.
    ///
    /// # Errors
    /// When the file cannot be read, holds more or fewer bytes than `layout` needs, or its stream is damaged.
    pub fn read(&self, layout: &StoredLayout) -> Result<InputVolume, InputError> {
        let (file, length) = open_regular(&self.file, &self.place)?;
        let mut source = BufReader::with_capacity(1 << 18, file);
        // An offset behind the end finds no voxels there, which is the better complaint than a failed seek.
        let mut at = self.offset;
        source.seek(SeekFrom::Start(at.min(length))).map_err(|e| self.io(e))?;
        at += self.pass_lines(&mut source)?;
        let mut sink = SampleSink::new(layout.stored, self.scale);
        match self.encoding {
            Encoding::Raw => {
                let start = self.raw_start(at, length, layout)?;
                source.seek(SeekFrom::Start(start)).map_err(|e| self.io(e))?;
                self.raw(&mut sink, &mut source, layout)?;
            }
            Encoding::Gzip => {
                self.check_stored(length.saturating_sub(at), layout)?;
                self.decoded(&mut sink, &mut MultiGzDecoder::new(&mut source), layout)?;
            }
            Encoding::Zlib => {
                self.check_stored(length.saturating_sub(at), layout)?;
                self.decoded(&mut sink, &mut ZlibDecoder::new(&mut source), layout)?;
                // Unlike gzip, the decoder leaves what follows unread, and unremarked.
                if !source.fill_buf().map_err(|e| self.io(e))?.is_empty() {
                    return Err(self.wrong("bytes follow the zlib stream".to_owned(), "remove them"));
                }
            }
        }
        InputVolume::new(layout, sink)
            .map_err(|problem| self.wrong(problem, "correct the header's dimensions or type"))
    }

    /// Passes over `skip_lines` lines; returns their length in bytes.
    fn pass_lines(&self, source: &mut impl BufRead) -> Result<u64, InputError> {
        let mut passed = 0;
        for line in 0..self.skip_lines {
            let bytes = source.skip_until(b'\n').map_err(|e| self.io(e))?;
            if bytes == 0 {
                let problem = format!("{} lines are to be skipped, {line} are there", self.skip_lines);
                return Err(self.wrong(problem, "correct `line skip`"));
            }
            passed += bytes as u64;
        }
        Ok(passed)
    }

    /// Offset of the first voxel, once the rest of the file is known to be exactly the voxels.
    fn raw_start(&self, at: u64, length: u64, layout: &StoredLayout) -> Result<u64, InputError> {
        let needed = layout.bytes();
        let start = match self.skip {
            Skip::Bytes(skip) => at.saturating_add(skip),
            Skip::AllButVoxels => at.max(length.saturating_sub(needed)),
        };
        let found = length.saturating_sub(start);
        match found.cmp(&needed) {
            std::cmp::Ordering::Equal => Ok(start),
            std::cmp::Ordering::Less => Err(self.wrong(
                format!("{}, but only {found} are there", layout.need()),
                "the file is cut short, or the dimensions, type or skip are wrong",
            )),
            std::cmp::Ordering::Greater => Err(self.wrong(
                format!("{}, but {found} are there", layout.need()),
                "correct the dimensions or type, or skip what stands in front of the voxels",
            )),
        }
    }

    /// Refuses a claim that the stored bytes cannot fulfil, before anything is decoded.
    fn check_stored(&self, available: u64, layout: &StoredLayout) -> Result<(), InputError> {
        if let Some(stored) = self.stored_bytes
            && stored != available
        {
            return Err(self.wrong(
                format!("the compressed data take {available} bytes, the header says {stored}"),
                "fetch the file again, or correct the header",
            ));
        }
        let Skip::Bytes(skip) = self.skip else {
            return Err(self.wrong(
                format!("{} data end where their stream ends", self.encoding.name()),
                "give the number of bytes to skip",
            ));
        };
        if layout.bytes().saturating_add(skip) > available.saturating_mul(MAX_DEFLATE_RATIO) {
            return Err(self.wrong(
                format!("{}, which {available} bytes of {} cannot hold", layout.need(), self.encoding.name()),
                "the file is cut short, or the dimensions or type are wrong",
            ));
        }
        Ok(())
    }

    /// `raw_start` has compared the claim with the file's length, so its memory may be reserved at once.
    fn raw(
        &self,
        sink: &mut SampleSink,
        source: &mut impl Read,
        layout: &StoredLayout,
    ) -> Result<(), InputError> {
        read_samples(sink, source, self.byte_order, self.count(layout)?, true).map_err(|fault| match fault {
            ReadFault::Failed(_, e) => self.io(e),
            ReadFault::Short(_) => self.io(std::io::ErrorKind::UnexpectedEof.into()),
            ReadFault::Memory => self.memory(layout),
        })
    }

    fn decoded(
        &self,
        sink: &mut SampleSink,
        stream: &mut impl Read,
        layout: &StoredLayout,
    ) -> Result<(), InputError> {
        let needed = layout.bytes();
        let damaged = |decoded: u64, source| InputError::Damaged {
            place: self.place.clone(),
            stream: self.encoding.name(),
            decoded,
            needed,
            source,
        };
        let short = |decoded: u64| {
            self.wrong(
                format!("{}, but the {} stream holds only {decoded}", layout.need(), self.encoding.name()),
                "correct the header's dimensions or type",
            )
        };
        if let Skip::Bytes(skip) = self.skip {
            let skipped = std::io::copy(&mut stream.take(skip), &mut std::io::sink());
            if skipped.map_err(|e| damaged(0, e))? < skip {
                return Err(short(0));
            }
        }
        read_samples(sink, stream, self.byte_order, self.count(layout)?, false).map_err(
            |fault| match fault {
                ReadFault::Short(decoded) => short(decoded),
                ReadFault::Failed(decoded, e) => damaged(decoded, e),
                ReadFault::Memory => self.memory(layout),
            },
        )?;
        // One byte more: there must be none, and asking for it makes the stream verify its checksum.
        match fill(stream, &mut [0]) {
            (0, None) => Ok(()),
            (_, None) => Err(self.wrong(
                format!("{}, but the {} stream holds more", layout.need(), self.encoding.name()),
                "correct the header's dimensions or type",
            )),
            (_, Some(e)) => Err(damaged(needed, e)),
        }
    }

    fn count(&self, layout: &StoredLayout) -> Result<usize, InputError> {
        usize::try_from(layout.layout.samples()).map_err(|_| self.memory(layout))
    }

    fn memory(&self, layout: &StoredLayout) -> InputError {
        InputError::Memory { place: self.place.clone(), bytes: layout.layout.bytes() }
    }

    fn io(&self, source: std::io::Error) -> InputError {
        InputError::Io { place: self.place.clone(), action: "read the voxels", source }
    }

    fn wrong(&self, problem: String, remedy: &str) -> InputError {
        InputError::Data { place: self.place.clone(), problem, remedy: remedy.to_owned() }
    }
}
