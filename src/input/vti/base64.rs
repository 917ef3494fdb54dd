//! Base64 that goes on behind its padding, as VTK writes it: the table of blocks and the blocks are padded each.

use std::io::{BufRead, Error, ErrorKind, Read, Result};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// Characters that are decoded at a time; a multiple of four.
const CHARACTERS: usize = 4096;

/// Decodes base64 up to the next element, white space left out.
pub(super) struct Base64<R> {
    source: R,
    decoded: Vec<u8>,
    given: usize,
}

impl<R: BufRead> Base64<R> {
    pub fn new(source: R) -> Self {
        Self { source, decoded: Vec::new(), given: 0 }
    }

    /// Decodes up to the next padding, or some more; nothing at the end.
    fn refill(&mut self) -> Result<()> {
        let mut text = Vec::with_capacity(CHARACTERS);
        'text: while text.len() < CHARACTERS {
            let buffer = self.source.fill_buf()?;
            if buffer.is_empty() {
                break;
            }
            let mut used = 0;
            for &byte in buffer {
                let ends = byte == b'<';
                if !ends {
                    used += 1;
                    if !byte.is_ascii_whitespace() {
                        text.push(byte);
                    }
                }
                let padded = text.len().is_multiple_of(4) && text.last() == Some(&b'=');
                if ends || padded || text.len() == CHARACTERS {
                    self.source.consume(used);
                    break 'text;
                }
            }
            self.source.consume(used);
        }
        self.given = 0;
        self.decoded.clear();
        STANDARD
            .decode_vec(&text, &mut self.decoded)
            .map_err(|e| Error::new(ErrorKind::InvalidData, format!("the base64 is damaged: {e}")))
    }
}

impl<R: BufRead> Read for Base64<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        if self.given == self.decoded.len() {
            self.refill()?;
        }
        let n = (&self.decoded[self.given..]).read(out)?;
        self.given += n;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(text: &str) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Base64::new(text.as_bytes()).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    #[test]
    fn padding_in_the_middle_is_no_end() {
        assert_eq!(decoded(" QQ==\n Qk I=Q0\nND<x/>").unwrap(), b"ABBCCC");
        assert_eq!(decoded("<x/>").unwrap(), b"");
        let long: Vec<u8> = (0..20_000_u32).map(|i| i as u8).collect();
        assert_eq!(decoded(&STANDARD.encode(&long)).unwrap(), long);
        assert!(decoded("QQ=").is_err() && decoded("Q!==").is_err() && decoded("QQ==Q").is_err());
    }
}
