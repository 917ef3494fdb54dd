//! A container, opened with the codec that wrote it.

use std::path::Path;
use std::sync::Arc;

use cvr_core::codec::{Codec, Decoder, FrameStore, Settings};
use cvr_core::container::EncodedVolume;
use cvr_core::pipeline::missing_level;
use cvr_core::volume::Level;

use crate::exit::BadInput;
use crate::registry::Names;

/// An opened container.
pub struct Opened {
    pub stream: Arc<EncodedVolume>,
    pub codec: Arc<dyn Codec>,
    /// The decoder. It keeps decoded frames if frames are predicted.
    pub decoder: Arc<dyn Decoder>,
}

impl Opened {
    /// Opens a container. `decoded_frames_mb` bounds the kept frames of a stream with predicted frames.
    pub fn open(path: &Path, names: &Names, decoded_frames_mb: u32) -> Result<Self, BadInput> {
        let stream = Arc::new(EncodedVolume::open(path)?);
        let at = |problem: String| BadInput(format!("{}: {problem}", path.display()));
        let codec = names.codecs().get(&stream.spec().codec).map_err(|e| at(e.to_string()))?.clone();
        let decoder = codec.decoder(stream.clone()).map_err(|e| at(e.to_string()))?;
        let decoder = FrameStore::open_mb(decoder.into(), decoded_frames_mb);
        Ok(Self { stream, codec, decoder })
    }
}

/// How much of a stream to decode.
#[derive(Copy, Clone, Debug, clap::Args)]
pub struct LevelArgs {
    /// Decode only the first N stages, if the codec refines in stages.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=254))]
    stages: Option<u8>,
    /// Decode this resolution, of a codec that has several: 0 is the full one, and each step halves every axis.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=32))]
    resolution: u8,
}

impl LevelArgs {
    /// The level, which the codec with these complete settings has.
    pub fn of(self, codec: &dyn Codec, settings: &Settings) -> Result<Level, BadInput> {
        let Self { stages, resolution } = self;
        match missing_level(codec, settings, (stages, resolution)) {
            Some(reason) => Err(BadInput(reason.to_string())),
            None => Ok(Level { resolution, stages: stages.unwrap_or(Level::ALL_STAGES) }),
        }
    }
}

/// What is kept of predicted frames.
#[derive(Copy, Clone, Debug, clap::Args)]
#[command(next_help_heading = "Memory")]
pub struct DecodedFramesArgs {
    /// Most decoded frames that are kept of a stream whose frames are predicted from others, in MB (10⁶ bytes); more are
    /// decoded anew.
    #[arg(
        long,
        value_name = "N",
        default_value_t = FrameStore::DEFAULT_MB,
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    pub decoded_frames_mb: u32,
}
