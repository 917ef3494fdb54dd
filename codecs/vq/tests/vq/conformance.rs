//! The conformance tests, over blocks, codebook sizes, codeword widths and tables.

use cvr_codec_tests::settings;
use cvr_core::codec::Settings;
use cvr_core::conformance;

fn passes(list: &[Settings]) {
    let dump = cvr_codec_tests::device::dump("vq::conformance");
    let report = conformance::run_with(cvr_vq::codec().as_ref(), list, dump);
    report.assert_ok();
    // May be refused: `largest`, whose range overflows, and `smallest normals`, whose steps are below 2^-100.
    assert!(report.refused <= 2 * list.len(), "{} of {} volumes refused", report.refused, report.checks);
}

#[test]
fn the_default_passes() {
    passes(&[Settings::default()]);
}

#[test]
fn blocks_of_4_and_16_bit_codewords_pass() {
    passes(&[settings(&[("block", "4")]), settings(&[("block", "4"), ("codeword_bits", "16")])]);
}

#[test]
fn odd_and_extreme_blocks_pass() {
    passes(&[
        settings(&[("block", "1"), ("codewords", "7")]),
        settings(&[("block", "3x5x2"), ("codewords", "33"), ("codeword_bits", "16")]),
        settings(&[("block", "16"), ("codewords", "2")]),
    ]);
}

#[test]
fn large_codebooks_and_tables_per_frame_pass() {
    passes(&[
        settings(&[("codewords", "65536"), ("tables", "per-frame")]),
        settings(&[
            ("codewords", "5"),
            ("tables", "per-frame"),
            ("training_blocks", "40"),
            ("iterations", "2"),
        ]),
        settings(&[("training_blocks", "1"), ("iterations", "0")]),
    ]);
}

/// If a device runs the shaders, a wrong shader fails.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(cvr_vq::codec(), "vq_step * f32(code)", "vq_step * f32(code ^ 1u)");
}
