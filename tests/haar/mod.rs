//! A codec for tests, without a snippet: an integer Haar transform. A device inverts it by passes over two scratch
//! buffers. It is lossless for integers. Frames of a group are predicted from the frame before. A volume has a second
//! resolution: the sums of its finest level.

mod passes;
mod transform;

use std::sync::Arc;

use cvr_core::codec::*;
use cvr_core::container::{Element, EncodedVolume, StreamWriter};
use cvr_core::volume::*;
use serde::{Deserialize, Serialize};

pub use passes::{Pass, Passes};

/// The codec.
#[derive(Debug)]
pub struct Haar {
    info: CodecInfo,
    /// The passes of the device, for every stream.
    pub passes: Passes,
    /// The frame from which a predicted frame is predicted: the one before it. Tests change it.
    pub predicted_from: fn(u32) -> u32,
}

/// Parameters of a stream.
#[derive(Copy, Clone, Debug, Serialize, Deserialize)]
struct Parameters {
    /// How often sums are transformed again.
    levels: u32,
    /// Frames of a group: one that decodes on its own, and the following ones.
    group: u32,
}

impl Haar {
    /// A volume through the codec, with a decoder whose passes can be changed.
    pub fn encoded(levels: i64, volume: &FiniteVolume) -> HaarDecoder {
        Self::in_groups(levels, 1, volume)
    }

    /// The same with groups of `group` frames.
    pub fn in_groups(levels: i64, group: i64, volume: &FiniteVolume) -> HaarDecoder {
        let haar = Self::default();
        let settings = [("levels", levels), ("group", group)];
        let settings: Settings = settings
            .map(|(name, value)| (name.to_owned(), SettingValue::Integer(value)))
            .into_iter()
            .collect();
        let stream = encode_temporary(&haar, &settings, volume).unwrap();
        haar.open(&Arc::new(stream)).unwrap()
    }

    fn open(&self, volume: &EncodedVolume) -> Result<HaarDecoder, DecodeError> {
        check_stream(volume, &self.info)?;
        let layout = volume.spec().layout.clone();
        let Parameters { levels, group } = volume.parameters()?;
        if levels > 6 || group == 0 {
            return Err(DecodeError::Corrupt(format!("{levels} levels, groups of {group} frames")));
        }
        let shape = [u64::from(layout.frames), layout.samples_per_frame()];
        let coefficients = volume.tensor_of_shape("coefficients", Element::U32, &shape)?.words().to_vec();
        let samples = layout.samples_per_frame() as usize;
        let at = |resolution: u8| {
            let extent = layout.extent.at_resolution(resolution).to_array();
            let of_frame = |words: &[u32]| {
                let all: Vec<i32> = words.iter().map(|w| *w as i32).collect();
                let mut low = transform::low(&all, (layout.extent.to_array(), layout.channels), extent);
                transform::inverse(&mut low, (extent, layout.channels), levels - u32::from(resolution));
                low.into_iter().map(|s| s as f32).collect()
            };
            coefficients.chunks_exact(samples).map(of_frame).collect()
        };
        let frames = (0..resolutions(levels)).map(at).collect();
        let (passes, predicted_from) = (self.passes.clone(), self.predicted_from);
        Ok(HaarDecoder { layout, levels, group, coefficients, frames, passes, predicted_from })
    }
}

/// Number of resolutions of a volume with this many transforms of its sums.
fn resolutions(levels: u32) -> u8 {
    if levels > 0 { 2 } else { 1 }
}

impl Default for Haar {
    fn default() -> Self {
        let info = CodecInfo {
            id: "haar",
            summary: "integer Haar transform",
            stream_version: 1,
            decoded_by: &[DecodedBy::Passes, DecodedBy::Cpu],
            fetch_cell: false,
            paper: None,
            settings: &[
                Setting {
                    name: "levels",
                    doc: "how often sums are transformed again",
                    kind: SettingKind::Integer { min: 0, max: 6 },
                    default: "2",
                },
                Setting {
                    name: "group",
                    doc: "frames of a group, of which all but the first are predicted from the one before them",
                    kind: SettingKind::Integer { min: 1, max: 64 },
                    default: "1",
                },
            ],
            methods: &[],
        };
        Self { info, passes: Passes::default(), predicted_from: |frame| frame - 1 }
    }
}

impl Codec for Haar {
    fn info(&self) -> &CodecInfo {
        &self.info
    }

