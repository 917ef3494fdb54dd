//! The switch for tests that need a device. No test is skipped without a message.
//!
//! The environment variable `CVR_DEVICE` says what a test that needs a device does:
//!
//! - `required`: run on the best adapter, fail without one (CI);
//! - `vulkan`, `gl`: the same, on an adapter of that backend;
//! - `none`: skip;
//! - `auto`, the default: run if there is an adapter, else skip.
//!
//! The results are printed, and appended to the file that `CVR_DEVICE_LOG` names, if any, as two fields separated by a
//! tab: `ran` and the adapter, `skipped` and the test, or `lacking` and the test with the missing feature. The test
//! script prints a summary of that file at its end.

use std::cell::RefCell;
use std::fmt::Display;
use std::io::Write;
use std::str::FromStr;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use crate::{Backend, Device, DeviceChoice};

/// What `CVR_DEVICE` says.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Switch {
    /// Fail if this device does not open.
    Required(DeviceChoice),
    /// The best adapter, if there is one.
    Auto,
    /// Skip.
    None,
}

impl FromStr for Switch {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "required" => Self::Required(DeviceChoice::Auto),
            "vulkan" => Self::Required(DeviceChoice::Backend(Backend::Vulkan)),
            "gl" => Self::Required(DeviceChoice::Backend(Backend::Gl)),
            "auto" | "" => Self::Auto,
            "none" => Self::None,
            _ => return Err(format!("CVR_DEVICE={text}: it must be required, vulkan, gl, auto or none")),
        })
    }
}

impl Switch {
    /// The switch of this process.
    fn of_environment() -> Self {
        let text = std::env::var("CVR_DEVICE").unwrap_or_default();
        text.parse().unwrap_or_else(|sentence| panic!("{sentence}"))
    }

    fn choice(&self) -> DeviceChoice {
        match self {
            Self::Required(choice) => choice.clone(),
            Self::Auto | Self::None => DeviceChoice::Auto,
        }
    }
}

/// A GL context belongs to one thread at a time. wgpu panics in a thread that waits six seconds for it, and compiling a
/// large shader in another thread takes longer. So tests on GL wait for each other before they begin.
static TURN: Mutex<()> = Mutex::new(());

thread_local! {
    /// Released when the thread ends: its test is then finished and all its resources are dropped.
    static HELD: RefCell<Option<MutexGuard<'static, ()>>> = const { RefCell::new(None) };
}

/// Waits until this thread is the only user of the device. It stays the only user until it ends.
fn take_turn() {
    HELD.with_borrow_mut(|held| {
        held.get_or_insert_with(|| TURN.lock().unwrap_or_else(PoisonError::into_inner));
    });
}

/// The device that the tests of this process share. `None` if this test is to be skipped.
///
/// On GL, the calling test has the device to itself until its thread ends.
///
/// # Panics
/// When `CVR_DEVICE` demands a device and none opens, when it has an unknown value, or when the log cannot be
/// written: a test must not pass by mistake.
pub fn test_device(test_name: &str) -> Option<&'static Device> {
    static SHARED: OnceLock<Result<Device, String>> = OnceLock::new();
    let switch = Switch::of_environment();
    let open = || {
        let shared = SHARED.get_or_init(|| {
            let device = Device::open(&switch.choice()).map_err(|e| e.to_string())?;
            log("ran", device.info());
            Ok(device)
        });
        shared.as_ref().inspect(|device| {
            if device.info().backend == Backend::Gl.name() {
                take_turn();
            }
        })
    };
    let reason = match &switch {
        Switch::None => "CVR_DEVICE=none",
        Switch::Auto => match open() {
            Ok(device) => return Some(device),
            Err(reason) => reason,
        },
        Switch::Required(choice) => match open() {
            Ok(device) => return Some(device),
            Err(reason) => panic!("{test_name} needs a device, and CVR_DEVICE asks for `{choice}`: {reason}"),
        },
    };
    println!("skipped {test_name}: {reason}");
    log("skipped", &test_name);
    None
}

/// A device for one test, to be lost or changed: the adapter of [`test_device`], opened again.
///
/// # Panics
/// When it does not open: a test asks [`test_device`] first.
#[must_use]
pub fn another_device() -> Device {
    let choice = Switch::of_environment().choice();
    Device::open(&choice).unwrap_or_else(|e| panic!("a second device does not open: {e}"))
}

