//! A codec for tests that has no snippet: an integer Haar transform, which a device undoes by passes over two scratch
//! buffers. Lossless, for integers.

mod passes;
mod transform;

use std::sync::Arc;

use cvr_core::codec::*;
use cvr_core::container::{Element, EncodedVolume, StreamWriter};
use cvr_core::volume::*;

pub use passes::{Pass, Passes};

/// The codec.
#[derive(Debug)]
pub struct Haar {
    info: CodecInfo,
    /// What the device runs, of every stream.
    pub passes: Passes,
}

impl Haar {
    /// A volume through the codec, with a decoder whose passes can be changed.
    pub fn encoded(levels: i64, volume: &FiniteVolume) -> HaarDecoder {
        let haar = Self::default();
        let settings: Settings = [("levels".to_owned(), SettingValue::Integer(levels))].into_iter().collect();
        let stream = encode_temporary(&haar, &settings, volume).unwrap();
        haar.open(&Arc::new(stream)).unwrap()
    }

    fn open(&self, volume: &EncodedVolume) -> Result<HaarDecoder, DecodeError> {
        check_stream(volume, &self.info)?;
        let layout = volume.spec().layout.clone();
        let levels: u32 = volume.parameters()?;
        if levels > 6 {
            return Err(DecodeError::Corrupt(format!("{levels} levels")));
        }
        let shape = [u64::from(layout.frames), layout.samples_per_frame()];
        let coefficients = volume.tensor_of_shape("coefficients", Element::U32, &shape)?.words().to_vec();
        let of_frame = |words: &[u32]| {
            let mut samples: Vec<i32> = words.iter().map(|w| *w as i32).collect();
            transform::inverse(&mut samples, (layout.extent.to_array(), layout.channels), levels);
            samples.into_iter().map(|s| s as f32).collect()
        };
        let samples = layout.samples_per_frame() as usize;
        let frames = coefficients.chunks_exact(samples).map(of_frame).collect();
        Ok(HaarDecoder { layout, levels, coefficients, frames, passes: self.passes.clone() })
    }
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
            settings: &[Setting {
                name: "levels",
                doc: "how often sums are transformed again",
                kind: SettingKind::Integer { min: 0, max: 6 },
                default: "2",
            }],
            methods: &[],
        };
        Self { info, passes: Passes::default() }
    }
}

impl Codec for Haar {
    fn info(&self) -> &CodecInfo {
        &self.info
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        Ok(Box::new(HaarEncoder { levels: settings.integer("levels")? as u32 }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(self.open(&volume)?))
    }
}

#[derive(Debug)]
struct HaarEncoder {
    levels: u32,
}

impl Encoder for HaarEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let layout = source.layout().clone();
        if !layout.sample.is_integer() {
            return Err(EncodeError::Unsupported(format!("integers only, not {}", layout.sample)));
        }
        for frame in (0..layout.frames).map(FrameIndex) {
            let mut values = vec![0.0; layout.samples_per_frame() as usize];
            source.read(frame, Region::whole(layout.extent), &mut values)?;
            let mut samples: Vec<i32> = values.into_iter().map(|v| v as i32).collect();
            transform::forward(&mut samples, (layout.extent.to_array(), layout.channels), self.levels);
            out.append_words("coefficients", &samples.into_iter().map(|s| s as u32).collect::<Vec<_>>())?;
            run.advance(layout.extent.voxels())?;
        }
        out.shape("coefficients", &[u64::from(layout.frames), layout.samples_per_frame()])?;
        out.parameters_of(&self.levels)?;
        Ok(EncodeReport { error_bound: Some(0.0), notes: Vec::new() })
    }
}

/// The decoder, all of whose frames the CPU has decoded.
#[derive(Debug)]
pub struct HaarDecoder {
    layout: VolumeLayout,
    levels: u32,
    coefficients: Vec<u32>,
    frames: Vec<Vec<f32>>,
    /// What the device runs.
    pub passes: Passes,
}

impl Decoder for HaarDecoder {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        _: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        check_key(&self.layout, key)?;
        let channels = self.layout.channels as usize;
        let row = key.region.extent.x() as usize * channels;
        let frame = &self.frames[key.frame.0 as usize];
        for (start, out) in key.region.rows().zip(out.chunks_exact_mut(row)) {
            out.copy_from_slice(&frame[self.layout.extent.index(start) * channels..][..row]);
        }
        Ok(())
    }

    fn rebuilds_frames(&self) -> bool {
        true
    }

    fn decoded_form(&self) -> DecodedForm {
        match self.layout.sample {
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
