//! The switch for tests that need a device, so that none skips in silence.
//!
//! The environment variable `CVR_DEVICE` says what a test that needs a device does:
//!
//! - `required`: fail without an adapter (CI);
//! - `none`: skip;
//! - `auto`, the default: run where there is an adapter, skip elsewhere.
//!
//! A skipped test prints one line, and appends its name to the file that `CVR_SKIPPED_LOG` names, if any; the
//! test script ends by printing how many did not run.

use std::io::Write;
use std::sync::OnceLock;

use crate::{Device, DeviceChoice};

/// The device that the tests of this process share, or `None` where this test is to be skipped.
///
/// # Panics
/// When `CVR_DEVICE` is `required` and no device opens, when it has an unknown value, or when the log cannot be
/// written: a test must not pass by mistake.
pub fn test_device(test_name: &str) -> Option<&'static Device> {
    static SHARED: OnceLock<Result<Device, String>> = OnceLock::new();
    let switch = std::env::var("CVR_DEVICE").unwrap_or_else(|_| "auto".to_owned());
    let open = || SHARED.get_or_init(|| Device::open(&DeviceChoice::Auto).map_err(|e| e.to_string()));
    let reason = match switch.as_str() {
        "none" => "CVR_DEVICE=none",
        "auto" => match open() {
            Ok(device) => return Some(device),
            Err(reason) => reason,
        },
        "required" => match open() {
            Ok(device) => return Some(device),
            Err(reason) => panic!("{test_name} needs a device (CVR_DEVICE=required): {reason}"),
        },
        other => panic!("CVR_DEVICE={other}: must be `required`, `none` or `auto`"),
    };
    println!("skipped {test_name}: {reason}");
    if let Some(path) = std::env::var_os("CVR_SKIPPED_LOG") {
        let logged = std::fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path)
            // One write, so that tests that run beside each other do not mix their lines.
            .and_then(|mut log| log.write_all(format!("{test_name}\n").as_bytes()));
        assert!(logged.is_ok(), "CVR_SKIPPED_LOG: {path:?} cannot be written: {logged:?}");
    }
    None
}

/// Destroys a device, which must not be the shared one of [`test_device`]: the next call on it finds it lost.
pub fn lose(device: &Device) {
    device.wgpu().destroy();
}

#[cfg(test)]
mod tests {
    use std::process::{Command, Output};

    use super::*;

    /// A test of this crate that does nothing but ask for the device.
    const PROBE: &str = "testing::tests::probe";

    #[test]
    fn probe() {
        let _ = test_device("testing::probe");
    }

    /// Runs the probe in a process of its own, since the switch is read from the environment.
    fn run_probe(switch: &str, log: &std::path::Path) -> Output {
        Command::new(std::env::current_exe().unwrap())
            .args(["--exact", PROBE, "--nocapture"])
            .env("CVR_DEVICE", switch)
            .env("CVR_SKIPPED_LOG", log)
            .output()
            .unwrap()
    }

    #[test]
    fn a_skipped_test_prints_and_logs_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("skipped");
        for _ in 0..2 {
            let output = run_probe("none", &log);
            assert!(output.status.success());
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(text.contains("skipped testing::probe: CVR_DEVICE=none"), "{text}");
        }
        assert_eq!(std::fs::read_to_string(&log).unwrap(), "testing::probe\n".repeat(2));
    }

    #[test]
    fn an_unknown_switch_or_an_unwritable_log_fails() {
        let folder = tempfile::tempdir().unwrap();
        assert!(!run_probe("yes", &folder.path().join("skipped")).status.success());
        assert!(!run_probe("none", &folder.path().join("missing/skipped")).status.success());
    }
}
