//! Zerotrees (Shapiro 1993) of values that are already quantised, in adaptive models (section 2.3 of the paper).

use cvr_core::codec::DecodeError;
use rayon::prelude::*;

use super::{
    Coder,
    arithmetic::Arithmetic,
    bands::{decode_band, encode_band, name, split},
    counts::Counts,
    family::{ancestors, inherited, orientation},
    fault::Fault,
    range::{Decoder, Encoder},
    symbols::{largest, read_largest, write_largest},
    values::Values,
};
use crate::stream::pyramid::{Band, Pyramid};

/// Zerotrees: a zero whose descendants are all zeros is one symbol, and its descendants cost nothing. A chunk holds the
/// bands of one orientation, from coarse to fine; LLL has the first chunk, which [`Arithmetic`] codes.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Zerotree;

/// A value that is not 0 follows.
const VALUE: usize = 0;
/// A zero, as all its descendants.
const ROOT: usize = 1;
/// A zero with a descendant that is none. The last band that is coded has no such symbol.
const ISOLATED: usize = 2;

/// The symbols of a band.
fn symbols(finest: bool) -> Counts {
    Counts::new(if finest { 2 } else { 3 })
}

/// Writes a band. `covered` says which coefficients are within a tree, and grows by the trees that start here.
/// `below`: which have a descendant that is not 0.
fn write(coefficients: &[i32], below: &[bool], covered: &mut [bool], finest: bool, encoder: &mut Encoder) {
    let mut symbols = symbols(finest);
    let mut values = Values::new(largest(coefficients).max(1));
    for ((value, below), covered) in coefficients.iter().zip(below).zip(covered) {
        match (*covered, *value, *below) {
            (true, ..) => {}
            (_, 0, true) => encoder.symbol(ISOLATED, &mut symbols),
            (_, 0, false) => {
                encoder.symbol(ROOT, &mut symbols);
                *covered = true;
            }
            (_, value, _) => {
                encoder.symbol(VALUE, &mut symbols);
                values.encode(value, true, encoder);
            }
        }
    }
}

/// Reads what [`write`] has written.
fn read(
    largest: u32,
    covered: &mut [bool],
    finest: bool,
    decoder: &mut Decoder<'_>,
    out: &mut [i32],
) -> Result<(), Fault> {
    let mut symbols = symbols(finest);
    let mut values = Values::new(largest.max(1));
    for (out, covered) in out.iter_mut().zip(covered).filter(|(_, covered)| !**covered) {
        match decoder.symbol(&mut symbols)? {
            VALUE if largest == 0 => return Err(Fault("a region of zeros has a value")),
            VALUE => *out = values.decode(true, decoder)?,
            symbol => *covered = symbol == ROOT,
        }
    }
    Ok(())
}

fn encode_orientation(bands: &[&Band], coefficients: &[i32]) -> Vec<u8> {
    let region = |band: &Band| &coefficients[band.range()];
    // Bands of zeros after the last other one are not coded.
    let Some(last) = bands.iter().rposition(|band| largest(region(band)) > 0) else { return Vec::new() };
    let mut below = vec![vec![false; bands[last].len()]];
    for pair in bands[..=last].windows(2).rev() {
        let found = ancestors(pair[1], region(pair[1]), &below[below.len() - 1], pair[0]);
        below.push(found);
    }
    let mut chunk = Vec::new();
    bands.iter().for_each(|band| write_largest(largest(region(band)), &mut chunk));
    let mut encoder = Encoder::new();
    let mut parent: Option<(&Band, Vec<bool>)> = None;
    for (level, band) in bands[..=last].iter().enumerate() {
        let mut covered = inherited(band, parent.as_ref().map(|(band, covered)| (*band, &covered[..])));
        write(region(band), &below[last - level], &mut covered, level == last, &mut encoder);
        parent = Some((band, covered));
    }
    chunk.extend(encoder.finish());
    chunk
}

/// Reads the coarsest bands of an orientation that has `levels`.
fn decode_orientation(
    bands: &[&Band],
    levels: usize,
    mut chunk: &[u8],
    out: Vec<&mut [i32]>,
) -> Result<(), DecodeError> {
    if chunk.is_empty() {
        return Ok(());
    }
    let named = |fault: Fault| fault.of(bands.first().map_or_else(String::new, |band| name(band)));
    let mut all = Vec::new();
    for _ in 0..levels {
        all.push(read_largest(&mut chunk).map_err(named)?);
    }
    let last = all
        .iter()
        .rposition(|largest| *largest > 0)
        .ok_or_else(|| named(Fault("an orientation of zeros has bytes")))?;
    let mut decoder = Decoder::new(chunk).map_err(named)?;
    let mut parent: Option<(&Band, Vec<bool>)> = None;
    for (level, ((band, out), largest)) in bands.iter().zip(out).zip(all).enumerate().take(last + 1) {
        let mut covered = inherited(band, parent.as_ref().map(|(band, covered)| (*band, &covered[..])));
        read(largest, &mut covered, level == last, &mut decoder, out)
            .map_err(|fault| fault.of(name(band)))?;
        parent = Some((band, covered));
    }
    if bands.len() > last { decoder.finish().map_err(named) } else { Ok(()) }
}

