//! From a volume to a container, in one call.

use std::path::Path;

use super::{Codec, EncodeError, Progress, Settings};
use crate::container::{ContainerError, ContainerWriter, EncodedVolume, Written};
use crate::memory::{self, Held};
use crate::volume::{BrickSource, FiniteVolume, Replaced};

/// Encodes `source` into a container at `path`. `settings` may be partial: defaults complete them, and the container
/// stores the complete settings. `replaced` counts the samples that were made finite before.
///
/// # Errors
/// When the settings are wrong, the codec cannot encode such a volume, there is no memory for it, reading or writing fails,
/// or `run` was cancelled. Nothing stands at `path` then.
pub fn encode_file(
    codec: &dyn Codec,
    settings: &Settings,
    source: &dyn BrickSource,
    replaced: Replaced,
    path: &Path,
    run: &Progress<'_>,
) -> Result<Written, EncodeError> {
    let settings = codec.info().complete(settings)?;
    let mut writer = ContainerWriter::create(path)?;
    let mut encoder = codec.encoder(&settings)?;
    let scratch = encoder.scratch_bytes(source.layout());
    memory::check(scratch, || format!("encoding {} voxels by {}", source.layout().extent, codec.info().id))?;
    let scratch = Held::new(scratch);
    let report = encoder.encode(source, &mut writer, run)?;
    drop(scratch);
    Ok(writer.finish(codec.info(), source.layout(), &settings, &report, replaced)?)
}

/// Encodes a volume into a temporary container, reads that back (checksums verified) and removes it.
///
/// # Errors
/// As [`encode_file`]; also when the temporary folder cannot be written.
pub fn encode_temporary(
    codec: &dyn Codec,
    settings: &Settings,
    volume: &FiniteVolume,
) -> Result<EncodedVolume, EncodeError> {
    let folder = tempfile::tempdir()
        .map_err(|source| ContainerError::Io { path: "a temporary folder".to_owned(), source })?;
    let path = folder.path().join("volume.cvr");
    encode_file(codec, settings, volume, volume.replaced(), &path, &Progress::silent())?;
    Ok(EncodedVolume::open(&path)?)
}
