//! The decoder: bricks on the CPU, and what a shader needs.

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, Constant, ConstantValue, DecodeError, DecodedForm, Decoder, Resource, ShaderDecode,
    TexelFormat, WgslModule, check_key, check_stream,
};
use cvr_core::container::{Element, EncodedVolume, Tensor};
use cvr_core::volume::{BrickKey, FrameIndex, ReferenceFrames, ValueRange, VolumeLayout};

use crate::decode::{code, half, value};
use crate::form::{Form, Kind, Parameters};
use crate::{INFO, SAMPLES};

/// Decodes a stream of `raw`.
#[derive(Debug)]
pub struct RawDecoder {
    layout: VolumeLayout,
    form: Form,
    range: ValueRange,
    samples: Tensor,
    words_per_frame: usize,
}

impl RawDecoder {
    pub fn new(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let Parameters { bits, range } = volume.parameters()?;
        let ordered = range.min.is_finite() && range.max.is_finite() && range.min <= range.max;
        let form = Form::new(bits, layout.sample, range);
        if !ordered || !form.step.is_finite() {
            return Err(DecodeError::Corrupt(format!("a value range of {} to {}", range.min, range.max)));
        }
        let words = form.words_per_frame(&layout);
        let shape = [u64::from(layout.frames), words];
        let samples = volume.tensor_of_shape(SAMPLES, Element::U32, &shape)?.clone();
        if let Some(word) = samples.words().iter().position(|word| !is_finite(form.kind, *word)) {
            return Err(DecodeError::Corrupt(format!("word {word} of `{SAMPLES}` holds no finite number")));
        }
        Ok(Self { layout, form, range, samples, words_per_frame: words as usize })
    }

    fn frame(&self, frame: FrameIndex) -> &[u32] {
        let at = frame.0 as usize * self.words_per_frame;
        &self.samples.words()[at..at + self.words_per_frame]
    }
}

/// Whether what a word holds is finite: no encoder writes anything else.
const fn is_finite(kind: Kind, word: u32) -> bool {
    const HALF: u32 = 0x7c00;
    match kind {
        Kind::Single => f32::from_bits(word).is_finite(),
        Kind::Half => word & HALF != HALF && (word >> 16) & HALF != HALF,
        Kind::Unsigned | Kind::Signed | Kind::Scaled => true,
    }
}

impl Decoder for RawDecoder {
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
        let channels = self.layout.channels as usize;
        assert_eq!(
            out.len() as u64,
            key.region.extent.voxels() * channels as u64,
            "output of the wrong size"
        );
        let row = key.region.extent.x() as usize * channels;
        let (samples, form) = (self.frame(key.frame), self.form);
        let rows = key.region.rows().zip(out.chunks_exact_mut(row));
        // One loop per kind, so that the inner loop has no branch.
        macro_rules! fill {
            ($value:expr) => {
                for (start, out) in rows {
                    let first = self.layout.extent.index(start) * channels;
                    for (k, out) in out.iter_mut().enumerate() {
                        *out = $value(code(&form, samples, first + k));
                    }
                }
            };
        }
        match form.kind {
            Kind::Unsigned => fill!(|code| code as f32),
            Kind::Single => fill!(f32::from_bits),
            Kind::Half => fill!(half),
            Kind::Signed | Kind::Scaled => fill!(|code| value(&form, code)),
        }
        Ok(())
    }

    fn value_range(&self, _key: BrickKey) -> Option<ValueRange> {
        Some(self.range)
    }

    fn decoded_form(&self) -> DecodedForm {
        let form = |format, scale, offset| DecodedForm { format, scale, offset };
        match (self.form.kind, self.layout.sample) {
            // A constant volume has no range to scale texels over.
            (Kind::Scaled, _) if self.range.span() == 0.0 => DecodedForm::FLOAT32,
            (Kind::Scaled, _) => form(TexelFormat::Unorm8, self.range.span() as f32, self.range.min),
            (Kind::Half, _) => form(TexelFormat::Float16, 1.0, 0.0),
            (_, sample) => DecodedForm::of(sample),
        }
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        // The shader counts samples in 32 bits.
        (self.layout.samples_per_frame() <= u64::from(u32::MAX)).then_some(self as &dyn ShaderDecode)
    }
}

impl ShaderDecode for RawDecoder {
    fn module(&self) -> WgslModule<'_> {
        let u32 = |name, value| Constant { name, value: ConstantValue::U32(value) };
        let f32 = |name, value| Constant { name, value: ConstantValue::F32(value) };
        let extent = ConstantValue::Vec3U32(self.layout.extent.to_array());
        WgslModule {
            file: "codecs/raw/src/decode.wgsl",
            source: include_str!("decode.wgsl"),
            constants: vec![
                u32("bits", self.form.bits),
                u32("lanes_log2", self.form.lanes_log2),
                u32("kind", self.form.kind as u32),
                f32("offset", self.form.offset),
                f32("step", self.form.step),
                f32("high", self.form.high),
                Constant { name: "extent", value: extent },
                u32("channels", self.layout.channels),
            ],
        }
    }

    fn agreement(&self) -> Agreement {
        match self.form.kind {
            // A fused multiply-add saves one rounding of the product, half an ulp of at most twice the magnitude.
            Kind::Scaled => Agreement::Ulp(2),
            _ => Agreement::Exact,
        }
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        if frame.0 >= self.layout.frames {
            return Err(DecodeError::NoSuchBrick(format!("frame {} of {}", frame.0, self.layout.frames)));
        }
        Ok(vec![Resource { name: SAMPLES, words: Cow::Borrowed(self.frame(frame)) }])
    }
}
