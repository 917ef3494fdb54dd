//! The battery of `cvr-core`, for every value of the setting.

use cvr_core::codec::{SettingValue, Settings};
use cvr_core::conformance;

fn with_bits(bits: &str) -> Settings {
    [("bits".to_owned(), SettingValue::from(bits))].into_iter().collect()
}

#[test]
fn native_passes_and_refuses_nothing() {
    let report = conformance::run(cvr_raw::codec().as_ref(), None);
    report.assert_ok();
    assert_eq!(report.refused, 0);
}

#[test]
fn eight_bits_and_half_pass() {
    let settings = [with_bits("8"), with_bits("half")];
    conformance::run_with(cvr_raw::codec().as_ref(), &settings, None).assert_ok();
}
