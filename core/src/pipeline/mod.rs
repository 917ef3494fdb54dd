//! Experiments: from TOML to the list of cells to run.
//!
//! [`Document::parse`] reads TOML and keeps the place of every key and value. [`Document::set`] changes values, as
//! `--set` does. [`Document::experiment`] turns it into the typed and checked [`Experiment`]: every name is known,
//! every value allowed. [`resolve`] multiplies it out into [`Cell`]s, and gives a reason for each refused combination.

mod cell;
mod colour;
mod config;
mod document;
mod file_path;
mod keys;
mod known;
mod overrides;
mod parse;
mod read;
mod resolve;
mod scene;
mod schema;
mod suggest;
#[cfg(test)]
mod tests;

pub use cell::Cell;
pub use colour::parse_colour;
pub use config::{
    ByteOrder, CodecSweep, Experiment, NoScene, PipelineAxes, RawLayout, Sweep, TooManyCells, Volume,
    VolumeSource,
};
pub use document::Document;
pub use file_path::{FilePath, FilePathError, UnsetVariable};
pub use keys::number;
pub use known::Known;
pub use parse::InvalidExperiment;
pub use resolve::{
    Capabilities, Reason, Refusal, Resolution, missing_level, resolve, undrawable, unsupported,
};
pub use scene::{FrameRange, Scene, SceneError, SceneOpacity, TransferDomain};
pub use schema::{json_schema, markdown};
