//! Ctrl-C: the first asks a run to stop, the second ends the process.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::exit::INTERRUPTED;

static STOP: AtomicBool = AtomicBool::new(false);

/// Listens for Ctrl-C from now on. The first sets the flag. The second ends the process at once. It costs only the
/// running cell, because every file is complete or missing.
#[must_use]
pub fn listen() -> &'static AtomicBool {
    let heard = || {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        eprintln!("stopping after the running step; again to stop at once");
    };
    // If the process listens already, or the system has no signals, nothing changes.
    let _ = ctrlc::set_handler(heard);
    &STOP
}
