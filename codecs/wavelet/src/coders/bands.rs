//! Coders that write one chunk per band.

use cvr_core::codec::DecodeError;
use rayon::prelude::*;

use super::{
    Coder,
    fault::Fault,
    symbols::{largest, read_largest, write_largest},
};
use crate::stream::pyramid::{Band, Pyramid};

/// Codes one region. The chunk of a region of zeros is empty: its length is the flag of the paper ("bit-pattern",
/// section 2.3) that marks unused regions. All other chunks start with the largest magnitude.
pub trait BandCoder: Sync {
    /// What follows the header. `largest` is at least 1.
    fn encode_body(&self, extent: [usize; 3], coefficients: &[i32], largest: u32) -> Vec<u8>;

    /// Reads what [`BandCoder::encode_body`] has written. `out` has as many coefficients as `extent`, all 0.
    ///
    /// # Errors
    /// It has not written this.
    fn decode_body(
        &self,
        extent: [usize; 3],
        body: &[u8],
        largest: u32,
        out: &mut [i32],
    ) -> Result<(), Fault>;
}

/// The chunk of a band.
pub fn encode_band(coder: &impl BandCoder, band: &Band, coefficients: &[i32]) -> Vec<u8> {
    let largest = largest(coefficients);
    let mut chunk = Vec::new();
    if largest > 0 {
        write_largest(largest, &mut chunk);
        chunk.extend(coder.encode_body(band.extent, coefficients, largest));
    }
    chunk
}

/// Reads the chunk of a band. `out` has the coefficients of the band, all 0.
///
/// # Errors
/// The chunk is corrupt.
pub fn decode_band(
    coder: &impl BandCoder,
    band: &Band,
    mut chunk: &[u8],
    out: &mut [i32],
) -> Result<(), Fault> {
    if chunk.is_empty() {
        return Ok(());
    }
    match read_largest(&mut chunk)? {
        0 => Err(Fault("a region of zeros has bytes")),
        largest => coder.decode_body(band.extent, chunk, largest, out),
    }
}

/// Checks the arguments of [`Coder::decode`].
///
/// # Errors
/// The pyramid has other chunks, fewer levels, or other coefficients.
pub fn check(
    coder: &impl Coder,
    pyramid: &Pyramid,
    levels: usize,
    chunks: &[&[u8]],
    out: &[i32],
) -> Result<(), DecodeError> {
    let expected = coder.chunks(pyramid);
    if chunks.len() != expected {
        return Err(DecodeError::Corrupt(format!("{} chunks of {expected}", chunks.len())));
    }
    if levels > pyramid.levels() {
        return Err(DecodeError::Corrupt(format!("level {levels} of {}", pyramid.levels())));
    }
    if out.len() != pyramid.coefficients(levels) {
        return Err(Fault("there is not as much room as there are coefficients").into());
    }
    Ok(())
}

/// [`check`], and `out` split into its bands.
///
/// # Errors
/// Those of [`check`].
pub fn split<'a>(
    coder: &impl Coder,
    pyramid: &Pyramid,
    levels: usize,
    chunks: &[&[u8]],
    mut out: &'a mut [i32],
) -> Result<Vec<&'a mut [i32]>, DecodeError> {
    check(coder, pyramid, levels, chunks, out)?;
    let own = |band: &Band| {
        let (head, tail) = std::mem::take(&mut out).split_at_mut(band.len());
        out = tail;
        head
    };
    Ok(pyramid.coarsest(levels).iter().map(own).collect())
}

/// Names a band in an error.
#[must_use]
pub fn name(band: &Band) -> String {
    let axes = band.high.map(|high| if high { 'H' } else { 'L' });
    format!("band {} of level {}", axes.iter().collect::<String>(), band.level)
}

impl<C: BandCoder> Coder for C {
    fn chunks(&self, pyramid: &Pyramid) -> usize {
        pyramid.bands().len()
    }

    fn encode(&self, pyramid: &Pyramid, coefficients: &[i32]) -> Vec<Vec<u8>> {
        let code = |band: &Band| encode_band(self, band, &coefficients[band.range()]);
        pyramid.bands().par_iter().with_max_len(1).map(code).collect()
    }

    fn decode(
        &self,
        pyramid: &Pyramid,
        levels: usize,
        chunks: &[&[u8]],
        out: &mut [i32],
    ) -> Result<(), DecodeError> {
        let regions = split(self, pyramid, levels, chunks, out)?;
        let read = |((band, chunk), region): ((&Band, &&[u8]), &mut [i32])| {
            decode_band(self, band, chunk, region).map_err(|fault| fault.of(name(band)))
        };
        pyramid.coarsest(levels).par_iter().zip(chunks).zip(regions).with_max_len(1).try_for_each(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coders::arithmetic::Arithmetic;

    #[test]
    fn only_an_empty_chunk_is_a_region_of_zeros() {
        let pyramid = Pyramid::new([2, 2, 2], 1, false);
        let chunks = |lll: &'static [u8]| [lll, &[], &[], &[], &[], &[], &[], &[]];
        Arithmetic.decode(&pyramid, 1, &chunks(&[]), &mut [0; 8]).unwrap();
        let error = Arithmetic.decode(&pyramid, 1, &chunks(&[0]), &mut [0; 8]).unwrap_err();
        assert_eq!(error.to_string(), "corrupt stream: band LLL of level 0: a region of zeros has bytes");
        assert_eq!(name(&pyramid.level(0)[5]), "band LHH of level 0");
    }
}
