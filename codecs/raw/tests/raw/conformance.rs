//! The conformance tests, for every value of the setting.

use std::sync::Arc;

use cvr_core::codec::{DecodedForm, SettingValue, Settings, TexelFormat, encode_temporary};
use cvr_core::conformance;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};

fn with_bits(bits: &str) -> Settings {
    [("bits".to_owned(), SettingValue::from(bits))].into_iter().collect()
}

#[test]
fn native_passes_and_refuses_nothing() {
    let dump = cvr_codec_tests::device::dump("raw::conformance");
    let report = conformance::run(cvr_raw::codec().as_ref(), dump);
    report.assert_ok();
    assert_eq!(report.refused, 0);
}

#[test]
fn eight_bits_and_half_pass() {
    let settings = [with_bits("8"), with_bits("half")];
    let dump = cvr_codec_tests::device::dump("raw::conformance");
    conformance::run_with(cvr_raw::codec().as_ref(), &settings, dump).assert_ok();
}

/// With eight bits, a range of zero would be a division by zero. The texture of a constant volume holds the value
/// itself.
#[test]
fn a_constant_volume_of_eight_bits_has_a_texel_of_its_own() {
    let form_of = |samples: Vec<u8>| {
        let extent = Extent::new(samples.len() as u32, 1, 1).unwrap();
        let layout = VolumeLayout::scalar(extent, SampleType::U8);
        let volume = FiniteVolume::new(DenseVolume::new(layout, Samples::U8(samples)).unwrap());
        let codec = cvr_raw::codec();
        let stream = encode_temporary(codec.as_ref(), &with_bits("8"), &volume).unwrap();
        codec.decoder(Arc::new(stream)).unwrap().decoded_form()
    };
    assert_eq!(form_of(vec![7; 5]), DecodedForm::FLOAT32);
    assert_eq!(form_of(vec![7, 9]).format, TexelFormat::Unorm8);
}

/// If a device runs the shaders, a wrong shader fails.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(cvr_raw::codec(), "lane * raw_bits", "(lane ^ 1u) * raw_bits");
}
