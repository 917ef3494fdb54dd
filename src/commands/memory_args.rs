//! The memory limit of a command.

use clap::Args;
use cvr_core::memory::{self, Bound, Source};

/// The bound on memory.
#[derive(Copy, Clone, Debug, Args)]
#[command(next_help_heading = "Memory")]
pub struct MemoryArgs {
    /// Limit of memory for voxels and streams, in GB (10⁹ bytes). A larger request is refused before memory is reserved
    /// [default: the free memory of the machine, or of the control group of this process, at the start].
    #[arg(long, value_name = "N", value_parser = gigabytes)]
    max_gb: Option<Gigabytes>,
}

/// An amount of memory.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
struct Gigabytes {
    bytes: u64,
}

impl MemoryArgs {
    /// Sets the limit of this process.
    pub fn allow(self) {
        let given = self.given_bytes().map(|bytes| Bound { bytes, source: Source::User });
        if let Some(bound) = given.or_else(memory::free) {
            memory::allow(bound);
        }
    }

    /// The limit that the user gave.
    pub fn given_bytes(self) -> Option<u64> {
        self.max_gb.map(|amount| amount.bytes)
    }
}

/// `2`, `0.5`.
fn gigabytes(text: &str) -> Result<Gigabytes, String> {
    match text.parse::<f64>() {
        Ok(amount) if amount.is_finite() && amount > 0.0 => Ok(Gigabytes { bytes: (amount * 1e9) as u64 }),
        _ => Err(format!("`{text}`: a number of GB above 0, as 2 or 0.5")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_decimal() {
        assert_eq!(gigabytes("2"), Ok(Gigabytes { bytes: 2_000_000_000 }));
        assert_eq!(gigabytes("0.0015"), Ok(Gigabytes { bytes: 1_500_000 }));
        for wrong in ["0", "-1", "inf", "nan", "2GB", ""] {
            assert!(gigabytes(wrong).is_err(), "{wrong}");
        }
    }
}
