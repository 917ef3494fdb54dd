//! A checked stream of whole volumes.

use std::sync::Arc;

use cvr_core::codec::{
    DecodeError, DecodedForm, DecodedFrame, Decoder, FrameDecode, LatestFrame, check_key_at,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::memory;
use cvr_core::volume::{BrickKey, FrameIndex, Level, ReferenceFrames, ValueRange, VolumeLayout};

use crate::decode::Shared;
use crate::passes::text::Texts;
use crate::stream::parameters::{CHUNKS, LENGTHS, MOST_DECOMPOSITIONS, Parameters, STEPS};
use crate::stream::pyramid::Pyramid;

/// Decodes a stream of whole volumes.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    pub(crate) shared: Shared,
    chunks: Tensor,
    /// Start of each chunk, and the end of the last.
    starts: Vec<usize>,
    /// Steps of all frames and channels.
    pub(crate) steps: Vec<f32>,
    /// The frame used last. All boxes of a frame share its transform.
    latest: LatestFrame,
    /// Of the passes on a device.
    pub(crate) texts: Texts,
}

impl Reader {
    /// # Errors
    /// When the stream contradicts itself.
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        let corrupt = |problem: String| Err(DecodeError::Corrupt(problem));
        let layout = volume.spec().layout.clone();
        let parameters: Parameters = volume.parameters()?;
        let Parameters { filter, decompositions, coder, paper, correction, range, .. } = parameters;
        if parameters.extent != layout.extent.to_array() {
            let [x, y, z] = parameters.extent;
            return corrupt(format!("coefficients of {x}×{y}×{z} voxels in a volume of {}", layout.extent));
        }
        if decompositions > MOST_DECOMPOSITIONS {
            return corrupt(format!(
                "{decompositions} decompositions; there are at most {MOST_DECOMPOSITIONS}"
            ));
        }
        if !(range.min.is_finite() && range.max.is_finite() && range.min <= range.max) {
            return corrupt(format!("a value range of {} to {}", range.min, range.max));
        }
        if correction.is_some_and(|unit| !unit.is_finite() || unit <= 0.0) {
            return corrupt(format!("corrections in units of {correction:?}"));
        }
        if filter.is_integer() && (!layout.sample.is_integer() || paper.is_some()) {
            return corrupt("filter 5-3 without integers".to_owned());
        }
        if layout.samples_per_frame() > i32::MAX as u64 {
            return corrupt(format!("a frame of {} voxels", layout.extent));
        }
        let extent = layout.extent.to_array().map(|n| n as usize);
        let pyramid = Pyramid::new(extent, decompositions as usize, filter.pads());
        let shared = Shared { filter, pyramid, coding: coder, paper, correction, range };
        let channels = u64::from(layout.frames) * u64::from(layout.channels);
        let lengths =
            volume.tensor_of_shape(LENGTHS, Element::U32, &[channels, shared.chunks() as u64])?.words();
        let total: u64 = lengths.iter().map(|n| u64::from(*n)).sum();
        let chunks = volume.tensor_of_shape(CHUNKS, Element::U8, &[total + 1])?.clone();
        let mut starts = vec![0];
        starts.extend(lengths.iter().scan(0, |at, n| {
            *at += *n as usize;
            Some(*at)
        }));
        let steps = volume.tensor_of_shape(STEPS, Element::U32, &[channels])?.words();
        let steps: Vec<f32> = steps.iter().map(|bits| f32::from_bits(*bits)).collect();
        if let Some(step) = steps.iter().find(|step| !step.is_finite() || **step < 0.0) {
            return corrupt(format!("a step of {step}"));
        }
        let texts = Texts::new(filter);
        Ok(Self { layout, shared, chunks, starts, steps, latest: LatestFrame::default(), texts })
    }

    /// Number of resolutions, the full one included.
    pub(crate) fn resolutions(&self) -> u8 {
        self.shared.pyramid.levels() as u8 + 1
    }

    /// Channel `channel` of a frame, among all.
    pub(crate) fn number(&self, frame: FrameIndex, channel: usize) -> usize {
        frame.0 as usize * self.layout.channels as usize + channel
    }

    /// The chunks of a channel.
    pub(crate) fn chunks(&self, number: usize) -> Vec<&[u8]> {
        let count = self.shared.chunks();
        let starts = &self.starts[number * count..=(number + 1) * count];
        starts.windows(2).map(|ends| &self.chunks.bytes()[ends[0]..ends[1]]).collect()
    }

    /// The whole frame at a resolution.
    fn frame(&self, frame: FrameIndex, resolution: u8) -> Result<Arc<DecodedFrame>, DecodeError> {
        let level = Level { resolution, ..Level::FULL };
        self.latest.get((frame, level), || self.decoded(frame, resolution))
    }

    fn decoded(&self, frame: FrameIndex, resolution: u8) -> Result<DecodedFrame, DecodeError> {
        let (channels, at) = (self.layout.channels as usize, usize::from(resolution));
        let layout = self.layout.at_resolution(resolution);
        let what = || format!("a decoded frame of {} voxels", layout.extent);
        memory::check(4 * layout.samples_per_frame(), what)?;
        let channel = |channel: usize| -> Result<Vec<f32>, DecodeError> {
            let number = self.number(frame, channel);
            let chunks = self.chunks(number);
            let coefficients = self.shared.coefficients(at, &chunks)?;
            let corrections = self.shared.corrections(at, &chunks)?;
            Ok(self.shared.samples(at, self.steps[number], &coefficients, &corrections))
        };
        let values = if channels == 1 {
            channel(0)?
        } else {
            let mut values = vec![0.0; layout.samples_per_frame() as usize];
            for c in 0..channels {
                let samples = channel(c)?;
                values.iter_mut().skip(c).step_by(channels).zip(samples).for_each(|(to, v)| *to = v);
            }
            values
        };
        DecodedFrame::new(layout, values)
            .ok_or_else(|| DecodeError::Corrupt("a frame of another size than its volume".to_owned()))
    }
}

impl Decoder for Reader {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn kept_frame(&self, frame: FrameIndex, level: Level) -> Result<Option<Arc<DecodedFrame>>, DecodeError> {
        let region = cvr_core::volume::Region::whole(self.layout.at_resolution(level.resolution).extent);
        check_key_at(&self.layout, self.resolutions(), BrickKey { frame, level, region })?;
        self.frame(frame, level.resolution).map(Some)
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        _: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        check_key_at(&self.layout, self.resolutions(), key)?;
        self.frame(key.frame, key.level.resolution)?.copy_region(key.region, out);
        Ok(())
    }

    fn rebuilds_frames(&self) -> bool {
        true
    }

    fn value_range(&self, _: BrickKey) -> Option<ValueRange> {
        Some(self.shared.range)
    }

    /// The low band lies at `2^r i + c (2^r − 1)`, where `c` is the place of the first low coefficient after one transform.
    fn coarse_shift(&self, resolution: u8) -> f32 {
        let part = 1.0 - 0.5_f64.powi(i32::from(resolution));
        ((0.5 - self.shared.filter.low_centre()) * part) as f32
    }

    fn decoded_form(&self) -> DecodedForm {
        if self.shared.filter.is_integer() {
            DecodedForm::of(self.layout.sample)
        } else {
            DecodedForm::FLOAT32
        }
    }

    fn frame_decode(&self) -> Option<&dyn FrameDecode> {
        Some(self)
    }
}
