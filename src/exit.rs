//! How a command ends: exit codes, and what is said to a person at a terminal.

/// Exit code of a run in which cells failed.
pub const SOME_FAILED: u8 = 1;
/// Exit code of bad input: command line, configuration, files.
pub const BAD_INPUT: u8 = 2;
/// Exit code of a run that Ctrl-C ended: 128 and the number of the signal, as shells have it.
pub const INTERRUPTED: u8 = 130;

/// What went wrong, for a person at a terminal.
#[derive(Debug)]
pub struct BadInput(pub String);

impl<E: std::error::Error> From<E> for BadInput {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}
