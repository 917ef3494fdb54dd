//! Every texel format, in chunks and as a whole.

use cvr_core::codec::{Agreement, DecodeError, DecodedForm, Resource, ShaderDecode, TexelFormat, WgslModule};
use cvr_core::shader::BindingLimits;
use cvr_core::volume::{BrickKey, ReferenceFrames, VolumeLayout};

use super::*;
use crate::testing::test_device;
use crate::toy::Toy;

/// The toy, to be kept in another form.
#[derive(Debug)]
struct Formed(Toy, DecodedForm);

impl Decoder for Formed {
    fn layout(&self) -> &VolumeLayout {
        self.0.layout()
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        self.0.decode_brick(key, references, out)
    }

    fn decoded_form(&self) -> DecodedForm {
        self.1
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        Some(self)
    }
}

impl ShaderDecode for Formed {
    fn module(&self) -> WgslModule<'_> {
        self.0.module()
    }

    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        self.0.resources(frame)
    }
}

fn form(format: TexelFormat, scale: f32, offset: f32) -> DecodedForm {
    DecodedForm { format, scale, offset }
}

fn decode(device: &Device, toy: &Formed) -> (VolumeTexture, usize) {
    let decoder = FrameDecoder::new(device, "toy", toy, FrameIndex::FIRST, Level::FULL).unwrap();
    decoder.decode().unwrap();
    (decoder.texture().clone(), decoder.slabs.iter().count())
}

/// Compares the texels bit for bit with those that the CPU would upload.
fn assert_as_uploaded(device: &Device, toy: &Formed) {
    let (decoded, _) = decode(device, toy);
    let uploaded = VolumeTexture::upload(device, toy.layout(), &toy.0.values(), toy.1).unwrap();
    let [decoded, uploaded] = [&decoded, &uploaded].map(|texture| texture.read(device).unwrap());
    assert!(decoded == uploaded, "{:?} {:?}", toy.0.layout, toy.1);
}

#[test]
fn every_form_holds_what_the_cpu_would_upload() {
    let Some(device) = test_device("decoding::forms") else { return };
    for (extent, channels) in [([1, 1, 1], 1), ([13, 17, 23], 1), ([130, 3, 2], 1), ([13, 17, 3], 3)] {
        for form in [
            form(TexelFormat::Unorm8, 255.0, 0.0),
            form(TexelFormat::Unorm8, 65535.0, 0.0),
            form(TexelFormat::Unorm16, 65535.0, 0.0),
            form(TexelFormat::Unorm16, 65535.0, -32768.0),
            form(TexelFormat::Float16, 1.0, 0.0),
            form(TexelFormat::Float16, 1_048_576.0, 0.0),
            DecodedForm::FLOAT32,
        ] {
            let mut toy = Toy::new(extent, channels);
            // The largest finite half.
            toy.words.iter_mut().for_each(|word| *word = (*word).min(65504));
            assert_as_uploaded(device, &Formed(toy, form));
        }
    }
}

#[test]
fn every_half_keeps_its_bits() {
    let Some(device) = test_device("decoding::halves") else { return };
    // All 16-bit patterns as singles. Finite halves, also subnormal ones, are kept.
    const SNIPPET: &str = "\
fn toy_fetch(p: vec3<i32>) -> vec4<f32> {
    return vec4<f32>(bitcast<f32>(toy_data(u32(p.x) + 64u * (u32(p.y) + 32u * u32(p.z)))), 0.0, 0.0, 0.0);
}
";
    let halves =
        (0..=u16::MAX).map(half::f16::from_bits).map(|h| if h.is_finite() { h } else { half::f16::ZERO });
    let words: Vec<u32> = halves.clone().map(|h| h.to_f32().to_bits()).collect();
    let toy = Formed(
        Toy { words, snippet: SNIPPET, ..Toy::new([64, 32, 32], 1) },
        form(TexelFormat::Float16, 1.0, 0.0),
    );
    let (texture, _) = decode(device, &toy);
    let got: Vec<u32> = texture.read(device).unwrap().into_iter().map(f32::to_bits).collect();
    let want: Vec<u32> = halves.map(|h| h.to_f32().to_bits()).collect();
    let zero = |bits: &u32| bits << 1 == 0;
    assert!(got.iter().zip(&want).all(|(got, want)| got == want || zero(got) && zero(want)));
}

#[test]
fn slabs_do_not_show() {
    let Some(device) = test_device("decoding::slabs") else { return };
    let toy = Formed(Toy::new([13, 17, 23], 1), DecodedForm::FLOAT32);
    let (whole, one) = decode(device, &toy);
    assert_eq!(one, 1);
    // Rows of 64 words, slices of 1088: five slices, one slice, and 12 of 17 rows at a time.
    for (storage_words, count) in [(5500, 5), (1100, 23), (800, 46)] {
        let small = device.with_binding_limits(BindingLimits { storage_words, storage_buffers: 8 });
        let (cut, slabs) = decode(&small, &toy);
        assert_eq!(slabs, count);
        assert!(cut.read(device).unwrap() == whole.read(device).unwrap(), "{storage_words}");
    }
    let none = device.with_binding_limits(BindingLimits { storage_words: 63, storage_buffers: 200 });
    let toy = Formed(Toy { words: vec![1], ..Toy::new([1; 3], 1) }, DecodedForm::FLOAT32);
    let error = FrameDecoder::new(&none, "toy", &toy, FrameIndex::FIRST, Level::FULL).unwrap_err();
    assert_eq!(error.to_string(), "a row of texels needs 256 bytes, this device offers 252");
}

#[test]
fn large_volumes_pass_through_a_bounded_buffer() {
    let Some(device) = test_device("decoding::large") else { return };
    // 40 MiB: two slabs, the second one cut; there and back.
    let toy = Formed(Toy::new([512, 512, 40], 1), DecodedForm::FLOAT32);
    let (texture, slabs) = decode(device, &toy);
    assert_eq!(slabs, 2);
    assert!(texture.read(device).unwrap() == toy.0.values());
}

#[test]
fn what_stays_resident_is_texels_and_words() {
    let Some(device) = test_device("decoding::resident") else { return };
    let toy = Formed(Toy::new([13, 17, 23], 1), form(TexelFormat::Unorm8, 65535.0, 0.0));
    let (texture, _) = decode(device, &toy);
    let samples = 13 * 17 * 23;
    assert_eq!((texture.bytes(), texture.resident_bytes()), (samples, samples + 4 * samples));
}

#[test]
fn a_codec_without_a_shader_is_refused() {
    let Some(device) = test_device("decoding::no_shader") else { return };
    let toy = Toy { snippet: "", ..Toy::new([2; 3], 1) };
    let error = VolumeTexture::decode(device, "toy", &toy, FrameIndex::FIRST, Level::FULL).unwrap_err();
    assert_eq!(error.to_string(), "codec `toy` does not decode this stream in a shader");
}
