//! Tests of the conformance tests: a correct codec passes, and each flaw is found under its property.

mod probe;

use super::{Property, run, run_shaders, run_with};
use crate::codec::{Codec, Decoder, SettingValue, Settings, VoxelDump};
use crate::conformance::decoded::Decoded;
use crate::volume::{FrameIndex, Level};
use probe::{Flaw, Probe};

/// The conformance tests find `property` violated, and nothing else.
fn finds(flaw: Flaw, property: Property) {
    let report = run(&Probe::new(flaw), None);
    assert!(report.fails(property), "{flaw:?} went unnoticed");
    let other = report.failures.iter().find(|f| f.property != property);
    assert!(other.is_none(), "{flaw:?} is also reported as {}", other.unwrap());
}

#[test]
fn a_sound_codec_passes() {
    let report = run(&Probe::new(Flaw::None), None);
    report.assert_ok();
    assert!(report.checks > 5000, "only {} checks", report.checks);
}

#[test]
fn an_encoder_that_fails_is_found() {
    finds(Flaw::EncodeFails, Property::Encode);
}

#[test]
fn a_codec_that_refuses_everything_is_found() {
    finds(Flaw::RefusesAll, Property::Encode);
}

#[test]
fn bytes_that_depend_on_threads_are_found() {
    finds(Flaw::ThreadDependent, Property::Threads);
}

#[test]
fn bytes_that_depend_on_the_run_are_found() {
    let report = run(&Probe::new(Flaw::Unrepeatable), None);
    assert!(report.fails(Property::Repeat));
}

#[test]
fn a_decoder_that_reads_the_settings_is_found() {
    finds(Flaw::ReadsSettings, Property::Stream);
}

#[test]
fn stages_that_make_it_worse_are_found() {
    finds_stages(Flaw::WorseStages, "of one more");
}

#[test]
fn stages_that_are_not_all_are_found() {
    finds_stages(Flaw::StageMissing, "3 stages are not all");
}

/// The probe's value range does not cover the flawed values. This is found too.
fn finds_stages(flaw: Flaw, message: &str) {
    let report = run(&Probe::new(flaw), None);
    let found =
        |f: &crate::conformance::Failure| f.property == Property::Stages && f.message.contains(message);
    assert!(report.failures.iter().any(found), "{flaw:?} went unnoticed");
}

#[test]
fn a_decoder_off_by_one_is_found() {
    finds(Flaw::OffByOne, Property::Bound);
}

#[test]
fn a_bound_that_does_not_hold_is_found() {
    finds(Flaw::WrongBound, Property::Bound);
}

#[test]
fn values_worse_than_their_mean_are_found_without_any_bound() {
    finds(Flaw::Inverts, Property::Trivial);
}

#[test]
fn values_that_are_not_finite_are_found() {
    let report = run(&Probe::new(Flaw::DecodesNan), None);
    assert!(report.fails(Property::Bound));
}

#[test]
fn a_value_range_too_narrow_is_found() {
    finds(Flaw::NarrowRange, Property::Range);
}

#[test]
fn a_single_voxel_that_differs_is_found() {
    finds(Flaw::VoxelDiffers, Property::Regions);
}

#[test]
fn a_key_that_is_not_checked_is_found() {
    finds(Flaw::UncheckedKey, Property::Keys);
}

#[test]
fn tensors_that_are_not_checked_are_found() {
    finds(Flaw::UncheckedTensor, Property::Damage);
}

#[test]
fn a_version_that_is_not_checked_is_found() {
    finds(Flaw::UncheckedVersion, Property::Version);
}

#[test]
fn a_snippet_that_is_no_wgsl_is_found() {
    finds(Flaw::BadSnippet, Property::Module);
}

#[test]
fn a_snippet_with_a_foreign_name_is_found() {
    finds(Flaw::ForeignName, Property::Module);
}

#[test]
fn a_pass_that_breaks_its_contract_is_found() {
    finds(Flaw::BadPass, Property::Module);
}

