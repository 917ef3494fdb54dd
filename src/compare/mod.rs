//! Comparison of runs: the same cells on other machines, or with other versions of this software.
//!
//! Cells are matched by what defines them ([`Identity`]) and not by where they ran; a ratio within the noise of both
//! measurements is a tie ([`Compared`]).

mod cells;
mod identity;
mod page;
mod quantity;
mod rows;
mod side;
mod text;

pub use cells::{Matched, Pairing, pair};
pub use identity::Identity;
pub use page::page;
pub use quantity::{Compared, Kind, QUANTITIES, Quantity, Verdict};
pub use rows::csv;
pub use side::{Side, read};
pub use text::text;

#[cfg(test)]
mod tests;
