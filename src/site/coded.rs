//! A frame of a stream, not decoded yet.

use cvr_core::codec::Decoder;
use cvr_core::shader::snippet_resources;
use cvr_core::volume::{FrameIndex, Level, VolumeLayout};

/// A frame of a stream at a level, and its decoder.
#[derive(Copy, Clone, Debug)]
pub struct CodedFrame<'a> {
    /// Codec id.
    pub codec: &'a str,
    /// The opened stream.
    pub decoder: &'a dyn Decoder,
    /// The frame's place in it.
    pub key: (FrameIndex, Level),
}

impl CodedFrame<'_> {
    /// Shape of the frame at the level.
    #[must_use]
    pub fn layout(&self) -> VolumeLayout {
        self.decoder.layout().at_resolution(self.key.1.resolution)
    }

    /// Bytes of a texel of the decoded frame on a device. Textures have one channel or four.
    #[must_use]
    pub fn texel_bytes(&self) -> u64 {
        let channels = if self.decoder.layout().channels == 1 { 1 } else { 4 };
        self.decoder.decoded_form().format.bytes() as u64 * channels
    }

    /// Bytes of the buffers from which a shader decodes the frame, per voxel of the stream. 0 if the codec has none.
    ///
    /// # Errors
    /// A sentence, when the stream lacks one.
    pub fn buffer_bytes_per_voxel(&self) -> Result<f64, String> {
        let Some(shader) = self.decoder.shader() else { return Ok(0.0) };
        let resources = snippet_resources(self.codec, self.decoder, shader, self.key);
        let resources = resources.map_err(|e| e.to_string())?;
        let bytes: usize = resources.iter().map(|r| r.words.len() * 4).sum();
        Ok(bytes as f64 / self.decoder.layout().voxels() as f64)
    }
}
