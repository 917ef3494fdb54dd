//! Contexts of neighbours, parents and other bands, and a binary range coder: the coder that costs least bits.
//!
//! A coefficient's magnitude is coded in the context of a weighted sum of magnitudes around it (after X. Wu, Context
//! Quantization with Fisher Discriminant for Adaptive Embedded Wavelet Image Coding, 1999, and JPEG 2000's contexts):
//! three neighbours before it, six along edges, its parent, and the same place in the bands of its level before it.

mod adaptive;
mod band;
pub(super) mod binarisation;
mod choosing;
mod magnitudes;
pub(super) mod models;
mod parts;
mod sides;

use cvr_core::codec::DecodeError;
use rayon::prelude::*;

use self::band::{Known, Side, code};
use self::choosing::{Choosing, Costs};
use self::magnitudes::{Magnitudes, Parents};
use self::models::Models;
use self::parts::{Slab, first_levels, slab_of_all, slabs};
use self::sides::{Reading, Writing};
use super::Coder;
use super::bands::check;
use super::fault::Fault;
use super::range::{Decoder, Encoder};
use crate::quantiser::{Rule, quantised};
use crate::stream::pyramid::{Band, Pyramid};

/// The coder.
#[derive(Copy, Clone, Debug, Default)]
pub struct Contexts;

/// Models of LLL, and of bands that are high-pass along one, two and three axes.
type Kinds = [Models; 4];

/// Codes the parts of a level's bands in a slab. `outs` get their coefficients. `with_side` codes a part of a band with
/// the side that a caller has for it.
fn code_slab(
    (pyramid, slab): (&Pyramid, &Slab),
    models: &mut Kinds,
    parents: &[Magnitudes],
    outs: &mut [&mut [i32]],
    mut with_side: impl FnMut(&Band, &mut Part<'_, '_>) -> Result<Magnitudes, Fault>,
) -> Result<(), Fault> {
    let mut done: Vec<Magnitudes> = Vec::with_capacity(7);
    for (number, (band, out)) in pyramid.level(slab.level).iter().zip(outs).enumerate() {
        let parents = parents.get(number).filter(|parent| !parent.is_empty());
        let parents = parents.map(|magnitudes| Parents { magnitudes, first_slice: slab.slices.start });
        let known = Known { number: number + 1, parents, done: &done };
        let models = &mut models[band.kind()];
        let own = with_side(band, &mut Part { models, known, extent: slab.extent(band), out })?;
        done.push(own);
    }
    Ok(())
}

/// A part of a band that is to be coded.
struct Part<'a, 'b> {
    models: &'a mut Models,
    known: Known<'b>,
    extent: [usize; 3],
    out: &'a mut [i32],
}

impl Part<'_, '_> {
    fn code(&mut self, side: &mut impl Side) -> Result<Magnitudes, Fault> {
        code(side, self.models, self.known, self.extent, self.out)
    }
}

/// The magnitudes of a level's bands.
fn magnitudes(bands: &[Band], coefficients: &[i32]) -> Vec<Magnitudes> {
    bands.par_iter().map(|band| Magnitudes::of(&coefficients[band.range()], band.extent)).collect()
}

/// The coefficients of a level, which lie in a row, by slabs and bands.
fn split<'a>(pyramid: &Pyramid, slabs: &[Slab], mut level: &'a mut [i32]) -> Vec<Vec<&'a mut [i32]>> {
    let mut out: Vec<Vec<&mut [i32]>> = slabs.iter().map(|_| Vec::with_capacity(7)).collect();
    for band in slabs.first().map_or(&[][..], |slab| pyramid.level(slab.level)) {
        for (slab, out) in slabs.iter().zip(&mut out) {
            let (own, rest) = level.split_at_mut(slab.places(band).len());
            out.push(own);
            level = rest;
        }
    }
    out
}

/// Takes from every value of LLL what its neighbours before it predict: the sum of differences along all axes
/// (L. Ibarria et al., Out-of-core Compression and Decompression of Large n-dimensional Scalar Fields, 2003).
fn differences(values: &mut [i32], extent: [usize; 3]) {
    let mut stride = 1;
    for n in extent {
        for i in (0..values.len()).rev().filter(|i| i / stride % n > 0) {
            values[i] = values[i].wrapping_sub(values[i - stride]);
        }
        stride *= n;
    }
}

/// The inverse of [`differences`].
fn sums(values: &mut [i32], extent: [usize; 3]) {
    let mut stride = 1;
    for n in extent {
        for i in (0..values.len()).filter(|i| i / stride % n > 0) {
            values[i] = values[i].wrapping_add(values[i - stride]);
        }
        stride *= n;
    }
}

