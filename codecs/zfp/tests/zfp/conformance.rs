//! The conformance tests, over rates: only a header, blocks that do not end on words, and all bits.

use cvr_codec_tests::settings;
use cvr_core::codec::Settings;
use cvr_core::conformance;

fn passes(list: &[Settings]) {
    let dump = cvr_codec_tests::device::dump("zfp::conformance");
    let report = conformance::run_with(cvr_zfp::codec().as_ref(), list, dump);
    report.assert_ok();
    assert_eq!(report.refused, 0);
}

#[test]
fn the_default_passes() {
    passes(&[Settings::default()]);
}

#[test]
fn low_rates_pass() {
    passes(&[settings(&[("rate", "0.140625")]), settings(&[("rate", "1")]), settings(&[("rate", "1.1")])]);
}

#[test]
fn high_rates_pass() {
    passes(&[settings(&[("rate", "8")]), settings(&[("rate", "17.3")]), settings(&[("rate", "32")])]);
}

/// If a device runs the shaders, a wrong shader fails.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(cvr_zfp::codec(), "var at = 9u;", "var at = 10u;");
}
