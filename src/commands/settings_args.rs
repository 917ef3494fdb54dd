//! Settings of a codec from `--set name=value`.

use cvr_core::codec::{CodecInfo, SettingValue, Settings};

use crate::exit::BadInput;

/// Complete settings from assignments such as `block=8`.
pub fn settings(info: &CodecInfo, assignments: &[String]) -> Result<Settings, BadInput> {
    let mut settings = Settings::default();
    for assignment in assignments {
        let Some((name, value)) = assignment.split_once('=') else {
            return Err(BadInput(format!("--set {assignment}: write a setting as name=value")));
        };
        settings.set(name.trim(), SettingValue::from(value.trim()));
    }
    Ok(info.complete(&settings)?)
}