/// Writes LLL and the coarsest levels in one chunk, and the slabs of all others. `write` writes a part of a band of a
/// level, at these places among the band's coefficients. `out` gets what was written.
fn write_all(
    pyramid: &Pyramid,
    out: &mut [i32],
    lll: &[i32],
    write: impl Fn(&mut Encoder, &Band, std::ops::Range<usize>, &mut Part<'_, '_>) -> Result<Magnitudes, Fault>
    + Sync,
) -> Vec<Vec<u8>> {
    // Sides that write find nothing corrupt.
    let written = |result: Result<(), Fault>| debug_assert_eq!(result, Ok(()));
    out.fill(0);
    let first = &pyramid.bands()[0];
    let (mut encoder, mut models) = (Encoder::new(), Kinds::default());
    let mut residuals = lll.to_vec();
    differences(&mut residuals, first.extent);
    let known = Known { number: 0, parents: None, done: &[] };
    let side = &mut Writing { encoder: &mut encoder, coefficients: &residuals };
    let coded = code(side, &mut models[0], known, first.extent, &mut out[first.range()]);
    written(coded.map(drop));
    out[first.range()].copy_from_slice(lll);
    let (mut parents, mut chunks) = (Vec::new(), Vec::new());
    let together = first_levels(pyramid);
    for level in 0..pyramid.levels() {
        let bands = pyramid.level(level);
        let range = range(bands);
        let code_one =
            |slab: &Slab, outs: &mut Vec<&mut [i32]>, encoder: &mut Encoder, models: &mut Kinds| {
                code_slab((pyramid, slab), models, &parents, outs, |band, part| {
                    write(encoder, band, slab.places(band), part)
                })
            };
        if level < together {
            let slab = [slab_of_all(pyramid, level)];
            let mut outs = split(pyramid, &slab, &mut out[range]);
            outs.iter_mut().for_each(|outs| written(code_one(&slab[0], outs, &mut encoder, &mut models)));
        } else {
            let slabs = slabs(pyramid, level);
            let outs = split(pyramid, &slabs, &mut out[range]);
            let coded = slabs.par_iter().zip(outs).map(|(slab, mut outs)| {
                let mut encoder = Encoder::new();
                written(code_one(slab, &mut outs, &mut encoder, &mut Kinds::default()));
                // Zeros need no bytes.
                if outs.iter().all(|out| out.iter().all(|c| *c == 0)) { Vec::new() } else { encoder.finish() }
            });
            chunks.par_extend(coded);
        }
        if level + 1 < pyramid.levels() {
            parents = magnitudes(bands, out);
        }
    }
    let zeros = out[..pyramid.coefficients(together)].iter().all(|c| *c == 0);
    chunks.insert(0, if zeros { Vec::new() } else { encoder.finish() });
    chunks
}

/// Chooses quantised coefficients, weighing error against bits, and writes them. `rules` are those of the bands, in
/// their order. `out` gets the quantised coefficients. LLL is rounded.
#[must_use]
pub fn choose(pyramid: &Pyramid, coefficients: &[f32], rules: &[Rule], out: &mut [i32]) -> Vec<Vec<u8>> {
    let scales: Vec<f32> = rules.iter().map(|rule| (1.0 / rule.step) as f32).collect();
    let first = coefficients[pyramid.bands()[0].range()].iter();
    let lll: Vec<i32> = first.map(|c| quantised(*c, rules[0], 0.5)).collect();
    let costs = Costs::default();
    write_all(pyramid, out, &lll, |encoder, band, places, part| {
        let coefficients = &coefficients[band.range()][places];
        let scale = scales[pyramid.number(band)];
        part.code(&mut Choosing { encoder, costs: &costs, coefficients, scale })
    })
}

impl Coder for Contexts {
    fn chunks(&self, pyramid: &Pyramid) -> usize {
        1 + (first_levels(pyramid)..pyramid.levels()).map(|level| slabs(pyramid, level).len()).sum::<usize>()
    }

    fn encode(&self, pyramid: &Pyramid, coefficients: &[i32]) -> Vec<Vec<u8>> {
        let mut out = vec![0; coefficients.len()];
        let lll = &coefficients[pyramid.bands()[0].range()];
        write_all(pyramid, &mut out, lll, |encoder, band, places, part| {
            part.code(&mut Writing { encoder, coefficients: &coefficients[band.range()][places] })
        })
    }

