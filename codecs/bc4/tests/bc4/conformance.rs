//! The conformance tests, for both qualities.

use cvr_codec_tests::settings;
use cvr_core::codec::Settings;
use cvr_core::conformance;

fn passes(settings: &Settings) {
    let dump = cvr_codec_tests::device::dump("bc4::conformance");
    let report = conformance::run_with(cvr_bc4::codec().as_ref(), std::slice::from_ref(settings), dump);
    report.assert_ok();
    // May be refused: `largest`, whose range overflows, and a volume whose steps would vanish.
    assert!(report.refused <= 2, "{} of {} volumes refused", report.refused, report.checks);
}

#[test]
fn the_default_passes() {
    passes(&Settings::default());
}

#[test]
fn the_range_passes() {
    passes(&settings(&[("quality", "range")]));
}

/// If a device runs the shaders, a wrong shader fails.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(cvr_bc4::codec(), "16u + 3u * texel", "16u + 3u * (texel ^ 1u)");
}
