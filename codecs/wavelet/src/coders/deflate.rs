//! Runs of zeros through deflate, which is LZ77 and Huffman codes as the paper's LZH (section 2.3).

use std::io::{Read, Write};

use flate2::{Compression, bufread::DeflateDecoder, write::DeflateEncoder};

use super::{
    bands::BandCoder,
    fault::Fault,
    order::Order,
    runs::{Parts, Runs, read},
};

/// The bytes of [`Runs`], deflated.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Deflate {
    /// Order within a region.
    pub order: Order,
}

impl BandCoder for Deflate {
    fn encode_body(&self, extent: [usize; 3], coefficients: &[i32], largest: u32) -> Vec<u8> {
        let runs = Runs { order: self.order }.encode_body(extent, coefficients, largest);
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        let written = encoder.write_all(&runs);
        debug_assert!(written.is_ok(), "a vector takes all bytes");
        encoder.finish().unwrap_or_default()
    }

    fn decode_body(
        &self,
        extent: [usize; 3],
        body: &[u8],
        largest: u32,
        out: &mut [i32],
    ) -> Result<(), Fault> {
        let mut parts = Inflate { decoder: DeflateDecoder::new(body), part: [0; _] };
        read(self.order, extent, &mut parts, largest, out)?;
        if parts.decoder.get_ref().is_empty() { Ok(()) } else { Err(Fault("bytes follow a deflate stream")) }
    }
}

/// Bytes of a part. It is a multiple of 4, and small enough for the nearest cache.
const PART: usize = 1 << 14;

/// Inflates into one part after the other. So the size of the inflated bytes never matters: reading ends where the
/// region has no room for a symbol.
struct Inflate<'a> {
    decoder: DeflateDecoder<&'a [u8]>,
    part: [u8; PART],
}

impl Parts for Inflate<'_> {
    fn part(&mut self) -> Result<&[u8], Fault> {
        let mut filled = 0;
        while filled < PART {
            match self.decoder.read(&mut self.part[filled..]) {
                Ok(0) => break,
                Ok(read) => filled += read,
                Err(_) => return Err(Fault("this is no deflate stream")),
            }
        }
        Ok(&self.part[..filled])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINES: Deflate = Deflate { order: Order::Lines };

    #[test]
    fn a_bomb_is_refused_by_the_size_of_its_region() {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&vec![1; 1 << 26]).unwrap();
        let body = encoder.finish().unwrap();
        assert!(body.len() < 1 << 17);
        let mut out = [0; 9];
        let fault = LINES.decode_body([9, 1, 1], &body, 1, &mut out).unwrap_err();
        assert_eq!(fault, Fault("a value follows the end of its region"));
        assert_eq!(out, [1; 9]);
    }

    #[test]
    fn symbols_continue_from_part_to_part() {
        let len = 3 * PART + 5;
        let coefficients = (0..len as i32).map(|i| i * 7919 % 90_000).collect::<Vec<_>>();
        let body = LINES.encode_body([len, 1, 1], &coefficients, 90_000);
        let mut out = vec![0; len];
        LINES.decode_body([len, 1, 1], &body, 90_000, &mut out).unwrap();
        assert!(out == coefficients);
        let more = [&body[..], &[0]].concat();
        LINES.decode_body([len, 1, 1], &more, 90_000, &mut vec![0; len]).unwrap_err();
    }
}
