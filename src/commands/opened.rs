//! A container, opened with the codec that wrote it.

use std::path::Path;
use std::sync::Arc;

use cvr_core::codec::{Codec, Decoder};
use cvr_core::container::EncodedVolume;

use crate::exit::BadInput;
use crate::registry::Names;

/// An opened container.
pub struct Opened {
    pub stream: Arc<EncodedVolume>,
    pub codec: Arc<dyn Codec>,
    pub decoder: Box<dyn Decoder>,
}

impl Opened {
    /// Opens a container.
    pub fn open(path: &Path, names: &Names) -> Result<Self, BadInput> {
        let stream = Arc::new(EncodedVolume::open(path)?);
        let at = |problem: String| BadInput(format!("{}: {problem}", path.display()));
        let codec = names.codecs().get(&stream.spec().codec).map_err(|e| at(e.to_string()))?.clone();
        let decoder = codec.decoder(stream.clone()).map_err(|e| at(e.to_string()))?;
        Ok(Self { stream, codec, decoder })
    }
}
