//! The zlib stream of a PNG file, held against its pixels. The crate `png` stops behind the last of them: it looks
//! neither at the stream's checksum nor at what follows.

use std::io::{BufRead, Read, Result, Seek, sink};

use flate2::read::ZlibDecoder;
use png::Info;

/// Bytes of the filtered rows of a picture, in the order of the file.
pub(super) fn row_bytes(info: &Info<'_>) -> u64 {
    // First column and row of each pass, and steps to the next.
    const ADAM7: [[u32; 4]; 7] =
        [[0, 0, 8, 8], [4, 0, 8, 8], [0, 4, 4, 8], [2, 0, 4, 4], [0, 2, 2, 4], [1, 0, 2, 2], [0, 1, 1, 2]];
    let passes: &[[u32; 4]] = if info.interlaced { &ADAM7 } else { &[[0, 0, 1, 1]] };
    let bits = info.bits_per_pixel() as u64;
    let pass = |[x, y, dx, dy]: [u32; 4]| {
        let count = |size: u32, first: u32, step: u32| u64::from(size.saturating_sub(first).div_ceil(step));
        let (columns, rows) = (count(info.width, x, dx), count(info.height, y, dy));
        if columns == 0 { 0 } else { rows * (1 + (columns * bits).div_ceil(8)) }
    };
    passes.iter().copied().map(pass).sum()
}

/// Checks the stream in the IDAT chunks of a file whose chunks are known to be whole.
///
/// # Errors
/// When the stream is damaged, or the file cannot be read.
pub(super) fn check(file: impl BufRead + Seek, due: u64) -> Result<Option<String>> {
    let mut stream = ZlibDecoder::new(ImageData { file, left: 0, given: 0, is_open: false });
    // The byte too many, which is not there, makes the stream verify its checksum.
    let bytes = std::io::copy(&mut (&mut stream).take(due.saturating_add(1)), &mut sink())?;
    if bytes != due {
        let bytes = if bytes > due { "more".to_owned() } else { format!("{bytes}") };
        return Ok(Some(format!("its rows take {due} bytes, and its stream holds {bytes}")));
    }
    let used = stream.total_in();
    let mut data = stream.into_inner();
    std::io::copy(&mut data, &mut sink())?;
    let follow = data.given - used;
    Ok((follow > 0).then(|| format!("{follow} bytes follow its stream")))
}

/// The concatenated contents of the IDAT chunks.
struct ImageData<R> {
    file: R,
    /// Bytes of the current chunk that were not given.
    left: u64,
    given: u64,
    /// Whether the file stands behind its signature.
    is_open: bool,
}

impl<R: BufRead + Seek> ImageData<R> {
    /// Opens the next IDAT chunk; `false` where there is none.
    fn next_chunk(&mut self) -> Result<bool> {
        // A signature takes 8 bytes, a checksum 4.
        let mut behind = if self.is_open { 4 } else { 8 };
        loop {
            self.file.seek_relative(behind)?;
            self.is_open = true;
            let mut head = [0; 8];
            self.file.read_exact(&mut head)?;
            let [a, b, c, d, kind @ ..] = head;
            let length = u32::from_be_bytes([a, b, c, d]);
            match &kind {
                b"IDAT" => {
                    self.left = u64::from(length);
                    return Ok(true);
                }
                b"IEND" => return Ok(false),
                _ => behind = i64::from(length) + 4,
            }
        }
    }
}

impl<R: BufRead + Seek> Read for ImageData<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        while self.left == 0 {
            if !self.next_chunk()? {
                // It may be asked again.
                self.file.seek_relative(-12)?;
                return Ok(0);
            }
        }
        let n = usize::try_from(self.left).unwrap_or(usize::MAX).min(out.len());
        let n = self.file.read(&mut out[..n])?;
        self.left -= n as u64;
        self.given += n as u64;
        if n == 0 && !out.is_empty() { Err(std::io::ErrorKind::UnexpectedEof.into()) } else { Ok(n) }
    }
}
