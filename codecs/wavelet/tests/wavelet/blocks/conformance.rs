//! The conformance tests: every type, channels and frames, damaged streams, threads, cells, and shaders if there is a
//! device.

use std::sync::Arc;

use cvr_codec_tests::device::{dump, notices_under};
use cvr_core::codec::Settings;
use cvr_core::conformance;

use cvr_wavelet::Wavelet as Blocks;

use super::codec::{METHODS, of};

/// Targets for one filter and block size. Some volumes are refused: floats without loss, and rates below that of constant
/// blocks.
fn passes(method: (&str, &str), targets: &[(&str, &str)]) {
    let list: Vec<Settings> = targets.iter().map(|(target, value)| of(method, target, value)).collect();
    conformance::run_with(&Blocks, &list, dump("wavelet::blocks::conformance")).assert_ok();
}

#[test]
fn haar_in_blocks_of_8_passes() {
    passes(METHODS[0], &[("rate", "40"), ("max_error", "3.5")]);
}

#[test]
fn haar_in_blocks_of_16_passes() {
    passes(METHODS[1], &[("lossless", "0")]);
}

#[test]
fn five_three_in_blocks_of_8_passes() {
    passes(METHODS[2], &[("psnr", "30")]);
}

#[test]
fn five_three_in_blocks_of_16_passes() {
    passes(METHODS[3], &[("psnr", "45")]);
}

#[test]
fn wrong_snippets_are_noticed() {
    let notices = |method, from, to| notices_under(Arc::new(Blocks), &[of(method, "psnr", "50")], from, to);
    notices(METHODS[0], "let second = low - (high >> 1u);", "let second = low - (high / 2);");
    notices(METHODS[3], "return (before + after + 2) >> 2u;", "return (before + after + 1) >> 2u;");
}
