//! A checked stream of `raw`: bricks on the CPU, and the data of the shader.

use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, TexelFormat, WgslModule, check_stream};
use cvr_core::container::EncodedVolume;
use cvr_core::kit::{PartedTensor, StreamReader};
use cvr_core::volume::{BrickKey, FrameIndex, Level, ValueRange, VolumeLayout};

use crate::decode::Frame;
use crate::form::{Form, Kind, Parameters};
use crate::{INFO, SAMPLES};

/// A stream that is read.
#[derive(Debug)]
pub struct Reader {
    layout: VolumeLayout,
    form: Form,
    range: ValueRange,
    samples: PartedTensor,
}

impl Reader {
    pub fn open(volume: &EncodedVolume) -> Result<Self, DecodeError> {
        check_stream(volume, &INFO)?;
        let layout = volume.spec().layout.clone();
        let Parameters { bits, range } = volume.parameters()?;
        let ordered = range.min.is_finite() && range.max.is_finite() && range.min <= range.max;
        let form = Form::new(bits, layout.sample, range);
        if !ordered || !form.step.is_finite() {
            return Err(DecodeError::Corrupt(format!("a value range of {} to {}", range.min, range.max)));
        }
        let shape = [u64::from(layout.frames), form.words_per_frame(&layout)];
        let samples = PartedTensor::open(volume, SAMPLES, &shape)?;
        if let Some(word) = samples.words().iter().position(|word| !is_finite(form.kind, *word)) {
            return Err(DecodeError::Corrupt(format!("word {word} of `{SAMPLES}` holds no finite number")));
        }
        Ok(Self { layout, form, range, samples })
    }
}

/// Whether all values of a word are finite. Encoders write only finite values.
const fn is_finite(kind: Kind, word: u32) -> bool {
    const HALF: u32 = 0x7c00;
    match kind {
        Kind::Single => f32::from_bits(word).is_finite(),
        Kind::Half => word & HALF != HALF && (word >> 16) & HALF != HALF,
        Kind::Unsigned | Kind::Signed | Kind::Scaled => true,
    }
}

impl StreamReader for Reader {
    type Frame<'a> = Frame<'a>;

    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn frame(&self, frame: FrameIndex, _level: Level) -> Frame<'_> {
        let (samples, VolumeLayout { extent, channels, .. }) =
            (self.samples.part(frame.0 as usize), &self.layout);
        Frame { samples, form: self.form, extent: *extent, channels: *channels }
    }

    fn range(&self, _key: BrickKey) -> Option<ValueRange> {
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

    /// The shader counts samples in 32 bits.
    fn fits_a_shader(&self) -> bool {
        self.layout.samples_per_frame() <= u64::from(u32::MAX)
    }

    fn module(&self) -> WgslModule<'_> {
        WgslModule::new("codecs/raw/src/decode.wgsl", include_str!("decode.wgsl"))
            .with("bits", self.form.bits)
            .with("lanes_log2", self.form.lanes_log2)
            .with("kind", self.form.kind as u32)
            .with("offset", self.form.offset)
            .with("step", self.form.step)
            .with("high", self.form.high)
            .with("extent", self.layout.extent)
            .with("channels", self.layout.channels)
    }

    fn agreement(&self) -> Agreement {
        match self.form.kind {
            // A fused multiply-add omits one rounding of the product: half an ulp of at most twice the magnitude.
            Kind::Scaled => Agreement::Ulp(2),
            _ => Agreement::Exact,
        }
    }

    fn buffers(&self, frame: FrameIndex) -> Vec<Resource<'_>> {
        vec![self.samples.resource(frame.0 as usize)]
    }
}
