//! The conformance tests, over codebook sizes, widths and tables, at every number of stages.

use cvr_codec_tests::settings;
use cvr_core::codec::Settings;
use cvr_core::conformance;

fn passes(list: &[Settings]) {
    let dump = cvr_codec_tests::device::dump("hvq::conformance");
    let report = conformance::run_with(cvr_hvq::codec().as_ref(), list, dump);
    report.assert_ok();
    // May be refused: `largest`, whose range overflows, and `smallest normals`, whose steps are below 2^-100.
    assert!(report.refused <= 2 * list.len(), "{} of {} volumes refused", report.refused, report.checks);
}

#[test]
fn the_default_passes() {
    passes(&[Settings::default()]);
}

#[test]
fn every_width_passes() {
    passes(&[
        settings(&[("codeword_bits", "16")]),
        settings(&[("mean_bits", "8"), ("codeword_bits", "16"), ("coarse_codewords", "9")]),
        settings(&[("mean_bits", "16"), ("detail_codewords", "33")]),
    ]);
}

#[test]
fn small_codebooks_and_little_training_pass() {
    passes(&[
        settings(&[("coarse_codewords", "2"), ("detail_codewords", "2"), ("mean_bits", "8")]),
        settings(&[("training_blocks", "1"), ("iterations", "0"), ("init", "random")]),
        settings(&[
            ("coarse_codewords", "3"),
            ("detail_codewords", "5"),
            ("iterations", "1"),
            ("init", "scalar"),
        ]),
    ]);
}

#[test]
fn large_codebooks_and_tables_per_frame_pass() {
    passes(&[
        settings(&[("coarse_codewords", "65536"), ("detail_codewords", "65536"), ("tables", "per-frame")]),
        settings(&[
            ("coarse_codewords", "7"),
            ("detail_codewords", "20"),
            ("tables", "per-frame"),
            ("training_blocks", "40"),
            ("iterations", "2"),
            ("init", "pnn"),
        ]),
    ]);
}

/// If a device runs the shaders, a wrong shader fails.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(
        cvr_hvq::codec(),
        "(inside.z * 4u + inside.y) * 4u + inside.x",
        "(inside.z * 4u + inside.x) * 4u + inside.y",
    );
}
