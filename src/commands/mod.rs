//! One file per command: arguments in, exit code out.

pub mod check_config;
pub mod codecs;
pub mod compare;
pub mod convert;
pub mod decode;
pub mod devices;
pub mod encode;
pub mod explain;
pub mod info;
pub mod merge;
pub mod presets;
pub mod render;
pub mod renderers;
pub mod run;
pub mod schema;
pub mod shader;
pub mod stability;

mod config_file;
mod histogram;
mod memory_args;
mod opened;
mod output;
mod scene_args;
mod settings_args;
mod volume_args;
mod volume_output;
