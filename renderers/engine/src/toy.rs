//! A codec for tests: words that are the values.

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, Constant, ConstantValue, DecodeError, DecodedForm, Decoder, Resource, ShaderDecode,
    TexelFormat, WgslModule,
};
use cvr_core::volume::{BrickKey, Extent, FrameIndex, ReferenceFrames, SampleType, VolumeLayout};

pub(crate) const SNIPPET: &str = "\
fn toy_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let first = ((v.z * toy_extent.y + v.y) * toy_extent.x + v.x) * toy_channels;
    var value = vec4<f32>(0.0);
    for (var c = 0u; c < toy_channels; c++) {
        value[c] = f32(toy_data(first + c));
    }
    return value;
}
fn toy_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    var cell: array<vec4<f32>, 8>;
    for (var i = 0; i < 8; i++) {
        cell[i] = toy_fetch(select(p, q, (vec3<i32>(i, i >> 1u, i >> 2u) & vec3<i32>(1)) == vec3<i32>(1)));
    }
    return cell;
}
";

/// Decodes nothing: its words are its values, below 2^16.
#[derive(Debug)]
pub(crate) struct Toy {
    pub(crate) layout: VolumeLayout,
    pub(crate) words: Vec<u32>,
    pub(crate) snippet: &'static str,
    pub(crate) form: DecodedForm,
}

impl Toy {
    /// Values that differ between neighbouring voxels.
    pub(crate) fn new(extent: [u32; 3], channels: u32) -> Self {
        let extent = Extent::try_from(extent).unwrap();
        let layout = VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::U16) };
        let words = (0..layout.samples_per_frame()).map(|i| (i * 40_503 % 65_521) as u32).collect();
        let form = DecodedForm { format: TexelFormat::Unorm16, scale: 65535.0, offset: 0.0 };
        Self { layout, words, snippet: SNIPPET, form }
    }

    pub(crate) fn values(&self) -> Vec<f32> {
        self.words.iter().map(|&word| word as f32).collect()
    }
}

impl Decoder for Toy {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn decode_brick(&self, _: BrickKey, _: &dyn ReferenceFrames, _: &mut [f32]) -> Result<(), DecodeError> {
        Err(DecodeError::Corrupt("the toy decodes in shaders only".to_owned()))
    }

    fn decoded_form(&self) -> DecodedForm {
        self.form
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        (!self.snippet.is_empty()).then_some(self)
    }
}

impl ShaderDecode for Toy {
    fn module(&self) -> WgslModule<'_> {
        let extent = ConstantValue::Vec3U32(self.layout.extent.to_array());
        let channels = ConstantValue::U32(self.layout.channels);
        let constants =
            vec![Constant { name: "extent", value: extent }, Constant { name: "channels", value: channels }];
        WgslModule { file: "toy/decode.wgsl", source: self.snippet, constants }
    }

    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }

    fn resources(&self, _: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        Ok(vec![Resource { name: "data", words: Cow::Borrowed(&self.words) }])
    }
}
