//! The voxels behind a header: skipped to, decompressed within bounds, checked against the claimed size.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use cvr_core::volume::{DenseVolume, SampleType, Samples, VolumeLayout};
use flate2::bufread::{MultiGzDecoder, ZlibDecoder};

use super::{ByteOrder, InputError, Place};

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
}

/// A deflate stream holds at most 1032 times its own bytes: 258 bytes per match of two one-bit codes.
const MAX_DEFLATE_RATIO: u64 = 1032;
/// A compressed stream's output grows in steps of at least this size, then doubles: memory follows what was
/// really decoded, not what was claimed.
const FIRST_STEP_BYTES: usize = 1 << 20;

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
    /// Reads the voxels of a scalar volume.
    ///
    /// # Errors
    /// When the file cannot be read, holds more or fewer bytes than `layout` needs, or its stream is damaged.
    pub fn read(&self, layout: VolumeLayout) -> Result<DenseVolume, InputError> {
        let samples = match layout.sample {
            SampleType::U8 => Samples::U8(self.samples(&layout)?),
            SampleType::I8 => Samples::I8(self.samples(&layout)?),
            SampleType::U16 => Samples::U16(self.samples(&layout)?),
            SampleType::I16 => Samples::I16(self.samples(&layout)?),
            SampleType::F32 => Samples::F32(self.samples(&layout)?),
            other => {
                return Err(InputError::Unsupported {
                    place: self.place.clone(),
                    found: format!("sample type {other}"),
                    supported: "u8, i8, u16, i16, f32".to_owned(),
                });
            }
        };
        DenseVolume::new(layout, samples)
            .map_err(|problem| self.wrong(problem, "correct the header's dimensions or type"))
    }

    fn samples<T: bytemuck::Pod>(&self, layout: &VolumeLayout) -> Result<Vec<T>, InputError> {
        let (file, length) = open_regular(&self.file, &self.place)?;
        let mut source = BufReader::with_capacity(1 << 18, file);
        // An offset behind the end finds no voxels there, which is the better complaint than a failed seek.
        let mut at = self.offset;
        source.seek(SeekFrom::Start(at.min(length))).map_err(|e| self.io(e))?;
        at += self.pass_lines(&mut source)?;
        let mut samples = match self.encoding {
            Encoding::Raw => {
                let start = self.raw_start(at, length, layout)?;
                source.seek(SeekFrom::Start(start)).map_err(|e| self.io(e))?;
                self.raw(&mut source, layout)?
            }
            Encoding::Gzip => {
                self.check_stored(length.saturating_sub(at), layout)?;
                self.decoded(&mut MultiGzDecoder::new(&mut source), layout)?
            }
            Encoding::Zlib => {
                self.check_stored(length.saturating_sub(at), layout)?;
                let samples = self.decoded(&mut ZlibDecoder::new(&mut source), layout)?;
                // Unlike gzip, the decoder leaves what follows unread, and unremarked.
                if !source.fill_buf().map_err(|e| self.io(e))?.is_empty() {
                    return Err(self.wrong("bytes follow the zlib stream".to_owned(), "remove them"));
                }
                samples
            }
        };
        if self.byte_order != ByteOrder::NATIVE && size_of::<T>() > 1 {
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut samples);
            bytes.chunks_exact_mut(size_of::<T>()).for_each(<[u8]>::reverse);
        }
        Ok(samples)
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
    fn raw_start(&self, at: u64, length: u64, layout: &VolumeLayout) -> Result<u64, InputError> {
        let needed = layout.bytes();
        let start = match self.skip {
            Skip::Bytes(skip) => at.saturating_add(skip),
            Skip::AllButVoxels => at.max(length.saturating_sub(needed)),
        };
        let found = length.saturating_sub(start);
        match found.cmp(&needed) {
            std::cmp::Ordering::Equal => Ok(start),
            std::cmp::Ordering::Less => Err(self.wrong(
                format!("{}, but only {found} are there", need(layout)),
                "the file is cut short, or the dimensions, type or skip are wrong",
            )),
            std::cmp::Ordering::Greater => Err(self.wrong(
                format!("{}, but {found} are there", need(layout)),
                "correct the dimensions or type, or skip what stands in front of the voxels",
            )),
        }
    }

    /// Refuses a claim that the stored bytes cannot fulfil, before anything is decoded.
    fn check_stored(&self, available: u64, layout: &VolumeLayout) -> Result<(), InputError> {
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
                format!("{}, which {available} bytes of {} cannot hold", need(layout), self.encoding.name()),
                "the file is cut short, or the dimensions or type are wrong",
            ));
        }
        Ok(())
    }

    /// `raw_start` has compared the claim with the file's length, so it may be reserved at once.
    fn raw<T: bytemuck::Pod>(
        &self,
        source: &mut impl Read,
        layout: &VolumeLayout,
    ) -> Result<Vec<T>, InputError> {
        let mut samples = Vec::new();
        self.extend(&mut samples, self.count(layout)?, layout)?;
        source.read_exact(bytemuck::cast_slice_mut(&mut samples)).map_err(|e| self.io(e))?;
        Ok(samples)
    }

    fn decoded<T: bytemuck::Pod>(
        &self,
        stream: &mut impl Read,
        layout: &VolumeLayout,
    ) -> Result<Vec<T>, InputError> {
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
                format!("{}, but the {} stream holds only {decoded}", need(layout), self.encoding.name()),
                "correct the header's dimensions or type",
            )
        };
        if let Skip::Bytes(skip) = self.skip {
            let skipped = std::io::copy(&mut stream.take(skip), &mut std::io::sink());
            if skipped.map_err(|e| damaged(0, e))? < skip {
                return Err(short(0));
            }
        }
        let count = self.count(layout)?;
        let mut samples: Vec<T> = Vec::new();
        while samples.len() < count {
            let from = samples.len();
            let step = from.max(FIRST_STEP_BYTES / size_of::<T>());
            self.extend(&mut samples, count.min(from + step), layout)?;
            let out: &mut [u8] = bytemuck::cast_slice_mut(&mut samples[from..]);
            let before = (from * size_of::<T>()) as u64;
            match fill(stream, out) {
                (filled, None) if filled == out.len() => {}
                (filled, None) => return Err(short(before + filled as u64)),
                (filled, Some(e)) => return Err(damaged(before + filled as u64, e)),
            }
        }
        // One byte more: there must be none, and asking for it makes the stream verify its checksum.
        match fill(stream, &mut [0]) {
            (0, None) => Ok(samples),
            (_, None) => Err(self.wrong(
                format!("{}, but the {} stream holds more", need(layout), self.encoding.name()),
                "correct the header's dimensions or type",
            )),
            (_, Some(e)) => Err(damaged(needed, e)),
        }
    }

    fn count(&self, layout: &VolumeLayout) -> Result<usize, InputError> {
        usize::try_from(layout.samples()).map_err(|_| self.memory(layout))
    }

    fn extend<T: bytemuck::Pod>(
        &self,
        samples: &mut Vec<T>,
        to: usize,
        layout: &VolumeLayout,
    ) -> Result<(), InputError> {
        samples.try_reserve_exact(to - samples.len()).map_err(|_| self.memory(layout))?;
        samples.resize(to, T::zeroed());
        Ok(())
    }

    fn memory(&self, layout: &VolumeLayout) -> InputError {
        InputError::Memory { place: self.place.clone(), bytes: layout.bytes() }
    }

    fn io(&self, source: std::io::Error) -> InputError {
        InputError::Io { place: self.place.clone(), action: "read the voxels", source }
    }

    fn wrong(&self, problem: String, remedy: &str) -> InputError {
        InputError::Data { place: self.place.clone(), problem, remedy: remedy.to_owned() }
    }
}

fn need(layout: &VolumeLayout) -> String {
    format!("{} voxels of {} take {} bytes", layout.extent, layout.sample, layout.bytes())
}

/// Reads until `out` is full, the stream ends, or it fails; says how many bytes came.
fn fill(stream: &mut impl Read, out: &mut [u8]) -> (usize, Option<std::io::Error>) {
    let mut filled = 0;
    while filled < out.len() {
        match stream.read(&mut out[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return (filled, Some(e)),
        }
    }
    (filled, None)
}
