//! Standard output. Its reader may stop early: `cvr shader | head` is not an error.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::exit::BAD_INPUT;

/// Prints a line like `println!`, but does not panic if the reader has gone.
macro_rules! say {
    ($($argument:tt)*) => { $crate::say::line(format_args!($($argument)*)) };
}

/// Whether standard output is the file that a command writes.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Sends later lines to standard error, because the command writes its file to standard output.
pub fn on_standard_error() {
    TAKEN.store(true, Ordering::Relaxed);
}

/// Prints a line. A closed pipe is not an error. A full disk ends the process.
pub fn line(text: Arguments<'_>) {
    if TAKEN.load(Ordering::Relaxed) {
        eprintln!("{text}");
        return;
    }
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            eprintln!("error: standard output: {error}");
            std::process::exit(i32::from(BAD_INPUT));
        }
        _ => {}
    }
}
