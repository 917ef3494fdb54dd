//! Decodes one channel of a frame: chunks, coefficients, samples. This code defines the codec of whole volumes.

use cvr_core::codec::DecodeError;
use cvr_core::memory;
use cvr_core::volume::ValueRange;
use rayon::prelude::*;

use crate::coders::Coding;
use crate::coders::corrections::{self, Correction};
use crate::quantiser::{self, INTEGER_STEPS, Rule, Scale};
use crate::stream::pyramid::Pyramid;
use crate::transform::{self, Filter, gain};

/// What all channels and frames of a stream share.
#[derive(Clone, Debug)]
pub struct Shared {
    /// Filter of the transform.
    pub filter: Filter,
    /// Shapes of the bands.
    pub pyramid: Pyramid,
    /// Entropy coder.
    pub coding: Coding,
    /// The paper's quantiser, if it was used.
    pub paper: Option<(u8, Scale)>,
    /// Unit of corrections in data units.
    pub correction: Option<f32>,
    /// Decoded samples are clamped to it.
    pub range: ValueRange,
}

impl Shared {
    /// Chunks of one channel of a frame.
    #[must_use]
    pub fn chunks(&self) -> usize {
        self.coding.coder().chunks(&self.pyramid) + usize::from(self.correction.is_some())
    }

    /// The rules of the bands under a step of a channel.
    #[must_use]
    pub fn rules(&self, step: f32) -> Vec<Rule> {
        match self.paper {
            Some(quality) => {
                let rules = quantiser::paper(self.filter, &self.pyramid, quality, self.range);
                rules.into_iter().map(|(rule, _)| rule).collect()
            }
            None => quantiser::rules(self.filter, &self.pyramid, step, self.range.min),
        }
    }

    /// Voxels along x, y and z at a resolution.
    #[must_use]
    pub fn extent(&self, resolution: usize) -> [usize; 3] {
        self.pyramid.extent(resolution)
    }

    /// One over the factor between samples and the low band at a resolution.
    #[must_use]
    pub fn low_scale(&self, resolution: usize) -> f64 {
        let gains = self.pyramid.extent(0).map(|n| gain::low(self.filter, n, resolution));
        1.0 / gains.iter().product::<f64>()
    }

    /// The quantised coefficients that a resolution needs.
    ///
    /// # Errors
    /// When chunks are corrupt, or there is no memory for them.
    pub fn coefficients(&self, resolution: usize, chunks: &[&[u8]]) -> Result<Vec<i32>, DecodeError> {
        let levels = self.pyramid.levels() - resolution;
        let count = self.pyramid.coefficients(levels);
        let mut out = memory::zeroed(count as u64, || format!("{count} coefficients"))?;
        let coder = self.coding.coder();
        coder.decode(&self.pyramid, levels, &chunks[..coder.chunks(&self.pyramid)], &mut out)?;
        Ok(out)
    }

    /// The corrections of a channel. Coarse resolutions have none.
    ///
    /// # Errors
    /// When they are corrupt.
    pub fn corrections(&self, resolution: usize, chunks: &[&[u8]]) -> Result<Vec<Correction>, DecodeError> {
        match (self.correction, chunks.last()) {
            (Some(_), Some(chunk)) if resolution == 0 => {
                corrections::decode(chunk, self.pyramid.extent(0).iter().product())
            }
            _ => Ok(Vec::new()),
        }
    }

    /// The samples of quantised coefficients at a resolution, in data units, corrected and within the range.
    #[must_use]
    pub fn samples(
        &self,
        resolution: usize,
        step: f32,
        coefficients: &[i32],
        corrections: &[Correction],
    ) -> Vec<f32> {
        let mut samples = self.transformed(resolution, step, coefficients);
        self.correct(&mut samples, corrections);
        samples
    }

    /// The samples before corrections and clamping.
    #[must_use]
    pub fn transformed(&self, resolution: usize, step: f32, coefficients: &[i32]) -> Vec<f32> {
        let (pyramid, levels) = (&self.pyramid, self.pyramid.levels() - resolution);
        let rules = self.rules(step);
        if self.filter.is_integer() {
            let steps: Vec<i32> = rules.iter().map(|rule| integer_step(*rule)).collect();
            let value = |band: &_, q| quantiser::integer(q, steps[pyramid.number(band)]);
            let samples: Vec<i32> = transform::inverse(self.filter, pyramid, levels, coefficients, value);
            return samples.into_par_iter().map(|v| v as f32).collect();
        }
        let value = |band: &_, q| {
            let rule = rules[pyramid.number(band)];
            rule.offset + rule.step * f64::from(q)
        };
        let mut samples: Vec<f32> = transform::inverse(self.filter, pyramid, levels, coefficients, value);
        let scale = self.low_scale(resolution) as f32;
        if scale != 1.0 {
            samples.par_iter_mut().for_each(|v| *v *= scale);
        }
        samples
    }

    /// Clamps to the range, and adds corrections.
    pub fn correct(&self, samples: &mut [f32], corrections: &[Correction]) {
        let ValueRange { min, max } = self.range;
        // What hostile coefficients turn into no number becomes the lowest.
        samples.par_iter_mut().for_each(|v| *v = v.max(min).min(max));
        let unit = self.correction.unwrap_or(0.0);
        for Correction { place, units } in corrections {
            if let Some(sample) = samples.get_mut(*place as usize) {
                *sample = (*sample + unit * *units as f32).max(min).min(max);
            }
        }
    }
}

/// The step of a band in units of 1 / [`INTEGER_STEPS`].
#[must_use]
pub fn integer_step(rule: Rule) -> i32 {
    (rule.step * f64::from(INTEGER_STEPS)).round() as i32
}