    fn resolutions(&self, settings: &Settings) -> u8 {
        resolutions(settings.integer("levels").unwrap_or(0) as u32)
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let [levels, group] = [settings.integer("levels")?, settings.integer("group")?].map(|n| n as u32);
        Ok(Box::new(HaarEncoder(Parameters { levels, group })))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(self.open(&volume)?))
    }
}

#[derive(Debug)]
struct HaarEncoder(Parameters);

impl Encoder for HaarEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let Parameters { levels, group } = self.0;
        let layout = source.layout().clone();
        if !layout.sample.is_integer() {
            return Err(EncodeError::Unsupported(format!("integers only, not {}", layout.sample)));
        }
        let mut before: Vec<i32> = Vec::new();
        for frame in (0..layout.frames).map(FrameIndex) {
            let mut values = vec![0.0; layout.samples_per_frame() as usize];
            source.read(frame, Region::whole(layout.extent), &mut values)?;
            let samples: Vec<i32> = values.into_iter().map(|v| v as i32).collect();
            let mut coded = samples.clone();
            if frame.0 % group > 0 {
                coded.iter_mut().zip(&before).for_each(|(sample, before)| *sample -= before);
            }
            before = samples;
            transform::forward(&mut coded, (layout.extent.to_array(), layout.channels), levels);
            out.append_words("coefficients", &coded.into_iter().map(|s| s as u32).collect::<Vec<_>>())?;
            run.advance(layout.extent.voxels())?;
        }
        out.shape("coefficients", &[u64::from(layout.frames), layout.samples_per_frame()])?;
        out.parameters_of(&self.0)?;
        Ok(EncodeReport { error_bound: Some(0.0), notes: Vec::new() })
    }
}

/// The decoder. The CPU has inverted the transforms of all frames.
#[derive(Debug)]
pub struct HaarDecoder {
    layout: VolumeLayout,
    levels: u32,
    group: u32,
    coefficients: Vec<u32>,
    /// Every frame, by resolution. A predicted frame is stored as the difference from its reference.
    frames: Vec<Vec<Vec<f32>>>,
    /// The passes of the device.
    pub passes: Passes,
    predicted_from: fn(u32) -> u32,
}

impl HaarDecoder {
    fn resolutions(&self) -> u8 {
        resolutions(self.levels)
    }
}

impl Decoder for HaarDecoder {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn dependencies(&self, frame: FrameIndex) -> Dependencies {
        match frame.0 % self.group {
            0 => Dependencies::Intra,
            _ => Dependencies::Predicted(FrameIndex((self.predicted_from)(frame.0))),
        }
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        check_key_at(&self.layout, self.resolutions(), key)?;
        let BrickKey { frame, level, region } = key;
        let extent = self.layout.extent.at_resolution(level.resolution);
        let channels = self.layout.channels as usize;
        let row = region.extent.x() as usize * channels;
        let own = &self.frames[level.resolution as usize][frame.0 as usize];
        let reference = match self.dependencies(frame).frames() {
            [Some(of), _] => {
                let missing = || DecodeError::MissingReference { frame: frame.0, missing: of.0 };
                Some(references.frame(of).ok_or_else(missing)?)
            }
            [None, _] => None,
        };
        for (start, out) in region.rows().zip(out.chunks_exact_mut(row)) {
            let first = extent.index(start) * channels;
            out.copy_from_slice(&own[first..][..row]);
            if let Some(reference) = reference {
                out.iter_mut().zip(&reference[first..]).for_each(|(out, r)| *out += r);
            }
        }
        Ok(())
    }

    fn rebuilds_frames(&self) -> bool {
        true
    }

    fn decoded_form(&self) -> DecodedForm {
        match self.layout.sample {
            // Sums of predicted frames are rounded down in each frame, so they may lie below the volume's range.
            _ if self.group > 1 => DecodedForm::FLOAT32,
            SampleType::U8 => DecodedForm { format: TexelFormat::Unorm8, scale: 255.0, offset: 0.0 },
            SampleType::I8 => DecodedForm { format: TexelFormat::Unorm8, scale: 255.0, offset: -128.0 },
            SampleType::U16 => DecodedForm { format: TexelFormat::Unorm16, scale: 65535.0, offset: 0.0 },
            _ => DecodedForm::FLOAT32,
        }
    }

    fn frame_decode(&self) -> Option<&dyn FrameDecode> {
        Some(self)
    }
}
