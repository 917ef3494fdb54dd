//! The conformance tests, over block sizes and index widths.

use cvr_core::codec::{SettingValue, Settings};
use cvr_core::conformance;

fn settings(block: &str, index_bits: i64) -> Settings {
    let pairs = [("block", SettingValue::from(block)), ("index_bits", SettingValue::Integer(index_bits))];
    pairs.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn passes(list: &[Settings]) {
    let dump = cvr_codec_tests::device::dump("s3dc::conformance");
    let report = conformance::run_with(cvr_s3dc::codec().as_ref(), list, dump);
    report.assert_ok();
    // `largest`: a range from the lowest to the highest single overflows.
    assert!(report.refused <= list.len(), "{} of {} volumes refused", report.refused, report.checks);
}

#[test]
fn the_default_passes() {
    passes(&[Settings::default()]);
}

#[test]
fn every_index_width_passes() {
    passes(&[settings("4", 1), settings("4", 2), settings("8", 8)]);
}

#[test]
fn odd_and_extreme_blocks_pass() {
    passes(&[settings("1", 4), settings("3x5x2", 2), settings("128", 4)]);
}

/// If a device runs the shaders, a wrong shader fails.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(
        cvr_s3dc::codec(),
        "(1u << s3dc_index_bits) - 1u",
        "(1u << s3dc_index_bits) - 2u",
    );
}
