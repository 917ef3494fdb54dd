//! Kept streams in a codec's crate. They must decode to the same values for ever.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use cvr_core::codec::{Codec, DecodedFrame, Progress, Settings, decode_stages, encode_file};
use cvr_core::container::{ContainerWriter, EncodedVolume, StreamWriter as _};
use cvr_core::volume::{FiniteVolume, FrameIndex, Level, NoReferences, Replaced};

/// A kept stream, and `N` numbers of stages from which it is decoded.
#[derive(Debug)]
pub struct Kept<const N: usize> {
    /// Name of its file.
    pub name: &'static str,
    /// Version that wrote it.
    pub version: u32,
    /// CRC-32C of all decoded samples for each number of stages, as little-endian singles, frame after frame.
    pub crc32c: [u32; N],
    /// Settings and volume from which it was made.
    pub made: fn() -> (Settings, FiniteVolume),
}

impl<const N: usize> Kept<N> {
    /// The stream of this name. If it is missing and `CVR_BLESS` is set, it is written first.
    #[must_use]
    pub fn stream(&self, codec: &dyn Codec, crate_folder: &str) -> EncodedVolume {
        open(codec, &path(crate_folder, self.name), self.made)
    }
}

/// Decodes each stream and compares it with the stored checksums.
///
/// # Panics
/// When one decodes to anything else, or is of another version; the message holds its checksums.
pub fn assert_unchanged<const N: usize>(
    codec: &dyn Codec,
    crate_folder: &str,
    all: &[Kept<N>],
    stages: [u8; N],
) {
    let mut problems = Vec::new();
    for kept in all {
        let stream = kept.stream(codec, crate_folder);
        assert_eq!(stream.spec().stream_version, kept.version, "{}", kept.name);
        problems.extend(compare(kept.name, checksums(codec, stream, stages), kept.crc32c).err());
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// Path of the stream of this name. `crate_folder` is `env!("CARGO_MANIFEST_DIR")`.
#[must_use]
fn path(crate_folder: &str, name: &str) -> PathBuf {
    Path::new(crate_folder).join("tests/streams").join(format!("{name}.cvr"))
}

/// Opens a stream. If it is missing and `CVR_BLESS` is set, it is written first. An existing one is never written.
#[must_use]
fn open(codec: &dyn Codec, path: &Path, made: impl FnOnce() -> (Settings, FiniteVolume)) -> EncodedVolume {
    if !path.exists() && std::env::var_os("CVR_BLESS").is_some() {
        let (settings, volume) = made();
        encode_file(codec, &settings, &volume, Replaced::default(), path, &Progress::silent()).unwrap();
    }
    EncodedVolume::open(path).unwrap()
}

/// CRC-32C of all decoded samples for each number of stages, as little-endian singles, frame after frame.
#[must_use]
pub fn checksums<const N: usize>(codec: &dyn Codec, stream: EncodedVolume, stages: [u8; N]) -> [u32; N] {
    let decoder = codec.decoder(Arc::new(stream)).unwrap();
    stages.map(|stages| {
        (0..decoder.layout().frames).map(FrameIndex).fold(0, |crc, frame| {
            let values = decode_stages(decoder.as_ref(), frame, stages, &NoReferences).unwrap();
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            crc32c::crc32c_append(crc, &bytes)
        })
    })
}

/// CRC-32C of all decoded samples of a resolution, as little-endian singles, frame after frame.
#[must_use]
pub fn checksum_at(codec: &dyn Codec, stream: EncodedVolume, resolution: u8) -> u32 {
    let decoder = codec.decoder(Arc::new(stream)).unwrap();
    let level = Level { resolution, ..Level::FULL };
    (0..decoder.layout().frames).map(FrameIndex).fold(0, |crc, frame| {
        let decoded = DecodedFrame::at(decoder.as_ref(), frame, level).unwrap();
        let bytes: Vec<u8> = decoded.values().iter().flat_map(|v| v.to_le_bytes()).collect();
        crc32c::crc32c_append(crc, &bytes)
    })
}

/// Compares checksums with those that were kept.
///
/// # Errors
/// A sentence with both.
fn compare<const N: usize>(name: &str, found: [u32; N], kept: [u32; N]) -> Result<(), String> {
    if found == kept {
        return Ok(());
    }
    Err(format!("{name}: the checksums are {found:#010x?}, {kept:#010x?} were kept"))
}

/// The same stream with one bit of a tensor's byte flipped. Its checksums are updated, so it is otherwise valid.
#[must_use]
pub fn with_flipped(codec: &dyn Codec, stream: &EncodedVolume, tensor: &str, byte: usize) -> EncodedVolume {
    let (spec, folder) = (stream.spec().clone(), tempfile::tempdir().unwrap());
    let changed = folder.path().join("changed.cvr");
    let mut writer = ContainerWriter::create(&changed).unwrap();
    for (name, description) in &spec.tensors {
        let mut bytes = stream.tensor(name, description.element).unwrap().bytes().to_vec();
        if name == tensor {
            bytes[byte] ^= 1;
        }
        writer.append(name, description.element, &bytes).unwrap();
        writer.shape(name, &description.shape).unwrap();
        writer.parameters(spec.parameters.clone());
    }
    writer.finish(codec.info(), &spec.layout, &spec.settings, &spec.report, spec.replaced).unwrap();
    EncodedVolume::open(&changed).unwrap()
}
