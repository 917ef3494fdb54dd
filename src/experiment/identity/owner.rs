//! Whose the results in a folder are.

use serde::{Deserialize, Serialize};

/// What results are of.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// An experiment, run or merged.
    Run,
    /// A stability atlas.
    Atlas,
}

/// Whose results a folder holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// What they are of.
    #[serde(rename = "cvr")]
    pub kind: Kind,
    /// Name of the experiment.
    pub experiment: String,
    /// Hash of everything that identifies the experiment.
    pub identity: String,
}
