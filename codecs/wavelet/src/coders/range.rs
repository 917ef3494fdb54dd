//! A range coder: the crate `constriction`, with the models of this crate.

use constriction::{
    CoderError, Pos,
    stream::{
        Code, Decode, Encode,
        model::{DecoderModel, EncoderModel},
        queue::{RangeDecoder, RangeEncoder},
    },
};

use super::{
    bits::{BIT_PRECISION, Bit, Uniform},
    counts::Counts,
    fault::Fault,
    words::{self, Words},
};

/// Writes symbols.
#[derive(Debug)]
pub struct Encoder(RangeEncoder<u32, u64>);

impl Default for Encoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Encoder {
    /// Nothing has been written.
    #[must_use]
    pub fn new() -> Self {
        Self(RangeEncoder::new())
    }

    #[inline]
    fn put<M: EncoderModel<P, Probability = u32>, const P: usize>(&mut self, symbol: M::Symbol, model: M) {
        let written = self.0.encode_symbol(symbol, model);
        debug_assert!(written.is_ok(), "every symbol has an interval, and a vector takes all words");
    }

    /// Writes a symbol and counts it.
    #[inline]
    pub fn symbol(&mut self, symbol: usize, counts: &mut Counts) {
        self.put(symbol, counts.all());
        counts.count(symbol);
    }

    /// Writes a symbol that the decoder knows not to be 0, and counts it.
    #[inline]
    pub fn symbol_after_first(&mut self, symbol: usize, counts: &mut Counts) {
        self.put(symbol, counts.after_first());
        counts.count(symbol);
    }

    /// Writes a bit. It is 0 with probability `p / 65536`; `p` is at least 1.
    #[inline]
    pub fn encode_bit(&mut self, bit: bool, p: u16) {
        self.put(bit, Bit(p));
    }

    /// Writes the low `bits` of a number, at most 32, all equally probable.
    #[inline]
    pub fn encode_bits(&mut self, number: u32, bits: u32) {
        for shift in (0..bits).step_by(BIT_PRECISION) {
            let some = Uniform((bits - shift).min(BIT_PRECISION as u32));
            self.put(number >> shift & some.mask(), some);
        }
    }

    /// The bytes: those of big-endian words that are decided, and as few more as tell the last interval from all
    /// others. A decoder reads zeros after them.
    #[must_use]
    pub fn finish(self) -> Vec<u8> {
        let (decided, state) = (self.0.pos().0, self.0.state());
        words::bytes(Vec::from(self.0), decided, state.lower(), state.range().get())
    }
}

/// Reads symbols.
#[derive(Debug)]
pub struct Decoder<'a>(RangeDecoder<u32, u64, Words<'a>>);

impl<'a> Decoder<'a> {
    /// Reads the bytes of an encoder.
    ///
    /// # Errors
    /// None at this point.
    pub fn new(bytes: &'a [u8]) -> Result<Self, Fault> {
        RangeDecoder::with_backend(Words::new(bytes)).map(Self)
    }

    #[inline]
    fn get<M: DecoderModel<P, Probability = u32>, const P: usize>(
        &mut self,
        model: M,
    ) -> Result<M::Symbol, Fault> {
        self.0.decode_symbol(model).map_err(|error| match error {
            CoderError::Frontend(_) => Fault("bytes are outside of all intervals"),
            CoderError::Backend(fault) => fault,
        })
    }

    /// Reads a symbol and counts it.
    ///
    /// # Errors
    /// The bytes are corrupt.
    #[inline]
    pub fn symbol(&mut self, counts: &mut Counts) -> Result<usize, Fault> {
        let symbol = self.get(counts.all())?;
        counts.count(symbol);
        Ok(symbol)
    }

    /// Reads a symbol that is known not to be 0, and counts it.
    ///
    /// # Errors
    /// The bytes are corrupt.
    #[inline]
    pub fn symbol_after_first(&mut self, counts: &mut Counts) -> Result<usize, Fault> {
        let symbol = self.get(counts.after_first())?;
        counts.count(symbol);
        Ok(symbol)
    }

    /// Reads a bit. It is 0 with probability `p / 65536`; `p` is at least 1.
    ///
    /// # Errors
    /// The bytes are corrupt.
    #[inline]
    pub fn decode_bit(&mut self, p: u16) -> Result<bool, Fault> {
        self.get(Bit(p))
    }

    /// Reads a number of `bits`, at most 32.
    ///
    /// # Errors
    /// The bytes are corrupt.
    #[inline]
    pub fn decode_bits(&mut self, bits: u32) -> Result<u32, Fault> {
        let mut number = 0;
        for shift in (0..bits).step_by(BIT_PRECISION) {
            number |= self.get(Uniform((bits - shift).min(BIT_PRECISION as u32)))? << shift;
        }
        Ok(number)
    }

    /// Checks that the bytes end with the last symbol.
    ///
    /// # Errors
    /// More bytes follow.
    pub fn finish(self) -> Result<(), Fault> {
        let (words, ..) = self.0.into_raw_parts();
        words.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Symbols of all kinds, as many as `rounds` ask for.
    fn written(rounds: u32) -> Vec<u8> {
        let (mut encoder, mut counts) = (Encoder::new(), Counts::new(7));
        for i in 0..rounds {
            encoder.symbol((i * i % 7) as usize, &mut counts);
            encoder.symbol_after_first((1 + i % 6) as usize, &mut counts);
            encoder.encode_bit(i % 5 == 0, 60_000);
            encoder.encode_bit(true, 65_535);
            encoder.encode_bit(false, 1);
            encoder.encode_bits(i.wrapping_mul(2_654_435_769) >> (32 - i % 33).min(31), i % 33);
        }
        encoder.finish()
    }

    fn read(bytes: &[u8], rounds: u32) -> Result<bool, Fault> {
        let (mut decoder, mut counts) = (Decoder::new(bytes)?, Counts::new(7));
        let mut same = true;
        for i in 0..rounds {
            same &= decoder.symbol(&mut counts)? == (i * i % 7) as usize;
            same &= decoder.symbol_after_first(&mut counts)? == (1 + i % 6) as usize;
            same &= decoder.decode_bit(60_000)? == (i % 5 == 0);
            same &= decoder.decode_bit(65_535)? && !decoder.decode_bit(1)?;
            let number = i.wrapping_mul(2_654_435_769) >> (32 - i % 33).min(31);
            let mask = ((1_u64 << (i % 33)) - 1) as u32;
            same &= decoder.decode_bits(i % 33)? == number & mask;
        }
        decoder.finish().map(|()| same)
    }

    #[test]
    fn symbols_come_back_and_all_bytes_are_read() {
        for rounds in 0..300 {
            let mut bytes = written(rounds);
            assert_eq!(read(&bytes, rounds), Ok(true));
            for _ in 0..20 {
                bytes.push(0);
                assert_eq!(read(&bytes, rounds), Err(Fault("bytes follow the last symbol")));
            }
        }
    }

    #[test]
    fn no_byte_can_be_left_out() {
        for rounds in 1..100 {
            let bytes = written(rounds);
            for len in 0..bytes.len() {
                assert_ne!(read(&bytes[..len], rounds), Ok(true), "{len} of {} bytes", bytes.len());
            }
        }
        assert_eq!(read(&written(100)[..100], 100), Err(Fault("bytes end before the last symbol")));
    }

    #[test]
    fn a_likely_bit_costs_little() {
        let mut encoder = Encoder::new();
        for _ in 0..10_000 {
            encoder.encode_bit(false, 65_535);
        }
        assert_eq!(encoder.finish().len(), 0);
    }
}
