//! Exit codes, and messages of commands at their end.

/// Exit code of a run in which cells failed.
pub const SOME_FAILED: u8 = 1;
/// Exit code of bad input: command line, configuration, files.
pub const BAD_INPUT: u8 = 2;
/// Exit code of a run that Ctrl-C ended: 128 plus the number of the signal, the convention of shells.
pub const INTERRUPTED: u8 = 130;

/// An error message for a person at a terminal.
#[derive(Debug)]
pub struct BadInput(pub String);

impl<E: std::error::Error> From<E> for BadInput {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}
