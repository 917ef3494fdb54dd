//! A tiny lossless codec that can be given one flaw.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use serde::{Deserialize, Serialize};

use crate::codec::*;
use crate::container::{Element, EncodedVolume, StreamWriter, Tensor};
use crate::volume::*;

/// A deliberate flaw of the probe codec.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Flaw {
    None,
    EncodeFails,
    RefusesAll,
    ThreadDependent,
    Unrepeatable,
    ReadsSettings,
    OffByOne,
    WrongBound,
    DecodesNan,
    NarrowRange,
    VoxelDiffers,
    UncheckedKey,
    UncheckedTensor,
    UncheckedVersion,
    BadSnippet,
    ForeignName,
    BadPass,
    UncheckedPasses,
    UnlistedPasses,
    NothingDeferred,
    WorseStages,
    StageMissing,
    Inverts,
}

#[derive(Debug)]
pub struct Probe {
    flaw: Flaw,
    info: CodecInfo,
    runs: Arc<AtomicU32>,
}

impl Probe {
    pub fn new(flaw: Flaw) -> Self {
        let info = CodecInfo {
            id: "probe",
            summary: "single-precision samples",
            stream_version: 1,
            decoded_by: match flaw {
                Flaw::NothingDeferred => &[DecodedBy::Passes, DecodedBy::Cpu],
                Flaw::UnlistedPasses => &[DecodedBy::Cpu],
                _ => &[DecodedBy::Shader, DecodedBy::Cpu],
            },
            fetch_cell: false,
            paper: None,
            settings: &[Setting {
                name: "sign",
                doc: "-1 stores negated samples",
                kind: SettingKind::OneOf(&[1, -1]),
                default: "-1",
            }],
            methods: &[],
        };
        Self { flaw, info, runs: Arc::default() }
    }
}

#[derive(Serialize, Deserialize)]
struct Parameters {
    sign: i8,
    range: ValueRange,
}

impl Codec for Probe {
    fn info(&self) -> &CodecInfo {
        &self.info
    }

    fn stages(&self, _: &Settings) -> u8 {
        if matches!(self.flaw, Flaw::WorseStages | Flaw::StageMissing) { 3 } else { 1 }
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let sign = settings.integer("sign")? as i8;
        Ok(Box::new(ProbeEncoder { flaw: self.flaw, sign, runs: Arc::clone(&self.runs) }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        if self.flaw != Flaw::UncheckedVersion {
            check_stream(&volume, &self.info)?;
        }
        let layout = volume.spec().layout.clone();
        let Parameters { mut sign, range } = volume.parameters()?;
        if self.flaw == Flaw::ReadsSettings {
            sign = volume.spec().settings.integer("sign").unwrap_or(1) as i8;
        }
        let shape = [u64::from(layout.frames), layout.samples_per_frame()];
        let samples = if self.flaw == Flaw::UncheckedTensor {
            volume.tensor("samples", Element::U32)?
        } else {
            volume.tensor_of_shape("samples", Element::U32, &shape)?
        };
        let samples = samples.clone();
        Ok(Box::new(ProbeDecoder { flaw: self.flaw, layout, sign: f32::from(sign), range, samples }))
    }
}

#[derive(Debug)]
struct ProbeEncoder {
    flaw: Flaw,
    sign: i8,
    runs: Arc<AtomicU32>,
}

impl Encoder for ProbeEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        match self.flaw {
            Flaw::EncodeFails => return Err(EncodeError::Cancelled),
            Flaw::RefusesAll => return Err(EncodeError::Unsupported("on principle".to_owned())),
            _ => {}
        }
        let notes = match self.flaw {
            Flaw::ThreadDependent => vec![rayon::current_num_threads().to_string()],
            Flaw::Unrepeatable => vec![self.runs.fetch_add(1, Ordering::Relaxed).to_string()],
            _ => Vec::new(),
        };
        let layout = source.layout().clone();
        let mut range = ValueRange { min: f32::MAX, max: f32::MIN };
        for frame in 0..layout.frames {
            let mut values = vec![0.0; layout.samples_per_frame() as usize];
            source.read(FrameIndex(frame), Region::whole(layout.extent), &mut values)?;
            if self.flaw == Flaw::WrongBound {
                values.iter_mut().for_each(|v| *v = (*v / 4.0).round() * 4.0);
            }
            range = ValueRange::of(values.iter().copied()).into_iter().fold(range, ValueRange::union);
            if self.flaw == Flaw::Inverts {
                let ValueRange { min, max } = range_of_frame(&values);
                values.iter_mut().for_each(|v| *v = (min + (max - *v)).clamp(min, max));
            }
            let words: Vec<u32> = values.iter().map(|v| (v * f32::from(self.sign)).to_bits()).collect();
            out.append_words("samples", &words)?;
            run.advance(layout.extent.voxels())?;
        }
        out.shape("samples", &[u64::from(layout.frames), layout.samples_per_frame()])?;
        out.parameters_of(&Parameters { sign: self.sign, range })?;
        let error_bound = match self.flaw {
            Flaw::WrongBound => Some(1.0),
            // It promises nothing, and so breaks no promise.
            Flaw::Inverts => None,
            _ => Some(0.0),
        };
        Ok(EncodeReport { error_bound, notes })
    }
}

