//! Passes of a codec's own, without a device: their texts, their limits, and the sites that such a codec offers.

use std::sync::Arc;

use cvr::registry::Names;
use cvr_core::codec::{Codec as _, Decoder as _, Site};
use cvr_core::conformance;
use cvr_core::pipeline::{Capabilities, resolve};
use cvr_core::shader::{BindingKind, BindingLimits, DeferredError, DeferredShaders};
use cvr_core::volume::{FrameIndex, Level, SampleType};

use super::combinations::everything;
use super::volumes::varied;
use crate::haar::{Haar, HaarDecoder, Pass};

const ODD: [u32; 3] = [13, 17, 23];

fn shaders(decoder: &HaarDecoder, limits: BindingLimits) -> Result<DeferredShaders<'_>, DeferredError> {
    let format = decoder.decoded_form().format;
    DeferredShaders::generate("haar", decoder, (FrameIndex::FIRST, Level::FULL), format, limits)
}

#[test]
fn a_codec_without_a_snippet_passes_the_battery() {
    let report = conformance::run(&Haar::default(), None);
    report.assert_ok();
    assert!(report.checks > 2000, "only {} checks", report.checks);
}

#[test]
fn the_shaders_are_what_they_should_be() {
    let decoder = Haar::encoded(1, &varied([5, 4, 3], SampleType::U8, 3));
    let shaders = shaders(&decoder, BindingLimits::default()).unwrap();
    let entries: Vec<_> = shaders.passes.iter().map(|p| (&*p.shader.entry, p.workgroups)).collect();
    assert_eq!(
        entries,
        [
            ("haar_load", [3, 1, 1]),
            ("haar_lift", [1, 4, 3]),
            ("haar_lift", [1, 4, 3]),
            ("haar_row", [3, 4, 3]),
            ("haar_finish", [3, 1, 1]),
        ]
    );
    insta::assert_snapshot!(shaders.texts().collect::<Vec<_>>().join("\n// ==== next pass\n\n"));
}

/// Each level has its own box, and so its own workgroups. Sizes that no workgroup divides, scalars and colours.
#[test]
fn every_level_of_every_shape_is_generated() {
    for (size, channels) in [(ODD, 1), (ODD, 3), ([1; 3], 1), ([5, 1, 130], 3)] {
        for levels in 0..=6 {
            let decoder = Haar::encoded(levels, &varied(size, SampleType::I16, channels));
            let shaders = shaders(&decoder, BindingLimits::default()).unwrap();
            assert_eq!(shaders.passes.len() as i64, 2 + 3 * levels);
            let rows = shaders.passes.iter().filter(|p| p.shader.entry == "haar_row").map(|p| p.workgroups);
            let boxes: Vec<_> = rows.collect();
            assert!(boxes.is_sorted_by(|a, b| a[1] <= b[1] && a[2] <= b[2]), "{boxes:?}");
            assert_eq!(boxes.last(), (levels > 0).then_some(&[channels, size[1], size[2]]));
        }
    }
}

#[test]
fn buffers_are_split_over_bindings_and_no_pass_can_tell() {
    let decoder = Haar::encoded(2, &varied(ODD, SampleType::U16, 1));
    // 5083 words: parts of 2000, 2000 and 1083.
    let limits = BindingLimits { storage_words: 2000, storage_buffers: 8 };
    let whole = shaders(&decoder, BindingLimits::default()).unwrap();
    let split = shaders(&decoder, limits).unwrap();
    for (whole, split) in whole.passes.iter().zip(&split.passes) {
        let own = |text: &str| text[text.find("// ==== tests/haar").unwrap()..].to_owned();
        assert_eq!(own(&whole.shader.wgsl), own(&split.shader.wgsl));
        assert_eq!(3 * whole.shader.bindings.len(), split.shader.bindings.len());
    }
    let lift = &split.passes[1].shader;
    assert!(lift.wgsl.contains("haar_to_part2[i - 4000u] = word;"), "{}", lift.wgsl);
    let last = BindingKind::Scratch { buffer: 1, first: 4000, words: 1083, written: true };
    assert_eq!(lift.bindings.last().unwrap().kind, last);
    assert!(split.pack.wgsl.contains("return frame_words_part2[i - 4000u];"));
    // The stream's own buffer and the one that it is loaded into: three parts each, then five.
    let small = BindingLimits { storage_words: 1100, ..limits };
    let error = shaders(&decoder, small).unwrap_err().to_string();
    assert_eq!(
        error,
        "pass `haar_load` of codec `haar` needs 10 storage buffers, in parts of 4400 bytes; the device binds 8"
    );
}

#[test]
fn a_row_that_no_workgroup_can_hold_is_refused_with_both_numbers() {
    let long = |x| Haar::encoded(1, &varied([x, 1, 1], SampleType::U8, 1));
    shaders(&long(4096), BindingLimits::default()).unwrap();
    let error = shaders(&long(4097), BindingLimits::default()).unwrap_err().to_string();
    assert!(error.contains("take 16388 bytes") && error.contains("every device has 16384"), "{error}");
    assert!(error.contains("tests/haar/row.wgsl:9:"), "{error}");
}

#[test]
fn a_damaged_pass_is_refused_in_its_authors_file() {
    for (pass, from, to, place) in [
        (Pass::Load, "haar_samples", "haar_sample_count", "load.wgsl:5:12"),
        (Pass::Lift, "var low = at;", "var low = at", "lift.wgsl:16:"),
        (Pass::Row, "@compute", "@fragment", "row.wgsl:8:1"),
        (Pass::Finish, "fn haar_finish", "fn haar_end", "finish.wgsl:1:1"),
    ] {
        let mut decoder = Haar::encoded(1, &varied(ODD, SampleType::U8, 1));
        decoder.passes.change(pass, from, to);
        let error = shaders(&decoder, BindingLimits::default()).unwrap_err().to_string();
        assert!(error.contains(&format!("tests/haar/{place}")), "{to}\n{error}");
    }
}

#[test]
fn a_codec_without_a_snippet_is_drawn_deferred_and_host() {
    let names = Names::new().unwrap().with_codec(Arc::new(Haar::default())).unwrap();
    let mut experiment = everything(&names);
    experiment.codecs.retain(|sweep| sweep.id == "haar");
    let resolution = resolve(&experiment, &names.known(), &Capabilities::default());
    let sites = |site| resolution.cells.iter().filter(move |c| c.site == site).count();
    assert_eq!((sites(Site::Inline), sites(Site::Host)), (0, sites(Site::Deferred)));
    assert!(sites(Site::Deferred) > 0);
    let refusal = resolution.refused.iter().find(|r| r.cell.site == Site::Inline).unwrap();
    assert_eq!(
        refusal.reason.to_string(),
        "codec haar cannot be decoded at site inline; it offers: deferred, host"
    );
    let info = Haar::default();
    assert_eq!(info.info().offered().collect::<Vec<_>>(), [Site::Deferred, Site::Host]);
}
