//! The zlib blocks of VTK: a table (number of blocks, bytes of a block, bytes of the last one or 0 if it is whole,
//! compressed bytes of each), then the blocks.

use std::io::{Cursor, Error, ErrorKind, Read, Result};

use flate2::bufread::ZlibDecoder;

use super::super::ByteOrder;
use super::super::samples::fill;

/// Reads one number of the table.
pub(super) fn word(source: &mut dyn Read, bytes: usize, order: ByteOrder) -> Result<u64> {
    let mut word = [0; 8];
    source.read_exact(&mut word[..bytes])?;
    if order == ByteOrder::Big {
        word[..bytes].reverse();
    }
    Ok(u64::from_le_bytes(word))
}

/// The contents of the blocks, one after the other. Of a block no more is decoded than the table says, and memory
/// follows what the file really holds.
pub(super) struct Blocks<R> {
    source: R,
    compressed: std::vec::IntoIter<u64>,
    block_bytes: u64,
    last_bytes: u64,
    current: ZlibDecoder<Cursor<Vec<u8>>>,
    /// Bytes that the current block must still give.
    left: u64,
}

impl<R: Read> Blocks<R> {
    /// Reads the table, whose blocks must make up `needed` bytes.
    pub fn new(mut source: R, word_bytes: usize, order: ByteOrder, needed: u64) -> Result<Self> {
        let count = word(&mut source, word_bytes, order)?;
        let block_bytes = word(&mut source, word_bytes, order)?;
        let last = word(&mut source, word_bytes, order)?;
        let last_bytes = if last == 0 { block_bytes } else { last };
        let whole = u128::from(count.saturating_sub(1)) * u128::from(block_bytes);
        let total = if count == 0 { 0 } else { whole + u128::from(last_bytes) };
        if total != u128::from(needed) || last_bytes > block_bytes || block_bytes == 0 {
            return Err(invalid(format!("{count} blocks make {total} bytes, and {needed} are needed")));
        }
        let mut compressed = Vec::new();
        for _ in 0..count {
            let bytes = word(&mut source, word_bytes, order)?;
            compressed.try_reserve(1).map_err(|_| ErrorKind::OutOfMemory)?;
            compressed.push(bytes);
        }
        let current = ZlibDecoder::new(Cursor::new(Vec::new()));
        Ok(Self { source, compressed: compressed.into_iter(), block_bytes, last_bytes, current, left: 0 })
    }

    /// Opens the next block; `false` behind the last.
    fn next_block(&mut self) -> Result<bool> {
        let Some(bytes) = self.compressed.next() else { return Ok(false) };
        let mut block = Vec::new();
        let found = (&mut self.source).take(bytes).read_to_end(&mut block)? as u64;
        if found < bytes {
            return Err(Error::new(
                ErrorKind::UnexpectedEof,
                format!("a block takes {bytes} bytes, but only {found} are there"),
            ));
        }
        self.current = ZlibDecoder::new(Cursor::new(block));
        self.left = if self.compressed.len() == 0 { self.last_bytes } else { self.block_bytes };
        Ok(true)
    }

    /// Asks for a byte more than the block has: there must be none, and the stream then verifies its checksum. It must
    /// take all the bytes that the table gives it.
    fn end_block(&mut self) -> Result<()> {
        match fill(&mut self.current, &mut [0]) {
            (0, None) => {}
            (_, None) => return Err(invalid("a block holds more than its table says".to_owned())),
            (_, Some(e)) => return Err(e),
        }
        let block = self.current.get_ref();
        let left = (block.get_ref().len() as u64).saturating_sub(block.position());
        if left > 0 {
            return Err(invalid(format!("{left} bytes follow the zlib stream of a block")));
        }
        Ok(())
    }
}

fn invalid(problem: String) -> Error {
    Error::new(ErrorKind::InvalidData, problem)
}

impl<R: Read> Read for Blocks<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        if self.left == 0 && !self.next_block()? {
            return Ok(0);
        }
        let n = usize::try_from(self.left).unwrap_or(usize::MAX).min(out.len());
        if n == 0 {
            return Ok(0);
        }
        let n = self.current.read(&mut out[..n])?;
        if n == 0 {
            return Err(invalid(format!("a block ends {} bytes too early", self.left)));
        }
        self.left -= n as u64;
        if self.left == 0 {
            self.end_block()?;
        }
        Ok(n)
    }
}
