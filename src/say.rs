//! Standard output. Whoever reads it may stop: `cvr shader | head` is no mistake.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::exit::BAD_INPUT;

/// Prints a line like `println!`, but does not panic where nobody reads on.
macro_rules! say {
    ($($argument:tt)*) => { $crate::say::line(format_args!($($argument)*)) };
}

/// Whether standard output is the file that a command writes.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// From now on lines go to standard error: standard output is the file that a command writes.
pub fn on_standard_error() {
    TAKEN.store(true, Ordering::Relaxed);
}

/// Prints a line. A reader that has gone is no error; a disk that is full ends the process.
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