/// Reports that a test, or a part of it, cannot run because this device lacks its feature. Use it only if
/// [`Device::capabilities`] or [`Device::blends_single`] says so, never for a wrong result.
///
/// # Panics
/// When the log cannot be written.
pub fn lacking(test_name: &str, what: &dyn Display) {
    println!("not on this device: {test_name}: {what}");
    log("lacking", &format_args!("{test_name}: {what}"));
}

fn log(field: &str, text: &dyn Display) {
    let Some(path) = std::env::var_os("CVR_DEVICE_LOG") else { return };
    let line = format!("{field}\t{text}\n");
    let logged = std::fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(&path)
        // One write, so that tests in parallel do not mix their lines.
        .and_then(|mut log| log.write_all(line.as_bytes()));
    assert!(logged.is_ok(), "CVR_DEVICE_LOG: {path:?} cannot be written: {logged:?}");
}

/// Destroys a device. It must not be the shared one of [`test_device`]. The next call on it finds it lost.
pub fn lose(device: &Device) {
    device.wgpu().destroy();
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::process::{Command, Output};

    use super::*;

    /// A test of this crate that only asks for the device.
    const PROBE: &str = "testing::tests::probe";

    #[test]
    fn probe() {
        let Some(device) = test_device("testing::probe") else { return };
        assert_eq!(another_device().info(), device.info());
        if std::env::var_os("CVR_DEVICE_LOG").is_some_and(|path| path.to_string_lossy().ends_with("lacking"))
        {
            lacking("testing::probe", &"wings");
        }
    }

    /// Runs the probe in its own process, because the switch is read from the environment.
    fn run_probe(switch: &str, log: &Path) -> Output {
        Command::new(std::env::current_exe().unwrap())
            .args(["--exact", PROBE, "--nocapture"])
            .env("CVR_DEVICE", switch)
            .env("CVR_DEVICE_LOG", log)
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
        assert_eq!(std::fs::read_to_string(&log).unwrap(), "skipped\ttesting::probe\n".repeat(2));
    }

    #[test]
    fn the_log_names_the_adapter_and_what_it_lacks() {
        let Some(device) = test_device("testing::log") else { return };
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("lacking");
        let backend = device.info().backend.as_str();
        let switch = if matches!(backend, "vulkan" | "gl") { backend } else { "required" };
        let output = run_probe(switch, &log);
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains("not on this device: testing::probe: wings"), "{text}");
        let expected = format!("ran\t{}\nlacking\ttesting::probe: wings\n", device.info());
        assert_eq!(std::fs::read_to_string(&log).unwrap(), expected);
    }

    #[test]
    fn an_unknown_switch_or_an_unwritable_log_fails() {
        let folder = tempfile::tempdir().unwrap();
        let unknown = run_probe("yes", &folder.path().join("skipped"));
        assert!(!unknown.status.success());
        let text = String::from_utf8_lossy(&unknown.stderr).into_owned();
        assert!(text.contains("CVR_DEVICE=yes: it must be required, vulkan, gl, auto or none"), "{text}");
        assert!(!run_probe("none", &folder.path().join("missing/skipped")).status.success());
    }

    /// Without turns, threads would meet.
    #[test]
    fn threads_take_turns_and_give_them_back() {
        use std::sync::atomic::{AtomicU32, Ordering};
        // If all tests run in one thread, it may still hold the lock of an earlier one.
        drop(HELD.take());
        let (inside, most) = (AtomicU32::new(0), AtomicU32::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    take_turn();
                    take_turn();
                    most.fetch_max(inside.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::sleep(std::time::Duration::from_millis(5));
                    inside.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
        assert_eq!(most.into_inner(), 1);
    }

    #[test]
    fn every_word_of_the_switch_is_read() {
        for (word, choice) in [
            ("required", DeviceChoice::Auto),
            ("vulkan", DeviceChoice::Backend(Backend::Vulkan)),
            ("gl", DeviceChoice::Backend(Backend::Gl)),
        ] {
            assert_eq!(Switch::from_str(word), Ok(Switch::Required(choice)));
        }
        assert_eq!((Switch::from_str("auto"), Switch::from_str("")), (Ok(Switch::Auto), Ok(Switch::Auto)));
        assert_eq!(Switch::from_str("none"), Ok(Switch::None));
        for wrong in ["Vulkan", "none ", "1", "opengl"] {
            assert!(Switch::from_str(wrong).unwrap_err().starts_with(&format!("CVR_DEVICE={wrong}: ")));
        }
    }
}