    fn decode(
        &self,
        pyramid: &Pyramid,
        levels: usize,
        chunks: &[&[u8]],
        out: &mut [i32],
    ) -> Result<(), DecodeError> {
        check(self, pyramid, levels, chunks, out)?;
        let together = first_levels(pyramid);
        let mut chunks = chunks.iter();
        let first = chunks.next().copied().unwrap_or_default();
        if !first.is_empty() {
            read_first(pyramid, levels.min(together), first, out, levels >= together)?;
        }
        for level in together..levels {
            let slabs = slabs(pyramid, level);
            let own: Vec<&[u8]> = chunks.by_ref().take(slabs.len()).copied().collect();
            let parents = level.checked_sub(1).map(|above| magnitudes(pyramid.level(above), out));
            let outs = split(pyramid, &slabs, &mut out[range(pyramid.level(level))]);
            let parts = slabs.par_iter().zip(outs).zip(own).filter(|(_, chunk)| !chunk.is_empty());
            parts.try_for_each(|((slab, mut outs), chunk)| {
                let (mut decoder, models) = (Decoder::new(chunk)?, &mut Kinds::default());
                let parents = parents.as_deref().unwrap_or_default();
                code_slab((pyramid, slab), models, parents, &mut outs, |_, part| {
                    part.code(&mut Reading(&mut decoder))
                })?;
                decoder.finish()
            })?;
        }
        Ok(())
    }
}

/// Reads `levels` levels of the first chunk. `whole`: it has no more.
fn read_first(
    pyramid: &Pyramid,
    levels: usize,
    chunk: &[u8],
    out: &mut [i32],
    whole: bool,
) -> Result<(), Fault> {
    let (mut decoder, mut models) = (Decoder::new(chunk)?, Kinds::default());
    let first = &pyramid.bands()[0];
    let known = Known { number: 0, parents: None, done: &[] };
    let lll = &mut out[first.range()];
    code(&mut Reading(&mut decoder), &mut models[0], known, first.extent, lll)?;
    sums(lll, first.extent);
    let mut parents = Vec::new();
    for level in 0..levels {
        let slab = [slab_of_all(pyramid, level)];
        for outs in &mut split(pyramid, &slab, &mut out[range(pyramid.level(level))]) {
            code_slab((pyramid, &slab[0]), &mut models, &parents, outs, |_, part| {
                part.code(&mut Reading(&mut decoder))
            })?;
        }
        parents = magnitudes(pyramid.level(level), out);
    }
    if whole { decoder.finish() } else { Ok(()) }
}

/// Places of the coefficients of a level's bands, which lie in a row.
fn range(bands: &[Band]) -> std::ops::Range<usize> {
    bands.first().map_or(0, |band| band.start)..bands.last().map_or(0, |band| band.range().end)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More coefficients than the first chunk and one slab hold.
    fn large() -> (Pyramid, Vec<i32>) {
        let pyramid = Pyramid::new([200, 190, 130], 3, false);
        let value = |i: usize| {
            let h = (i as u32).wrapping_mul(0x9e37_79b9);
            // Quiet stretches, small numbers, and few large ones.
            match h >> 24 {
                0..180 if i / 4096 % 3 < 2 => 0,
                255 => h as i32 >> 8,
                n => (n % 7) as i32 - 3,
            }
        };
        let coefficients = (0..pyramid.coefficients(3)).map(value).collect();
        (pyramid, coefficients)
    }

    #[test]
    fn slabs_come_back_and_coarse_levels_read_no_finer_ones() {
        let (pyramid, coefficients) = large();
        let chunks = Contexts.encode(&pyramid, &coefficients);
        assert_eq!(chunks.len(), Contexts.chunks(&pyramid));
        assert!(chunks.len() > 3, "{} chunks", chunks.len());
        for levels in 0..=3 {
            let mut chunks: Vec<&[u8]> = chunks.iter().map(Vec::as_slice).collect();
            if levels < 3 {
                // Bytes that no decoder would take.
                *chunks.last_mut().unwrap() = &[0xff; 40];
            }
            let mut out = vec![0; pyramid.coefficients(levels)];
            Contexts.decode(&pyramid, levels, &chunks, &mut out).unwrap();
            assert!(out == coefficients[..out.len()], "{levels} levels");
        }
    }

    #[test]
    fn what_is_chosen_is_what_is_read_at_any_number_of_threads() {
        let (pyramid, coefficients) = large();
        let exact: Vec<f32> = coefficients.iter().map(|c| *c as f32 * 0.9 + 0.3).collect();
        let rules = vec![Rule { offset: 0.0, step: 1.3 }; pyramid.bands().len()];
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut out = vec![0; exact.len()];
            let chunks = pool.install(|| choose(&pyramid, &exact, &rules, &mut out));
            (chunks, out)
        };
        let (chunks, chosen) = with(1);
        assert!((chunks.clone(), chosen.clone()) == with(3));
        let mut out = vec![0; exact.len()];
        let chunks: Vec<&[u8]> = chunks.iter().map(Vec::as_slice).collect();
        Contexts.decode(&pyramid, 3, &chunks, &mut out).unwrap();
        assert!(out == chosen);
        // None is further from its coefficient than one step and a half.
        let near = |(c, q): (&f32, &i32)| (f64::from(*c) / 1.3 - f64::from(*q)).abs() <= 1.5 + 1e-4;
        assert!(exact.iter().zip(&chosen).all(near));
    }
}