impl Coder for Zerotree {
    fn chunks(&self, pyramid: &Pyramid) -> usize {
        if pyramid.levels() == 0 { 1 } else { 8 }
    }

    fn encode(&self, pyramid: &Pyramid, coefficients: &[i32]) -> Vec<Vec<u8>> {
        let code = |chunk: usize| match chunk.checked_sub(1) {
            None => {
                let lowest = &pyramid.bands()[0];
                encode_band(&Arithmetic, lowest, &coefficients[lowest.range()])
            }
            Some(number) => encode_orientation(&orientation(pyramid, number, pyramid.levels()), coefficients),
        };
        (0..self.chunks(pyramid)).into_par_iter().with_max_len(1).map(code).collect()
    }

    fn decode(
        &self,
        pyramid: &Pyramid,
        levels: usize,
        chunks: &[&[u8]],
        out: &mut [i32],
    ) -> Result<(), DecodeError> {
        let mut regions = split(self, pyramid, levels, chunks, out)?.into_iter();
        let mut of_chunk = vec![regions.next().into_iter().collect::<Vec<_>>()];
        of_chunk.resize_with(if levels == 0 { 1 } else { 8 }, Vec::new);
        for (i, region) in regions.enumerate() {
            of_chunk[1 + i % 7].push(region);
        }
        let read = |(chunk, (bytes, regions)): (usize, (&&[u8], Vec<&mut [i32]>))| match chunk.checked_sub(1)
        {
            None => {
                let lowest = &pyramid.bands()[0];
                regions.into_iter().try_for_each(|region| {
                    decode_band(&Arithmetic, lowest, bytes, region).map_err(|fault| fault.of(name(lowest)))
                })
            }
            Some(number) => {
                decode_orientation(&orientation(pyramid, number, levels), pyramid.levels(), bytes, regions)
            }
        };
        chunks.par_iter().zip(of_chunk).enumerate().with_max_len(1).try_for_each(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A band of so many kinds of symbols: that of a zero, or a value.
    fn by_hand(encoder: &mut Encoder, kinds: usize, largest: u32, band: &[Result<usize, i32>]) {
        let (mut symbols, mut values) = (Counts::new(kinds), Values::new(largest));
        for symbol in band {
            encoder.symbol(symbol.unwrap_or(VALUE), &mut symbols);
            if let Err(value) = symbol {
                values.encode(*value, true, encoder);
            }
        }
    }

    #[test]
    fn bytes_are_those_of_the_format() {
        // LLL; HLL of three levels; no other band has a coefficient.
        let pyramid = Pyramid::new([8, 1, 1], 3, false);
        let coefficients = [0, 0, 0, 3, 0, 0, 0, -1];
        let mut encoder = Encoder::new();
        by_hand(&mut encoder, 3, 1, &[Ok(ISOLATED)]);
        by_hand(&mut encoder, 3, 3, &[Ok(ROOT), Err(3)]);
        by_hand(&mut encoder, 2, 1, &[Ok(ROOT), Err(-1)]);
        let tree = [&[0, 3, 1][..], &encoder.finish()].concat();
        let mut chunks = vec![Vec::new(); 8];
        chunks[1].clone_from(&tree);
        assert_eq!(Zerotree.encode(&pyramid, &coefficients), chunks);

        let read = |levels, chunk: &[u8]| {
            let mut out = vec![0; pyramid.coefficients(levels)];
            let mut chunks = [&[][..]; 8];
            chunks[1] = chunk;
            Zerotree
                .decode(&pyramid, levels, &chunks, &mut out)
                .map(|()| out)
                .map_err(|error| error.to_string())
        };
        assert_eq!(read(3, &tree).unwrap(), coefficients);
        // A coarse volume reads a prefix, so it does not miss the end.
        let longer = [&tree[..], &[9; 9]].concat();
        assert_eq!(read(2, &longer).unwrap(), coefficients[..4]);
        assert!(read(3, &longer).unwrap_err().contains("bytes follow the last symbol"));
        assert!(read(3, &[0, 0, 0, 9]).unwrap_err().contains("an orientation of zeros has bytes"));
        let mut encoder = Encoder::new();
        by_hand(&mut encoder, 3, 1, &[Err(1)]);
        let value = [&[0, 3, 1][..], &encoder.finish()].concat();
        assert!(read(3, &value).unwrap_err().contains("a region of zeros has a value"));
    }
}
