//! Ctrl-C: the first asks a run to stop, the second ends the process.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::exit::INTERRUPTED;

static STOP: AtomicBool = AtomicBool::new(false);

/// Listens for Ctrl-C from now on. The flag becomes true with the first; a second ends the process at once, which
/// costs no more than the cell that runs, since every file is whole or not there.
#[must_use]
pub fn listen() -> &'static AtomicBool {
    let heard = || {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        eprintln!("stopping after the running step; again to stop at once");
    };
    // A process that listens already, or a system without signals, runs on as it did.
    let _ = ctrlc::set_handler(heard);
    &STOP
}
