//! The encoder: the command gets each channel of each frame as one file.

use std::sync::Arc;

use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::{Element, StreamWriter};
use cvr_core::volume::{BrickSource, FrameIndex, Region, SampleType, VolumeLayout};

use crate::STREAMS;
use crate::command::{Command, Field, RunError};
use crate::decoder::Parameters;
use crate::output::{self, OutputError};
use crate::samples::bytes;
use crate::trust::Trust;

/// Bytes per sample beyond which a compressed file counts as an error and is not read.
const SAMPLE_BYTES: u64 = 8;
/// Bytes in addition to the samples.
const HEADER_BYTES: u64 = 1 << 20;

/// Encodes by a command.
#[derive(Debug)]
pub struct ExternalEncoder {
    pub encode: Command,
    pub decode: Command,
    /// Type of the samples in files. `None` for the volume's own.
    pub sample: Option<SampleType>,
    pub trust: Arc<Trust>,
}

impl Encoder for ExternalEncoder {
    /// A frame in single precision, and one channel of it as in its file.
    fn scratch_bytes(&self, layout: &VolumeLayout) -> u64 {
        let sample = self.sample.unwrap_or(layout.sample);
        layout.samples_per_frame() * 4 + layout.extent.voxels() * sample.bytes() as u64
    }

    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        self.trust.add(&self.decode);
        let layout = source.layout().clone();
        let sample = self.sample.unwrap_or(layout.sample);
        let field = Field { extent: layout.extent, sample };
        let folder = tempfile::tempdir().map_err(|e| external(format!("no temporary folder: {e}")))?;
        let [input, written] = ["samples", "compressed"].map(|name| folder.path().join(name));
        let channels = layout.channels as usize;
        let mut values = vec![0.0; layout.samples_per_frame() as usize];
        let longest = layout.extent.voxels().saturating_mul(SAMPLE_BYTES).saturating_add(HEADER_BYTES);
        let mut lengths = Vec::new();
        for frame in (0..layout.frames).map(FrameIndex) {
            source.read(frame, Region::whole(layout.extent), &mut values)?;
            for channel in 0..channels {
                let samples = values.iter().skip(channel).step_by(channels).copied();
                output::write(&input, &bytes(samples, sample))
                    .map_err(|e| external(format!("{}: {e}", input.display())))?;
                // Without this, a command that writes nothing would succeed with the output of the one before.
                _ = std::fs::remove_file(&written);
                self.encode.run(field, [&input, &written], folder.path(), || run.advance(0)).map_err(
                    |e| match e {
                        RunError::Cancelled => EncodeError::Cancelled,
                        other => external(other.to_string()),
                    },
                )?;
                let said =
                    |problem: &dyn std::fmt::Display| external(format!("`{}` {problem}", self.encode.text()));
                let stream = output::read(&written, 0..=longest).map_err(|e| match e {
                    OutputError::Size(_) => said(&format!(
                        "{e}; a compressed file of {} voxels has {longest} at most",
                        layout.extent
                    )),
                    other => said(&other),
                })?;
                if stream.is_empty() {
                    return Err(said(&OutputError::Missing));
                }
                out.append(STREAMS, Element::U8, &stream)?;
                lengths.push(stream.len() as u64);
            }
            run.advance(layout.extent.voxels())?;
        }
        out.shape(STREAMS, &[lengths.iter().sum()])?;
        out.parameters_of(&Parameters {
            decode: self.decode.text().to_owned(),
            value: self.decode.value(),
            timeout_seconds: self.decode.timeout().as_secs(),
            sample,
            extent: layout.extent.to_array(),
            lengths,
        })?;
        let note = "times are those of whole processes, one for each frame and channel: their start counts";
        Ok(EncodeReport { error_bound: None, notes: vec![note.to_owned()] })
    }
}

fn external(problem: String) -> EncodeError {
    EncodeError::Failed(problem)
}
