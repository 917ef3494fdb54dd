//! The conformance tests, over payloads, targets, transforms and tables.

use cvr_codec_tests::settings;
use cvr_core::codec::Settings;
use cvr_core::conformance;

fn passes(list: &[Settings]) {
    let dump = cvr_codec_tests::device::dump("tvq::conformance");
    let report = conformance::run_with(cvr_tvq::codec().as_ref(), list, dump);
    report.assert_ok();
    // May be refused: `largest`, whose range overflows, and `smallest normals`, whose steps are below 2^-100.
    assert!(report.refused <= 2 * list.len(), "{} of {} volumes refused", report.refused, report.checks);
}

#[test]
fn the_default_passes() {
    passes(&[Settings::default()]);
}

#[test]
fn the_payload_variable_passes() {
    passes(&[settings(&[("payload", "variable")])]);
}

/// If a device runs the shaders, a wrong shader fails.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(
        cvr_tvq::codec(),
        "f32(clamp(sum, 0, 65535))",
        "f32(clamp(sum + 1, 0, 65535))",
    );
}
