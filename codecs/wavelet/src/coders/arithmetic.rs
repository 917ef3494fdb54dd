//! Adaptive arithmetic coding with a zero mode (section 2.3 of the paper).

use super::{
    bands::BandCoder,
    counts::Counts,
    fault::Fault,
    order::Lines,
    range::{Decoder, Encoder},
    region::{Piece, Region, pieces},
    values::Values,
};

/// Values in an adaptive model of their region, line by line. After a zero, one symbol tells how many more follow.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Arithmetic;

/// The symbol of a run of as many further zeros or more, after which another symbol continues the run. "Using a value
/// of 127 for n showed up to be very good for nearly all datasets and quantizations".
const MORE: usize = 127;

impl BandCoder for Arithmetic {
    fn encode_body(&self, _: [usize; 3], coefficients: &[i32], largest: u32) -> Vec<u8> {
        let mut encoder = Encoder::new();
        let (mut values, mut lengths) = (Values::new(largest), Counts::new(MORE + 1));
        // Invariant: a run that ends within the region ends before a value that is not zero.
        let (mut left, mut after_run) = (coefficients.len(), false);
        for piece in pieces(Lines::default(), coefficients) {
            match piece {
                Piece::Value(value) => {
                    values.encode(value, after_run, &mut encoder);
                    left -= 1;
                    after_run = false;
                }
                Piece::Zeros(zeros) => {
                    values.encode_zero(&mut encoder);
                    left -= 1;
                    let mut further = zeros - 1;
                    // The decoder knows where the region ends.
                    while left > 0 {
                        let length = further.min(MORE);
                        encoder.symbol(length, &mut lengths);
                        further -= length;
                        left -= length;
                        if length < MORE {
                            break;
                        }
                    }
                    after_run = true;
                }
            }
        }
        encoder.finish()
    }

    fn decode_body(&self, _: [usize; 3], body: &[u8], largest: u32, out: &mut [i32]) -> Result<(), Fault> {
        let mut decoder = Decoder::new(body)?;
        let (mut values, mut lengths) = (Values::new(largest), Counts::new(MORE + 1));
        let mut region = Region::new(Lines::default(), out);
        let mut after_run = false;
        while region.left() > 0 {
            match values.decode(after_run, &mut decoder)? {
                0 => {
                    region.zeros(1)?;
                    while region.left() > 0 {
                        let length = decoder.symbol(&mut lengths)?;
                        region.zeros(length)?;
                        if length < MORE {
                            break;
                        }
                    }
                    after_run = true;
                }
                value => {
                    region.value(value)?;
                    after_run = false;
                }
            }
        }
        decoder.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes what the format says, symbol by symbol.
    fn by_hand(symbols: &[(char, i32)], largest: u32) -> Vec<u8> {
        let mut encoder = Encoder::new();
        let (mut values, mut lengths) = (Values::new(largest), Counts::new(128));
        for (kind, number) in symbols {
            match kind {
                'z' => values.encode_zero(&mut encoder),
                'v' => values.encode(*number, false, &mut encoder),
                'n' => values.encode(*number, true, &mut encoder),
                _ => encoder.symbol(*number as usize, &mut lengths),
            }
        }
        encoder.finish()
    }

    #[test]
    fn runs_follow_zeros() {
        let runs: [(usize, &[(char, i32)]); 9] = [
            (1, &[('z', 0), ('r', 0)]),
            (2, &[('z', 0), ('r', 1)]),
            (126, &[('z', 0), ('r', 125)]),
            (127, &[('z', 0), ('r', 126)]),
            (128, &[('z', 0), ('r', 127), ('r', 0)]),
            (129, &[('z', 0), ('r', 127), ('r', 1)]),
            (254, &[('z', 0), ('r', 127), ('r', 126)]),
            (255, &[('z', 0), ('r', 127), ('r', 127), ('r', 0)]),
            (256, &[('z', 0), ('r', 127), ('r', 127), ('r', 1)]),
        ];
        for (zeros, symbols) in runs {
            // In the middle: the next value is known not to be zero. At the end: what the rest of the region says is
            // not written.
            let mut coefficients = vec![-3];
            coefficients.extend(vec![0; zeros]);
            coefficients.push(2);
            let middle = [&[('v', -3)], symbols, &[('n', 2)]].concat();
            let whole = if (zeros - 1) % 127 == 0 { &symbols[..symbols.len() - 1] } else { symbols };
            let end = [&[('v', -3)], whole].concat();
            for (coefficients, symbols) in [(&coefficients[..], middle), (&coefficients[..zeros + 1], end)] {
                let extent = [coefficients.len(), 1, 1];
                let body = Arithmetic.encode_body(extent, coefficients, 3);
                assert_eq!(body, by_hand(&symbols, 3), "{zeros} zeros");
                let mut out = vec![0; coefficients.len()];
                Arithmetic.decode_body(extent, &body, 3, &mut out).unwrap();
                assert_eq!(out, coefficients);
            }
        }
    }

    #[test]
    fn a_run_cannot_pass_the_end() {
        let body = by_hand(&[('z', 0), ('r', 5)], 1);
        Arithmetic.decode_body([6, 1, 1], &body, 1, &mut [0; 6]).unwrap();
        Arithmetic.decode_body([5, 1, 1], &body, 1, &mut [0; 5]).unwrap_err();
    }
}
