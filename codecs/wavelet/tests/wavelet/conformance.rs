//! The conformance tests, over filters, coders and targets.

use cvr_codec_tests::settings;
use cvr_core::codec::Settings;
use cvr_core::conformance;

fn passes(list: &[Settings]) {
    let dump = cvr_codec_tests::device::dump("wavelet::conformance");
    let report = conformance::run_with(cvr_wavelet::codec().as_ref(), list, dump);
    report.assert_ok();
}

#[test]
fn the_default_passes() {
    passes(&[Settings::default()]);
}

#[test]
fn every_filter_passes() {
    let filters = ["haar", "daubechies-4", "coiflet-6", "cdf-2-6", "cdf-spline-2-6", "5-3"];
    passes(&filters.map(|filter| settings(&[("filter", filter), ("decompositions", "3")])));
}

#[test]
fn every_coder_passes() {
    let coders = ["runs", "deflate", "arithmetic", "zerotree"];
    let of =
        |coder| settings(&[("coder", coder), ("order", "octree"), ("quality", "200"), ("filter", "cdf-2-6")]);
    passes(&coders.map(of));
}

#[test]
fn every_target_passes() {
    passes(&[
        settings(&[("psnr", "40")]),
        settings(&[("max_error", "2"), ("decompositions", "2")]),
        settings(&[("filter", "5-3"), ("max_error", "3")]),
        settings(&[("filter", "5-3"), ("psnr", "35"), ("decompositions", "0")]),
        settings(&[("decompositions", "0")]),
        settings(&[("quality", "60"), ("quant_scale", "printed"), ("filter", "haar")]),
    ]);
}

/// If a device runs the passes, wrong ones fail.
#[test]
fn wrong_passes_are_noticed() {
    let notices = |filter, from, to| {
        let settings = settings(&[("filter", filter), ("decompositions", "2")]);
        cvr_codec_tests::device::notices_under(cvr_wavelet::codec(), &[settings], from, to);
    };
    notices("5-3", " + 2) >> 2u)", " + 1) >> 2u)");
    notices("cdf-9-7", "return min(place, 2 * last - place);", "return place % (last + 1);");
}
