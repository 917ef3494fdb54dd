//! A coefficient as bits: whether it is 0, the number of bits of its magnitude in unary, the bits themselves, the sign.

use super::adaptive::Adaptive;
use super::models::Models;
use crate::coders::fault::Fault;
use crate::coders::range::{Decoder, Encoder};

/// Writes a bit and learns it.
#[inline]
pub fn write_bit(encoder: &mut Encoder, model: &mut Adaptive, bit: bool) {
    encoder.encode_bit(bit, model.zero());
    model.learn(bit);
}

/// Reads a bit and learns it.
///
/// # Errors
/// The bytes are corrupt.
#[inline]
pub fn read_bit(decoder: &mut Decoder<'_>, model: &mut Adaptive) -> Result<bool, Fault> {
    let bit = decoder.decode_bit(model.zero())?;
    model.learn(bit);
    Ok(bit)
}

/// Writes a coefficient.
#[inline]
pub fn write(
    encoder: &mut Encoder,
    models: &mut Models,
    value: i32,
    class: usize,
    negative: impl Fn() -> (usize, usize),
) {
    write_bit(encoder, &mut models.nonzero[class], value != 0);
    if value == 0 {
        return;
    }
    let magnitude = value.unsigned_abs();
    let below = magnitude.ilog2() as usize;
    for longer in &mut models.longer[..below] {
        write_bit(encoder, &mut longer[class], true);
    }
    write_bit(encoder, &mut models.longer[below][class], false);
    if below > 0 {
        let second = magnitude >> (below - 1) & 1;
        write_bit(encoder, &mut models.second[below][class], second == 1);
        if below > 1 {
            let third = magnitude >> (below - 2) & 1;
            write_bit(encoder, &mut models.third[below][second as usize], third == 1);
            encoder.encode_bits(magnitude & ((1 << (below - 2)) - 1), below as u32 - 2);
        }
    }
    let (band, signs) = negative();
    write_bit(encoder, &mut models.negative[band][signs], value < 0);
}

/// Reads a coefficient.
///
/// # Errors
/// The bytes are corrupt.
#[inline]
pub fn read(
    decoder: &mut Decoder<'_>,
    models: &mut Models,
    class: usize,
    negative: impl Fn() -> (usize, usize),
) -> Result<i32, Fault> {
    if !read_bit(decoder, &mut models.nonzero[class])? {
        return Ok(0);
    }
    let mut below = 0;
    while read_bit(decoder, &mut models.longer[below][class])? {
        below += 1;
        if below > 30 {
            return Err(Fault("a coefficient has more than 31 bits"));
        }
    }
    let mut magnitude = 1;
    if below > 0 {
        let second = read_bit(decoder, &mut models.second[below][class])?;
        magnitude = 2 | i32::from(second);
        if below > 1 {
            let third = read_bit(decoder, &mut models.third[below][usize::from(second)])?;
            let rest = decoder.decode_bits(below as u32 - 2)?;
            magnitude = (magnitude << 1 | i32::from(third)) << (below - 2) | rest as i32;
        }
    }
    let (band, signs) = negative();
    let negative = read_bit(decoder, &mut models.negative[band][signs])?;
    Ok(if negative { -magnitude } else { magnitude })
}
