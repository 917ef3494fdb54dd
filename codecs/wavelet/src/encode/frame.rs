//! A frame whose channels are transformed, and its coding under a step.

use cvr_core::codec::EncodeError;
use cvr_core::memory;
use cvr_core::volume::{BrickSource, FrameIndex};
use rayon::prelude::*;

use super::for_slabs;
use crate::coders::{Coding, contexts};
use crate::decode::Shared;
use crate::quantiser::{self, DEAD_ZONE, Rule};
use crate::transform;

/// The coefficients of the channels of a frame.
#[derive(Debug)]
pub struct Frame<'a> {
    /// What frames share.
    pub shared: &'a Shared,
    /// Its number.
    pub index: FrameIndex,
    /// Coefficients of each channel. Those of the reversible filter are integers below 2²⁴.
    pub channels: Vec<Vec<f32>>,
}

/// A coded frame.
#[derive(Debug)]
pub struct Coded {
    /// The step of the samples' error.
    pub step: f32,
    /// Chunks of each channel.
    pub channels: Vec<Vec<Vec<u8>>>,
}

impl Coded {
    /// Bytes of chunks, of their lengths and of the steps.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let chunks = self.channels.iter().flatten();
        chunks.map(|chunk| chunk.len() + 4).sum::<usize>() + 4 * self.channels.len()
    }
}

impl<'a> Frame<'a> {
    /// Reads and transforms a frame.
    ///
    /// # Errors
    /// When the source fails, or there is no memory for the frame.
    pub fn read(
        source: &dyn BrickSource,
        index: FrameIndex,
        shared: &'a Shared,
    ) -> Result<Self, EncodeError> {
        let channels = source.layout().channels as usize;
        let voxels = source.layout().extent.voxels();
        let what = || format!("the coefficients of {} voxels", source.layout().extent);
        memory::check(8 * voxels * channels as u64, what)?;
        let mut planes: Vec<Vec<f32>> = (0..channels).map(|_| Vec::with_capacity(voxels as usize)).collect();
        for_slabs(source, index, |values| {
            for (c, plane) in planes.iter_mut().enumerate() {
                match channels {
                    1 => plane.extend_from_slice(values),
                    _ => plane.extend(values.iter().skip(c).step_by(channels)),
                }
            }
        })?;
        let channels = planes.into_iter().map(|plane| shared.forward(plane)).collect();
        Ok(Self { shared, index, channels })
    }

    /// The frame under a step: the squared error of a sample is about a twelfth of its square.
    #[must_use]
    pub fn coded(&self, step: f32) -> Coded {
        self.coded_in(step, &mut Vec::new())
    }

    /// The same. `room` gets the quantised coefficients of each channel. The next call may use it again.
    #[must_use]
    pub fn coded_in(&self, step: f32, room: &mut Vec<Vec<i32>>) -> Coded {
        room.resize(self.channels.len(), Vec::new());
        let pairs = self.channels.iter().zip(room);
        let code = |(coefficients, quantised): (&Vec<f32>, &mut Vec<i32>)| {
            quantised.resize(coefficients.len(), 0);
            self.shared.code(coefficients, step, quantised)
        };
        Coded { step, channels: pairs.map(code).collect() }
    }

    /// A frame of a constant volume, under a step so large that its coefficients are all small. With a bound, no sample
    /// is corrected.
    #[must_use]
    pub fn constant(&self) -> Coded {
        let mut coded = self.coded(self.shared.range.max.abs().max(1.0));
        if self.shared.correction.is_some() {
            coded.channels.iter_mut().for_each(|chunks| chunks.push(Vec::new()));
        }
        coded
    }

    /// The coefficients of the reversible filter as they are.
    #[must_use]
    pub fn lossless(&self) -> Coded {
        let integers = |plane: &Vec<f32>| plane.par_iter().map(|c| *c as i32).collect::<Vec<_>>();
        let coder = self.shared.coding.coder();
        let channels = self.channels.iter().map(|plane| coder.encode(&self.shared.pyramid, &integers(plane)));
        // Under a step of 0, all steps of the reversible filter are 1.
        Coded { step: 0.0, channels: channels.collect() }
    }
}

impl Shared {
    /// The coefficients of samples.
    fn forward(&self, samples: Vec<f32>) -> Vec<f32> {
        if !self.filter.is_integer() {
            return transform::forward(self.filter, &self.pyramid, samples);
        }
        let integers: Vec<i32> = samples.par_iter().map(|v| *v as i32).collect();
        drop(samples);
        let coefficients = transform::forward(self.filter, &self.pyramid, integers);
        coefficients.into_par_iter().map(|c| c as f32).collect()
    }

    /// Chunks of a channel. `quantised` gets its quantised coefficients.
    fn code(&self, coefficients: &[f32], step: f32, quantised: &mut [i32]) -> Vec<Vec<u8>> {
        let pyramid = &self.pyramid;
        let rules: Vec<(Rule, f64)> = match self.paper {
            Some(quality) => {
                let rules = quantiser::paper(self.filter, pyramid, quality, self.range);
                rules.into_iter().map(|(rule, dead)| (rule, 0.5 * dead)).collect()
            }
            None => self.rules(step).into_iter().map(|rule| (rule, DEAD_ZONE)).collect(),
        };
        if self.coding == Coding::Contexts && self.paper.is_none() {
            let rules: Vec<Rule> = rules.into_iter().map(|(rule, _)| rule).collect();
            return contexts::choose(pyramid, coefficients, &rules, quantised);
        }
        for (band, (rule, dead)) in pyramid.bands().iter().zip(rules) {
            let pairs = quantised[band.range()].par_iter_mut().zip(&coefficients[band.range()]);
            pairs.for_each(|(q, c)| *q = quantiser::quantised(*c, rule, dead));
        }
        self.coding.coder().encode(pyramid, quantised)
    }
}
