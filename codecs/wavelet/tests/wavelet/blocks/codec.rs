//! The codec with settings of blocks.

use std::sync::Arc;

use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, EncodeError, Settings, decode_frame, encode_temporary};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, NoReferences};
use cvr_wavelet::Wavelet as Blocks;

/// Both filters with both block sizes.
pub const METHODS: [(&str, &str); 4] = [("haar", "8"), ("haar", "16"), ("5-3", "8"), ("5-3", "16")];

pub fn of((filter, block): (&str, &str), target: &str, value: &str) -> Settings {
    let method = [("filter", filter), ("block", block)];
    match target {
        "lossless" => settings(&method),
        "rate" => settings(&[method[0], method[1], ("bits_per_voxel", value)]),
        _ => settings(&[method[0], method[1], (target, value)]),
    }
}

pub fn encoded(volume: &FiniteVolume, settings: &Settings) -> Result<Arc<EncodedVolume>, EncodeError> {
    encode_temporary(&Blocks, settings, volume).map(Arc::new)
}

/// All frames, one after another.
pub fn decoded(stream: &Arc<EncodedVolume>) -> Vec<f32> {
    let decoder = Blocks.decoder(Arc::clone(stream)).unwrap();
    let frames = (0..decoder.layout().frames).map(FrameIndex);
    frames.flat_map(|f| decode_frame(decoder.as_ref(), f, &NoReferences).unwrap()).collect()
}

pub fn source(volume: &FiniteVolume) -> Vec<f32> {
    (0..volume.layout().frames).flat_map(|f| volume.dense().frame_values(FrameIndex(f))).collect()
}
