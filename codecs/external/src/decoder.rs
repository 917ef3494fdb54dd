//! The decoder: it decodes whole frames with the command in the stream, if that command is trusted.

use std::time::Duration;

use cvr_core::codec::{
    DecodeError, DecodedForm, DecodedFrame, Decoder, LatestFrame, check_key, check_stream,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::memory::{self, Held};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ReferenceFrames, SampleType, VolumeLayout};
use serde::{Deserialize, Serialize};

use crate::command::{Command, Field};
use crate::output::{self, OutputError};
use crate::samples::read_values;
use crate::trust::Trust;
use crate::{INFO, STREAMS};

/// The decode parameters in the container.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// The command, placeholders and all.
    pub decode: String,
    /// Replacement of `{value}`.
    pub value: f64,
    /// How long it may run.
    pub timeout_seconds: u64,
    /// Type of the samples that the command writes.
    pub sample: SampleType,
    /// Voxels of each field along x, y, z. It must equal the volume's own shape before the command runs, because the
    /// effect of a wrong shape is unknown.
    pub extent: [u32; 3],
    /// Bytes of each compressed file: the channels of the first frame, of the second, and so on.
    pub lengths: Vec<u64>,
}

/// Decodes a stream of `external`.
#[derive(Debug)]
pub struct ExternalDecoder {
    layout: VolumeLayout,
    command: Command,
    sample: SampleType,
    streams: Tensor,
    /// Start of each compressed file, and the end of the last.
    starts: Vec<usize>,
    /// The frame used last. All bricks of a frame share one run of the command, in any thread.
    latest: LatestFrame,
}

impl ExternalDecoder {
    pub fn new(volume: &EncodedVolume, trust: &Trust) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let Parameters { decode, value, timeout_seconds, sample, extent, lengths } = volume.parameters()?;
        let timeout = Duration::from_secs(timeout_seconds);
        let command = Command::parse(&decode, value, timeout)
            .map_err(|e| DecodeError::Corrupt(format!("the command `{decode}`: {e}")))?;
        trust.check(&command)?;
        if extent != layout.extent.to_array() {
            let [x, y, z] = extent;
            let problem = format!("fields of {x}×{y}×{z} voxels in a volume of {}", layout.extent);
            return Err(DecodeError::Corrupt(problem));
        }
        let files = u64::from(layout.frames) * u64::from(layout.channels);
        if lengths.len() as u64 != files {
            let problem = format!("{} compressed files for {files} frames and channels", lengths.len());
            return Err(DecodeError::Corrupt(problem));
        }
        let total = lengths.iter().try_fold(0_u64, |sum, n| sum.checked_add(*n));
        let total = total.ok_or_else(|| DecodeError::Corrupt("lengths overflow".to_owned()))?;
        let streams = volume.tensor_of_shape(STREAMS, Element::U8, &[total])?.clone();
        let mut starts = vec![0];
        starts.extend(lengths.iter().scan(0, |at, n| {
            *at += *n as usize;
            Some(*at)
        }));
        Ok(Self { layout, command, sample, streams, starts, latest: LatestFrame::default() })
    }

    /// A whole frame, channels interleaved.
    fn decoded(&self, frame: FrameIndex) -> Result<DecodedFrame, DecodeError> {
        let channels = self.layout.channels as usize;
        let field = Field { extent: self.layout.extent, sample: self.sample };
        let failed = |problem: String| DecodeError::Failed(problem);
        let folder = tempfile::tempdir().map_err(|e| failed(format!("no temporary folder: {e}")))?;
        let [input, written] = ["compressed", "samples"].map(|name| folder.path().join(name));
        let what = || format!("a frame of {} voxels that a command decodes", self.layout.extent);
        let mut frame_values: Vec<f32> = memory::zeroed(self.layout.samples_per_frame(), what)?;
        let held = Held::of(&frame_values);
        for channel in 0..channels {
            let file = frame.0 as usize * channels + channel;
            let stream = &self.streams.bytes()[self.starts[file]..self.starts[file + 1]];
            output::write(&input, stream).map_err(|e| failed(format!("{}: {e}", input.display())))?;
            _ = std::fs::remove_file(&written);
            let run = self.command.run(field, [&input, &written], folder.path(), || Ok(()));
            run.map_err(|e| failed(e.to_string()))?;
            let expected = self.layout.extent.voxels() * self.sample.bytes() as u64;
            let to = frame_values.iter_mut().skip(channel).step_by(channels);
            let read = output::open(&written, expected..=expected)
                .and_then(|(file, _)| Ok(read_values(file, self.sample, to)?));
            read.map_err(|e| {
                let (text, sample) = (self.command.text(), self.sample);
                failed(match e {
                    OutputError::Size(_) | OutputError::Missing => {
                        format!("`{text}` {e}; {} voxels of {sample} are {expected}", self.layout.extent)
                    }
                    other => format!("`{text}` {other}"),
                })
            })?;
            let mut of_channel = frame_values.iter().skip(channel).step_by(channels);
            if let Some(value) = of_channel.find(|v| !v.is_finite()) {
                return Err(failed(format!("`{}` wrote a sample of {value}", self.command.text())));
            }
        }
        drop(held);
        DecodedFrame::new(self.layout.clone(), frame_values)
            .ok_or_else(|| failed("a frame of another size than its volume".to_owned()))
    }
}

impl Decoder for ExternalDecoder {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        _references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        check_key(&self.layout, key)?;
        let frame = self.latest.get((key.frame, Level::FULL), || self.decoded(key.frame))?;
        frame.copy_region(key.region, out);
        Ok(())
    }

    fn rebuilds_frames(&self) -> bool {
        true
    }

    fn decoded_form(&self) -> DecodedForm {
        DecodedForm::of(self.sample)
    }
}
