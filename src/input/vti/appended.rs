//! Where the appended payloads lie: each from its offset to that of the next, the last up to the closing tag. A file
//! that lost or gained bytes shows there, before its XML or another array becomes voxels.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Result, Seek as _, SeekFrom};

use super::super::samples::fill;
use super::base64::Base64;
use super::blocks::word;
use super::header::{Appended, Header};

/// Most bytes behind the closing tag, and most white space or zeros behind a payload.
const TAIL_BYTES: u64 = 1 << 16;
const CLOSING: &[u8] = b"</AppendedData>";

/// The appended data of a file. Positions are offsets in the file.
pub(super) struct Section<'a> {
    header: &'a Header,
    start: u64,
    /// The closing tag.
    end: u64,
    is_base64: bool,
    /// Beginnings of all payloads, each once, in order.
    payloads: Vec<u64>,
}

impl<'a> Section<'a> {
    /// Finds the closing tag. `None`: there is none, or an offset lies behind it.
    pub fn find(
        file: &mut BufReader<File>,
        length: u64,
        header: &'a Header,
        appended: Appended,
    ) -> Result<Option<Self>> {
        let from = length.saturating_sub(TAIL_BYTES).max(appended.offset.min(length));
        file.seek(SeekFrom::Start(from))?;
        let mut tail = Vec::new();
        file.take(TAIL_BYTES).read_to_end(&mut tail)?;
        let Some(at) = tail.windows(CLOSING.len()).rposition(|w| w == CLOSING) else { return Ok(None) };
        let end = from + at as u64;
        let start = appended.offset;
        let mut payloads: Vec<u64> =
            header.appended_offsets.iter().map(|offset| start.saturating_add(*offset)).collect();
        payloads.sort_unstable();
        payloads.dedup();
        let is_inside = payloads.last().is_none_or(|last| *last <= end);
        Ok(is_inside.then_some(Self { header, start, end, is_base64: appended.is_base64, payloads }))
    }

    /// Where the payload that begins at `start` must have ended: the next one's beginning, or the closing tag.
    pub fn end_of(&self, start: u64) -> u64 {
        let next = self.payloads.partition_point(|other| *other <= start);
        self.payloads.get(next).copied().unwrap_or(self.end)
    }

    /// Holds every payload against what follows it, by the lengths in front of each.
    ///
    /// # Errors
    /// A sentence, when one does not end where it must.
    pub fn check(&self, file: &mut BufReader<File>) -> Result<std::result::Result<(), String>> {
        for &start in &self.payloads {
            let end = self.end_of(start);
            let is_held = if self.is_base64 {
                self.base64_holds(file, start, end)?
            } else {
                self.raw_holds(file, start, end)?
            };
            if !is_held {
                let follows = if end == self.end { "`</AppendedData>`" } else { "the next array" };
                return Ok(Err(format!(
                    "the appended values at offset {} do not end where {follows} begins, {} bytes behind",
                    start - self.start,
                    end - start
                )));
            }
        }
        Ok(Ok(()))
    }

    /// Bytes of lengths in front of a payload, and of the payload behind them; `None` if they exceed `most`.
    fn lengths(&self, source: &mut dyn Read, most: u64) -> Result<Option<(u64, Vec<u64>)>> {
        let width = self.header.word_bytes;
        let mut next = || word(source, width, self.header.byte_order);
        if !self.header.is_compressed {
            return Ok(Some((width as u64, vec![next()?])));
        }
        let (count, _, _) = (next()?, next()?, next()?);
        let table = count.saturating_add(3).saturating_mul(width as u64);
        if table > most {
            return Ok(None);
        }
        let blocks = (0..count).map(|_| next()).collect::<Result<_>>()?;
        Ok(Some((table, blocks)))
    }

    fn raw_holds(&self, file: &mut BufReader<File>, start: u64, end: u64) -> Result<bool> {
        file.seek(SeekFrom::Start(start))?;
        let found = self.lengths(&mut file.by_ref().take(end - start), end - start);
        let Ok(Some((table, payload))) = found else { return Ok(false) };
        let bytes = payload.iter().fold(table, |sum, n| sum.saturating_add(*n));
        let Some(rest) = (end - start).checked_sub(bytes).filter(|rest| *rest <= TAIL_BYTES) else {
            return Ok(false);
        };
        // With the last byte of the payload.
        file.seek(SeekFrom::Start(end - rest - 1))?;
        let mut between = Vec::new();
        file.take(rest + 1).read_to_end(&mut between)?;
        Ok(match &between[..] {
            // White space right before what follows may be an indentation that moved into the payload.
            [last] => !last.is_ascii_whitespace(),
            // Writers may align what they append; XML goes on in a new line.
            [_, 0 | b'\n' | b'\r', rest @ ..] => rest.iter().all(|b| *b == 0 || b.is_ascii_whitespace()),
            _ => false,
        })
    }

    /// Lengths and payload may be encoded together or apart, each apart with its own padding; so may blocks.
    fn base64_holds(&self, file: &mut BufReader<File>, start: u64, end: u64) -> Result<bool> {
        file.seek(SeekFrom::Start(start))?;
        let found = self.lengths(&mut Base64::new(file.by_ref().take(end - start)), end - start);
        let Ok(Some((table, payload))) = found else { return Ok(false) };
        let characters = |bytes: u64| bytes.div_ceil(3).saturating_mul(4);
        // Padding shows that the lengths are encoded apart.
        file.seek(SeekFrom::Start(start))?;
        let text = file.by_ref().take(end - start).bytes().map_while(Result::ok);
        let last = text.filter(|b| !b.is_ascii_whitespace()).nth(characters(table) as usize - 1);
        let is_apart = last == Some(b'=') || table.is_multiple_of(3);
        let bytes = payload.iter().fold(0_u64, |sum, n| sum.saturating_add(*n));
        let each = payload.iter().fold(0_u64, |sum, n| sum.saturating_add(characters(*n)));
        let possible = if is_apart {
            [characters(bytes), each].map(|payload| characters(table).saturating_add(payload))
        } else {
            [characters(table.saturating_add(bytes)); 2]
        };
        if possible.contains(&(end - start)) {
            return Ok(true);
        }
        // White space stands within, or behind the last.
        file.seek(SeekFrom::Start(start))?;
        let mut text = file.take(end - start);
        let mut count = 0;
        loop {
            let buffer = text.fill_buf()?;
            if buffer.is_empty() {
                return Ok(possible.contains(&count));
            }
            count += buffer.iter().filter(|b| !b.is_ascii_whitespace()).count() as u64;
            let n = buffer.len();
            text.consume(n);
        }
    }
}

/// Whether anything but white space follows: more base64, or more numbers.
pub(super) fn has_more(stream: &mut dyn Read) -> Result<bool> {
    match fill(stream, &mut [0]) {
        (0, None) => Ok(false),
        (_, None) => Ok(true),
        (_, Some(e)) => Err(e),
    }
}
