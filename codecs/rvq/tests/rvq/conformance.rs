//! The battery of `cvr-core`, over stages, codebook sizes, entries and tables.

use cvr_codec_tests::settings;
use cvr_core::codec::Settings;
use cvr_core::conformance;

/// With a device where there is one, or without: every shader takes seconds to compile there.
fn passes(list: &[Settings], on_device: bool) {
    // `largest`: a range from the lowest to the highest single overflows. `smallest normals`: steps below 2^-100.
    passes_but(list, on_device, 2 * list.len());
}

/// The same, with at most so many volumes refused.
fn passes_but(list: &[Settings], on_device: bool, refused: usize) {
    let dump = if on_device { cvr_codec_tests::device::dump("rvq::conformance") } else { None };
    let report = conformance::run_with(cvr_rvq::codec().as_ref(), list, dump);
    report.assert_ok();
    assert!(report.refused <= refused, "{} of {} volumes refused", report.refused, report.checks);
}

#[test]
fn the_default_passes() {
    passes(&[Settings::default()], true);
}

/// Scales of more than 12 stages, codes of 7 bits in two words, entries of 16 bits, scales from a buffer.
#[test]
fn many_stages_and_tables_per_frame_pass() {
    let pairs =
        [("entries", "16"), ("stages", "13"), ("codewords", "70"), ("tables", "per-frame"), ("beam", "1")];
    passes(&[settings(&pairs)], true);
}

/// Means, groups and escapes.
#[test]
fn the_payload_variable_passes() {
    passes(&[settings(&[("payload", "variable"), ("rate", "2"), ("stages", "3")])], true);
}

#[test]
fn odd_and_extreme_settings_pass() {
    passes(
        &[
            settings(&[("entries", "8"), ("stages", "2"), ("codewords", "20")]),
            settings(&[("stages", "1"), ("codewords", "5"), ("draw", "uniform"), ("init", "pca")]),
            settings(&[("stages", "16"), ("codewords", "2"), ("beam", "2")]),
            settings(&[("codewords", "4096"), ("refinement", "0")]),
            settings(&[("training_blocks", "1"), ("iterations", "0"), ("codewords", "1")]),
        ],
        false,
    );
}

#[test]
fn odd_and_extreme_settings_of_variable_pass() {
    let variable = |pairs: &[(&str, &str)]| {
        let quick = [("payload", "variable"), ("beam", "1"), ("refinement", "1"), ("stages", "2")];
        settings(&[&quick[..], pairs].concat())
    };
    passes(
        &[
            variable(&[("psnr", "30"), ("tables", "per-frame"), ("entries", "16"), ("codewords", "70")]),
            variable(&[("rate", "0.01"), ("codewords", "1")]),
        ],
        false,
    );
    // Escapes of 16 bits do not keep next to no error in floats of any range.
    passes_but(&[variable(&[("max_error", "1e-30"), ("codewords", "16")])], false, 40);
}

/// Where a device runs the shaders, a wrong one does not pass.
#[test]
fn a_wrong_snippet_is_noticed() {
    cvr_codec_tests::device::notices(cvr_rvq::codec(), "vec3<i32>(0x8000);", "vec3<i32>(0x8100);");
}
