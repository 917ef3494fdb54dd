//! Runs of zeros (section 2.3 of the paper): "we just compress a run of n zeros by storing 0 followed by n−1".

use super::{
    bands::BandCoder,
    fault::Fault,
    order::{Cursor, Lines, Octree, Order},
    region::{Piece, Region, pieces},
    symbols::{fold, signed, unfold},
};

/// Runs of zeros in an order. A run continues over the ends of lines.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Runs {
    /// Order within a region.
    pub order: Order,
}

impl BandCoder for Runs {
    fn encode_body(&self, extent: [usize; 3], coefficients: &[i32], largest: u32) -> Vec<u8> {
        match self.order {
            Order::Lines => write(Lines::default(), coefficients, width(largest)),
            Order::Octree => write(Octree::new(extent), coefficients, width(largest)),
        }
    }

    fn decode_body(
        &self,
        extent: [usize; 3],
        mut body: &[u8],
        largest: u32,
        out: &mut [i32],
    ) -> Result<(), Fault> {
        read(self.order, extent, &mut body, largest, out)
    }
}

/// Bytes of a symbol: the fewest of 1, 2 and 4 in which all values of the region fit.
#[must_use]
pub const fn width(largest: u32) -> usize {
    match largest {
        0..=0x7f => 1,
        0x80..=0x7fff => 2,
        _ => 4,
    }
}

fn write(cursor: impl Cursor, coefficients: &[i32], width: usize) -> Vec<u8> {
    // The alphabet: all symbols of this width. A longer run is split.
    let longest = 1_usize << (8 * width);
    let mut body = Vec::new();
    let mut push = |symbol: u32| body.extend_from_slice(&symbol.to_le_bytes()[..width]);
    for piece in pieces(cursor, coefficients) {
        match piece {
            Piece::Value(value) => push(fold(value.unsigned_abs(), value < 0)),
            Piece::Zeros(mut zeros) => {
                while zeros > 0 {
                    let run = zeros.min(longest);
                    push(0);
                    push((run - 1) as u32);
                    zeros -= run;
                }
            }
        }
    }
    body
}

/// Bytes that come in parts. All parts but the last have a multiple of 4 bytes. An empty one is the end.
pub trait Parts {
    /// The next part.
    ///
    /// # Errors
    /// The bytes cannot be read.
    fn part(&mut self) -> Result<&[u8], Fault>;
}

impl Parts for &[u8] {
    fn part(&mut self) -> Result<&[u8], Fault> {
        Ok(std::mem::take(self))
    }
}

/// Reads a region. It takes parts only as long as the region has room for their symbols.
///
/// # Errors
/// The symbols are not those of a region.
pub fn read(
    order: Order,
    extent: [usize; 3],
    parts: &mut impl Parts,
    largest: u32,
    out: &mut [i32],
) -> Result<(), Fault> {
    match order {
        Order::Lines => read_in(Lines::default(), parts, largest, out),
        Order::Octree => read_in(Octree::new(extent), parts, largest, out),
    }
}

fn read_in(cursor: impl Cursor, parts: &mut impl Parts, largest: u32, out: &mut [i32]) -> Result<(), Fault> {
    match width(largest) {
        1 => read_symbols::<1>(cursor, parts, largest, out),
        2 => read_symbols::<2>(cursor, parts, largest, out),
        _ => read_symbols::<4>(cursor, parts, largest, out),
    }
}

fn read_symbols<const WIDTH: usize>(
    cursor: impl Cursor,
    parts: &mut impl Parts,
    largest: u32,
    out: &mut [i32],
) -> Result<(), Fault> {
    let mut region = Region::new(cursor, out);
    // Whether the last symbol was 0, so that the next one is a length.
    let mut run = false;
    loop {
        let part = parts.part()?;
        if part.is_empty() {
            break;
        }
        let (symbols, rest) = part.as_chunks::<WIDTH>();
        for bytes in symbols {
            let mut symbol = [0; 4];
            symbol[..WIDTH].copy_from_slice(bytes);
            let symbol = u32::from_le_bytes(symbol);
            if run {
                region.zeros((symbol as usize).saturating_add(1))?;
                run = false;
            } else if symbol == 0 {
                run = true;
            } else {
                let (magnitude, negative) = unfold(symbol);
                region.value(signed(magnitude, negative, largest)?)?;
            }
        }
        if !rest.is_empty() {
            return Err(Fault("bytes end within a symbol"));
        }
    }
    if run { Err(Fault("a run of zeros has no length")) } else { region.finish() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coders::bands::{decode_band, encode_band};
    use crate::stream::pyramid::Pyramid;

    fn chunk(order: Order, extent: [usize; 3], coefficients: &[i32]) -> Vec<u8> {
        let band = Pyramid::new(extent, 0, false).bands()[0];
        let chunk = encode_band(&Runs { order }, &band, coefficients);
        let mut out = vec![0; coefficients.len()];
        decode_band(&Runs { order }, &band, &chunk, &mut out).unwrap();
        assert_eq!(out, coefficients);
        chunk
    }

    #[test]
    fn bytes_are_those_computed_by_hand() {
        let coefficients = [0, 0, 0, 1, -1, 0, 127, -127];
        assert_eq!(chunk(Order::Lines, [8, 1, 1], &coefficients), [127, 0, 2, 1, 2, 0, 0, 253, 254]);
        // Two bytes per symbol from a magnitude of 128 on, four from 32768 on.
        assert_eq!(chunk(Order::Lines, [3, 1, 1], &[0, 0, -128]), [0x80, 1, 0, 0, 1, 0, 0, 1]);
        assert_eq!(
            chunk(Order::Lines, [2, 1, 1], &[0x8000, 0]),
            [0x80, 0x80, 2, 0xff, 0xff, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
        );
        // In lines 0 0 5 | 0 6 0; in the octree 0 0 0 6 5 0.
        assert_eq!(chunk(Order::Octree, [3, 2, 1], &[0, 0, 5, 0, 6, 0]), [6, 0, 2, 11, 9, 0, 0]);
    }

    #[test]
    fn a_run_is_split_at_the_size_of_the_alphabet() {
        for (zeros, body) in
            [(255, &[0, 254][..]), (256, &[0, 255]), (257, &[0, 255, 0, 0]), (600, &[0, 255, 0, 255, 0, 87])]
        {
            let mut coefficients = vec![0; zeros];
            coefficients.push(1);
            assert_eq!(chunk(Order::Lines, [zeros + 1, 1, 1], &coefficients), [&[1], body, &[1]].concat());
        }
    }

    #[test]
    fn every_fault_of_a_body_is_found() {
        let read = |body: &[u8]| Runs { order: Order::Lines }.decode_body([4, 1, 1], body, 2, &mut [0; 4]);
        read(&[0, 3]).unwrap();
        read(&[1, 4, 0, 1]).unwrap();
        for body in [&[][..], &[0], &[0, 2], &[0, 4], &[0, 3, 1], &[0, 3, 0], &[0, 2, 5], &[0, 3, 0, 0]] {
            read(body).unwrap_err();
        }
        let wide = |body: &[u8]| Runs { order: Order::Lines }.decode_body([4, 1, 1], body, 300, &mut [0; 4]);
        wide(&[0, 0, 3, 0]).unwrap();
        wide(&[0, 0, 3, 0, 0]).unwrap_err();
    }
}