#[test]
fn passes_that_info_does_not_list_are_found() {
    finds(Flaw::UnlistedPasses, Property::Module);
}

#[test]
fn passes_of_a_frame_that_does_not_exist_are_found() {
    finds(Flaw::UncheckedPasses, Property::Keys);
}

#[test]
fn a_promised_site_without_any_shader_is_found() {
    let report = run(&Probe::new(Flaw::NothingDeferred), Some(&Dump::default()));
    assert!(report.fails(Property::Parity));
    assert!(report.failures.iter().all(|f| f.property == Property::Parity));
}

#[test]
fn settings_that_do_not_exist_are_a_failure() {
    let settings: Settings = [("nonsense".to_owned(), SettingValue::Integer(1))].into_iter().collect();
    assert!(run_with(&Probe::new(Flaw::None), &[settings], None).fails(Property::Encode));
}

/// A "device" that decodes on the CPU. It may change one bit of the last voxel, for a snippet or for passes.
#[derive(Default)]
struct Dump {
    flips_snippet: bool,
    flips_passes: bool,
}

impl Dump {
    fn values(
        decoder: &dyn Decoder,
        (frame, level): (FrameIndex, Level),
        flips: bool,
    ) -> Result<Vec<f32>, String> {
        let mut values = Decoded::at(decoder, level)?.values(frame).to_vec();
        if let Some(last) = values.last_mut().filter(|_| flips) {
            *last = f32::from_bits(last.to_bits() ^ 1);
        }
        Ok(values)
    }
}

impl VoxelDump for Dump {
    fn dump_at(
        &self,
        _: &str,
        decoder: &dyn Decoder,
        key: (FrameIndex, Level),
        _: bool,
    ) -> Result<Vec<f32>, String> {
        Self::values(decoder, key, self.flips_snippet)
    }

    fn dump_frame(
        &self,
        _: &str,
        decoder: &dyn Decoder,
        key: (FrameIndex, Level),
    ) -> Result<Vec<f32>, String> {
        Self::values(decoder, key, self.flips_passes)
    }
}

#[test]
fn a_faithful_device_passes_and_one_flipped_bit_is_found() {
    let codec = Probe::new(Flaw::None);
    let right = run(&codec, Some(&Dump::default()));
    right.assert_ok();
    assert!(!right.shader_not_run() && right.shader_samples > 1000);
    assert!(
        right
            .to_string()
            .ends_with(&format!("; {} samples through the shader compared", right.shader_samples))
    );
    for (flips_snippet, path) in [(true, "fetch"), (false, "passes")] {
        let report = run(&codec, Some(&Dump { flips_snippet, flips_passes: !flips_snippet }));
        assert!(report.fails(Property::Parity));
        let told =
            |f: &crate::conformance::Failure| f.property == Property::Parity && f.message.contains(path);
        assert!(report.failures.iter().all(told), "{path}");
    }
}

#[test]
fn a_choice_of_volumes_finds_a_flipped_bit_too() {
    let codec = Probe::new(Flaw::None);
    let with = |dump: &Dump| run_shaders(&codec, &[Settings::default()], dump);
    let right = with(&Dump::default());
    right.assert_ok();
    assert!(right.shader_samples > 1000);
    let wrong = with(&Dump { flips_snippet: true, ..Dump::default() });
    assert!(wrong.fails(Property::Parity), "{wrong}");
}

#[test]
fn a_battery_without_a_device_says_that_no_shader_ran() {
    let report = run(&Probe::new(Flaw::None), None);
    assert!(report.shader_not_run() && report.shader_samples == 0);
    assert!(report.to_string().contains("shader not run: no device"), "{report}");
}

#[test]
#[should_panic(expected = "codec `probe` fails")]
fn a_failing_report_panics() {
    let codec: &dyn Codec = &Probe::new(Flaw::RefusesAll);
    run(codec, None).assert_ok();
}
