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

/// Few codes do not reach this.
const DIRECTLY: [(&str, &str); 4] =
    [("payload", "variable"), ("psnr", "60"), ("index_bits", "4"), ("codes", "3")];

#[test]
fn blocks_that_are_coded_directly_pass() {
    passes(&[settings(&DIRECTLY)]);
}

/// A step that is off by one is noticed, and so is an escape that is read one word late.
#[test]
fn a_wrong_escape_is_noticed() {
    let list = [settings(&DIRECTLY)];
    for (from, to) in [
        ("(8u + ((form >> 5u) & 7u))", "(9u + ((form >> 5u) & 7u))"),
        ("end - tvq_parts * (nth + 1u", "end - tvq_parts * (nth"),
    ] {
        cvr_codec_tests::device::notices_under(cvr_tvq::codec(), &list, from, to);
    }
}

/// Where a device runs the shaders, a wrong one does not pass.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(
        cvr_tvq::codec(),
        "f32(clamp(sum, 0, 65535))",
        "f32(clamp(sum + 1, 0, 65535))",
    );
}
