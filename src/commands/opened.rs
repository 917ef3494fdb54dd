//! A container, opened with the codec that wrote it.

use std::path::Path;
use std::sync::Arc;

use cvr_core::codec::{Codec, Decoder, Settings};
use cvr_core::container::EncodedVolume;
use cvr_core::pipeline::missing_stages;
use cvr_core::volume::Level;

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

/// How much of a stream to decode.
#[derive(Copy, Clone, Debug, clap::Args)]
pub struct LevelArgs {
    /// Decode only the first N stages, if the codec refines in stages.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=254))]
    stages: Option<u8>,
}

impl LevelArgs {
    /// The level, which the codec with these complete settings has.
    pub fn of(self, codec: &dyn Codec, settings: &Settings) -> Result<Level, BadInput> {
        match missing_stages(codec, settings, self.stages) {
            Some(reason) => Err(BadInput(reason.to_string())),
            None => Ok(self.stages.map_or(Level::FULL, |stages| Level { stages, ..Level::FULL })),
        }
    }
}
