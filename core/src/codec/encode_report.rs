//! What an encoder promises of its stream, as the container stores it.

use serde::{Deserialize, Serialize};

/// What an encoder promises of its stream; stored in the container.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EncodeReport {
    /// No decoded sample (integers: after rounding) differs from the source by more than this, in data units.
    pub error_bound: Option<f64>,
    /// Cases that the user should know of, one sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}