fn range_of_frame(values: &[f32]) -> ValueRange {
    ValueRange::of(values.iter().copied()).unwrap_or(ValueRange { min: 0.0, max: 0.0 })
}

#[derive(Debug)]
struct ProbeDecoder {
    flaw: Flaw,
    layout: VolumeLayout,
    sign: f32,
    range: ValueRange,
    samples: Tensor,
}

impl Decoder for ProbeDecoder {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        _: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        match check_key(&self.layout, key) {
            Err(_) if self.flaw == Flaw::UncheckedKey => return Ok(()),
            checked => checked?,
        }
        let n = self.layout.samples_per_frame() as usize;
        let frame = &self.samples.words()[key.frame.0 as usize * n..][..n];
        let channels = self.layout.channels as usize;
        let wrong = self.flaw == Flaw::VoxelDiffers && key.region.extent == Extent::ONE;
        let shift = usize::from(wrong || self.flaw == Flaw::OffByOne);
        let row = key.region.extent.x() as usize * channels;
        for (start, out) in key.region.rows().zip(out.chunks_exact_mut(row)) {
            let first = self.layout.extent.index(start) * channels;
            for (k, out) in out.iter_mut().enumerate() {
                *out = f32::from_bits(frame[(first + k + shift) % n]) * self.sign;
                // The second of three stages is less accurate than the first.
                if self.flaw == Flaw::WorseStages && key.level.stages == 2 {
                    *out += 3.0;
                }
                if self.flaw == Flaw::StageMissing && key.level.stages == 3 {
                    *out += 1.0;
                }
                if self.flaw == Flaw::DecodesNan {
                    *out /= 0.0;
                }
            }
        }
        Ok(())
    }

    fn value_range(&self, _: BrickKey) -> Option<ValueRange> {
        let ValueRange { min, max } = self.range;
        let narrow = self.flaw == Flaw::NarrowRange && min < max;
        Some(ValueRange { min, max: if narrow { max.next_down() } else { max } })
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        let lacks = matches!(self.flaw, Flaw::NothingDeferred | Flaw::UnlistedPasses);
        (!lacks).then_some(self as &dyn ShaderDecode)
    }

    fn frame_decode(&self) -> Option<&dyn FrameDecode> {
        (self.flaw != Flaw::NothingDeferred).then_some(self as &dyn FrameDecode)
    }
}

const SNIPPET: &str = "
fn probe_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let first = ((v.z * probe_extent.y + v.y) * probe_extent.x + v.x) * probe_channels;
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < probe_channels; c++) {
        out[c] = bitcast<f32>(probe_samples(first + c)) * probe_sign;
    }
    return out;
}";

impl ShaderDecode for ProbeDecoder {
    fn module(&self) -> WgslModule<'_> {
        let source = match self.flaw {
            Flaw::BadSnippet => "fn probe_fetch(p: vec3<i32>) -> vec4<f32> { return 1u; }",
            Flaw::ForeignName => concat!(
                "fn other() -> f32 { return 1.0; }\n",
                "fn probe_fetch(p: vec3<i32>) -> vec4<f32> { return vec4<f32>(other()); }"
            ),
            _ => SNIPPET,
        };
        let constants = vec![
            Constant { name: "extent", value: ConstantValue::Vec3U32(self.layout.extent.to_array()) },
            Constant { name: "channels", value: ConstantValue::U32(self.layout.channels) },
            Constant { name: "sign", value: ConstantValue::F32(self.sign) },
        ];
        WgslModule { file: "probe.wgsl", source, constants }
    }

    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        let n = self.layout.samples_per_frame() as usize;
        if frame.0 >= self.layout.frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {}", frame.0)));
        }
        let words = Cow::Borrowed(&self.samples.words()[frame.0 as usize * n..][..n]);
        Ok(vec![Resource { name: "samples", words }])
    }
}

const PASS: &str = "
@compute @workgroup_size(64)
fn probe_copy(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < probe_count {
        probe_set_out(id.x, bitcast<u32>(bitcast<f32>(probe_samples(id.x)) * probe_sign));
    }
}";

impl FrameDecode for ProbeDecoder {
    fn passes(&self, frame: FrameIndex, level: Level) -> Result<FramePasses<'_>, DecodeError> {
        let key = BrickKey { frame, level, region: Region::whole(self.layout.extent) };
        let frame = match check_key(&self.layout, key) {
            Err(_) if self.flaw == Flaw::UncheckedPasses => FrameIndex::FIRST,
            checked => checked.map(|()| frame)?,
        };
        let words = self.layout.samples_per_frame();
        let constants = vec![
            Constant { name: "count", value: ConstantValue::U32(words as u32) },
            Constant { name: "sign", value: ConstantValue::F32(self.sign) },
        ];
        let source = if self.flaw == Flaw::BadPass { "fn probe_copy() {}" } else { PASS };
        let pass = FramePass {
            module: WgslModule { file: "probe_copy.wgsl", source, constants },
            entry: "copy",
            workgroups: [words.div_ceil(64) as u32, 1, 1],
            scratch: vec![ScratchUse { name: "out", buffer: "values" }],
        };
        Ok(FramePasses {
            resources: self.resources(frame)?,
            scratch: vec![Scratch { name: "values", words }],
            passes: vec![pass],
            result: "values",
        })
    }

    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }
}
