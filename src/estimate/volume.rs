//! The layout of a volume that is not loaded.

use std::ffi::OsString;
use std::path::PathBuf;

use cvr_core::pipeline::{Volume, VolumeSource};
use cvr_core::volume::VolumeLayout;

use crate::experiment::inputs::volumes::LoadError;
use crate::input;

/// The layout from the headers of a volume's files, or from its generator's settings. `None` for slices: their number
/// and size are known only after reading.
///
/// # Errors
/// When a variable in its path is unset, a file is missing, or its header is unusable.
pub fn volume_layout(volume: &Volume) -> Result<Option<VolumeLayout>, LoadError> {
    match &volume.source {
        VolumeSource::File { files, raw, spacing } => {
            let lookup = |name: &str| -> Option<OsString> { std::env::var_os(name) };
            let paths: Result<Vec<PathBuf>, _> = files.iter().map(|path| path.expand(&lookup)).collect();
            let name = || volume.name.clone();
            let paths = paths.map_err(|source| LoadError::Unset { volume: name(), source })?;
            input::layout(&paths, raw.as_ref(), *spacing)
                .map_err(|source| LoadError::Input { volume: name(), source: Box::new(source) })
        }
        VolumeSource::Generated { extent, frames, sample, .. } => {
            Ok(Some(VolumeLayout { frames: *frames, ..VolumeLayout::scalar(*extent, *sample) }))
        }
    }
}
