//! Standard output. Whoever reads it may stop: `cvr shader | head` is no mistake.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _};

use crate::exit::BAD_INPUT;

/// Prints a line like `println!`, but does not panic where nobody reads on.
macro_rules! say {
    ($($argument:tt)*) => { $crate::say::line(format_args!($($argument)*)) };
}

/// Prints a line. A reader that has gone is no error; a disk that is full ends the process.
pub fn line(text: Arguments<'_>) {
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            eprintln!("error: standard output: {error}");
            std::process::exit(i32::from(BAD_INPUT));
        }
        _ => {}
    }
}
