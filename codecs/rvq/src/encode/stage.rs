//! One stage: a codebook of what the stages before it leave.

use cvr_codebook::lbg::Stop;
use cvr_codebook::pack::BitPacker;
use cvr_codebook::settings::TrainingSettings;
use cvr_codebook::{Codebook, Quantiser, Search, Training, Vectors, train_over};
use cvr_core::codec::{Cancelled, Progress};
use cvr_groups::Scale;
use rayon::prelude::*;

use crate::stream::{Entries, Geometry};

/// A round of training that gains less than this part of the distortion is the last.
const GAIN: f64 = 1e-3;
/// Vectors that one thread searches at a time.
const ROWS: usize = 256;

/// A codebook, in units of the decoder's sums.
#[derive(Clone, Debug)]
pub struct Stage {
    pub codebook: Codebook,
    /// What its entries count.
    pub scale: Scale,
}

/// What the entries of a codebook with these components have to reach: the upper end of the codes is one less than the lower.
fn reach(values: &[f64], bits: u32) -> f64 {
    let half = f64::from(1_u32 << (bits - 1));
    values.iter().fold(0.0, |most, v| most.max(if *v < 0.0 { -v * (half - 1.0) / half } else { *v }))
}

impl Stage {
    /// At most `size` codewords for some vectors. All stages but the `first` have the zero vector as codeword 0, so that a
    /// stage need not raise the error of any block.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn train(
        vectors: &Vectors,
        (size, first): (usize, bool),
        entries: Entries,
        with: &TrainingSettings,
        seed: u64,
        run: &Progress<'_>,
    ) -> Result<Self, Cancelled> {
        let (bits, mut scale) = (entries.code_bits(), Scale::ONE);
        let quantiser = |first: &[f64]| {
            let (quantiser, of_first) = Quantiser::of_entries(bits, reach(first, bits));
            scale = of_first;
            quantiser
        };
        let own = if first { size } else { size - 1 };
        if own == 0 {
            return Ok(Self::zero(vectors.dimension(), entries));
        }
        let training = Training {
            size: own,
            quantiser: Quantiser::of_entries(bits, 0.0).0,
            initial: with.initial,
            seed,
            stop: Stop { rounds: with.iterations, gain: GAIN },
        };
        let codebook = train_over(vectors, &training, quantiser, run)?.codebook;
        if first && entries != Entries::Colours {
            return Ok(Self { codebook, scale });
        }
        let zero = std::iter::repeat_n(0.0, if first { 0 } else { vectors.dimension() });
        // What is left may be zero already.
        let words = codebook.values().chunks_exact(codebook.dimension());
        let others = words.filter(|word| first || word.iter().any(|v| *v != 0.0)).flatten();
        let values: Vec<f64> = zero.chain(others.map(|v| f64::from(*v))).collect();
        Ok(Self::of(&values, codebook.dimension(), entries))
    }

    /// The zero vector alone.
    #[must_use]
    pub fn zero(dimension: usize, entries: Entries) -> Self {
        Self::of(&vec![0.0; dimension], dimension, entries)
    }

    /// The codewords nearest to `values` (one after the other) that a stream can hold.
    #[must_use]
    pub fn of(values: &[f64], dimension: usize, entries: Entries) -> Self {
        let bits = entries.code_bits();
        let (quantiser, scale) = Quantiser::of_entries(bits, reach(values, bits));
        let stored: Vec<f64> =
            values.iter().enumerate().map(|(i, v)| stored(quantiser, entries, i % 3, *v)).collect();
        Self { codebook: Codebook::one_for_each(&stored, dimension, quantiser), scale }
    }

    /// Takes from each vector the codeword that is nearest to it.
    pub fn subtract_nearest(&self, vectors: &mut Vectors) {
        let (search, dimension) = (Search::new(&self.codebook, None), vectors.dimension());
        vectors.values_mut().par_chunks_mut(ROWS * dimension).for_each(|rows| {
            let nearest = search.rows(rows);
            for (row, nearest) in rows.chunks_exact_mut(dimension).zip(nearest) {
                subtract(row, self.codebook.codeword(nearest.index as usize));
            }
        });
    }
}

/// `row −= codeword`.
pub fn subtract(row: &mut [f32], codeword: &[f32]) {
    row.iter_mut().zip(codeword).for_each(|(v, c)| *v -= c);
}

/// The value nearest to `value` that an entry of channel `c` holds.
fn stored(quantiser: Quantiser, entries: Entries, c: usize, value: f64) -> f64 {
    let dropped = entries.dropped(c);
    let code = u32::from(quantiser.code(value));
    let most = ((1_u32 << entries.code_bits()) - 1) >> dropped;
    // Half a step is rounded up.
    let kept = ((code + ((1 << dropped) >> 1)) >> dropped).min(most);
    f64::from(quantiser.value(kept << dropped))
}

/// The codebooks of a table in words, each filled up with zeros to the length of the largest.
#[must_use]
pub fn packed(stages: &[Stage], g: &Geometry) -> Vec<u32> {
    let codebook_codes = (g.codewords * g.dimension()) as usize;
    let codes = stages.iter().flat_map(|stage| {
        let codes = stage.codebook.codes();
        codes.iter().map(|code| u32::from(*code)).chain(std::iter::repeat_n(0, codebook_codes - codes.len()))
    });
    let mut words = Vec::with_capacity(g.words(0) as usize);
    if g.entries == Entries::Colours {
        let codes: Vec<u32> = codes.collect();
        words.extend(codes.chunks_exact(3).map(|c| c[0] >> 5 | (c[1] >> 5) << 11 | (c[2] >> 6) << 22));
    } else {
        let mut packer = BitPacker::new(g.entries.code_bits());
        codes.for_each(|code| packer.push(code, &mut words));
        packer.flush(&mut words);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_reach_both_ends_of_their_values() {
        let stage = Stage::of(&[-32768.0, 32512.0, 256.0, -256.0], 4, Entries::Bits8);
        assert_eq!((stage.scale.units(), stage.codebook.codes()), (256, &[0, 255, 129, 127][..]));
    }

    #[test]
    fn colours_keep_their_upper_bits() {
        let stage = Stage::of(&[-32768.0, 33.0, 33.0, 32767.0, 15.0, 31.0], 6, Entries::Colours);
        assert_eq!(stage.scale, Scale::ONE);
        assert_eq!(stage.codebook.values(), [-32768.0, 32.0, 64.0, 32736.0, 0.0, 0.0]);
    }
}
