//! The conformance tests, with commands that copy.
#![cfg(unix)]

use cvr_core::codec::{SettingValue, Settings};
use cvr_core::conformance;

#[test]
fn copies_pass_in_both_sample_types() {
    for sample in ["native", "f32"] {
        let settings: Settings = [("sample".to_owned(), SettingValue::from(sample))].into_iter().collect();
        let report = conformance::run_with(cvr_external::codec().as_ref(), &[settings], None);
        report.assert_ok();
        assert_eq!(report.refused, 0);
    }
}
