//! The number of pairs of frames that time a cell.

use std::num::ParseIntError;

use cvr_engine::timing::PairBudget;

/// Environment variable that limits pairs: tests draw thousands of cells and need no precise times.
const VARIABLE: &str = "CVR_FRAME_PAIRS";

/// The variable holds no number.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{VARIABLE}={text}: it must be the most pairs of frames that a cell is timed by ({error})")]
pub struct NoNumber {
    text: String,
    error: ParseIntError,
}

/// The budget of this process: the protocol's, limited by the environment, but not below the protocol's least.
///
/// # Errors
/// When the environment variable holds no number.
pub fn checked_budget() -> Result<PairBudget, NoNumber> {
    capped(std::env::var(VARIABLE).ok())
}

/// The same. If the environment variable is not a number, the protocol's budget; a run refuses this before it begins.
#[must_use]
pub fn budget() -> PairBudget {
    checked_budget().unwrap_or_default()
}

fn capped(text: Option<String>) -> Result<PairBudget, NoNumber> {
    let budget = PairBudget::default();
    let Some(text) = text else { return Ok(budget) };
    let most: usize = text.trim().parse().map_err(|error| NoNumber { text, error })?;
    Ok(PairBudget { max_pairs: most.clamp(budget.min_pairs, budget.max_pairs), ..budget })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cap_lies_within_the_protocol() {
        let most = |text: &str| capped(Some(text.to_owned())).map(|budget| budget.max_pairs);
        assert_eq!((most("1"), most("9"), most("1000")), (Ok(7), Ok(9), Ok(31)));
        assert_eq!(capped(None), Ok(PairBudget::default()));
        let error = most("few").unwrap_err().to_string();
        assert!(error.starts_with("CVR_FRAME_PAIRS=few: it must be"), "{error}");
    }
}
