//! Which commands may run.

use std::collections::BTreeSet;
use std::sync::Mutex;

use cvr_core::codec::DecodeError;

use crate::command::Command;

/// Environment variable with which a user trusts the commands of all streams: `1`.
const TRUST_ALL: &str = "CVR_TRUST_COMMANDS";

/// The commands that this process may run to decode: those of encoders that it made from its own configuration.
///
/// A stream names the command that decodes it, and may come from anyone. If that command simply ran, opening a file
/// would run a program of its author's choice.
#[derive(Debug, Default)]
pub struct Trust(Mutex<BTreeSet<String>>);

impl Trust {
    /// Trusts a command. The encoder of a stream calls this.
    pub fn add(&self, command: &Command) {
        // The set is complete even if a thread panicked while it held the lock.
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).insert(command.text().to_owned());
    }

    /// Refuses an untrusted command, which came with a file.
    ///
    /// # Errors
    /// [`DecodeError::Refused`], with the command and the way out.
    pub fn check(&self, command: &Command) -> Result<(), DecodeError> {
        let own = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).contains(command.text());
        if own || std::env::var_os(TRUST_ALL).is_some_and(|v| v == "1") {
            return Ok(());
        }
        Err(DecodeError::Refused(format!(
            "this stream asks to run the command `{}` on this machine; if you trust where it comes from, set \
             {TRUST_ALL}=1",
            command.text()
        )))
    }
}
